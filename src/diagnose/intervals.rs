//! 95 % intervals of parameters: Laplace approximation of a fit with its effective number of observations.

use nalgebra::DMatrix;

use super::command_units::CommandUnits;
use super::fit::Fit;
use super::model::{Base, Parameter, corrected_residual, dot};
use super::report::Interval;
use super::score::{effective_observations, likelihood, random_information, scale_free};
use super::segments::Segments;
use super::settings::{conventions::WITHIN_95, solver};
use crate::motor::catalogue::kind;
use crate::motor::fit::ParameterId;

/// A fit's posterior covariance.
pub(crate) fn covariance(segments: &Segments, base: &Base, fit: &Fit) -> DMatrix<f64> {
    let n_eff = effective_observations(segments, &fit.corrected);
    let mut hessian = scale_free(base, fit, n_eff).hessian;
    if fit.model.is_random() {
        let noise = likelihood(segments, base, fit).noise;
        for (k, information) in random_information(segments, base, fit, noise) {
            hessian[(k, k)] += information;
        }
    }
    let n = hessian.nrows();
    let ridged = || {
        let mut ridged = hessian.clone();
        (0..n).for_each(|k| ridged[(k, k)] *= 1.0 + solver::LAST_DIGITS);
        ridged.try_inverse()
    };
    (hessian.clone().try_inverse())
        .or_else(ridged)
        .unwrap_or_else(|| DMatrix::zeros(n, n))
}

/// The interval of parameter `k` in SI, and in units of the command if no torque is known.
pub(crate) fn interval(
    segments: &Segments,
    fit: &Fit,
    covariance: &DMatrix<f64>,
    k: usize,
    units: Option<CommandUnits>,
) -> Interval {
    let unit = unit_of(fit.model.parameters[k].id);
    let own = ends(segments, fit, covariance, k, has_torque(unit));
    // R and Kt, and their tolerances, cancel there.
    let in_command = units.and_then(|units| {
        let own = ends(segments, fit, covariance, k, false);
        units.of(&Interval { unit, ..own })
    });
    Interval {
        unit,
        in_command,
        ..own
    }
}

/// Value and ends of the interval, with or without the tolerances of R and Kt.
fn ends(
    segments: &Segments,
    fit: &Fit,
    covariance: &DMatrix<f64>,
    k: usize,
    is_relative: bool,
) -> Interval {
    let Parameter { log, lo, hi, .. } = fit.model.parameters[k];
    let x = fit.x[k];
    let mut deviation = covariance[(k, k)].max(0.0).sqrt();
    // Torques, inertias and currents are identifiable relative to R and Kt only, whose tolerances add.
    if is_relative {
        let share = if log { 1.0 } else { x.abs() };
        deviation = deviation.hypot(fit.model.scale * share);
    }
    let parameter = &fit.model.parameters[k];
    let at = |x: f64| parameter.value(x.clamp(lo, hi));
    let (mut low, mut high) = (x - WITHIN_95 * deviation, x + WITHIN_95 * deviation);
    if !parameter.smooth {
        let n_eff = effective_observations(segments, &fit.corrected);
        low = profile_end(segments, fit, k, lo, n_eff);
        high = profile_end(segments, fit, k, hi, n_eff);
    }
    let (a, b) = (at(low), at(high));
    Interval {
        value: parameter.value(x),
        lo95: a.min(b),
        hi95: a.max(b),
        unit: "",
        at_bound: false,
        reference: None,
        in_command: None,
    }
}

/// End of the 95 % interval towards a limit by the profile likelihood, for a parameter of which the prediction is not
/// a smooth function: a threshold between two commanded levels can only be located between them.
fn profile_end(segments: &Segments, fit: &Fit, k: usize, limit: f64, n_eff: f64) -> f64 {
    let least = fit.square_sum();
    let is_beyond = |at: f64| {
        let mut x = fit.x.clone();
        x[k] = at;
        corrected_residual(segments, &fit.model.motor(&x)).is_none_or(|residual| {
            let risen = dot(&residual, &residual) / least.max(f64::MIN_POSITIVE);
            n_eff * risen.ln() > WITHIN_95 * WITHIN_95
        })
    };
    let from = fit.x[k];
    let at = |share: f64| from + share * (limit - from);
    let (mut inside, mut beyond) = (0.0, 1.0);
    // Outwards from a thousandth of the range, then by bisection.
    let mut share = solver::PROFILE_FIRST;
    while share < 1.0 {
        if is_beyond(at(share)) {
            beyond = share;
            break;
        }
        inside = share;
        share *= 2.0;
    }
    for _ in 0..solver::BISECTIONS {
        let middle = 0.5 * (inside + beyond);
        if is_beyond(at(middle)) {
            beyond = middle;
        } else {
            inside = middle;
        }
    }
    at(beyond)
}

/// Whether values in this unit are identifiable relative to R and Kt only.
fn has_torque(unit: &str) -> bool {
    ["N m", "kg m", "A"]
        .iter()
        .any(|start| unit.starts_with(start))
}

/// Unit of an effect's parameter; empty for a base parameter, which is relative to the motor file's.
fn unit_of(id: ParameterId) -> &'static str {
    match id {
        ParameterId::Nominal(_) => "",
        ParameterId::Effect(index, k) => kind(index).parameters[k].unit,
    }
}

/// The interval of a function of the parameters, by the delta method.
pub(crate) fn interval_of(
    fit: &Fit,
    covariance: &DMatrix<f64>,
    unit: &'static str,
    of: impl Fn(&[f64]) -> f64,
) -> Interval {
    let value = of(&fit.x);
    let gradient: Vec<f64> = (0..fit.x.len())
        .map(|k| {
            let moved = |by: f64| {
                let mut x = fit.x.clone();
                x[k] += by;
                of(&x)
            };
            (moved(solver::FORMULA_STEP) - moved(-solver::FORMULA_STEP))
                / (2.0 * solver::FORMULA_STEP)
        })
        .collect();
    let mut variance = 0.0;
    for (i, a) in gradient.iter().enumerate() {
        for (j, b) in gradient.iter().enumerate() {
            variance += a * covariance[(i, j)] * b;
        }
    }
    let half = WITHIN_95 * variance.max(0.0).sqrt();
    Interval {
        value,
        lo95: value - half,
        hi95: value + half,
        unit,
        at_bound: false,
        reference: None,
        in_command: None,
    }
}
