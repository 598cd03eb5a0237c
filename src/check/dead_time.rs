//! A dead time of many samples between command and motion.
//!
//! After a jump of the command from rest the position begins as a power of the time since the motion's onset: 1 for a shaft without inertia, 2
//! with it, 3 behind an inductance. From the times `t1` and `t2` at which it has passed `x` and `4 x`, the onset of a square is `2 t1 -
//! t2`, which is before that of a smaller power. Short dead times are found by the whole answer
//! ([`command_offset`](super::command_offset)).

use super::finding::{Finding, Kind, Severity};
use super::jump::{Jump, jumps};
use super::subject::Subject;
use super::words::time;

/// A dead time of at least so many samples.
const LEAST_SAMPLES: f64 = 8.0;
/// Samples after a jump that are looked at.
const LOOKED_AT: usize = 500;
/// Counts of `x`: one of dither at rest is no motion.
const ONSET_COUNTS: f64 = 2.0;
/// The onset lies beyond this share of `t1`: that of a third power is at 0.41.
const SHARP: f64 = 0.55;
/// Counts a sample that a shaft at rest may seem to turn.
const AT_REST: f64 = 0.05;
/// So large a share of the jumps must have the dead time, each at least this share of the middle one: friction at the breakaway
/// holds a shaft now longer, now shorter.
const MOST: f64 = 2.0 / 3.0;
const AGREE: f64 = 0.7;

/// A dead time that most jumps of the command have.
pub(super) fn dead_time(subject: &Subject<'_>, slack: usize, step_s: f64) -> Option<Finding> {
    let jumps = jumps(subject.run, slack, LOOKED_AT);
    let mut onsets: Vec<(usize, f64)> = (jumps.iter())
        .filter(|jump| jump.speed_counts_s.abs() * step_s <= AT_REST)
        .filter_map(|jump| onset_s(jump).map(|onset_s| (jump.at, onset_s)))
        .collect();
    let looked_at = onsets.len();
    onsets.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (_, middle_s) = *onsets.get(looked_at / 2)?;
    onsets
        .retain(|(_, onset_s)| *onset_s >= AGREE * middle_s && *onset_s >= LEAST_SAMPLES * step_s);
    if middle_s < LEAST_SAMPLES * step_s || (onsets.len() as f64) < MOST * looked_at as f64 {
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
            "the shaft begins to move {} ({samples:.0} samples) after the command jumps: a dead time between command and motion",
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

/// When the motion begins, in s after the jump; `None` where it is not seen, 0 where the rise is too slow to tell.
fn onset_s(jump: &Jump) -> Option<f64> {
    let x = ONSET_COUNTS.max(4.0 * jump.ahead.1);
    let passes = |counts: f64| {
        let first = jump
            .answer
            .iter()
            .position(|&(t_s, y)| t_s >= 0.0 && y >= counts)?;
        let (after, before) = (jump.answer[first], jump.answer[first.checked_sub(1)?]);
        let share = (counts - before.1) / (after.1 - before.1);
        Some(before.0 + share.clamp(0.0, 1.0) * (after.0 - before.0))
    };
    let (t1, t2) = (passes(x)?, passes(4.0 * x)?);
    let onset_s = 2.0 * t1 - t2;
    Some(if onset_s >= SHARP * t1 { onset_s } else { 0.0 })
}
