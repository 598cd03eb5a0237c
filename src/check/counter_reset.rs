//! A counter that is reset to 0 during a run.
//!
//! The position jumps in one sample to 0 or to its initial value and stays there, while the steps on either side are
//! those of steady motion. Jumps by the counter's range belong to [`counter_wrap`](super::counter_wrap), jumps that
//! return to [`misread_position`](super::misread_position).

use super::counter_wrap::BITS;
use super::finding::{Finding, Kind, Severity};
use super::misread_position::misread_positions;
use super::subject::Subject;
use super::words::digits;
use crate::recording::Run;

/// Samples before and after the jump from which the speed there is estimated, and the fewest on either side.
const BESIDE: usize = 8;
const LEAST_BESIDE: usize = 3;
/// Least size of the jump: as a multiple of the largest neighbouring step, and in counts.
const LEAPS: f64 = 5.0;
const LEAST_COUNTS: f64 = 10.0;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Reset {
    /// Number of the first sample after the reset.
    at: usize,
    /// Size of the jump in counts.
    leap: f64,
    /// The largest neighbouring step in counts.
    beside: f64,
}

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    if !subject.has("position") {
        return Vec::new();
    }
    let resets = resets(run);
    let Some(first) = resets.first() else {
        return Vec::new();
    };
    let more = match resets.len() {
        1 => String::new(),
        times => format!("; {times} times in all"),
    };
    vec![subject.finding(
        Kind::CounterReset,
        Severity::Fatal,
        (first.at - 1, resets[resets.len() - 1].at),
        format!(
            "the counter is set to {} in mid-run: it goes from {} to {} counts between {:.3} and {:.3} s, and by {} counts a sample at most beside that{more}",
            run.counts[first.at],
            run.counts[first.at - 1],
            run.counts[first.at],
            run.t_s[first.at - 1],
            run.t_s[first.at],
            digits(first.beside, 3),
        ),
        [
            ("leap_counts", first.leap),
            ("largest_step_beside_counts", first.beside),
            ("first_after_sample", first.at as f64),
            ("resets", resets.len() as f64),
        ],
        format!(
            "cut the run at {:.3} s into two, or add {} to the counts from there on",
            run.t_s[first.at], -first.leap
        ),
    )]
}

fn resets(run: &Run) -> Vec<Reset> {
    let misread = misread_positions(run);
    let is_misread = |k: usize| misread.binary_search(&k).is_ok();
    let mut found: Vec<Reset> = Vec::new();
    for at in LEAST_BESIDE..run.len().saturating_sub(LEAST_BESIDE) {
        let step = difference(run, at);
        let lands_at = |count: i64, most: f64| {
            run.counts[at].abs_diff(count) as f64 <= most
                && run.counts[at - 1].abs_diff(count) as f64 > most
        };
        if step.abs() < LEAST_COUNTS || is_misread(at) || is_misread(at - 1) {
            continue;
        }
        // Another reset nearby, as of a bouncing switch, is not motion.
        let lasts_s = run.t_s[at] - run.t_s[at - 1];
        let beside = (at.saturating_sub(BESIDE).max(1)..run.len().min(at + BESIDE + 1))
            .filter(|&k| k != at)
            .map(|k| {
                let longer = lasts_s / (run.t_s[k] - run.t_s[k - 1]);
                difference(run, k).abs() * longer.max(1.0)
            })
            .fold(1.0, f64::max);
        let lands = lands_at(0, beside) || lands_at(run.counts[0], beside);
        if lands && step.abs() > LEAPS * beside && !is_range(run, step.abs(), beside) {
            found.push(Reset {
                at,
                leap: step,
                beside,
            });
        }
    }
    found
}

/// Whether a jump is a counter range of some width in bits, or one turn, up to the motion in the same sample.
fn is_range(run: &Run, leap: f64, motion: f64) -> bool {
    let widths = BITS.map(|bits| f64::from(bits).exp2());
    let mut ranges = widths.chain([run.counts_per_rev]);
    ranges.any(|range| (leap - range).abs() <= motion + 1.0)
}

fn difference(run: &Run, k: usize) -> f64 {
    run.counts[k] as f64 - run.counts[k - 1] as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(count: impl Fn(i64) -> i64) -> Run {
        Run {
            counts_per_rev: 720.0,
            t_s: (0..400).map(|k| 0.003 * f64::from(k)).collect(),
            counts: (0..400).map(count).collect(),
            ..Run::default()
        }
    }

    #[test]
    fn a_counter_that_is_set_to_0_is_found_at_any_speed() {
        let of = |run: &Run| resets(run).iter().map(|r| r.at).collect::<Vec<_>>();
        for per_sample in [0, 1, 7, -40] {
            let sound = run(|k| 1000 + per_sample * k);
            assert_eq!(of(&sound), [0; 0], "{per_sample}");
            let reset =
                run(|k| per_sample * if k < 150 { k } else { k - 150 } + 300 * i64::from(k < 150));
            assert_eq!(of(&reset), [150], "{per_sample}");
        }
        // Slow motion with two resets.
        assert_eq!(of(&run(|k| (k % 190) / 3)), [190, 380]);
    }

    #[test]
    fn wraps_and_reversals_are_no_resets() {
        for range in [256_i64, 720, 65_536] {
            let round = run(|k| (range - 100 + 3 * k).rem_euclid(range));
            assert_eq!(resets(&round), [], "{range}");
        }
        let misread = run(|k| if k == 77 { 0 } else { 5000 + 30 * k });
        assert_eq!(resets(&misread), []);
        let back_and_forth = run(|k| 30 * (200 - (k - 200).abs()));
        assert_eq!(resets(&back_and_forth), []);
    }
}
