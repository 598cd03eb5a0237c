//! The next recording: the proposal of the diagnosis, else a profile that is still missing.

use crate::diagnose::{Diagnosis, KnownChange, Settings, Verdict};

/// Profiles recorded without a proposal, in this order: slow, fast, free, braked.
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

/// A planned recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    /// The profile, as `--profile` takes it.
    pub profile: String,
    /// How long in s.
    pub duration_s: f64,
    /// Known change on the bench for it.
    pub change: Option<KnownChange>,
    /// Purpose as a phrase.
    pub why: String,
}

/// Next step after a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Next {
    /// None: the cause is known.
    Nothing,
    /// A recording.
    Record(Plan),
    /// The proposed recording needs a change on the bench by the user.
    ByHand,
}

/// Whether the cause is known: a closed verdict with enough probability, and no proposed recording that would
/// separate the remaining effects.
pub(super) fn is_known(
    verdict: Verdict,
    probability: f64,
    is_more_proposed: bool,
    settings: &Settings,
) -> bool {
    let is_closed = matches!(
        verdict,
        Verdict::Effect | Verdict::NoGap | Verdict::Parameters | Verdict::NoChange
    );
    is_closed && !is_more_proposed && probability >= settings.confident
}

/// Next step; `recorded` are the plans so far, `can_change` whether the bench changes itself, as a virtual one does.
pub(super) fn next(found: &Diagnosis, recorded: &[Plan], can_change: bool) -> Next {
    if is_known(
        found.verdict,
        found.probability,
        found.next_experiment.is_some(),
        &found.settings,
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
        // All profiles were recorded: repeat the first.
        profile: missing.unwrap_or_else(|| format!("{},{first}s", KINDS[0])),
        duration_s: first,
        change: None,
        why: "no profile is proposed; this kind is still missing".to_owned(),
    })
}

fn purpose(tells_apart: &[String]) -> String {
    /// Most effects named.
    const NAMED: usize = 4;
    match tells_apart {
        [one] => format!("to show whether {one} is present"),
        several if several.len() > NAMED => format!(
            "to separate {} and {} more",
            several[..NAMED].join(", "),
            several.len() - NAMED
        ),
        several => format!("to separate {}", several.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_confident_verdict_without_open_alternatives_is_known() {
        let settings = Settings::default();
        let confident = settings.confident;
        let is_known = |verdict, probability, is_more_proposed| {
            is_known(verdict, probability, is_more_proposed, &settings)
        };
        for closed in [
            Verdict::Effect,
            Verdict::NoGap,
            Verdict::Parameters,
            Verdict::NoChange,
        ] {
            assert!(is_known(closed, confident, false));
            assert!(!is_known(closed, confident - 0.01, false));
            // A proposed recording would separate the remaining effects.
            assert!(!is_known(closed, 0.99, true));
        }
        for open in [
            Verdict::Ambiguous,
            Verdict::Partial,
            Verdict::OutsideCatalogue,
            Verdict::BadRecording,
        ] {
            assert!(!is_known(open, 0.99, false));
        }
    }

    #[test]
    fn few_effects_are_named_and_many_are_counted() {
        let ids = |n: usize| -> Vec<String> { (0..n).map(|k| format!("e{k}")).collect() };
        assert_eq!(purpose(&ids(1)), "to show whether e0 is present");
        assert_eq!(purpose(&ids(2)), "to separate e0, e1");
        assert_eq!(purpose(&ids(6)), "to separate e0, e1, e2, e3 and 2 more");
    }
}
