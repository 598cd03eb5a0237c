//! The score of a set of effects, the effective number of observations, the posterior.
//!
//! Two scores of a fit, both Laplace approximations of a log evidence (MacKay 2003, chapter 28):
//!
//! - **likelihood**: quantization and a random load torque whose strength is fitted,
//!   `-1/2 (e'e + ln|S|) - prior + 1/2 ln|P| - 1/2 ln|H| - ln(options) - |S| ln(39)`, `e` the whitened innovations;
//! - **scale-free**: one unknown variance of the corrected residual and as many observations as it effectively has,
//!   `-1/2 N ln MSE - prior + 1/2 ln|P| - 1/2 ln|H| - ln(options) - |S| ln(39)` with `H = J'J N/(n MSE) + P`.
//!
//! Neither rewards a fit below the noise floor. The likelihood is used where its noise is credible: where the best set leaves a
//! random load and whitened squares that a bench has. Elsewhere the model is wrong in more than noise, a likelihood is overconfident
//! (Yang and Zhu 2018), and the scale-free score is used.

use crate::motor::catalogue::ids;
use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::fit::{Fit, Moved, gram};
use super::model::{Base, Member, Model, dot, less, range_of};
use super::noise::{LinearPlant, Noise, Whitener, likeliest};
use super::segments::{Segments, drag, time_constant_s};
use super::settings::solver::{
    COEFFICIENTS, DIFFERENCE, LAST_DIGITS, REFINEMENTS, TIME_CONSTANTS_S,
};
use crate::motor::catalogue::{Prior, catalogue};
use crate::motor::fit::ParameterId;
use crate::motor::{CommandKind, Motor};
use crate::units::ROUNDING_VARIANCE;

/// Optimum of a score near a fit, in nats.
#[derive(Debug, Clone)]
pub(crate) struct Optimum {
    /// Negative log likelihood.
    pub data: f64,
    /// Negative log prior density of the parameters and of the noise.
    pub prior: f64,
    /// Log prior odds of the set and volume of its posterior relative to its prior.
    pub volume: f64,
    /// `J'J` in units of the noise, plus the precision of the prior.
    pub hessian: DMatrix<f64>,
}

impl Optimum {
    /// Negative log posterior density.
    pub fn cost(&self) -> f64 {
        self.data + self.prior
    }

    /// The log evidence where no data cost below this is rewarded.
    pub fn score(&self, least: f64) -> f64 {
        let score = self.volume - self.data.max(least) - self.prior;
        if score.is_finite() {
            score
        } else {
            f64::NEG_INFINITY
        }
    }
}

/// Likelihood of a fit.
#[derive(Debug, Clone)]
pub(crate) struct Likelihood {
    pub optimum: Optimum,
    pub noise: Noise,
    pub plant: LinearPlant,
    /// Whitened squares over their expectation.
    pub squares: f64,
}

/// The linearized plant of a motor.
pub(crate) fn plant_of(segments: &Segments, motor: &Motor, kind: CommandKind) -> LinearPlant {
    let p = &motor.parameters;
    let commands = segments.runs.iter().flat_map(|run| &run.command);
    let supply = match kind {
        CommandKind::Voltage => p.supply_v,
        _ => LAST_DIGITS,
    };
    let largest = commands.fold(supply, |most, u| most.max(u.abs()));
    let number = |id: &str, key: &str| {
        let number = ParameterId::effect(id, key);
        number.and_then(|id| id.get(motor)).unwrap_or(0.0)
    };
    LinearPlant {
        time_constant_s: (p.inertia_kg_m2 / drag(p, kind).max(f64::MIN_POSITIVE))
            .clamp(TIME_CONSTANTS_S.0, TIME_CONSTANTS_S.1),
        stall_counts_s2: largest / kind.per_nm(p) / p.inertia_kg_m2 / segments.runs[0].rad,
        jitter_s: number(ids::SAMPLE_JITTER, "spread_s").hypot(segments.arrivals_s),
        loss: number(ids::MISSED_COUNTS, "probability"),
    }
}

/// Fisher information of a random effect's parameter in the variances `s` of the innovations: `1/2 sum (d ln s/dx)^2`.
pub(crate) fn random_information(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
    noise: Noise,
) -> Vec<(usize, f64)> {
    let of = |k: usize| {
        let parameter = &fit.model.parameters[k];
        let h = DIFFERENCE * (parameter.hi - parameter.lo);
        let variances = [-h, h].map(|by| {
            let mut x = fit.x.clone();
            x[k] += by;
            let plant = plant_of(segments, &fit.model.motor(&x), base.kind);
            Whitener::new(segments, &plant, noise)
        });
        let pairs = variances[0].variances().zip(variances[1].variances());
        let slopes = pairs.filter(|(a, _)| *a > 0.0);
        let squares = slopes.map(|(a, b)| ((b / a).ln() / (2.0 * h)).powi(2));
        (k, 0.5 * squares.sum::<f64>())
    };
    fit.model.random().map(of).collect()
}

/// Log prior odds of a set and log volume of its posterior relative to its prior: `1/2 ln|P| - 1/2 ln|H| - ln(options) - |S| ln(39)`. An angle
/// anywhere on the circle has the density 1/(2 pi), which is the precision that gives the Laplace approximation this normalization.
fn log_volume(base: &Base, model: &Model, hessian: &DMatrix<f64>) -> f64 {
    let (mut prior, mut posterior) = (model.precision.clone(), hessian.clone());
    for k in 0..prior.nrows() {
        if prior[(k, k)] <= 0.0 {
            prior[(k, k)] = 1.0 / TAU;
            posterior[(k, k)] += 1.0 / TAU;
        }
    }
    let per_effect = (catalogue().len() as f64).ln();
    let options: f64 = model.members.iter().map(|m| log_options(base, m)).sum();
    0.5 * (log_det(&prior) - log_det(&posterior))
        - options
        - model.members.len() as f64 * per_effect
}

/// Log of the number of discrete alternatives of an effect: orders of the angle, sides, values of a list.
pub(crate) fn log_options(base: &Base, member: &Member) -> f64 {
    let of = |parameter: &crate::motor::catalogue::EffectParameter| match parameter.prior {
        Prior::OneOf(values) if parameter.key != "max_rate_hz" => (values.len() as f64).ln(),
        _ if parameter.key == "cycles_per_rev" => {
            let (lo, hi) = range_of(parameter, base);
            (hi - lo + 1.0).max(1.0).ln()
        }
        _ if parameter.key == "encoder_side" => 2f64.ln(),
        _ => 0.0,
    };
    catalogue()[member.index].parameters.iter().map(of).sum()
}

/// Log determinant of a positive definite matrix; infinite of any other, which no parameter is determined by.
fn log_det(matrix: &DMatrix<f64>) -> f64 {
    let cholesky = matrix.clone().cholesky();
    let sum = cholesky.map(|c| 2.0 * c.l().diagonal().iter().map(|d| d.ln()).sum::<f64>());
    sum.filter(|sum| sum.is_finite()).unwrap_or(f64::INFINITY)
}

/// The scale-free score of a fit for an effective number of observations.
pub(crate) fn scale_free(base: &Base, fit: &Fit, n_eff: f64) -> Optimum {
    let floor = ROUNDING_VARIANCE;
    let n = fit.corrected.len().max(1) as f64;
    let model = &fit.model;
    let precision = model.precision_as_unlikely(&fit.x);
    let distance = DVector::from_column_slice(&fit.x) - &model.mean;
    let squares = fit.square_sum();
    let data = |square_sum: f64| 0.5 * n_eff * (square_sum / n).max(floor).ln();
    let mut best = (data(squares), fit.prior);
    let mut mean_square = (squares / n).max(floor);
    for _ in 0..REFINEMENTS {
        let weight = n_eff / (n * mean_square);
        let hessian = &fit.gram * weight + &precision;
        let right = &fit.gradient * weight - &precision * &distance;
        let Some(step) = hessian.cholesky().map(|c| c.solve(&right)) else {
            break;
        };
        let then = squares - 2.0 * fit.gradient.dot(&step) + (&fit.gram * &step).dot(&step);
        let found = (
            data(then),
            fit.prior + prior_of_step(&precision, &distance, &step),
        );
        if found.0 + found.1 >= best.0 + best.1 {
            break;
        }
        best = found;
        mean_square = (then / n).max(floor);
    }
    let weight = n_eff / (n * mean_square);
    let mut hessian = &fit.gram * weight + &precision;
    with_profiles(fit, &precision, &mut hessian, &|moved| {
        (weight * moved.square, &moved.along * weight)
    });
    Optimum {
        data: best.0,
        prior: best.1,
        volume: log_volume(base, model, &hessian),
        hessian,
    }
}

/// Replaces the curvature along each parameter that the prediction does not depend on smoothly by that of its profile: at one standard
/// deviation the cost has risen by half a nat; where it jumps, the posterior is uniform up to there. `weighed` gives of a step the square
/// of the change and its products with the columns, in units of the noise.
fn with_profiles(
    fit: &Fit,
    precision: &DMatrix<f64>,
    hessian: &mut DMatrix<f64>,
    weighed: &dyn Fn(&Moved) -> (f64, DVector<f64>),
) {
    for profile in &fit.profiles {
        let k = profile.parameter;
        hessian.row_mut(k).fill(0.0);
        hessian.column_mut(k).fill(0.0);
        hessian[(k, k)] = precision[(k, k)];
    }
    // The other parameters follow a step.
    let others = hessian.clone().cholesky();
    for profile in &fit.profiles {
        let risen = |moved: &Moved| {
            let (square, mut along) = weighed(moved);
            fit.profiles
                .iter()
                .for_each(|one| along[one.parameter] = 0.0);
            let followed = others.as_ref().map_or(0.0, |c| along.dot(&c.solve(&along)));
            0.5 * (square - followed)
        };
        let width = |side: &[Moved]| {
            let mut uniform = 0.0;
            for moved in side {
                let cost = risen(moved);
                if cost >= 0.5 {
                    return (moved.by * (0.5 / cost).sqrt()).max(uniform);
                }
                uniform = moved.by / 3f64.sqrt();
            }
            uniform
        };
        let [below, above] = &profile.sides;
        let deviation = 0.5 * (width(below) + width(above));
        if deviation > 0.0 {
            hessian[(profile.parameter, profile.parameter)] += deviation.powi(-2);
        }
    }
}

/// By how much a step changes a normal prior's negative log density.
fn prior_of_step(precision: &DMatrix<f64>, distance: &DVector<f64>, step: &DVector<f64>) -> f64 {
    let off = distance + step;
    0.5 * ((precision * &off).dot(&off) - (precision * distance).dot(distance))
}

/// The likelihood of a fit, at its optimum by linear steps, each under the likeliest noise of what is left.
pub(crate) fn likelihood(segments: &Segments, base: &Base, fit: &Fit) -> Likelihood {
    let usual_load = base.settings.usual_load;
    let mut residual = fit.residual.clone();
    let mut best: Option<Likelihood> = None;
    for _ in 0..=REFINEMENTS {
        let plant = plant_of(segments, &fit.model.motor(&fit.x), base.kind);
        let noise = likeliest(segments, &plant, usual_load, &residual);
        if best.as_ref().is_some_and(|best| best.noise == noise) {
            break;
        }
        let (found, step) = likelihood_under(segments, base, fit, noise);
        if (best.as_ref()).is_none_or(|best| found.optimum.cost() < best.optimum.cost()) {
            best = Some(found);
        }
        residual = less(&fit.residual, &fit.columns, &step);
    }
    best.expect("one refinement at least")
}

/// The likelihood of a fit under a noise, at its optimum by a linear step or where it is; and that step.
pub(crate) fn likelihood_under(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
    noise: Noise,
) -> (Likelihood, DVector<f64>) {
    let model = &fit.model;
    let plant = plant_of(segments, &model.motor(&fit.x), base.kind);
    let precision = model.precision_as_unlikely(&fit.x);
    let distance = DVector::from_column_slice(&fit.x) - &model.mean;
    let whitener = Whitener::new(segments, &plant, noise);
    let white = whitener.whiten(&fit.residual);
    let columns = whitener.whiten_all(&fit.columns);
    let mut hessian = gram(&columns) + &precision;
    let mut right =
        DVector::from_fn(columns.len(), |i, _| dot(&columns[i], &white)) - &precision * &distance;
    let none = DVector::zeros(columns.len());
    let mut solved = hessian.clone();
    for (k, information) in random_information(segments, base, fit, noise) {
        hessian[(k, k)] += information;
        // The variance of the innovations was not made for another value of it.
        solved.row_mut(k).fill(0.0);
        solved.column_mut(k).fill(0.0);
        solved[(k, k)] = 1.0;
        right[k] = 0.0;
    }
    with_profiles(fit, &precision, &mut hessian, &|moved| {
        let change = whitener.whiten(&moved.change);
        let along = DVector::from_fn(columns.len(), |i, _| dot(&columns[i], &change));
        (dot(&change, &change), along)
    });
    let step = (solved.cholesky()).map_or_else(|| none.clone(), |solved| solved.solve(&right));
    let volume = log_volume(base, model, &hessian);
    let expected: f64 = segments.weight.iter().sum();
    let at = |step: &DVector<f64>| {
        let moved = less(&white, &columns, step);
        let optimum = Optimum {
            data: whitener.cost(&moved),
            prior: fit.prior
                + prior_of_step(&precision, &distance, step)
                + noise.prior(base.settings.usual_load),
            volume,
            hessian: hessian.clone(),
        };
        let squares = dot(&moved, &moved) / expected;
        Likelihood {
            optimum,
            noise,
            plant,
            squares,
        }
    };
    let (moved, here) = (at(&step), at(&none));
    let is_lower = moved.optimum.cost() <= here.optimum.cost();
    (if is_lower { moved } else { here }, step)
}

/// Effective number of independent observations in a corrected residual: by octaves of its cosine transform (Satterthwaite 1946), or by
/// its autocorrelation (Thiebaux and Zwiers 1984) if that is less.
pub(crate) fn effective_observations(segments: &Segments, residual: &[f64]) -> f64 {
    let mut bands: Vec<(f64, f64)> = Vec::new();
    let mut lagged: Vec<f64> = Vec::new();
    let mut squares = 0.0;
    for segment in &segments.segments {
        let r = &residual[segment.range()];
        squares += dot(r, r);
        for (band, power, coefficients) in octaves(r) {
            if bands.len() <= band {
                bands.resize(band + 1, (0.0, 0.0));
            }
            bands[band].0 += power;
            bands[band].1 += coefficients;
        }
        for lag in 1..r.len() {
            if lagged.len() < lag {
                lagged.push(0.0);
            }
            lagged[lag - 1] += dot(&r[lag..], r);
        }
    }
    let n = residual.len() as f64;
    if squares <= 0.0 {
        return n;
    }
    let sum: f64 = bands.iter().map(|(power, _)| power).sum();
    let spread: f64 = bands
        .iter()
        .filter(|(_, n)| *n > 0.0)
        .map(|(p, n)| p * p / n)
        .sum();
    let by_bands = sum * sum / spread;
    let correlated = lagged
        .iter()
        .map(|l| l / squares)
        .take_while(|rho| *rho > 0.0);
    let by_lags = n / (1.0 + 2.0 * correlated.sum::<f64>());
    by_bands.min(by_lags).clamp(1.0, n)
}

/// Octave, power and number of coefficients of the orthonormal cosine transform (DCT-II) of a segment.
fn octaves(r: &[f64]) -> Vec<(usize, f64, f64)> {
    let n = r.len();
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    let mut left = dot(r, r);
    let most = n.min(COEFFICIENTS);
    for j in 0..most {
        // cos(pi j (k + 1/2)/n) by the recurrence of Chebyshev.
        let angle = std::f64::consts::PI * j as f64 / n as f64;
        let (twice, first) = (2.0 * angle.cos(), (0.5 * angle).cos());
        let (mut before, mut now, mut sum) = (first, first, 0.0);
        for value in r {
            sum += value * now;
            (before, now) = (now, twice * now - before);
        }
        let power = sum * sum * if j == 0 { 1.0 } else { 2.0 } / n as f64;
        left -= power;
        let band = if j == 0 { 0 } else { j.ilog2() as usize + 1 };
        match found.last_mut() {
            Some(last) if last.0 == band => {
                last.1 += power;
                last.2 += 1.0;
            }
            _ => found.push((band, power, 1.0)),
        }
    }
    if n > most {
        found.push((
            COEFFICIENTS.ilog2() as usize + 1,
            left.max(0.0),
            (n - most) as f64,
        ));
    }
    found
}

/// Probabilities of scores: `p ~ exp(learning_rate score)`.
pub(crate) fn posterior(scores: &[f64], learning_rate: f64) -> Vec<f64> {
    let best = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let odds: Vec<f64> = (scores.iter())
        .map(|score| (learning_rate * (score - best)).exp())
        .collect();
    let sum: f64 = odds.iter().sum();
    odds.iter().map(|odd| odd / sum).collect()
}

/// Time constant in s of a fit's motor.
pub(crate) fn fitted_time_constant_s(fit: &Fit) -> f64 {
    time_constant_s(&fit.model.motor(&fit.x))
}
