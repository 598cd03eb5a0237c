//! Profiles that are meant: what people call them, slips of the hand, and shares and times that are spelt otherwise.

use crate::motor::meant;

/// What a profile is called elsewhere, and its name here.
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

/// The word that is meant by `asked`, with its share and time as they are written here; none where it is like none of `names`.
pub(super) fn nearest(asked: &str, names: &[&'static str]) -> Option<String> {
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
        None => meant(&plain, names.iter().copied())?,
    };
    let share = share_of(share).map_or(String::new(), |share| format!("@{share}"));
    let digits = time.trim_end_matches(|c: char| c.is_alphabetic() || c == ' ');
    let seconds = digits.parse::<f64>().ok().filter(|s| *s > 0.0);
    let time = seconds.map_or(String::new(), |seconds| format!(",{seconds}s"));
    Some(format!("{name}{share}{time}"))
}

/// A share as a fraction of the supply: per cents are above 1.
fn share_of(text: &str) -> Option<f64> {
    let value: f64 = text.trim_end_matches(['%', ' ']).parse().ok()?;
    let share = if text.ends_with('%') || value > 1.0 {
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
    fn what_people_type_leads_to_a_profile_that_there_is() {
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
            assert_eq!(nearest(asked, &names).as_deref(), Some(word), "{asked}");
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
