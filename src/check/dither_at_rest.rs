//! One count of dither without a command: the shaft rests on an encoder edge.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;

/// Fewest alternating changes of one count: fewer are a shaft that settles.
const FEWEST_CHANGES: usize = 10;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    if !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    let (mut changes, mut first, mut last, mut before) = (0_usize, 0, 0, 0_i64);
    for k in 1..run.len() {
        let moved = run.counts[k].saturating_sub(run.counts[k - 1]);
        if run.command[k - 1] != 0.0 || moved.unsigned_abs() > 1 {
            before = 0;
        } else if moved != 0 {
            if before == -moved {
                if changes == 0 {
                    first = k - 1;
                }
                changes += 1;
                last = k;
            }
            before = moved;
        }
    }
    if changes < FEWEST_CHANGES {
        return Vec::new();
    }
    vec![subject.finding(
        Kind::DitherAtRest,
        Severity::Note,
        (first, last),
        format!("one count of dither at rest, {changes} times there and back: the shaft stands on an edge of the encoder"),
        [("times_there_and_back", changes as f64)],
        "no correction needed; one count of noise at standstill causes no model error",
    )]
}
