//! A shaft at rest under a command that turned it before: the drive was off, or the shaft was held.
//!
//! A command that has turned the shaft by a whole turn, from rest or through a reversal, overcomes friction, dead
//! zone and any angle-dependent load. No effect of the catalogue keeps the shaft at rest under the same or a larger
//! command of that sign, and a model fitted across such an interval explains a switch by parameters. The interval
//! begins where the speed begins to fall.
//!
//! A reversing shaft is at rest as well, within the resolution of a coarse encoder. The counts lost to acceleration
//! in the turn before are therefore subtracted from the missing travel: under a chirp the reversal takes half a
//! period.

use super::finding::{Finding, Kind, Severity};
use super::misread_position::misread_positions;
use super::subject::Subject;
use super::words::{digits, time, unit};
use crate::recording::Run;

/// A command is held while it varies by less than this share: a PWM step of 8 bits is 0.4 %, a measured supply varies
/// by 1 %.
const HOLDS: f64 = 0.02;
/// Turns after which no angle-dependent load can hold the shaft.
const TURNED: f64 = 1.0;
/// Least counts of these turns: one count of quantization is 2 % of them.
const LEAST_COUNTS: f64 = 50.0;
const LEAST_STILL: usize = 10;
/// Least missing travel in turns, acceleration included, and in counts (one of quantization is 5 % of them).
const MISSED_TURNS: f64 = 0.25;
const MISSED_COUNTS: f64 = 20.0;
/// A standstill that begins with the command, at rest, and ends in motion is a dead time up to this length in s: the
/// range of the catalogue's `transport_delay` ends at 0.3 s.
const LONGEST_DELAY_S: f64 = 0.5;
/// The run-out begins at the last speed above this share of the largest. Convention.
const FULL_SPEED: f64 = 0.9;
/// Samples over which the speed of the run-out is averaged.
const SPEED_SAMPLES: usize = 4;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Off {
    /// Number of the sample at which the speed begins to fall.
    pub from: usize,
    /// Number of the first sample at rest.
    pub still: usize,
    /// Number of the last sample at rest.
    pub to: usize,
    /// Smallest command in the interval.
    command: f64,
    /// The command of the turn before, and its rate.
    turned: Turned,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Turned {
    command: f64,
    counts_s: f64,
    /// Counts lost to acceleration, relative to this rate from the first sample of the command on.
    behind: f64,
}

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    if !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    off_intervals(subject.run)
        .iter()
        .map(|off| finding(subject, off))
        .collect()
}

fn finding(subject: &Subject<'_>, off: &Off) -> Finding {
    let run = subject.run;
    let unit = unit(run.command_kind);
    let at = |sample: usize| digits(run.t_s[sample], 4);
    let rpm = 60.0 * off.turned.counts_s / run.counts_per_rev;
    let command = digits(off.command, 4);
    subject.finding(
        Kind::OffUnderCommand,
        Severity::Warning,
        (off.from, off.to),
        format!(
            "the shaft stands still from {} to {} s under {command} {unit}, and {} {unit} turned it at {} RPM before: the drive was off, or the shaft was held",
            at(off.still),
            at(off.to),
            digits(off.turned.command, 4),
            digits(rpm, 3),
        ),
        [
            ("command", off.command),
            ("still_from_s", run.t_s[off.still]),
            ("still_s", run.t_s[off.to] - run.t_s[off.still]),
            ("run_out_s", run.t_s[off.still] - run.t_s[off.from]),
            ("turned_by_command", off.turned.command),
            ("turned_counts_per_s", off.turned.counts_s),
        ],
        if off.to + 1 == run.len() {
            format!(
                "end the run at {from} s; or command 0 from there on (--command 0V@{from}s at the end of the points of the import)",
                from = at(off.from)
            )
        } else {
            format!(
                "leave out {} to {} s ({}), or command 0 there",
                at(off.from),
                at(off.to),
                time(run.t_s[off.to] - run.t_s[off.from])
            )
        },
    )
}

/// Every standstill under a command that turned the shaft before, with its run-out.
pub(crate) fn off_intervals(run: &Run) -> Vec<Off> {
    let misread = misread_positions(run);
    if misread.is_empty() {
        return intervals(run);
    }
    let kept: Vec<usize> = (0..run.len())
        .filter(|k| misread.binary_search(k).is_err())
        .collect();
    let in_run = |off: Off| Off {
        from: kept[off.from],
        still: kept[off.still],
        to: kept[off.to],
        ..off
    };
    let found = intervals(&run.without(&misread));
    found.into_iter().map(in_run).collect()
}

fn intervals(run: &Run) -> Vec<Off> {
    let mut found: Vec<Off> = Vec::new();
    let mut turned: [Option<Turned>; 2] = [None; 2];
    let mut moving_from = 0;
    for (from, to) in standstills(run) {
        learn(run, moving_from, from, &mut turned);
        for (direction, turned) in [1.0, -1.0].into_iter().zip(turned) {
            let Some(turned) = turned else { continue };
            let least = (1.0 - HOLDS) * turned.command.abs();
            let is_held = |k: usize| direction * run.command[k] >= least;
            // A command holds until the next sample.
            let mut k = from;
            while k < to {
                if !is_held(k) {
                    k += 1;
                    continue;
                }
                let end = (k..to).find(|&k| !is_held(k)).unwrap_or(to);
                if let Some(off) = off(run, (from, to), (k, end), turned) {
                    match found.last_mut() {
                        // The last count of the run-out splits a standstill.
                        Some(last) if off.still <= last.to + 1 => last.to = off.to,
                        _ => found.push(off),
                    }
                }
                k = end;
            }
        }
        moving_from = to;
    }
    found
}

/// A standstill (`rest`) during whose part `held` the command is one that turned the shaft.
fn off(run: &Run, rest: (usize, usize), held: (usize, usize), turned: Turned) -> Option<Off> {
    let (still, to) = held;
    let still_s = run.t_s[to] - run.t_s[still];
    let missed = turned.counts_s * still_s - turned.behind;
    let is_long = to - still >= LEAST_STILL
        && missed >= MISSED_COUNTS
        && missed >= MISSED_TURNS * run.counts_per_rev;
    // The command steps at rest, and the shaft responds late.
    let is_late = still > rest.0 && to == rest.1 && to + 1 < run.len();
    if !is_long || (is_late && still_s < LONGEST_DELAY_S) {
        return None;
    }
    let least = (still..to)
        .map(|k| run.command[k])
        .min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let from = if still == rest.0 {
        run_out(run, still, (1.0 - HOLDS) * turned.command)
    } else {
        still
    };
    Some(Off {
        from,
        still,
        to,
        command: least,
        turned,
    })
}

/// The sample from which the speed falls to the standstill at `still` under a command of at least `least`, with its
/// sign.
fn run_out(run: &Run, still: usize, least: f64) -> usize {
    let is_held = |k: usize| least.signum() * run.command[k] >= least.abs();
    let from = (0..still).rev().take_while(|&k| is_held(k)).last();
    let Some(from) = from else { return still };
    let speed = |k: usize| {
        let before = k.saturating_sub(SPEED_SAMPLES).max(from);
        let counts = run.counts[k].abs_diff(run.counts[before]) as f64;
        counts / (run.t_s[k] - run.t_s[before])
    };
    let moving = from + 1..=still;
    let top = moving.clone().map(speed).fold(0.0, f64::max);
    moving
        .rev()
        .find(|&k| speed(k) >= FULL_SPEED * top)
        .unwrap_or(still)
}

/// Intervals at rest: the count varies by at most one, which is dither on an edge.
fn standstills(run: &Run) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut from = 0;
    let (mut low, mut high) = (i64::MAX, i64::MIN);
    for k in 0..=run.len() {
        let next = run.counts.get(k).copied();
        if let Some(count) = next {
            let (lower, higher) = (low.min(count), high.max(count));
            if higher.abs_diff(lower) <= 1 {
                (low, high) = (lower, higher);
                continue;
            }
            if k - from >= LEAST_STILL {
                found.push((from, k - 1));
            }
            (from, low, high) = (k, count, count);
        } else if k - from >= LEAST_STILL {
            found.push((from, k - 1));
        }
    }
    found
}

/// Records the commands that turn the shaft by a revolution between two standstills: the smallest for each direction.
fn learn(run: &Run, from: usize, to: usize, turned: &mut [Option<Turned>; 2]) {
    let mut k = from;
    while k < to {
        let direction = run.command[k].signum();
        if run.command[k] == 0.0 || !direction.is_finite() {
            k += 1;
            continue;
        }
        let same = |k: &usize| direction * run.command[*k] > 0.0;
        let end = (k..to).find(|k| !same(k)).unwrap_or(to);
        let passed =
            |sample: usize| direction * run.counts[sample].saturating_sub(run.counts[k]) as f64;
        let whole = (TURNED * run.counts_per_rev).max(LEAST_COUNTS);
        let half = (k..=end).find(|&sample| passed(sample) >= 0.5 * whole);
        let turn = (k..=end).find(|&sample| passed(sample) >= whole);
        if let (Some(half), Some(turn)) = (half, turn) {
            let lasts_s = run.t_s[turn] - run.t_s[half];
            let counts_s = (passed(turn) - passed(half)) / lasts_s;
            let largest = (k..turn).fold(0.0, |most, k| f64::max(most, run.command[k].abs()));
            let slot = &mut turned[usize::from(direction < 0.0)];
            let is_less = slot.is_none_or(|known| largest < known.command.abs());
            if is_less && counts_s.is_finite() && lasts_s > 0.0 {
                // The command began in the standstill before, or before a reversal.
                let onset = (0..k).rev().take_while(same).last().unwrap_or(k);
                let ideal = counts_s * (run.t_s[turn] - run.t_s[onset]);
                let made = direction * run.counts[turn].saturating_sub(run.counts[onset]) as f64;
                *slot = Some(Turned {
                    command: direction * largest,
                    counts_s,
                    behind: (ideal - made).max(0.0),
                });
            }
        }
        k = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First-order motor (100 counts/s/V, 80 ms) at 10 ms whose drive is off in these samples.
    fn run(command: impl Fn(usize) -> f64, is_off: impl Fn(usize) -> bool) -> Run {
        let mut run = Run {
            counts_per_rev: 200.0,
            ..Run::default()
        };
        let (mut speed, mut position) = (0.0, 0.0_f64);
        for k in 0..400 {
            run.t_s.push(0.01 * f64::from(k as u32));
            run.command.push(command(k));
            run.counts.push(position.round() as i64);
            let driven = if is_off(k) { 0.0 } else { command(k) };
            speed += (0.01 / 0.08) * (100.0 * driven - speed);
            position += 0.01 * speed;
        }
        run
    }

    #[test]
    fn a_drive_that_is_off_at_the_end_or_in_between_is_found_by_its_coasting() {
        let step = |k: usize| if k < 50 { 0.0 } else { 6.0 };
        assert_eq!(off_intervals(&run(step, |_| false)), []);
        let ended = off_intervals(&run(step, |k| k >= 200));
        let [off] = ended[..] else {
            panic!("{ended:?}")
        };
        assert!(off.from.abs_diff(200) <= 3, "{off:?}");
        assert!((220..280).contains(&off.still) && off.to == 399, "{off:?}");
        let meanwhile = off_intervals(&run(step, |k| (200..320).contains(&k)));
        let [off] = meanwhile[..] else {
            panic!("{meanwhile:?}")
        };
        assert!(off.to.abs_diff(320) <= 2, "{off:?}");
        // Another level of the same sign, and the opposite sign.
        let levels = |k: usize| [0.0, 3.0, -3.0, 4.0][k / 100];
        let found = off_intervals(&run(levels, |k| k >= 310));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(off_intervals(&run(|k| -step(k), |k| k >= 200)).len() == 1);
    }

    #[test]
    fn a_small_command_or_a_partial_turn_is_not_reported_as_off() {
        // At rest under less than the command that turned it; and an arm that has never made a turn.
        let staircase = |k: usize| [0.0, 6.0, 1.0, 1.0][k / 100];
        assert_eq!(off_intervals(&run(staircase, |k| k >= 200)), []);
        let mut arm = run(|k| if k < 50 { 0.0 } else { 6.0 }, |k| k >= 200);
        arm.counts_per_rev = 4000.0;
        assert_eq!(off_intervals(&arm), []);
        // A dead time of 0.2 s.
        let pulses = |k: usize| {
            if (k / 100).is_multiple_of(2) {
                0.0
            } else {
                6.0
            }
        };
        assert_eq!(off_intervals(&run(pulses, |k| k % 100 < 20)), []);
    }
}
