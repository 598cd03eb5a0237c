//! How sure, how many counts, which effects: the words that all sentences share.

use crate::diagnose::settings::RIVAL_WORDS;

/// How sure, in words; never rounded up to certainty.
pub(crate) fn sure(probability: f64) -> String {
    match probability {
        p if p >= 0.999 => "over 99.9 % sure".to_owned(),
        p if p >= 0.99 => format!("{:.1} % sure", (1000.0 * p).floor() / 10.0),
        p => format!("{:.0} % sure", 100.0 * p),
    }
}

/// Counts with as many digits as matter.
pub(crate) fn counts(counts: f64) -> String {
    match counts {
        c if c >= 100.0 => format!("{c:.0}"),
        c if c >= 10.0 => format!("{c:.1}"),
        c => format!("{c:.2}"),
    }
}

/// Effects as words.
pub(crate) fn words(set: &[&str]) -> String {
    let names: Vec<String> = set.iter().map(|id| id.replace('_', " ")).collect();
    match names.split_first() {
        Some((first, [])) => first.clone(),
        Some((first, others)) => format!("{first} with {}", others.join(" and ")),
        None => String::new(),
    }
}

/// Rivals, as many as are read.
pub(crate) fn rivals(sets: &[Vec<&'static str>]) -> String {
    listed(sets.iter().map(|set| words(set)).collect(), "or")
}

/// The same of causes as the document names them.
pub(crate) fn rivals_of(causes: &[&str]) -> String {
    let name = |cause: &&str| match *cause {
        "none" => "no effect at all".to_owned(),
        "unknown" => "an unknown cause".to_owned(),
        ids => words(&ids.split('+').collect::<Vec<&str>>()),
    };
    listed(causes.iter().map(name).collect(), "and")
}

fn listed(all: Vec<String>, last_word: &str) -> String {
    let count = all.len();
    let mut names: Vec<String> = Vec::new();
    let mut length = 0;
    for name in all {
        length += name.split_whitespace().count();
        if !names.is_empty() && length > RIVAL_WORDS {
            break;
        }
        names.push(name);
    }
    if names.len() < count {
        names.push(format!("{} more", count - names.len()));
    }
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => {
            format!("{} {last_word} {last}", others.join(", "))
        }
        _ => names.concat(),
    }
}

/// Two digits of a share.
pub(crate) fn digits(percent: f64) -> String {
    match percent {
        p if p >= 10.0 => format!("{p:.0}"),
        p if p >= 1.0 => format!("{p:.1}"),
        p if p >= 0.01 => format!("{p:.2}"),
        _ => "less than 0.01".to_owned(),
    }
}

/// A number with three digits that count.
pub(crate) fn three(value: f64) -> String {
    let size = value.abs().max(1e-12).log10().floor() as i32;
    let decimals = usize::try_from(2 - size).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn certainty_is_never_rounded_up() {
        assert_eq!(sure(0.934), "93 % sure");
        assert_eq!(sure(0.9899), "99 % sure");
        assert_eq!(sure(0.9989), "99.8 % sure");
        assert_eq!(sure(1.0), "over 99.9 % sure");
    }

    #[test]
    fn several_effects_are_one_beside_others() {
        assert_eq!(words(&["dead_zone"]), "dead zone");
        assert_eq!(words(&["backlash", "stribeck"]), "backlash with stribeck");
        assert_eq!(words(&["a", "b_c", "d"]), "a with b c and d");
        assert_eq!(words(&[]), "");
    }

    #[test]
    fn a_small_share_is_not_nothing() {
        assert_eq!(digits(0.004), "less than 0.01");
        assert_eq!(digits(0.014), "0.01");
        assert_eq!(digits(12.3), "12");
    }

    #[test]
    fn three_digits_count_whatever_the_size() {
        assert_eq!(three(1234.6), "1235");
        assert_eq!(three(-0.00456), "-0.00456");
        assert_eq!(three(0.0), "0");
    }
}
