//! Recordings with too few samples or counts to determine anything about a motor.

use super::channel_stuck;
use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;

/// Fewest samples of a recording. Convention: five samples for each of gain, time constant, initial value and final
/// value of a first-order response.
pub(crate) const FEWEST_SAMPLES: usize = 20;

/// Fewest counts in all runs together: the quantization of first and last value (0.4 counts RMS) is then less than a
/// tenth of the travel.
const FEWEST_COUNTS: u64 = 5;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let samples = subject.run.len();
    if samples >= FEWEST_SAMPLES {
        return Vec::new();
    }
    vec![subject.finding(
        Kind::TooShort,
        Severity::Fatal,
        subject.whole(),
        format!("{samples} samples are too few for anything to be concluded"),
        [
            ("samples", samples as f64),
            ("fewest_samples", FEWEST_SAMPLES as f64),
        ],
        format!("record longer, at least {FEWEST_SAMPLES} samples"),
    )]
}

/// Finding for runs in which the shaft hardly moves, all together. The message has the command at which a run is at
/// rest.
pub(super) fn find_among(subjects: &[Subject<'_>]) -> Vec<Finding> {
    let is_commanded = |subject: &Subject<'_>| subject.run.command.iter().any(|u| *u != 0.0);
    let told: Vec<(&Subject<'_>, u64)> = subjects
        .iter()
        .filter(|subject| {
            subject.run.len() >= FEWEST_SAMPLES
                && subject.has("position")
                && (is_commanded(subject) || !subject.has("command"))
                && channel_stuck::find(subject).is_empty()
        })
        .map(|subject| (subject, travel(&subject.run.counts)))
        .collect();
    let all = told
        .iter()
        .fold(0_u64, |sum, told| sum.saturating_add(told.1));
    if all >= FEWEST_COUNTS {
        return Vec::new();
    }
    let found = |&(subject, counts): &(&Subject<'_>, u64)| {
        let together = match told.len() {
            1 => String::new(),
            _ => format!(" ({all} in all runs)"),
        };
        subject.finding(
            Kind::TooShort,
            Severity::Fatal,
            subject.whole(),
            format!("the shaft moves by {counts} counts{together}: too little for anything to be concluded"),
            [
                ("counts", counts as f64),
                ("counts_of_all_runs", all as f64),
                ("fewest_counts", FEWEST_COUNTS as f64),
            ],
            format!("command more, or record longer: the shaft must pass {FEWEST_COUNTS} counts at least"),
        )
    };
    told.iter().map(found).collect()
}

fn travel(counts: &[i64]) -> u64 {
    let ends = counts.iter().min().zip(counts.iter().max());
    ends.map_or(0, |(low, high)| high.abs_diff(*low))
}

#[cfg(test)]
mod tests {
    use crate::check::{Kind, check, check_training};
    use crate::recording::Run;

    fn run(counts_per_sample: f64) -> Run {
        let count = |k: usize| (counts_per_sample * k as f64) as i64;
        Run {
            sample_time_s: 0.03,
            counts_per_rev: 720.0,
            supply_v: Some(4.5),
            t_s: (0..100).map(|k| 0.03 * f64::from(k)).collect(),
            command: vec![4.5; 100],
            counts: (0..100).map(count).collect(),
            ..Run::default()
        }
    }

    /// Motion in a held-out run does not determine a model of a run at rest.
    #[test]
    fn the_shaft_has_to_move_in_training_data() {
        let runs = [run(0.045), run(5.0)];
        let is_short = |found: Vec<crate::check::Finding>| {
            found.iter().any(|finding| finding.id == Kind::TooShort)
        };
        assert!(!is_short(check(&runs, None)));
        for (from, is_still) in [(0, true), (1, false)] {
            let part = from..from + 1;
            let found = check_training(&runs, std::slice::from_ref(&part), None);
            assert_eq!(is_short(found), is_still, "{part:?}");
        }
        assert!(is_short(check_training(&runs, &[1..2, 0..1], None)));
    }
}
