//! A recording of a few samples says nothing of a motor.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;

/// Fewest samples of a recording. A first-order response has a gain, a time constant and a start; five
/// samples for each and for its end is the convention here.
pub(crate) const FEWEST_SAMPLES: usize = 20;

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
