//! Logged speeds between encoder edges: 0 in rows without an edge, or the last value kept at rest.
//!
//! A loop faster than the edges has rows without an edge. A program that writes 0 there logs a speed that alternates
//! between 0 and its value, whose integral is too small by the share of such rows. A program that keeps the last
//! speed never returns to 0: the value stays constant to the last digit while the command is 0, and its integral
//! grows without bound.

use super::finding::{Finding, Kind, Severity};
use super::kept_speed::{KEPT_ROWS, KEPT_SHARE, SPEED_KEPT};
use super::subject::Subject;
use super::words::{digits, time};
use super::zero_speeds::SPEED_ZERO;
use crate::recording::{Run, Steps};

/// Rows around a row over which the speed is averaged.
const AROUND: usize = 12;
/// Least speed in counts a row: quantization to whole counts then never gives 0.
const LEAST_COUNTS_A_ROW: f64 = 2.0;
/// Least speed on each side of a row as a share of the average.
const BOTH_SIDES: f64 = 0.6;
/// A row is 0 below this share of the average.
const ZERO: f64 = 0.1;
/// Least share of the rows of a turning shaft that are 0, and their least number: run-up and run-out have a few.
const LEAST_SHARE: f64 = 0.2;
const LEAST_ROWS: usize = 30;
/// Most consecutive rows that are 0.
const MOST_BETWEEN: usize = AROUND;

/// Least travel of a kept speed in counts.
const KEPT_COUNTS: f64 = 10.0;
/// Largest deviation from a straight line: quantization causes 0.5 at either end.
const STRAIGHT_COUNTS: f64 = 1.0;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let Some(step_s) = Steps::of(run).map(|steps| steps.median_s()) else {
        return Vec::new();
    };
    if !run.is_integrated() || step_s <= 0.0 {
        return Vec::new();
    }
    let (seen, by_import) = (zero(run, step_s), zero_by_import(run));
    let figures = by_import.or(seen.map(|(_, figures)| figures));
    let rows = seen.map_or_else(|| subject.whole(), |(rows, _)| rows);
    let zero = figures.map(|figures| zero_finding(subject, rows, figures));
    let mut found: Vec<Finding> = zero.into_iter().collect();
    if subject.has("command") {
        found.extend(kept(subject, step_s).or_else(|| kept_by_import(subject)));
    }
    found
}

/// Counts added by each row, scaled to the median step; none where a step is longer than usual.
fn increments(run: &Run, step_s: f64) -> Vec<f64> {
    let step = |k: usize| {
        let counts = run.counts[k + 1] as f64 - run.counts[k] as f64;
        counts * step_s / (run.t_s[k + 1] - run.t_s[k])
    };
    (0..run.len().saturating_sub(1)).map(step).collect()
}

/// Share of rows at 0, rows of a turning shaft, and RPM in its other rows.
type Figures = (f64, f64, f64);

/// As the import counted them: it has the speeds before they are summed up and rounded to counts.
fn zero_by_import(run: &Run) -> Option<Figures> {
    let seen = run.header.get("imported")?.get(SPEED_ZERO)?;
    let figure = |key: &str| seen.get(key)?.as_float();
    let edge_rpm = 60.0 * figure("speed_at_edges_counts_s")? / run.counts_per_rev;
    Some((figure("share")?, figure("turning_rows")?, edge_rpm))
}

fn zero_finding(
    subject: &Subject<'_>,
    rows: (usize, usize),
    (share, turning, edge_rpm): Figures,
) -> Finding {
    subject.finding(
        Kind::SpeedZeroBetweenEdges,
        Severity::Fatal,
        rows,
        format!(
            "the speed jumps between 0 and {} RPM while the shaft turns: {:.0} % of these rows are 0, so the position that is summed up from it is too small",
            digits(edge_rpm, 3),
            100.0 * share,
        ),
        [
            ("zero_share", share),
            ("zero_rows", share * turning),
            ("turning_rows", turning),
            ("speed_at_edges_rpm", edge_rpm),
        ],
        "log the count itself (--position COL:counts), or leave out the rows without an edge; the rows are faster than the edges",
    )
}

/// The first and last row at 0, and the figures.
fn zero(run: &Run, step_s: f64) -> Option<((usize, usize), Figures)> {
    let steps = increments(run, step_s);
    let (mut turning, mut at_zero, mut together) = (0_usize, 0_usize, 0_usize);
    let (mut first, mut last) = (usize::MAX, 0);
    let mut speed_sum = 0.0;
    for k in AROUND..steps.len().saturating_sub(AROUND) {
        let around = &steps[k - AROUND..=k + AROUND];
        let mean = around.iter().sum::<f64>() / around.len() as f64;
        // The shaft turns on both sides: rows before a start and after a stop are at rest.
        let half = |rows: &[f64]| rows.iter().sum::<f64>() / AROUND as f64;
        let (before, after) = (half(&around[..AROUND]), half(&around[AROUND + 1..]));
        let least = (before * mean.signum()).min(after * mean.signum());
        if mean.abs() < LEAST_COUNTS_A_ROW || least < BOTH_SIDES * mean.abs() || !mean.is_finite() {
            together = 0;
            continue;
        }
        turning += 1;
        if steps[k].abs() >= ZERO * mean.abs() {
            together = 0;
            speed_sum += steps[k].abs();
            continue;
        }
        together += 1;
        if together > MOST_BETWEEN {
            return None;
        }
        at_zero += 1;
        (first, last) = (first.min(k), k);
    }
    let share = at_zero as f64 / turning as f64;
    if turning < LEAST_ROWS || share < LEAST_SHARE {
        return None;
    }
    let edge_rpm =
        60.0 * speed_sum / (turning - at_zero).max(1) as f64 / step_s / run.counts_per_rev;
    Some(((first, last), (share, turning as f64, edge_rpm)))
}

fn kept(subject: &Subject<'_>, step_s: f64) -> Option<Finding> {
    let run = subject.run;
    let top = (increments(run, step_s).iter()).fold(0.0, |most, step| f64::max(most, step.abs()));
    let mut k = 1;
    while k < run.len() {
        if run.command[k] != 0.0 || run.command[k - 1] == 0.0 {
            k += 1;
            continue;
        }
        let end = (k..run.len())
            .find(|&k| run.command[k] != 0.0)
            .unwrap_or(run.len() - 1);
        if let Some((from, counts_s)) = straight_end(run, k, end)
            && (counts_s * step_s).abs() <= KEPT_SHARE * top
        {
            return Some(kept_finding(subject, (from, end), counts_s));
        }
        k = end.max(k + 1);
    }
    None
}

/// A kept speed as the import found it in the speeds themselves.
fn kept_by_import(subject: &Subject<'_>) -> Option<Finding> {
    let seen = subject.run.header.get("imported")?.get(SPEED_KEPT)?;
    let figure = |key: &str| seen.get(key)?.as_float();
    let at = |t_s: f64| {
        let times = &subject.run.t_s;
        times.partition_point(|t| *t < t_s).min(times.len() - 1)
    };
    let rows = (at(figure("from_s")?), at(figure("to_s")?));
    Some(kept_finding(subject, rows, figure("counts_s")?))
}

fn kept_finding(subject: &Subject<'_>, (from, end): (usize, usize), counts_s: f64) -> Finding {
    let run = subject.run;
    let rpm = 60.0 * counts_s / run.counts_per_rev;
    let lasts_s = run.t_s[end] - run.t_s[from];
    subject.finding(
        Kind::SpeedKept,
        Severity::Warning,
        (from, end),
        format!(
            "the speed stays at {} RPM for {} while nothing is commanded: it is kept from the last edge",
            digits(rpm, 3),
            time(lasts_s),
        ),
        [
            ("kept_rpm", rpm),
            ("kept_s", lasts_s),
            ("counts_too_many", counts_s * lasts_s),
        ],
        "write 0 when no edge comes for longer than at the slowest speed, or log the count itself (--position COL:counts)",
    )
}

/// The longest tail of these samples in which the position is a sloped straight line: its first sample, and its rate
/// in counts/s.
fn straight_end(run: &Run, from: usize, end: usize) -> Option<(usize, f64)> {
    let is_straight = |first: usize| -> Option<f64> {
        let span_s = run.t_s[end] - run.t_s[first];
        let rate = (run.counts[end] as f64 - run.counts[first] as f64) / span_s;
        let is_near = |k: usize| {
            let line = run.counts[first] as f64 + rate * (run.t_s[k] - run.t_s[first]);
            (run.counts[k] as f64 - line).abs() <= STRAIGHT_COUNTS
        };
        (rate.is_finite() && (first..=end).all(is_near)).then_some(rate)
    };
    let latest = end
        .checked_sub(KEPT_ROWS)
        .filter(|&latest| latest >= from)?;
    is_straight(latest)?;
    // Bisection: the earlier the straight part begins, the longer it is.
    let (mut low, mut high) = (from, latest);
    while low < high {
        let middle = low.midpoint(high);
        match is_straight(middle) {
            Some(_) => high = middle,
            None => low = middle + 1,
        }
    }
    let rate = is_straight(high)?;
    let counts = rate * (run.t_s[end] - run.t_s[high]);
    (counts.abs() >= KEPT_COUNTS).then_some((high, rate))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::check;

    /// First-order motor whose speed in counts a row is logged as `logged` makes of it, row for row.
    fn run(logged: impl Fn(usize, f64, f64) -> f64) -> Run {
        let header = "[imported]\nposition = \"integrated from speeds, backward\"\n";
        let mut run = Run {
            header: header.parse().expect("TOML"),
            sample_time_s: 0.01,
            counts_per_rev: 720.0,
            ..Run::default()
        };
        let (mut speed, mut sum, mut shown) = (0.0, 0.0_f64, 0.0);
        for k in 0..600 {
            let command = if (50..400).contains(&k) { 6.0 } else { 0.0 };
            speed += 0.12 * (2.0 * command - speed);
            shown = logged(k, speed, shown);
            sum += shown;
            run.t_s.push(0.01 * k as f64);
            run.command.push(command);
            run.counts.push(sum.round() as i64);
        }
        run
    }

    fn kinds(run: &Run) -> Vec<Kind> {
        let found = check(std::slice::from_ref(run), None);
        let of_these = |kind: &Kind| matches!(kind, Kind::SpeedZeroBetweenEdges | Kind::SpeedKept);
        found.iter().map(|f| f.id).filter(of_these).collect()
    }

    #[test]
    fn speeds_of_0_between_edges_are_found_and_coasting_is_none() {
        assert_eq!(kinds(&run(|_, speed, _| speed)), []);
        for every in [2, 3, 5] {
            let zero = run(|k, speed, _| if k % every == 0 { speed } else { 0.0 });
            assert_eq!(kinds(&zero), [Kind::SpeedZeroBetweenEdges], "{every}");
        }
        let few = run(|k, speed, _| if k % 9 == 0 { 0.0 } else { speed });
        assert_eq!(kinds(&few), []);
    }

    #[test]
    fn a_speed_that_is_held_at_rest_is_found() {
        let kept = run(|_, speed, shown| {
            if speed < 0.8 && shown > 0.0 {
                shown
            } else {
                speed
            }
        });
        assert_eq!(kinds(&kept), [Kind::SpeedKept]);
    }
}
