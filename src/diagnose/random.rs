//! Parameters of random effects (lost edges, late samples): maximum likelihood of the variance that they predict.
//!
//! In: a fit. Out: the fit with these parameters at the maximum of the likelihood and all others changed by linear
//! steps. Least squares does not depend on them: a variance has no residual.

use super::fit::Fit;
use super::model::{Base, predict};
use super::noise::likeliest;
use super::score::{likelihood_under, plant_of};
use super::segments::Segments;
use super::settings::solver::{OCTAVES, REFINED, SAME};

/// A fit with maximum likelihood parameters of its random effects, each under its likeliest noise: octaves of the range, then halving.
pub(crate) fn with_likeliest(segments: &Segments, base: &Base, fit: Fit) -> Fit {
    if !fit.model.is_random() {
        return fit;
    }
    let cost_at = |x: &[f64]| -> f64 {
        let Some(predicted) = predict(segments, &fit.model.motor(x)) else {
            return f64::INFINITY;
        };
        let moved = Fit {
            x: x.to_vec(),
            residual: segments.residual(&predicted),
            prior: fit.model.prior(x),
            ..fit.clone()
        };
        let plant = plant_of(segments, &fit.model.motor(x), base.kind);
        let noise = likeliest(segments, &plant, base.settings.usual_load, &moved.residual);
        let (likelihood, _) = likelihood_under(segments, base, &moved, noise);
        likelihood.optimum.cost()
    };
    let mut x = fit.x.clone();
    let mut least = cost_at(&x);
    for k in fit.model.random() {
        let (lo, hi) = (fit.model.parameters[k].lo, fit.model.parameters[k].hi);
        let mut try_at = |value: f64, x: &mut Vec<f64>| {
            let mut moved = x.clone();
            moved[k] = value.clamp(lo, hi);
            let cost = cost_at(&moved);
            if cost < least - SAME {
                (least, *x) = (cost, moved);
            }
        };
        // A spread or a probability is known to a factor at first; at the least one it is at its bound.
        try_at(lo, &mut x);
        (0..OCTAVES).for_each(|octave| try_at(lo + (hi - lo) * 0.5f64.powi(octave), &mut x));
        let mut step = 0.5 * (x[k] - lo);
        for _ in 0..REFINED {
            step *= 0.5;
            let value = x[k];
            try_at(value - step, &mut x);
            try_at(value + step, &mut x);
        }
    }
    if x == fit.x {
        return fit;
    }
    Fit::at(segments, &fit.model, x).unwrap_or(fit)
}
