//! A recording of a few samples, or of a few counts, says nothing of a motor.

use super::channel_stuck;
use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;

/// Fewest samples of a recording. A first-order response has a gain, a time constant and a start; five
/// samples for each and for its end is the convention here.
pub(crate) const FEWEST_SAMPLES: usize = 20;

/// Fewest counts that the shaft must pass, in all runs together: the rounding of the first and the last (0.4 counts, root mean
/// square) is then less than a tenth of what is measured.
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

/// Runs in which, all together, the shaft hardly moves. One that stands still beside others that move says at which command.
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

/// From the lowest to the highest count.
fn travel(counts: &[i64]) -> u64 {
    let ends = counts.iter().min().zip(counts.iter().max());
    ends.map_or(0, |(low, high)| high.abs_diff(*low))
}
