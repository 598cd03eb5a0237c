//! Step responses: the counts after a step of the command relative to the extrapolated motion before it.
//!
//! Before the step the shaft rests or turns steadily. A straight line through those positions is extrapolated with
//! its standard error (prediction of linear regression); the difference is the response.

use super::gap_in_time::pauses;
use crate::recording::Run;
use crate::units::ROUNDING_VARIANCE as ROUNDING;

/// Least step as a share of the largest command.
const JUMPS: f64 = 0.2;
/// A command is held while it varies by less than this share of the largest: a PWM step of 8 bits is 0.4 %, a
/// measured supply varies by 1 %.
const HOLDS: f64 = 0.02;
/// Samples before the step that may already contain the response, if the command column is late.
pub(super) const MOST_LATE: usize = 4;
/// Fewest and most positions of the line.
const LEAST_LINE: usize = 9;
const MOST_LINE: usize = 41;
/// Fewest and most samples examined after the step.
const LEAST_AFTER: usize = 4;
pub(super) const MOST_AFTER: usize = 60;
/// Least response in counts, plus so many standard errors of the line.
const ANSWER_COUNTS: f64 = 10.0;
const ANSWER_ERRORS: f64 = 10.0;
/// Most steps examined in a run.
const MOST_JUMPS: usize = 200;

/// One step of the command and its response.
#[derive(Debug)]
pub(super) struct Jump {
    /// Number of the first sample with the new command.
    pub at: usize,
    /// Response: time from the step in s, and counts beyond the line in the direction of the response; begins with
    /// the few samples before the step that the line leaves out.
    pub answer: Vec<(f64, f64)>,
    /// Response at the time of the step in counts, and its standard error.
    pub ahead: (f64, f64),
    /// Speed before the step in counts/s, in the direction of the response.
    pub speed_counts_s: f64,
}

/// Every step of a run from rest or steady turning, with at most `most_after` samples after it. Counts that are
/// uncertain by `slack` samples are ahead only if they were so earlier. In a pause the command is unknown, so that
/// line and response end there.
pub(super) fn jumps(run: &Run, slack: usize, most_after: usize) -> Vec<Jump> {
    let sizes = run.command.iter().map(|u| u.abs());
    let largest = sizes.fold(0.0_f64, f64::max);
    let apart = |a: usize, b: usize| (run.command[a] - run.command[b]).abs();
    let same = |a: usize, b: usize| apart(a, b) <= HOLDS * largest;
    let pauses: Vec<usize> = pauses(run).iter().map(|pause| pause.before).collect();
    // The samples around this one up to the next pauses.
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
            // A command holds until the next sample.
            let end = (at + held_after).min(whole.end - 1);
            let line = held_before.checked_sub(MOST_LATE)?;
            let is_long_enough = line >= LEAST_LINE && end - at >= LEAST_AFTER;
            is_long_enough.then(|| answer(run, at, line, end, slack))?
        })
        .take(MOST_JUMPS)
        .collect()
}

/// Counts from the step on, minus a line through the `line` positions before it.
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
    // Curvature of the line: the part of t^2 orthogonal to constant and slope, and its value at the step.
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
    // An accelerating or decelerating shaft has no line.
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

    /// Rest, then 10 counts a sample from sample 50 on; a pause of 20 samples before this sample.
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
        // In the step, right after it, and so shortly before it that no line is left.
        for pause in [50, 51, 53, 40] {
            assert!(jumps(&run(pause), 0, MOST_AFTER).is_empty(), "{pause}");
        }
        let answer = |pause: usize| jumps(&run(pause), 0, MOST_AFTER)[0].answer.len();
        assert_eq!(answer(20), answer(120));
        assert_eq!(answer(70), answer(120) - (110 - 69));
    }
}
