//! The identified effects that the held-out error confirms, their nested models and noise floors.
//!
//! In: the identified effects, the search, held-out segments if there are any. Out: [`Confirmed`]. An effect is dropped
//! that the reported fits do not reach, that has a parameter at a bound there, that adds to the held-out error, or that
//! removes too little of it.

use super::causes::at_bound;
use crate::diagnose::budget::{Shares, cross_validated};
use crate::diagnose::fit::Fit;
use crate::diagnose::model::{Base, corrected_residual, mean_square};
use crate::diagnose::nested::{self, Step};
use crate::diagnose::noise::{LinearPlant, Noise, expected_mean_square};
use crate::diagnose::report::FloorParts;
use crate::diagnose::score::{effective_observations, plant_of};
use crate::diagnose::search::Found;
use crate::diagnose::segments::Segments;
use crate::diagnose::verdict::{Identified, adds_error, immaterial};

/// Segments and the search in them.
pub(super) struct Data<'a> {
    pub segments: &'a Segments,
    /// On which the error is measured; `None` for cross-validation.
    pub judged_on: Option<&'a Segments>,
    pub base: &'a Base,
    pub found: &'a Found,
    /// The noise floor without random errors.
    pub floor: FloorParts,
    /// Whether the error is measured on held-out runs.
    pub has_held_out_runs: bool,
}

/// Nested models of confirmed effects.
pub(super) struct Confirmed {
    /// Nominal, re-identified parameters, with one effect after the other.
    pub steps: Vec<Step>,
    /// Their held-out residuals.
    pub errors: Vec<Vec<f64>>,
    pub floors: Floors,
    /// Effective number of observations in the nominal model's error.
    pub n_eff: f64,
    /// Dropped effects with a parameter at a bound, with the fit that ended there, and others.
    pub bounded: Vec<(&'static str, Fit)>,
    pub rejected: Vec<&'static str>,
}

/// Noise floor of each nested model, and the shares of the error above it.
pub(super) struct Floors {
    pub parts: Vec<FloorParts>,
    /// In counts RMS.
    pub counts: Vec<f64>,
    pub shares: Shares,
}

/// Drops effects from `named` until the others are confirmed; `none` is the probability that no effect is present.
pub(super) fn confirmed(
    data: &Data,
    without: &[Step],
    named: &mut Vec<Identified>,
    none: f64,
) -> Option<Confirmed> {
    let settings = &data.base.settings;
    let (mut bounded, mut rejected) = (Vec::new(), Vec::new());
    loop {
        let dropped = (&mut bounded, &mut rejected);
        let steps = nested_fits(data, without, named, dropped);
        let errors = errors(data, &steps)?;
        let judged_on = data.judged_on.unwrap_or(data.segments);
        let n_eff = effective_observations(judged_on, &errors[0]);
        // Without a probable effect the error by a random load is not reducible. Beside one, a law that is not modelled
        // may be a part of it, and stays visible.
        let has_load = named.is_empty() && none >= settings.identified;
        let floors = Floors::new(data, &steps, &errors, has_load);
        let Some(k) = unconfirmed(data, &errors, &floors, n_eff) else {
            return Some(Confirmed {
                steps,
                errors,
                floors,
                n_eff,
                bounded,
                rejected,
            });
        };
        rejected.push(steps[2 + k].name);
        named.retain(|one| one.effect != steps[2 + k].name);
    }
}

/// The last effect that adds to the held-out error by more than its sampling error, or that removes too little of what
/// is left before it: nothing of that of held-out runs, or less than an immaterial share where the scale-free score
/// judges, whose error is not noise.
fn unconfirmed(data: &Data, errors: &[Vec<f64>], floors: &Floors, n_eff: f64) -> Option<usize> {
    let settings = &data.base.settings;
    let shares = &floors.shares;
    let effects: Vec<(f64, f64)> = (2..errors.len())
        .map(|m| (shares.between(m - 1, m).0, shares.left(m - 1).0))
        .collect();
    let is_above_floor = data.found.judge.is_relevant && shares.left(errors.len() - 1).1 > 0.0;
    let least = match (data.found.judge.is_likelihood, data.has_held_out_runs) {
        (false, _) if is_above_floor => Some(settings.unexplained_share),
        (_, true) => Some(0.0),
        _ => None,
    };
    let squares: Vec<f64> = errors.iter().map(|error| mean_square(error)).collect();
    (least.and_then(|least| immaterial(&effects, least)))
        .or_else(|| adds_error(&squares, &floors.counts, n_eff, settings))
}

impl Floors {
    /// Of each model with its random effects, and with the random load where `has_load`.
    fn new(data: &Data, steps: &[Step], errors: &[Vec<f64>], has_load: bool) -> Self {
        let segments = data.judged_on.unwrap_or(data.segments);
        // This recording's share of an expected error is no more than its own.
        let random = |(step, error): (&Step, &Vec<f64>)| {
            let expected = random_floor(data, segments, [&steps[1].fit, &step.fit], has_load);
            expected.map(|floor| floor.min(mean_square(error).sqrt()))
        };
        let parts = steps.iter().zip(errors).map(|of| FloorParts {
            random: random(of),
            ..data.floor
        });
        let parts: Vec<FloorParts> = parts.collect();
        let counts: Vec<f64> = parts.iter().map(FloorParts::largest).collect();
        Self {
            shares: Shares::new(segments, errors, &counts, &data.base.settings),
            parts,
            counts,
        }
    }
}

/// The nested models of the effects that are identified, without those that remove nothing in the reported fits or have a parameter at a
/// bound of its range there: these are no longer among the named ones, but among the rejected or the bounded ones.
fn nested_fits(
    data: &Data,
    without: &[Step],
    named: &mut Vec<Identified>,
    (bounded, rejected): (&mut Vec<(&'static str, Fit)>, &mut Vec<&'static str>),
) -> Vec<Step> {
    loop {
        let ids: Vec<&'static str> = named.iter().map(|one| one.effect).collect();
        let steps =
            nested::with_effects(data.segments, data.base, without.to_vec(), &ids, data.found);
        let largest = &steps[steps.len() - 1].fit;
        let is_reached = |id: &str| steps.iter().any(|step| step.name == id);
        let not_reached = ids.iter().find(|id| !is_reached(id)).copied();
        rejected.extend(not_reached);
        let dropped = not_reached.or_else(|| {
            let first = at_bound(largest).into_iter().find(|id| ids.contains(id));
            bounded.extend(first.map(|id| (id, largest.clone())));
            first
        });
        match dropped {
            Some(dropped) => named.retain(|one| one.effect != dropped),
            None => break steps,
        }
    }
}

/// Error in counts RMS of a perfect model on recordings with a model's random effects, and with the random load torque of the best set, as
/// the re-identified motor responds to it; none where there is neither, and where the likelihood, which alone sees their variance, is not the
/// score.
fn random_floor(
    data: &Data,
    segments: &Segments,
    [refitted, model]: [&Fit; 2],
    has_load: bool,
) -> Option<f64> {
    let plant_of = |fit: &Fit| plant_of(segments, &fit.model.motor(&fit.x), data.base.kind);
    let own = plant_of(model);
    let plant = LinearPlant {
        jitter_s: own.jitter_s,
        loss: own.loss,
        ..plant_of(refitted)
    };
    let noise = match has_load {
        true => data.found.best().likelihood.noise,
        false => Noise::NONE,
    };
    let has_effect = plant.loss > 0.0 || plant.jitter_s > segments.arrivals_s;
    (data.found.judge.is_likelihood && (has_effect || noise.strength > 0.0))
        .then(|| expected_mean_square(segments, &plant, noise).sqrt())
}

/// Held-out residuals of each step: on other segments, or by cross-validation.
fn errors(data: &Data, steps: &[Step]) -> Option<Vec<Vec<f64>>> {
    let of = |(k, Step { fit, .. }): (usize, &Step)| match (data.judged_on, k) {
        (Some(others), _) => corrected_residual(others, &fit.model.motor(&fit.x)),
        (None, 0) => Some(fit.corrected.clone()),
        (None, _) => Some(cross_validated(data.segments, data.base, fit)),
    };
    steps.iter().enumerate().map(of).collect()
}
