//! Edges that are lost at speed: the rate of counts falls while the command holds or rises.
//!
//! The speed of a motor rises with the voltage, whatever friction, drag, sag or heat subtract, and settles at a held
//! voltage. A counter that is too slow for its edges violates both: beyond its maximum rate it counts less the faster
//! the shaft turns (a non-paralysable or paralysable detector: Knoll, Radiation Detection and Measurement, 2010,
//! chapter 4 VII). Three patterns, the first two in one run, the third over several runs of a motor:
//!
//! - at a held command the rate rises to a peak, then falls within the rise time and stays there;
//! - after a step of the command towards zero the rate rises;
//! - the steady rate at a higher command is lower than at lower ones.
//!
//! Excluded: a slow fall (heat), a fall to zero (end stop), oscillation (load, spring, second order), a changing
//! command (controller, chirp) and a rate that saturates (driver at its limit). An interval of held command therefore
//! begins with a step.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;
use super::words::{digits, time};
use crate::motor::CommandKind;

/// A command is held while it varies by less than this share of the largest: a PWM step of 8 bits is 0.4 %, a
/// measured supply varies by 1 %.
const HOLDS: f64 = 0.02;
/// Most time bins of an interval of held command.
const SLOTS: usize = 120;
/// Fewest bins, and least count of the fastest one: quantization is then 5 % of it.
const LEAST_BINS: usize = 12;
const BIN_COUNTS: f64 = 20.0;
/// Least fall from the peak: less may be the overshoot of a second order (damping 0.33, electrical time constant
/// twice the mechanical one).
const FALL: f64 = 0.25;
/// Longest fall in rise times: heating takes far longer.
const LONGEST_FALL: f64 = 3.0;
/// Largest variation afterwards as a share of the fall, which an oscillation exceeds.
const STAYS: f64 = 0.25;
/// Below this share of the peak an end stop holds the shaft.
const END_STOP: f64 = 0.02;
/// A rate is steady if it varies by less than this share in the last third.
const STEADY: f64 = 0.05;
/// Least difference between two commands, and between two rates.
pub(super) const DIFFERS: f64 = 0.05;
/// Least fall below the rate of a lower command: a sagging supply under a driver at its limit causes less.
const FALLS: f64 = 0.1;
/// Least step at the beginning of a held command, as a share of the largest: a held crest of a sine has none.
const JUMPS: f64 = 0.05;

/// An interval of held command and its rates.
#[derive(Debug, Clone)]
pub(super) struct Hold {
    /// Numbers of its first and last sample.
    pub from: usize,
    pub to: usize,
    /// The command, as it is.
    pub command: f64,
    /// Middle of each bin in s, and its rate in counts/s in the direction of the command.
    bins: Vec<(f64, f64)>,
}

/// A steady rate at a command.
#[derive(Debug, Clone, Copy)]
struct Level<'a> {
    subject: &'a Subject<'a>,
    interval: (usize, usize),
    command: f64,
    rate: f64,
}

pub(super) fn find(subjects: &[Subject<'_>]) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut levels = Vec::new();
    for subject in subjects {
        if subject.run.command_kind != CommandKind::Voltage || !subject.has("command") {
            continue;
        }
        let holds = holds(subject);
        let before = found.len();
        found.extend(holds.iter().filter_map(|hold| falls(subject, hold)).take(1));
        if found.len() == before {
            let pairs = holds.windows(2);
            found.extend(pairs.filter_map(|pair| rises(subject, pair)).take(1));
        }
        levels.extend(holds.iter().filter_map(|hold| level(subject, hold)));
    }
    for direction in [1.0, -1.0] {
        let mut same: Vec<Level<'_>> = (levels.iter())
            .filter(|level| level.command * direction > 0.0)
            .copied()
            .collect();
        same.sort_by(|a, b| a.command.abs().total_cmp(&b.command.abs()));
        for finding in stops(&same) {
            if found.iter().all(|other: &Finding| other.run != finding.run) {
                found.push(finding);
            }
        }
    }
    found
}

pub(super) fn holds(subject: &Subject<'_>) -> Vec<Hold> {
    let run = subject.run;
    let largest = run
        .command
        .iter()
        .fold(0.0_f64, |most, u| most.max(u.abs()));
    let mut found = Vec::new();
    let mut from = 0;
    for k in 1..=run.len() {
        if k < run.len() && (run.command[k] - run.command[from]).abs() <= HOLDS * largest {
            continue;
        }
        // A command holds until the next sample.
        let to = k.min(run.len() - 1);
        let has_jumped =
            from == 0 || (run.command[from] - run.command[from - 1]).abs() >= JUMPS * largest;
        if has_jumped && let Some(bins) = bins(subject, from, to) {
            found.push(Hold {
                from,
                to,
                command: run.command[from],
                bins,
            });
        }
        from = k;
    }
    found
}

/// The rates of an interval in as many bins as quantization allows.
fn bins(subject: &Subject<'_>, from: usize, to: usize) -> Option<Vec<(f64, f64)>> {
    let run = subject.run;
    let steps = to - from;
    let mut many = SLOTS.min(steps);
    while many >= LEAST_BINS {
        let mut most = 0_u64;
        let bins: Vec<(f64, f64)> = (0..many)
            .map(|bin| {
                let (a, b) = (from + bin * steps / many, from + (bin + 1) * steps / many);
                most = most.max(run.counts[b].abs_diff(run.counts[a]));
                let counts = run.counts[b].saturating_sub(run.counts[a]) as f64;
                let middle_s = 0.5 * (run.t_s[a] + run.t_s[b]);
                (middle_s, counts / (run.t_s[b] - run.t_s[a]))
            })
            .collect();
        if most as f64 >= BIN_COUNTS {
            return Some(bins);
        }
        many /= 2;
    }
    None
}

/// The rate of the last third, if it is steady.
pub(super) fn steady(hold: &Hold) -> Option<f64> {
    let last = &hold.bins[2 * hold.bins.len() / 3..];
    let mean = last.iter().map(|bin| bin.1).sum::<f64>() / last.len() as f64;
    let varies = last
        .iter()
        .map(|bin| (bin.1 - mean).abs())
        .fold(0.0, f64::max);
    let moves = hold.bins.iter().map(|bin| bin.1.abs()).fold(0.0, f64::max);
    (varies <= STEADY * mean.abs() && mean.abs() > END_STOP * moves).then_some(mean)
}

/// A rate that peaks under a held command, falls and stays low.
fn falls(subject: &Subject<'_>, hold: &Hold) -> Option<Finding> {
    let run = subject.run;
    let direction = hold.command.signum();
    // The fall must not be the run-out from a previous higher command.
    let mut before = run.command[..hold.from].iter();
    if hold.command == 0.0 || before.any(|u| direction * u > (1.0 + DIFFERS) * hold.command.abs()) {
        return None;
    }
    let rates: Vec<(f64, f64)> = (hold.bins.iter())
        .map(|&(at_s, rate)| (at_s, direction * rate))
        .collect();
    let peak_at = (0..rates.len()).max_by(|&a, &b| rates[a].1.total_cmp(&rates[b].1))?;
    let peak = rates[peak_at].1;
    let mut last: Vec<f64> = rates[2 * rates.len() / 3..]
        .iter()
        .map(|bin| bin.1)
        .collect();
    last.sort_by(f64::total_cmp);
    let settled = last[last.len() / 2];
    let fall = peak - settled;
    if fall < FALL * peak || settled < END_STOP * peak || rates[0].1 > 0.9 * peak {
        return None;
    }
    let start_s = run.t_s[hold.from];
    let rise_s = rates.iter().find(|bin| bin.1 >= 0.9 * peak)?.0 - start_s;
    let down = &rates[peak_at..];
    let still_up = down
        .iter()
        .take_while(|bin| bin.1 >= peak - 0.1 * fall)
        .last()?;
    let there = down
        .iter()
        .position(|bin| bin.1 <= settled + STAYS * fall)?;
    let stays = down[there..]
        .iter()
        .all(|bin| (bin.1 - settled).abs() <= STAYS * fall);
    let falls_in_s = down[there].0 - still_up.0;
    let stays_for_s = run.t_s[hold.to] - down[there].0;
    // Within one turn an unbalanced load causes the same pattern.
    let counts_there = settled * stays_for_s;
    if !stays
        || counts_there < run.counts_per_rev
        || falls_in_s > LONGEST_FALL * rise_s
        || stays_for_s < rise_s
    {
        return None;
    }
    Some(subject.finding(
        Kind::EdgesLostAtSpeed,
        Severity::Warning,
        (hold.from, hold.to),
        format!(
            "the rate of counts rises to {} counts/s and falls to {} within {} while the command holds at {} V",
            digits(peak, 4),
            digits(settled, 4),
            time(falls_in_s),
            digits(hold.command, 4),
        ),
        [
            ("peak_counts_per_s", peak),
            ("settled_counts_per_s", settled),
            ("lost_share", fall / peak),
            ("rise_s", rise_s),
            ("fall_s", falls_in_s),
            ("command_v", hold.command),
        ],
        remedy(peak),
    ))
}

/// A rate that rises after a step of the command towards zero.
fn rises(subject: &Subject<'_>, pair: &[Hold]) -> Option<Finding> {
    let [first, second] = pair else { return None };
    let run = subject.run;
    let direction = first.command.signum();
    let taken_back = second.from <= first.to
        && second.command * direction >= 0.0
        && second.command.abs() < (1.0 - 2.0 * DIFFERS) * first.command.abs();
    if !taken_back {
        return None;
    }
    let rate = direction * steady(first).filter(|rate| rate * direction > 0.0)?;
    let mut after = second.bins.iter().map(|bin| direction * bin.1);
    let peak = after.clone().fold(0.0, f64::max);
    let last = after.next_back()?;
    // Within one turn an unbalanced load causes the same pattern.
    let passed = run.counts[second.to].abs_diff(run.counts[second.from]) as f64;
    if passed < run.counts_per_rev {
        return None;
    }
    // A falling load keeps accelerating.
    if peak < (1.0 + FALL) * rate || last > rate {
        return None;
    }
    Some(subject.finding(
        Kind::EdgesLostAtSpeed,
        Severity::Warning,
        (first.from, second.to),
        format!(
            "the rate of counts rises from {} to {} counts/s after the command is taken back from {} to {} V at {:.3} s",
            digits(rate, 4),
            digits(peak, 4),
            digits(first.command, 4),
            digits(second.command, 4),
            run.t_s[second.from],
        ),
        [
            ("steady_counts_per_s", rate),
            ("peak_counts_per_s", peak),
            ("lost_share", 1.0 - rate / peak),
            ("command_v", first.command),
            ("command_after_v", second.command),
        ],
        remedy(peak),
    ))
}

/// The steady rate of a held command; runs with known different loads are not compared.
fn level<'a>(subject: &'a Subject<'a>, hold: &Hold) -> Option<Level<'a>> {
    if subject.run.header.contains_key("differs") {
        return None;
    }
    let rate = steady(hold)? * hold.command.signum();
    (rate > 0.0 && hold.command != 0.0).then_some(Level {
        subject,
        interval: (hold.from, hold.to),
        command: hold.command,
        rate,
    })
}

/// Levels, by rising command, at which the rate is below that of lower ones.
fn stops(levels: &[Level<'_>]) -> Vec<Finding> {
    let mut found = Vec::new();
    // Commands with rising rates, and the gain of the last step up in counts/s/V.
    let mut good: Vec<(f64, f64)> = Vec::new();
    let mut from = 0;
    while from < levels.len() {
        let command = levels[from].command.abs();
        let to = from
            + levels[from..]
                .partition_point(|level| level.command.abs() <= (1.0 + DIFFERS) * command);
        let same = &levels[from..to];
        from = to;
        // The fastest repetition: a slower one may have been obstructed.
        let rate = same.iter().map(|level| level.rate).fold(0.0, f64::max);
        let [.., (u0, r0), (u1, r1)] = good[..] else {
            good.push((command, rate));
            continue;
        };
        let gain = (r1 - r0) / (u1 - u0);
        let expected = r1 + gain * (command - u1);
        if gain <= 0.0 || rate >= (1.0 - FALLS) * r1 {
            if rate > r1 {
                good.push((command, rate));
            }
            continue;
        }
        found.extend(same.iter().map(|level| {
            level.subject.finding(
                Kind::EdgesLostAtSpeed,
                Severity::Warning,
                level.interval,
                format!(
                    "at {} V there are {} counts/s, where {} would follow from {} at {} V and {} at {} V: the rate falls while the command rises",
                    digits(level.command, 4),
                    digits(level.rate, 4),
                    digits(expected, 4),
                    digits(r0, 4),
                    digits(u0, 4),
                    digits(r1, 4),
                    digits(u1, 4),
                ),
                [
                    ("counts_per_s", level.rate),
                    ("expected_counts_per_s", expected),
                    ("lost_share", 1.0 - level.rate / expected),
                    ("command_v", level.command),
                    ("lower_command_v", u1),
                    ("lower_counts_per_s", r1),
                ],
                remedy(r1.max(rate)),
            )
        }));
    }
    found
}

fn remedy(rate: f64) -> String {
    format!(
        "the counter is too slow for more than some {} edges/s: count in hardware (a timer's encoder mode, a counter chip), decode fewer edges a turn, or stay below that speed; a driver that is at its limit gives no more speed either",
        digits(rate, 2)
    )
}
