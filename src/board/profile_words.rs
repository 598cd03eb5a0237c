//! Suggestions for an unknown profile name: synonyms, misspellings, and other notations of share and time.

use crate::motor::nearest_name;

/// Synonyms of profiles, with the profile.
const ALSO_CALLED: [(&str, &str); 20] = [
    ("constant", "step"),
    ("dc", "step"),
    ("sin", "chirp"),
    ("sine", "chirp"),
    ("sweep", "chirp"),
    ("prbs", "jog"),
    ("random", "jog"),
    ("noise", "jog"),
    ("stair", "staircase"),
    ("stairs", "staircase"),
    ("levels", "staircase"),
    ("reverse", "reversing"),
    ("reversal", "reversing"),
    ("triangle", "ramp"),
    ("sawtooth", "ramp"),
    ("pulse", "square"),
    ("slow", "crawl"),
    ("zero", "rest"),
    ("off", "rest"),
    ("brake", "brakes"),
];

/// Suggestion for `asked`, as a phrase; empty if no name is similar.
pub(super) fn hint(asked: &str, names: &[&'static str]) -> String {
    match nearest(asked, names) {
        Some(Suggestion::Word(word)) => format!("did you mean '{word}'? "),
        Some(Suggestion::NoShare { name, share }) => format!(
            "'@{share}' is no share of the supply: it is above 0 and at most 1, as in '{name}@0.5'; --supply sets the volts; "
        ),
        None => String::new(),
    }
}

#[derive(Debug, PartialEq)]
enum Suggestion {
    Word(String),
    /// A profile of this name with an invalid share of the supply.
    NoShare {
        name: &'static str,
        share: String,
    },
}

/// The name most similar to `asked`, with share and time in the right notation; `None` if none is.
fn nearest(asked: &str, names: &[&'static str]) -> Option<Suggestion> {
    let (rest, time) = match asked.split_once(',') {
        Some((rest, time)) => (rest, time.trim()),
        None => (asked, ""),
    };
    let (name, share) = match rest.split_once('@') {
        Some((name, share)) => (name, share.trim()),
        None => (rest, ""),
    };
    let plain = name.trim().to_lowercase();
    let called = ALSO_CALLED.iter().find(|(word, _)| *word == plain);
    let name = match called {
        Some((_, name)) => *name,
        None => nearest_name(&plain, names.iter().copied())?,
    };
    let share = match share_of(share) {
        _ if share.is_empty() => String::new(),
        Some(share) => format!("@{share}"),
        None => {
            let share = share.to_owned();
            return Some(Suggestion::NoShare { name, share });
        }
    };
    let digits = time.trim_end_matches(|c: char| c.is_alphabetic() || c == ' ');
    let seconds = digits.parse::<f64>().ok().filter(|s| *s > 0.0);
    let time = seconds.map_or(String::new(), |seconds| format!(",{seconds}s"));
    Some(Suggestion::Word(format!("{name}{share}{time}")))
}

/// From this value on a number without a sign is a percentage; a smaller one above 1 may be a voltage or a multiple.
const PER_CENT_FROM: f64 = 10.0;

fn share_of(text: &str) -> Option<f64> {
    let value: f64 = text.trim_end_matches(['%', ' ']).parse().ok()?;
    let share = if text.ends_with('%') || value >= PER_CENT_FROM {
        value / 100.0
    } else {
        value
    };
    (share > 0.0 && share <= 1.0).then_some(share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::{BUILT_IN, Profile};

    #[test]
    fn synonyms_and_typos_suggest_a_built_in_profile() {
        let names = BUILT_IN.map(|(name, _)| name);
        for (asked, word) in [
            ("stpe", "step"),
            ("Step", "step"),
            ("steps", "step"),
            ("sin", "chirp"),
            ("sine", "chirp"),
            ("stair", "staircase"),
            ("reverse", "reversing"),
            ("crwal@0.2", "crawl@0.2"),
            ("step@50%", "step@0.5"),
            ("step@50", "step@0.5"),
            ("step,4", "step,4s"),
            ("jog@0.4,8 sec", "jog@0.4,8s"),
        ] {
            let meant = Some(Suggestion::Word(word.to_owned()));
            assert_eq!(nearest(asked, &names), meant, "{asked}");
            assert!(Profile::named(word, 4.5, 4.0).is_ok(), "{word}");
        }
        for (_, name) in ALSO_CALLED {
            assert!(Profile::built_in(name, 4.5, 4.0).is_some(), "{name}");
        }
        for asked in ["banana", "x", ""] {
            assert_eq!(nearest(asked, &names), None, "{asked}");
        }
    }
}
