//! Counts that fall while the command is positive: two wires are swapped.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;

/// Counts that must have passed under a command, so that rounding and one count of dither are at most 5 % of them.
const FEWEST_COUNTS: f64 = 20.0;
/// Share of the counts passed under a command that must go the wrong way. A load that drives the shaft half of the time
/// (an arm that is lifted and lowered) stays at 0; a delay, coasting and reversals pull a right wiring towards 0, never past it.
const AGAINST: f64 = 0.5;

/// A shaft that is this many times as fast at the beginning as before it turns back was braked on the way.
const SLOWED: f64 = 2.0;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    if run.is_empty() || !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    let (mut along, mut passed) = (0.0, 0.0);
    let (mut positive, mut negative) = (0.0_f64, 0.0_f64);
    let from = braked(&run.counts);
    let mut resting: f64 = (run.counts[..=from].windows(2))
        .map(|pair| pair[0].abs_diff(pair[1]) as f64)
        .sum();
    for (pair, &command) in run.counts.windows(2).zip(&run.command).skip(from) {
        let moved = pair[1].saturating_sub(pair[0]) as f64;
        if command == 0.0 {
            resting += moved.abs();
        } else {
            along += moved * command.signum();
            passed += moved.abs();
            let side = if command > 0.0 {
                &mut positive
            } else {
                &mut negative
            };
            *side += moved;
        }
    }
    // A load pushes one way only: against both signs of the command nothing but the wires turns the shaft. Against one sign an arm
    // that falls does, by half a turn and a swing.
    let is_one_way = !(positive < 0.0 && negative > 0.0);
    if is_one_way && passed < run.counts_per_rev {
        return Vec::new();
    }
    // What moves as much without a command, or while it is braked, is driven by something else.
    if passed < FEWEST_COUNTS || resting > passed || along > -AGAINST * passed {
        return Vec::new();
    }
    let what = if positive < 0.0 || negative == 0.0 {
        "the counts fall while the command is positive"
    } else {
        "the counts rise while the command is negative"
    };
    vec![subject.finding(
        Kind::EncoderReversed,
        Severity::Fatal,
        subject.whole(),
        format!("{what}: A and B (or the motor leads) are swapped"),
        [
            ("counts_under_positive_command", positive),
            ("counts_under_negative_command", negative),
            ("share_along_the_command", along / passed),
        ],
        "scale = -1 under [position] of the mapping, or swap the two wires",
    )]
}

/// The sample up to which a shaft that turns from the beginning is braked: its own inertia turns it against the command. 0 where it
/// keeps its speed or begins at rest.
fn braked(counts: &[i64]) -> usize {
    let moved = |from: usize, to: usize| counts[to].saturating_sub(counts[from]) as f64;
    let steps = 1..counts.len();
    let Some(first) = steps.clone().find(|k| moved(k - 1, *k) != 0.0) else {
        return 0;
    };
    let direction = moved(first - 1, first).signum();
    let turned = steps
        .into_iter()
        .find(|k| moved(k - 1, *k) * direction < 0.0);
    let end = turned.map_or(counts.len() - 1, |k| k - 1);
    let window = (end / 10).max(3);
    if end < 2 * window {
        return 0;
    }
    let (begins, ends) = (moved(0, window).abs(), moved(end - window, end).abs());
    if begins > SLOWED * ends { end } else { 0 }
}
