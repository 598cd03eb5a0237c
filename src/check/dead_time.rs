//! A dead time of many samples between command and motion.
//!
//! After a step from rest the position grows as a power of the time since the onset: 1 without inertia, 2 with it, 3
//! with an inductance as well. From the times `t1` and `t2` at which it has passed `x` and `4 x`, the onset of a
//! square is `2 t1 - t2`, which is before that of a smaller power. Shorter dead times are estimated from the whole
//! response by [`command_offset`](super::command_offset).

use super::finding::{Finding, Kind, Severity};
use super::step_response::{StepResponse, step_responses};
use super::subject::Subject;
use super::words::time;

/// Least dead time in samples.
const LEAST_SAMPLES: f64 = 8.0;
/// Samples examined after a step.
const EXAMINED: usize = 500;
/// `x` in counts: more than one count of dither at rest.
const ONSET_COUNTS: f64 = 2.0;
/// Least onset as a share of `t1`: a third power gives 0.41.
const SHARP: f64 = 0.55;
/// Largest speed at rest in counts a sample.
const AT_REST: f64 = 0.05;
/// Least share of the steps that have the dead time, each at least this share of the median: stiction holds a shaft
/// for varying times.
const MOST: f64 = 2.0 / 3.0;
const AGREE: f64 = 0.7;

pub(super) fn dead_time(subject: &Subject<'_>, slack: usize, step_s: f64) -> Option<Finding> {
    let steps = step_responses(subject.run, slack, EXAMINED);
    let mut onsets: Vec<(usize, f64)> = (steps.iter())
        .filter(|step| step.speed_counts_s.abs() * step_s <= AT_REST)
        .filter_map(|step| onset_s(step).map(|onset_s| (step.at, onset_s)))
        .collect();
    let examined = onsets.len();
    onsets.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (_, middle_s) = *onsets.get(examined / 2)?;
    onsets
        .retain(|(_, onset_s)| *onset_s >= AGREE * middle_s && *onset_s >= LEAST_SAMPLES * step_s);
    if middle_s < LEAST_SAMPLES * step_s || (onsets.len() as f64) < MOST * examined as f64 {
        return None;
    }
    let first = onsets.iter().map(|onset| onset.0).min()?;
    let last = onsets.iter().map(|onset| onset.0).max()?;
    let samples = middle_s / step_s;
    Some(subject.finding(
        Kind::CommandEarly,
        Severity::Warning,
        (first, last),
        format!(
            "the shaft begins to move {} ({samples:.0} samples) after the step of the command: a dead time between command and motion",
            time(middle_s),
        ),
        [
            ("dead_time_s", middle_s),
            ("dead_time_samples", samples),
            ("jumps", onsets.len() as f64),
        ],
        format!(
            "log the command when the drive takes it, or move its column down by {samples:.0} rows; look for a bus, a soft start, a buffer or play in between; to a model it is `transport_delay`"
        ),
    ))
}

/// Onset of motion in s after the step; `None` without motion, 0 where the rise is too slow to determine it.
fn onset_s(step: &StepResponse) -> Option<f64> {
    let x = ONSET_COUNTS.max(4.0 * step.at_step.1);
    let passes = |counts: f64| {
        let first = step
            .response
            .iter()
            .position(|&(t_s, y)| t_s >= 0.0 && y >= counts)?;
        let (after, before) = (step.response[first], step.response[first.checked_sub(1)?]);
        let share = (counts - before.1) / (after.1 - before.1);
        Some(before.0 + share.clamp(0.0, 1.0) * (after.0 - before.0))
    };
    let (t1, t2) = (passes(x)?, passes(4.0 * x)?);
    let onset_s = 2.0 * t1 - t2;
    Some(if onset_s >= SHARP * t1 { onset_s } else { 0.0 })
}
