//! A shaft that turns before the first command.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    if !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    let before = run.command.iter().take_while(|u| **u == 0.0).count();
    if before < 2 || before == run.len() {
        return Vec::new();
    }
    let first = run.counts[0];
    let moved = run.counts[..before].iter().map(|n| n.abs_diff(first)).max();
    // One count is dither on an edge.
    let Some(moved) = moved.filter(|moved| *moved > 1) else {
        return Vec::new();
    };
    vec![subject.finding(
        Kind::StartsInMotion,
        Severity::Note,
        (0, before - 1),
        format!("the shaft moves by {moved} counts before anything is commanded"),
        [
            ("counts", moved as f64),
            ("before_s", run.t_s[before - 1] - run.t_s[0]),
        ],
        "wait until the shaft is at rest before recording: a simulation starts from rest",
    )]
}
