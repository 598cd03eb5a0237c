//! First looks: a few steps from each place where a fit may start, on short horizons.
//!
//! What is far behind a set that is known on the same horizons is not looked at to the end.

use rayon::prelude::*;

use super::data::RunData;
use super::fit::Fit;
use super::growth::Field;
use super::problem::Problem;
use super::search::Start;

/// Most steps from the best start, and of each fit of an effect whose order was scanned for.
const FIRST_STEPS: usize = 2;
const SCANNED_STEPS: usize = 6;
/// How many orders are still in play after a beginning.
const SCANS_KEPT: usize = 2;
/// How many nats behind a known set a look may be and still reach it; of beginnings their share.
const OUT_OF_REACH: f64 = 200.0;

/// What first looks have to reach: the evidence of a known set on the same horizons, less [`OUT_OF_REACH`].
pub(super) struct Bar {
    /// On each beginning.
    on_beginnings: Vec<f64>,
    /// On all of the runs.
    on_all: f64,
}

impl Bar {
    /// Of this fit, after a step on these horizons; `None` where it cannot be simulated.
    pub fn new(field: &Field<'_>, best: &Fit, level: usize) -> Option<Self> {
        let samples = |problem: &Problem<'_>| problem.runs.iter().map(RunData::len).sum::<usize>();
        let all = samples(field.problem).max(1) as f64;
        let wander = field.problem.levels[level];
        let least = |problem: &Problem<'_>| {
            let fit = problem.fit_at(&best.hypothesis, &best.p, wander, 1)?;
            Some(fit.log_evidence - OUT_OF_REACH * samples(problem) as f64 / all)
        };
        let on_all = least_of_all(field.problem, best, level)?;
        let beginnings = field.beginnings.par_iter().with_max_len(1);
        let on_beginnings: Option<Vec<f64>> = beginnings.map(least).collect();
        Some(Self {
            on_beginnings: on_beginnings?,
            on_all,
        })
    }

    /// Whether a look is too far behind to be worth long horizons.
    pub fn is_out_of_reach(&self, look: &Fit) -> bool {
        look.log_evidence < self.on_all
    }
}

/// The evidence below which a look at all of the runs is too far behind this fit to be worth long horizons; `None` as for a [`Bar`].
pub(super) fn least_of_all(problem: &Problem<'_>, best: &Fit, level: usize) -> Option<f64> {
    let wander = problem.levels[level];
    let reached = if best.wander == wander {
        best.log_evidence
    } else {
        (problem.fit_at(&best.hypothesis, &best.p, wander, 1)?).log_evidence
    };
    Some(reached - OUT_OF_REACH)
}

/// A step from every start on short horizons, and a few more from where the best of them leads.
pub(super) fn first_fit(problem: &Problem<'_>, starts: Vec<Start>, level: usize) -> Option<Fit> {
    let wander = problem.levels[level];
    let first = best_fit(starts, |(hypothesis, start)| {
        problem.fit_at(&hypothesis, &start, wander, 1)
    })?;
    problem.fit_at(&first.hypothesis, &first.p, wander, FIRST_STEPS)
}

/// The same of a torque that repeats with the angle: a simulated angle that is some counts off is far off in phase, so
/// the first part of the runs comes first, and the order is let go last. One step where the best of a beginning is below the bar.
pub(super) fn scanned_fit(
    field: &Field<'_>,
    mut starts: Vec<Start>,
    level: usize,
    bar: Option<&Bar>,
) -> Option<Fit> {
    let problem = field.problem;
    let shortest = problem.levels.first().copied()?;
    let short = problem.levels[level];
    let mut steps = SCANNED_STEPS;
    for (k, beginning) in field.beginnings.iter().enumerate() {
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
        let is_below = bar
            .zip(fits.first())
            .is_some_and(|(bar, best)| best.log_evidence < bar.on_beginnings[k]);
        if is_below {
            fits.truncate(1);
            steps = 1;
        }
        starts = fits
            .into_iter()
            .map(|fit| (fit.hypothesis, fit.p))
            .collect();
        if is_below {
            break;
        }
    }
    best_fit(starts, |(hypothesis, p)| {
        problem.fit_at(&hypothesis, &p, short, steps)
    })
}

/// The likelier of two looks, where there are two.
pub(super) fn likelier(a: Option<Fit>, b: Option<Fit>) -> Option<Fit> {
    let found = a.into_iter().chain(b);
    found.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
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

#[cfg(test)]
mod tests {
    use super::super::rank::heads;
    use super::super::samples::{fit, index, motor_with, problem, ready, recording};
    use super::super::search::Search;
    use super::*;

    /// What an order is scanned for stops early behind a set that is right, and only there.
    #[test]
    fn a_scan_that_is_far_behind_a_known_set_stops_early_and_the_right_one_does_not() {
        let cogging = ("cogging", &[0.02, 12.0, 1.1][..]);
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[cogging])));
        let parts = [0.25, 0.5].map(|share| heads(&runs, share));
        let beginnings = parts.each_ref().map(|runs| problem(&nominal, runs));
        let problem = problem(&nominal, &runs);
        let field = Field::new(&problem, &beginnings);
        let level = 1;
        let without = fit(&problem, &[]);
        let right = fit(&problem, &[cogging]);
        let bar = Bar::new(&field, &right, level).expect("it can be simulated");
        let search = Search::new(&problem, &without, level).expect("it can be simulated");
        let look = |id: &str, bar: Option<&Bar>| {
            let starts = search.starts(index(id), None);
            scanned_fit(&field, starts, level, bar).expect("it can be simulated")
        };
        let found = look("cogging", Some(&bar));
        assert!(!bar.is_out_of_reach(&found));
        assert_eq!(found.p, look("cogging", None).p);
        let ripple = look("torque_ripple", Some(&bar));
        let in_full = look("torque_ripple", None);
        assert!(bar.is_out_of_reach(&ripple) && bar.is_out_of_reach(&in_full));
        assert!(ripple.log_evidence < in_full.log_evidence);
        assert_ne!(ripple.p, in_full.p);
    }

    /// A pendulum that has been over the top one turn too often is far off for good: seen from the beginning it is not.
    #[test]
    fn a_heavy_pendulum_is_found_from_the_beginnings_and_not_from_whole_runs() {
        let gravity = ("gravity_load", &[0.09, 2.6][..]);
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[gravity])));
        let parts = [0.25, 0.5].map(|share| heads(&runs, share));
        let beginnings = parts.each_ref().map(|runs| problem(&nominal, runs));
        let problem = problem(&nominal, &runs);
        let field = Field::new(&problem, &beginnings);
        let without = fit(&problem, &[]);
        let search = Search::new(&problem, &without, 1).expect("it can be simulated");
        let starts = search.starts(index(gravity.0), None);
        let direct = first_fit(&problem, starts.clone(), 1).expect("it can be simulated");
        let found = scanned_fit(&field, starts, 1, None).expect("it can be simulated");
        assert!(
            found.log_evidence > direct.log_evidence + 100.0,
            "{} {}",
            found.log_evidence,
            direct.log_evidence
        );
    }
}
