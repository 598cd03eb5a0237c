//! Parameters of random effects (lost edges, late samples): maximum likelihood of the variance that they predict.
//!
//! In: a fit. Out: the fit with these parameters at the maximum of the likelihood and all others changed by linear
//! steps. Least squares does not depend on them: a variance has no residual.

use super::fit::Fit;
use super::model::{Base, predict};
use super::noise::likeliest;
use super::score::{likelihood_under, plant_of};
use super::segments::Segments;
use super::settings::solver::{BISECTIONS, RANDOM_STEP, SAME};

/// A fit with maximum likelihood parameters of its random effects, each under its likeliest noise: a step search with halving.
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
        let parameter = &fit.model.parameters[k];
        let mut step = RANDOM_STEP * (parameter.hi - parameter.lo);
        for _ in 0..BISECTIONS {
            let moved = [-step, step].map(|by| {
                let mut moved = x.clone();
                moved[k] = (x[k] + by).clamp(parameter.lo, parameter.hi);
                (cost_at(&moved), moved)
            });
            let [below, above] = moved;
            let (cost, moved) = if below.0 < above.0 { below } else { above };
            if cost < least - SAME {
                (least, x) = (cost, moved);
            } else {
                step *= 0.5;
            }
        }
    }
    if x == fit.x {
        return fit;
    }
    Fit::at(segments, &fit.model, x).unwrap_or(fit)
}
