//! What is recorded next: what the diagnosis asks for, else a kind of profile that is still missing.

use crate::diagnose::{Diagnosis, KnownChange, SURE, Verdict};

/// Kinds of profile that are recorded where no profile is expected to tell more, in this order: slow, quick, free, braked.
const KINDS: [&str; 8] = [
    "reversing",
    "crawl@0.2",
    "chirp",
    "coasts",
    "staircase",
    "jog",
    "brakes",
    "ramp",
];

/// One recording that is to be made.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    /// The profile, as `--profile` takes it.
    pub profile: String,
    /// How long in s.
    pub duration_s: f64,
    /// What is changed on the bench for it.
    pub change: Option<KnownChange>,
    /// What it is for, in a phrase.
    pub why: String,
}

/// How it goes on after a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Next {
    /// The cause stands.
    Nothing,
    /// This is recorded.
    Record(Plan),
    /// Only a change on the bench tells more, and nobody but the user can make it.
    ByHand,
}

/// Whether the verdict says what causes the gap, or that there is none, surely enough. That there is none stands only where no further
/// recording would show what these may hide.
pub(super) fn stands(verdict: Verdict, probability: f64, is_more_asked: bool) -> bool {
    let says = match verdict {
        Verdict::Effect => true,
        Verdict::NoGap | Verdict::Parameters => !is_more_asked,
        _ => false,
    };
    says && probability >= SURE
}

/// How it goes on; `recorded` are the plans so far, `can_change` says whether the bench changes itself, as a virtual one does.
pub(super) fn next(found: &Diagnosis, recorded: &[Plan], can_change: bool) -> Next {
    if stands(
        found.verdict,
        found.probability,
        found.next_experiment.is_some(),
    ) {
        return Next::Nothing;
    }
    let is_new = |profile: &str, change: Option<&KnownChange>| {
        !(recorded.iter()).any(|plan| plan.profile == profile && plan.change.as_ref() == change)
    };
    let asked = found.next_experiment.as_ref();
    if let Some(asked) = asked.filter(|asked| is_new(&asked.profile, asked.change.as_ref())) {
        if asked.change.is_some() && !can_change {
            return Next::ByHand;
        }
        return Next::Record(Plan {
            profile: asked.profile.clone(),
            duration_s: asked.duration_s,
            change: asked.change.clone(),
            why: purpose(&asked.tells_apart),
        });
    }
    let first = recorded.first().map_or(0.0, |plan| plan.duration_s);
    let kind = KINDS.into_iter().map(|kind| format!("{kind},{first}s"));
    let missing = kind.into_iter().find(|word| {
        let name = word.split(['@', ',']).next().unwrap_or(word);
        !recorded
            .iter()
            .any(|plan| plan.profile.split(['@', ',']).next() == Some(name))
    });
    Next::Record(Plan {
        // All kinds were recorded: the richest once more.
        profile: missing.unwrap_or_else(|| format!("{},{first}s", KINDS[0])),
        duration_s: first,
        change: None,
        why: "no profile is expected to settle it; this kind is still missing".to_owned(),
    })
}

/// What a recording is to tell, in a phrase.
fn purpose(tells_apart: &[String]) -> String {
    /// So many effects are named.
    const NAMED: usize = 4;
    match tells_apart {
        [one] => format!("to show whether {one} is there"),
        several if several.len() > NAMED => format!(
            "to tell {} and {} more apart",
            several[..NAMED].join(", "),
            several.len() - NAMED
        ),
        several => format!("to tell {} apart", several.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_says_something_surely_stands() {
        for says in [Verdict::Effect, Verdict::NoGap, Verdict::Parameters] {
            assert!(stands(says, 0.9, false) && !stands(says, 0.89, false));
            // What a recording may hide is not known to be away.
            assert_eq!(stands(says, 0.99, true), says == Verdict::Effect);
        }
        for open in [
            Verdict::Ambiguous,
            Verdict::Partial,
            Verdict::OutsideCatalogue,
            Verdict::BadRecording,
        ] {
            assert!(!stands(open, 0.99, false));
        }
    }

    #[test]
    fn few_effects_are_named_and_many_are_counted() {
        let ids = |n: usize| -> Vec<String> { (0..n).map(|k| format!("e{k}")).collect() };
        assert_eq!(purpose(&ids(1)), "to show whether e0 is there");
        assert_eq!(purpose(&ids(2)), "to tell e0, e1 apart");
        assert_eq!(purpose(&ids(6)), "to tell e0, e1, e2, e3 and 2 more apart");
    }
}
