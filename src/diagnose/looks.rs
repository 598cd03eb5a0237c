//! First looks: a few steps from each place where a fit may start, on short horizons.

use rayon::prelude::*;

use super::fit::{Fit, Problem};
use super::search::Start;

/// Most steps from the best start, and of each fit of an effect whose order was scanned for.
const FIRST_STEPS: usize = 2;
const SCANNED_STEPS: usize = 6;
/// How many orders are still in play after a beginning.
const SCANS_KEPT: usize = 2;

/// A step from every start on short horizons, and a few more from where the best of them leads.
pub(super) fn first_fit(problem: &Problem<'_>, starts: Vec<Start>, level: usize) -> Option<Fit> {
    let wander = problem.levels[level];
    let first = best_fit(starts, |(hypothesis, start)| {
        problem.fit_at(&hypothesis, &start, wander, 1)
    })?;
    problem.fit_at(&first.hypothesis, &first.p, wander, FIRST_STEPS)
}

/// The same where an order was scanned for: a simulated angle that is some counts off is far off in phase, so
/// the first part of the runs comes first, and the order is let go last.
pub(super) fn scanned_fit(
    problem: &Problem<'_>,
    beginnings: &[Problem<'_>],
    mut starts: Vec<Start>,
    level: usize,
) -> Option<Fit> {
    let shortest = problem.levels.first().copied()?;
    let short = problem.levels[level];
    for beginning in beginnings {
        let fit = |(hypothesis, p): Start| {
            let held = hypothesis.with_orders_held(&p);
            let p = beginning.fit_at(&held, &p, shortest, SCANNED_STEPS)?.p;
            beginning.fit_at(&hypothesis, &p, short, SCANNED_STEPS)
        };
        let mut fits: Vec<Fit> = starts
            .into_par_iter()
            .with_max_len(1)
            .filter_map(fit)
            .collect();
        fits.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        fits.truncate(SCANS_KEPT);
        starts = fits
            .into_iter()
            .map(|fit| (fit.hypothesis, fit.p))
            .collect();
    }
    best_fit(starts, |(hypothesis, p)| {
        problem.fit_at(&hypothesis, &p, short, SCANNED_STEPS)
    })
}

/// The likeliest of the fits from these starts, side by side where somebody has nothing else to do.
fn best_fit(starts: Vec<Start>, fit: impl Fn(Start) -> Option<Fit> + Sync + Send) -> Option<Fit> {
    let fits: Vec<Fit> = starts
        .into_par_iter()
        .with_max_len(1)
        .filter_map(fit)
        .collect();
    fits.into_iter()
        .max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
}
