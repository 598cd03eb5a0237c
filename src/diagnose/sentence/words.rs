//! Format of figures and names.

use crate::motor::catalogue::ids;

/// A 95 % interval of a share, clipped at 0.
pub(crate) fn percent_interval(lo95: f64, hi95: f64) -> String {
    let end = |share: f64| percent(share.max(0.0));
    format!(
        "95 % interval {} to {}",
        end(lo95).trim_end_matches(" %"),
        end(hi95)
    )
}

/// A probability with its relation: two decimals, three above 0.99; never 0 or 1.
pub(crate) fn probability(p: f64) -> String {
    match p {
        p if p >= 0.999 => "> 0.999".to_owned(),
        p if p >= 0.99 => format!("= {:.3}", (1000.0 * p).floor() / 1000.0),
        p if p < 0.005 => "< 0.01".to_owned(),
        p => format!("= {p:.2}"),
    }
}

/// Counts with the significant digits.
pub(crate) fn counts(counts: f64) -> String {
    match counts {
        c if c >= 100.0 => format!("{c:.0}"),
        c if c >= 10.0 => format!("{c:.1}"),
        c => format!("{c:.2}"),
    }
}

/// A share in percent.
pub(crate) fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p >= 10.0 => format!("{p:.0} %"),
        p if p >= 0.1 => format!("{p:.1} %"),
        p if p > 0.0 => "< 0.1 %".to_owned(),
        _ => "0 %".to_owned(),
    }
}

/// An effect's id as words, usable as a noun.
pub(crate) fn name(id: &str) -> String {
    let noun = match id {
        ids::ASYMMETRIC_VISCOUS => "asymmetric viscous friction",
        ids::COAST_AT_ZERO => "coasting at zero command",
        ids::COULOMB_FRICTION => "Coulomb friction",
        ids::PRESLIDING => "presliding friction",
        ids::PWM_FREEWHEEL => "PWM freewheeling",
        ids::STRIBECK => "Stribeck friction",
        _ => return id.replace('_', " "),
    };
    noun.to_owned()
}

/// A list with `last_word` before its last member.
pub(crate) fn listed(all: &[String], last_word: &str) -> String {
    match all.split_last() {
        Some((last, others)) if !others.is_empty() => {
            format!("{} {last_word} {last}", others.join(", "))
        }
        _ => all.concat(),
    }
}

/// A value with three significant digits.
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
        assert_eq!(probability(0.934), "= 0.93");
        assert_eq!(probability(0.9989), "= 0.998");
        assert_eq!(probability(1.0), "> 0.999");
    }

    #[test]
    fn figures_have_significant_digits() {
        assert_eq!(percent(0.0004), "< 0.1 %");
        assert_eq!(percent(0.123), "12 %");
        assert_eq!(counts(123.4), "123");
        assert_eq!(three(-0.00456), "-0.00456");
        assert_eq!(three(1234.6), "1235");
    }

    #[test]
    fn lists_are_joined_with_commas_and_and() {
        let all: Vec<String> = ["a", "b", "c"].map(str::to_owned).to_vec();
        assert_eq!(listed(&all, "and"), "a, b and c");
        assert_eq!(listed(&all[..1], "or"), "a");
    }
}
