//! Step responses: the counts after a step of the command relative to the extrapolated motion before it.
//!
//! Before the step the shaft rests or turns steadily. A straight line through those positions is extrapolated with
//! its standard error (prediction of linear regression); the difference is the response.

use super::gap_in_time::pauses;
use crate::recording::Run;
use crate::units::ROUNDING_VARIANCE as ROUNDING;

/// Least step as a share of the largest command.
const LEAST_STEP: f64 = 0.2;
/// A command is held while it varies by less than this share of the largest: a PWM step of 8 bits is 0.4 %, a
/// measured supply varies by 1 %.
const HELD_WITHIN: f64 = 0.02;
/// Samples before the step that may already contain the response, if the command column is late.
pub(super) const MOST_LATE: usize = 4;
/// Fewest and most positions of the line.
const LEAST_LINE: usize = 9;
const MOST_LINE: usize = 41;
/// Fewest and most samples examined after the step.
const LEAST_AFTER: usize = 4;
pub(super) const MOST_AFTER: usize = 60;
/// Least response in counts, plus so many standard errors of the line.
const LEAST_RESPONSE_COUNTS: f64 = 10.0;
const LEAST_RESPONSE_ERRORS: f64 = 10.0;
/// Most steps examined in a run.
const MOST_STEPS: usize = 200;

/// One step of the command and its response.
#[derive(Debug)]
pub(super) struct StepResponse {
    /// Number of the first sample with the new command.
    pub at: usize,
    /// Response: time from the step in s, and counts beyond the line in the direction of the response; begins with
    /// the few samples before the step that the line leaves out.
    pub response: Vec<(f64, f64)>,
    /// Response at the time of the step in counts, and its standard error.
    pub at_step: (f64, f64),
    /// Speed before the step in counts/s, in the direction of the response.
    pub speed_counts_s: f64,
}

/// Every step of a run from rest or steady turning, with at most `most_after` samples after it. Counts that are
/// uncertain by `slack` samples are ahead only if they were so earlier. In a pause the command is unknown, so that
/// line and response end there.
pub(super) fn step_responses(run: &Run, slack: usize, most_after: usize) -> Vec<StepResponse> {
    let sizes = run.command.iter().map(|u| u.abs());
    let largest = sizes.fold(0.0_f64, f64::max);
    let difference = |a: usize, b: usize| (run.command[a] - run.command[b]).abs();
    let is_held = |a: usize, b: usize| difference(a, b) <= HELD_WITHIN * largest;
    let pauses: Vec<usize> = pauses(run).iter().map(|pause| pause.before).collect();
    // The samples around this one up to the next pauses.
    let between_pauses = |at: usize| {
        let next = pauses.partition_point(|before| *before < at);
        let from = next.checked_sub(1).map_or(0, |last| pauses[last] + 1);
        from..pauses.get(next).map_or(run.len(), |before| before + 1)
    };
    (1..run.len())
        .filter(|&at| largest > 0.0 && difference(at, at - 1) >= LEAST_STEP * largest)
        .filter_map(|at| {
            let range = between_pauses(at);
            let held_before = (at.saturating_sub(MOST_LATE + MOST_LINE).max(range.start)..at)
                .rev()
                .take_while(|&k| is_held(k, at - 1))
                .count();
            let held_after = (at..range.end.min(at + most_after))
                .take_while(|&k| is_held(k, at))
                .count();
            // A command holds until the next sample.
            let end = (at + held_after).min(range.end - 1);
            let line = held_before.checked_sub(MOST_LATE)?;
            let is_long_enough = line >= LEAST_LINE && end - at >= LEAST_AFTER;
            is_long_enough.then(|| response_after(run, at, line, end, slack))?
        })
        .take(MOST_STEPS)
        .collect()
}

/// Counts from the step on, minus a line through the `line` positions before it.
fn response_after(
    run: &Run,
    at: usize,
    line: usize,
    end: usize,
    slack: usize,
) -> Option<StepResponse> {
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
    let (mut residual, mut curvature) = (0.0, 0.0);
    for k in before {
        let rest = position(k) - on_line(time_s(k));
        residual += rest * rest;
        curvature += square(time_s(k) - mean_t) * rest;
    }
    let curvature_at_step = (curvature / (t4 - tt * tt / n - t3 * t3 / tt) * square(-mean_t)).abs();
    let variance = (residual / (n - 2.0)).max(ROUNDING);
    let error = |t: f64| (variance * (1.0 + 1.0 / n + (t - mean_t).powi(2) / tt)).sqrt();
    let change = position(end) - on_line(time_s(end));
    let is_response =
        change.abs() >= LEAST_RESPONSE_COUNTS + LEAST_RESPONSE_ERRORS * error(time_s(end));
    // An accelerating or decelerating shaft has no line.
    let is_straight = curvature_at_step <= 2.0 * error(0.0);
    let beyond = |k: usize| change.signum() * (position(k) - on_line(time_s(k)));
    (is_response && is_straight).then(|| StepResponse {
        at,
        response: (last + 1..=end).map(|k| (time_s(k), beyond(k))).collect(),
        at_step: (
            beyond(at - slack),
            error(time_s(at - slack)) + curvature_at_step,
        ),
        speed_counts_s: change.signum() * speed,
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
    fn a_step_response_ends_at_a_pause() {
        // In the step, right after it, and so shortly before it that no line is left.
        for pause in [50, 51, 53, 40] {
            assert!(
                step_responses(&run(pause), 0, MOST_AFTER).is_empty(),
                "{pause}"
            );
        }
        let samples = |pause: usize| step_responses(&run(pause), 0, MOST_AFTER)[0].response.len();
        assert_eq!(samples(20), samples(120));
        assert_eq!(samples(70), samples(120) - (110 - 69));
    }
}
