//! Counters that wrapped and were not unwrapped, or that may have wrapped unnoticed in a pause.
//!
//! A counter of `n` bits is known up to multiples of its range `M = 2^n`. It wrapped where the counts jump by about
//! `M`, stay inside a range of `M`, and are smooth motion after subtracting `M` (phase unwrapping: Oppenheim and
//! Schafer, Discrete-Time Signal Processing, 2010, section 13.6). In a pause in which the shaft can turn by more than
//! `M / 2` the number of wraps is not determined.

use super::finding::{Finding, Kind, Severity};
use super::gap_in_time::pauses;
use super::subject::Subject;
use super::words::time;
use crate::recording::Run;

/// Counter widths in bits: 8 is the smallest of a microcontroller, 12 and 24 are those of absolute encoders and
/// counter chips, 32 is a `long`.
pub(super) const BITS: std::ops::RangeInclusive<u32> = 8..=32;
/// The remainder of an unwrapped jump is motion if it is at most this multiple of the largest step elsewhere.
const MOTION: f64 = 2.0;
/// Largest ratio of the squared second differences after and before unwrapping. A false correction by `M` adds `2
/// M^2`.
const SMOOTHER: f64 = 0.1;
/// Jumps of an unusual range agree within this share, and are at least this many.
const AGREE: f64 = 0.02;
const LEAST_LEAPS: usize = 3;
/// Range of the counters that the recorder flags after a gap: 16 bits.
const RANGE_OF_FLAG: f64 = 65_536.0;
/// A step beyond half the range is shorter in the other direction.
const HALF: f64 = 0.5;

#[derive(Debug, Clone, PartialEq)]
struct Round {
    range: f64,
    /// Numbers of the samples before each wrap.
    before: Vec<usize>,
}

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let round = round(run);
    let mut found: Vec<Finding> = round.iter().map(|round| wraps(subject, round)).collect();
    let range = stated_range(run).or(round.map(|round| round.range));
    let range = range.or_else(|| is_flagged_over_gap(run).then_some(RANGE_OF_FLAG));
    found.extend(range.and_then(|range| over_gaps(subject, range)));
    found
}

fn wraps(subject: &Subject<'_>, round: &Round) -> Finding {
    let run = subject.run;
    let (lowest, highest) = extremes(&run.counts);
    let first = round.before[0];
    let last = round.before[round.before.len() - 1];
    let kind = match round.range.log2() {
        bits if bits.fract() == 0.0 => format!(
            "a counter of {bits} bits{}",
            if lowest < 0 { ", signed" } else { "" }
        ),
        _ => format!("a counter of {} counts", round.range),
    };
    subject.finding(
        Kind::CounterWrap,
        Severity::Warning,
        (first, last + 1),
        format!(
            "the counts leap {} times by {} and stay between {lowest} and {highest}: {kind} wraps, first from {} to {} between samples {} and {}",
            round.before.len(),
            round.range,
            run.counts[first],
            run.counts[first + 1],
            first + 1,
            first + 2,
        ),
        [
            ("range_counts", round.range),
            ("leaps", round.before.len() as f64),
            ("first_after_sample", first as f64 + 1.0),
            ("lowest_counts", lowest as f64),
            ("highest_counts", highest as f64),
        ],
        format!(
            "--wrap {0} of the import, or `wrap = {0}` in [position] of its mapping (in the column's own numbers), or count in 32 bits (`long`) on the board",
            round.range
        ),
    )
}

/// The counter that wraps in these counts, if any.
fn round(run: &Run) -> Option<Round> {
    let (lowest, highest) = extremes(&run.counts);
    let span = highest as f64 - lowest as f64;
    let widths = BITS.map(|bits| f64::from(bits).exp2());
    let turn = Some(run.counts_per_rev.round());
    let candidates = widths.chain(turn).chain(unusual(run, span));
    let mut fitting: Vec<f64> = candidates
        .filter(|range| *range > span && *range < 2.0 * span + 2.0)
        .collect();
    fitting.sort_by(f64::total_cmp);
    fitting.into_iter().find_map(|range| leaps(run, range))
}

/// The wraps by this range, if unwrapping makes the motion smooth.
fn leaps(run: &Run, range: f64) -> Option<Round> {
    let raw: Vec<f64> = (run.counts.windows(2))
        .map(|pair| pair[1] as f64 - pair[0] as f64)
        .collect();
    let leap = |step: f64| step.abs() > HALF * range;
    let straight: Vec<f64> = (raw.iter())
        .map(|&step| {
            if leap(step) {
                step - range * step.signum()
            } else {
                step
            }
        })
        .collect();
    let before: Vec<usize> = (0..raw.len()).filter(|&k| leap(raw[k])).collect();
    let largest = (raw.iter())
        .filter(|step| !leap(**step))
        .fold(1.0_f64, |most, step| most.max(step.abs()));
    let motion = before
        .iter()
        .all(|&k| straight[k].abs() <= MOTION * largest);
    let smooth = roughness(&straight) < SMOOTHER * roughness(&raw);
    (!before.is_empty() && motion && smooth).then_some(Round { range, before })
}

fn roughness(steps: &[f64]) -> f64 {
    (steps.windows(2))
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum()
}

/// An unusual range, from jumps that agree on it.
fn unusual(run: &Run, span: f64) -> Option<f64> {
    let step = |k: usize| run.counts[k + 1] as f64 - run.counts[k] as f64;
    let mut ranges: Vec<f64> = (1..run.len().saturating_sub(2))
        .filter(|&k| step(k).abs() > HALF * span)
        .map(|k| {
            let beside = 0.5 * (step(k - 1).abs() + step(k + 1).abs());
            step(k).abs() + beside
        })
        .collect();
    ranges.sort_by(f64::total_cmp);
    let middle = *ranges.get(ranges.len() / 2)?;
    let agree = |range: &f64| (range / middle - 1.0).abs() < AGREE;
    (ranges.len() >= LEAST_LEAPS && ranges.iter().all(agree)).then_some(middle.round())
}

fn extremes(counts: &[i64]) -> (i64, i64) {
    let ends = |(low, high): (i64, i64), &n: &i64| (low.min(n), high.max(n));
    counts.iter().fold((i64::MAX, i64::MIN), ends)
}

/// The range in counts of the counter that the import or the recorder unwrapped.
fn stated_range(run: &Run) -> Option<f64> {
    let number = |value: &toml::Value| match value {
        toml::Value::Float(value) => Some(*value),
        toml::Value::Integer(value) => Some(*value as f64),
        _ => None,
    };
    let imported = run.header.get("imported");
    let range = imported
        .and_then(|imported| imported.get("wrap_counts"))
        .or_else(|| run.header.get("wrap_counts"));
    range.and_then(number).filter(|range| *range > 0.0)
}

/// Whether the recorder flagged the counts after a pause.
fn is_flagged_over_gap(run: &Run) -> bool {
    let is_flagged = |k: usize| (run.flags.as_ref()).is_some_and(|flags| flags[k].counts_leap);
    (pauses(run).iter()).any(|pause| is_flagged(pause.before + 1))
}

/// Pauses in which the shaft can turn by more than half the range.
fn over_gaps(subject: &Subject<'_>, range: f64) -> Option<Finding> {
    let run = subject.run;
    let rate = |k: usize| {
        let counts = run.counts[k + 1].abs_diff(run.counts[k]) as f64;
        counts / (run.t_s[k + 1] - run.t_s[k])
    };
    let pauses = pauses(subject.run);
    let in_pause: std::collections::BTreeSet<usize> =
        pauses.iter().map(|pause| pause.before).collect();
    // The top speed outside the wraps.
    let top = (0..run.len().saturating_sub(1))
        .filter(|k| !in_pause.contains(k))
        .filter(|&k| run.counts[k + 1].abs_diff(run.counts[k]) as f64 <= HALF * range)
        .map(rate)
        .fold(0.0, f64::max);
    let at_rest = |k: usize| run.command[k] == 0.0 && run.counts[k] == run.counts[k + 1];
    let ambiguous: Vec<_> = pauses
        .iter()
        .filter(|pause| top * pause.lasts_s > HALF * range && !at_rest(pause.before))
        .collect();
    let first = ambiguous.first()?;
    let longest_s = ambiguous
        .iter()
        .map(|pause| pause.lasts_s)
        .fold(0.0, f64::max);
    Some(subject.finding(
        Kind::WrapOverGap,
        Severity::Fatal,
        (first.before, ambiguous[ambiguous.len() - 1].before + 1),
        format!(
            "in {} of {} the counter of {range} counts can go round unseen: at {top:.0} counts/s the shaft turns {:.1} times its range, first after sample {} at {:.3} s",
            if ambiguous.len() == 1 { "a pause".to_owned() } else { format!("{} pauses", ambiguous.len()) },
            time(longest_s),
            top * longest_s / range,
            first.before + 1,
            run.t_s[first.before],
        ),
        [
            ("range_counts", range),
            ("top_counts_per_s", top),
            ("pauses", ambiguous.len() as f64),
            ("longest_s", longest_s),
            ("first_after_sample", first.before as f64 + 1.0),
        ],
        "split the log there into two runs, or record again without the pause; position and speed across it are not known",
    ))
}
