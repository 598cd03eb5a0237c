//! First looks: a few steps from each place where a fit may start, on short horizons.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::fit::{Fit, Problem};
use super::growth::HOPELESS;
use super::search::Start;

/// Most steps from the best start, and of each fit of an effect whose order was scanned for.
const FIRST_STEPS: usize = 2;
const SCANNED_STEPS: usize = 6;
/// How many orders are still in play after a beginning.
const SCANS_KEPT: usize = 2;

/// A set to look at.
pub(super) struct Asked {
    /// The indices of its effects in the catalogue.
    pub effects: Vec<usize>,
    /// Where its fits start.
    pub starts: Vec<Start>,
    /// What it could weigh by a regression's promise, where an order was scanned for that is worth a closer look.
    pub could_weigh: Option<f64>,
}

/// First looks at these sets, and closer ones at those that ask for one and by their first look or their promise are not
/// hopelessly behind `bar` and the best of all.
pub(super) fn looks(
    problem: &Problem<'_>,
    beginnings: &[Problem<'_>],
    asked: Vec<Asked>,
    level: usize,
    bar: Option<f64>,
    of: &(dyn Fn(Vec<usize>, Fit) -> Candidate + Sync),
) -> Vec<Candidate> {
    let first: Vec<(Asked, Option<Candidate>)> = asked
        .into_par_iter()
        .with_max_len(1)
        .map(|set| {
            let fit = first_fit(problem, &set.starts, level);
            let found = fit.map(|fit| of(set.effects.clone(), fit));
            (set, found)
        })
        .collect();
    let weights = first
        .iter()
        .filter_map(|(_, c)| Some(c.as_ref()?.log_weight));
    let least = weights.chain(bar).fold(f64::NEG_INFINITY, f64::max) - HOPELESS;
    first
        .into_par_iter()
        .with_max_len(1)
        .filter_map(|(set, found)| {
            let weight = found.as_ref().map_or(f64::NEG_INFINITY, |c| c.log_weight);
            let is_close = |could_weigh: f64| could_weigh.max(weight) > least;
            if !set.could_weigh.is_some_and(is_close) {
                return found;
            }
            let fit = scanned_fit(problem, beginnings, &set.starts, level);
            let closer = fit.map(|fit| of(set.effects, fit));
            match closer {
                Some(closer) if closer.log_weight > weight => Some(closer),
                _ => found,
            }
        })
        .collect()
}

/// A step from every start on short horizons, and a few more from where the best of them leads.
pub(super) fn first_fit(problem: &Problem<'_>, starts: &[Start], level: usize) -> Option<Fit> {
    let wander = problem.levels[level];
    let first = best_fit(
        starts
            .iter()
            .filter_map(|(hypothesis, start)| problem.fit_at(hypothesis, start, wander, 1)),
    )?;
    problem.fit_at(&first.hypothesis, &first.p, wander, FIRST_STEPS)
}

/// The same where an order was scanned for: a simulated angle that is some counts off is far off in phase, so
/// the first part of the runs comes first, and the order is let go last.
pub(super) fn scanned_fit(
    problem: &Problem<'_>,
    beginnings: &[Problem<'_>],
    starts: &[Start],
    level: usize,
) -> Option<Fit> {
    let shortest = problem.levels.first().copied()?;
    let short = problem.levels[level];
    let mut starts = starts.to_vec();
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
    best_fit(
        starts
            .into_iter()
            .filter_map(|(hypothesis, p)| problem.fit_at(&hypothesis, &p, short, SCANNED_STEPS)),
    )
}

fn best_fit(fits: impl Iterator<Item = Fit>) -> Option<Fit> {
    fits.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
}
