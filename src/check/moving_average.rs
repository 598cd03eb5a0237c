//! A logged speed (or position) that is the mean of the last rows.
//!
//! The integral of a moving average of speeds is the moving average of the positions. A first-order step response
//! becomes `K m(t)`, the mean of `r(t - j h)` over `j = 0 .. N - 1` with `r(z) = z - tau (1 - exp(-z / tau))`, which
//! has a kink after `N` rows. A dead time has its kink at its end only; a filter or an inductance has none: its
//! response has two time constants, `z - (tau + f) + (tau^2 exp(-z / tau) - f^2 exp(-z / f)) / (tau - f)`. All three
//! are fitted to the positions after the steps, with one gain `K` for each step; the mean is reported where its
//! residual is far below the best of the others.

use super::command_offset::{AT_REST, fitted_part, golden};
use super::finding::{Finding, Kind, Severity};
use super::step_response::{MOST_AFTER, StepResponse, step_responses};
use super::subject::Subject;
use super::words::time;
use crate::recording::Steps;
use crate::units::ROUNDING_VARIANCE as ROUNDING;

/// Window lengths tried, in rows.
const FEWEST_ROWS: usize = 3;
const MOST_ROWS: usize = 30;
/// Grid of time constants of the motor and of the filter in samples: the first, and the ratio between neighbours. The
/// motor's is refined between the neighbours of the best.
const SHORTEST_TAU: f64 = 0.5;
const TAU_STEP: f64 = 1.5;
const TAUS: i32 = 13;
const FILTERS: i32 = 11;
/// Grid of dead times in samples; it begins before the command, as an integrated speed is uncertain by one sample.
const EARLIEST: f64 = -1.0;
const DEAD_STEP: f64 = 0.5;
const MEAN_DEADS: i32 = 7;
const OTHER_DEADS: i32 = 20;
const MOST_FITTED: usize = 6;
/// The RMS residual of the mean is at most this share of the first-order one, and the log likelihood ratio exceeds
/// this bound, which correlated residuals do not reach.
const LEAVES: f64 = 0.8;
const LEAST_LOG_RATIO: f64 = 30.0;
/// Least log likelihood ratio against a filter; from `LEAST_LOG_RATIO` on a warning, below it a note.
const LIKELIER: f64 = 8.0;
/// Least counts of all responses together: the kink is then above quantization.
const LEAST_COUNTS: f64 = 40.0;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    if !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    let run = subject.run;
    let Some(step_s) = Steps::of(run).map(|steps| steps.median_s()) else {
        return Vec::new();
    };
    let all = step_responses(run, usize::from(run.is_integrated()), MOST_AFTER);
    let fitted: Vec<&StepResponse> = (all.iter())
        .filter(|step| step.speed_counts_s * step_s >= -AT_REST)
        .take(MOST_FITTED)
        .collect();
    let samples: usize = fitted.iter().map(|step| fitted_part(step).count()).sum();
    let farthest = (fitted.iter().flat_map(|step| fitted_part(step)))
        .fold(0.0, |most, (_, counts)| f64::max(most, *counts));
    if samples == 0 || farthest < LEAST_COUNTS || step_s <= 0.0 {
        return Vec::new();
    }
    let rounding = ROUNDING * samples as f64;
    let deads = |n: i32| (0..n).map(|k| EARLIEST + DEAD_STEP * f64::from(k));
    let first_orders = deads(OTHER_DEADS)
        .map(|dead| best_tau(|tau| residual(&fitted, step_s, |z| first_order(z - dead, tau))));
    let plain = first_orders.fold(f64::INFINITY, f64::min);
    // Quantization alone is left.
    if plain <= rounding / LEAVES.powi(2) {
        return Vec::new();
    }
    let means =
        (FEWEST_ROWS..=MOST_ROWS).flat_map(|rows| deads(MEAN_DEADS).map(move |d| (rows, d)));
    let best = means.map(|(rows, dead)| {
        let of = |tau: f64| residual(&fitted, step_s, |z| mean_of(rows, z - dead, tau));
        (rows, best_tau(of))
    });
    let Some((rows, mean)) = best.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Vec::new();
    };
    let log_ratio =
        |others: f64, least: f64| 0.5 * samples as f64 * (others / mean.max(least)).ln();
    let is_better = mean <= LEAVES.powi(2) * plain && log_ratio(plain, rounding) >= LEAST_LOG_RATIO;
    if !is_better || rows == MOST_ROWS {
        return Vec::new();
    }
    let filters = || (0..FILTERS).map(|k| SHORTEST_TAU * TAU_STEP.powi(k));
    let both = deads(OTHER_DEADS).flat_map(|dead| filters().map(move |filter| (dead, filter)));
    let filtered = both.map(|(dead, filter)| {
        best_tau(|tau| residual(&fitted, step_s, |z| two_constants(z - dead, tau, filter)))
    });
    let others = filtered.fold(plain, f64::min);
    let over_filter = log_ratio(others, f64::MIN_POSITIVE);
    if over_filter < LIKELIER {
        return Vec::new();
    }
    let (severity, besides) = match over_filter >= LEAST_LOG_RATIO {
        true => (Severity::Warning, ""),
        false => (
            Severity::Note,
            " (a filter with a delay fits nearly as well)",
        ),
    };
    let late_s = 0.5 * (rows as f64 - 1.0) * step_s;
    let what = if run.is_integrated() {
        "speed"
    } else {
        "position"
    };
    vec![subject.finding(
        Kind::MovingAverage,
        severity,
        fitted.first().zip(fitted.last()).map_or((0, 0), |(first, last)| (first.at, last.at)),
        format!(
            "the {what} is a moving average of {rows} rows{besides}: after a jump of the command its answer bends after {}, and is late by {}",
            time(rows as f64 * step_s),
            time(late_s),
        ),
        [
            ("rows", rows as f64),
            ("late_s", late_s),
            ("rms_counts", (mean / samples as f64).sqrt()),
            ("rms_counts_without", (others / samples as f64).sqrt()),
            ("jumps", fitted.len() as f64),
            ("log_likelihood_ratio", over_filter),
        ],
        "log the value before it is averaged, or the count itself; to a model it is nearly `transport_delay` of that lateness",
    )]
}

/// Residual with the best time constant: grid search, then golden-section search.
fn best_tau(left: impl Fn(f64) -> f64) -> f64 {
    let of = |ln_tau: f64| left(ln_tau.exp());
    let tried = (0..TAUS).map(|k| SHORTEST_TAU.ln() + f64::from(k) * TAU_STEP.ln());
    let best = tried
        .map(|ln_tau| (ln_tau, of(ln_tau)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(f64::INFINITY, |best| golden(best, TAU_STEP.ln(), of))
}

/// Position of a first-order response after `z` samples, for a gain of 1.
fn first_order(z: f64, tau: f64) -> f64 {
    let z = z.max(0.0);
    z - tau * (1.0 - (-z / tau).exp())
}

fn mean_of(rows: usize, z: f64, tau: f64) -> f64 {
    let sum: f64 = (0..rows).map(|j| first_order(z - j as f64, tau)).sum();
    sum / rows as f64
}

/// The first-order response behind a first-order filter.
fn two_constants(z: f64, tau: f64, filter: f64) -> f64 {
    let z = z.max(0.0);
    // Two equal time constants are the limit of two that differ slightly.
    let filter = if (tau / filter - 1.0).abs() < 1e-3 {
        1.001 * filter
    } else {
        filter
    };
    let ends = tau * tau * (-z / tau).exp() - filter * filter * (-z / filter).exp();
    z - (tau + filter) + ends / (tau - filter)
}

/// Residual in counts^2 of a response shape over the steps; one gain for each step.
fn residual(steps: &[&StepResponse], step_s: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let of_one = |step: &&StepResponse| {
        let (mut ff, mut fy, mut yy) = (0.0, 0.0, 0.0);
        for &(t_s, y) in fitted_part(step) {
            let f = shape(t_s / step_s);
            (ff, fy, yy) = (ff + f * f, fy + f * y, yy + y * y);
        }
        if ff > 0.0 { yy - fy * fy / ff } else { yy }
    };
    steps.iter().map(of_one).sum()
}
