//! Where the command jumps from one held level to another, and how far the counts have gone from where they would have been without.
//!
//! Before the jump the shaft rests or turns steadily; a straight line through those positions says where it would be afterwards,
//! and how surely (linear regression's prediction). Motion beyond it is the response to the jump.

use super::gap_in_time::pauses;
use crate::recording::Run;
use crate::units::ROUNDING_VARIANCE as ROUNDING;

/// A jump is at least this share of the largest command.
const JUMPS: f64 = 0.2;
/// A command holds while it stays within this share of the largest: a PWM step of 8 bits is 0.4 %, a measured supply varies by 1 %.
const HOLDS: f64 = 0.02;
/// Samples before the jump in which the shaft may already answer, where the command is late in its column.
pub(super) const MOST_LATE: usize = 4;
/// Positions of the line, at least and at most.
const LEAST_LINE: usize = 9;
const MOST_LINE: usize = 41;
/// Steps after the jump that are looked at, at least and at most.
const LEAST_AFTER: usize = 4;
pub(super) const MOST_AFTER: usize = 60;
/// The answer passes so many counts, and beside them so many standard errors of the line.
const ANSWER_COUNTS: f64 = 10.0;
const ANSWER_ERRORS: f64 = 10.0;
/// Most jumps of a run that are looked at.
const MOST_JUMPS: usize = 200;

/// One jump of the command, and the answer.
#[derive(Debug)]
pub(super) struct Jump {
    /// Number of the first sample with the new command.
    pub at: usize,
    /// Of the sample of the jump, those after it and the few before it that the line leaves out: time from the jump in s, and counts
    /// beyond the line in the direction of the answer.
    pub answer: Vec<(f64, f64)>,
    /// Counts beyond the line when the command jumps, and their standard error.
    pub ahead: (f64, f64),
    /// Speed before in counts/s, in the direction of the answer.
    pub speed_counts_s: f64,
}

/// Every jump of a run from rest or steady turning, and at most so many steps after it (`most_after`). Counts that are uncertain by so
/// many samples (`slack`) are ahead only where they were before. The command in a pause is not known, so that line and answer end
/// at one.
pub(super) fn jumps(run: &Run, slack: usize, most_after: usize) -> Vec<Jump> {
    let sizes = run.command.iter().map(|u| u.abs());
    let largest = sizes.fold(0.0_f64, f64::max);
    let apart = |a: usize, b: usize| (run.command[a] - run.command[b]).abs();
    let same = |a: usize, b: usize| apart(a, b) <= HOLDS * largest;
    let pauses: Vec<usize> = pauses(run).iter().map(|pause| pause.before).collect();
    // The samples around one that no pause divides.
    let undivided = |at: usize| {
        let next = pauses.partition_point(|before| *before < at);
        let from = next.checked_sub(1).map_or(0, |last| pauses[last] + 1);
        from..pauses.get(next).map_or(run.len(), |before| before + 1)
    };
    (1..run.len())
        .filter(|&at| largest > 0.0 && apart(at, at - 1) >= JUMPS * largest)
        .filter_map(|at| {
            let whole = undivided(at);
            let held_before = (at.saturating_sub(MOST_LATE + MOST_LINE).max(whole.start)..at)
                .rev()
                .take_while(|&k| same(k, at - 1))
                .count();
            let held_after = (at..whole.end.min(at + most_after))
                .take_while(|&k| same(k, at))
                .count();
            // A command is in force until the sample after it.
            let end = (at + held_after).min(whole.end - 1);
            let line = held_before.checked_sub(MOST_LATE)?;
            let is_long_enough = line >= LEAST_LINE && end - at >= LEAST_AFTER;
            is_long_enough.then(|| answer(run, at, line, end, slack))?
        })
        .take(MOST_JUMPS)
        .collect()
}

/// Counts from the jump on, minus a line through the `line` positions before.
fn answer(run: &Run, at: usize, line: usize, end: usize, slack: usize) -> Option<Jump> {
    let position = |k: usize| run.counts[k].saturating_sub(run.counts[at]) as f64;
    let time_s = |k: usize| run.t_s[k] - run.t_s[at];
    let last = at - MOST_LATE;
    let before = last + 1 - line..=last;
    let n = line as f64;
    let mean_t = before.clone().map(time_s).sum::<f64>() / n;
    let mean_p = before.clone().map(position).sum::<f64>() / n;
    let (mut tt, mut tp, mut t3, mut t4) = (0.0, 0.0, 0.0, 0.0);
    for k in before.clone() {
        let t = time_s(k) - mean_t;
        tt += t * t;
        tp += t * (position(k) - mean_p);
        t3 += t.powi(3);
        t4 += t.powi(4);
    }
    let speed = tp / tt;
    let on_line = |t: f64| mean_p + speed * (t - mean_t);
    // A bend of the line: the part of t^2 that mean and line do not have, and what it makes at the jump.
    let square = |t: f64| t * t - tt / n - t3 / tt * t;
    let (mut left, mut bent) = (0.0, 0.0);
    for k in before {
        let rest = position(k) - on_line(time_s(k));
        left += rest * rest;
        bent += square(time_s(k) - mean_t) * rest;
    }
    let bend = (bent / (t4 - tt * tt / n - t3 * t3 / tt) * square(-mean_t)).abs();
    let variance = (left / (n - 2.0)).max(ROUNDING);
    let error = |t: f64| (variance * (1.0 + 1.0 / n + (t - mean_t).powi(2) / tt)).sqrt();
    let gone = position(end) - on_line(time_s(end));
    let is_answer = gone.abs() >= ANSWER_COUNTS + ANSWER_ERRORS * error(time_s(end));
    // A shaft that is still speeding up or running down has no line.
    let is_straight = bend <= 2.0 * error(0.0);
    let beyond = |k: usize| gone.signum() * (position(k) - on_line(time_s(k)));
    (is_answer && is_straight).then(|| Jump {
        at,
        answer: (last + 1..=end).map(|k| (time_s(k), beyond(k))).collect(),
        ahead: (beyond(at - slack), error(time_s(at - slack)) + bend),
        speed_counts_s: gone.signum() * speed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rest, then 10 counts a sample from the sample 50 on; a pause of 20 samples before this sample.
    fn run(pause: usize) -> Run {
        let t = |k: usize| (if k < pause { k } else { k + 20 }) as f64;
        Run {
            counts_per_rev: 100.0,
            t_s: (0..120).map(|k| 0.01 * t(k)).collect(),
            command: (0..120).map(|k| if k < 50 { 0.0 } else { 6.0 }).collect(),
            counts: (0..120)
                .map(|k| (10.0 * (t(k) - t(50))).max(0.0) as i64)
                .collect(),
            ..Run::default()
        }
    }

    #[test]
    fn what_a_pause_divides_is_no_jump_and_no_answer() {
        // In the jump, right after it, and so soon before it that no line is left.
        for pause in [50, 51, 53, 40] {
            assert!(jumps(&run(pause), 0, MOST_AFTER).is_empty(), "{pause}");
        }
        let answer = |pause: usize| jumps(&run(pause), 0, MOST_AFTER)[0].answer.len();
        assert_eq!(answer(20), answer(120));
        assert_eq!(answer(70), answer(120) - (110 - 69));
    }
}
