//! The error budget: held-out squared error above the noise floor, split by step.
//!
//! In: the nested models (nominal, re-identified parameters, with one effect after the other) on held-out data. Out:
//! for each step the share of the nominal reducible squared error that it removes, with 95 % intervals by the
//! Bayesian bootstrap (Rubin 1981) over segments, or over runs where there are enough. Held out are `--hold-out`
//! runs, segments outside the searched subset, or the folds of a cross-validation, each predicted by one linear step
//! from the fit on the other folds.

mod floor;
mod place;

pub(crate) use floor::{median, stated_floor, travel};
pub(crate) use place::located;

use std::ops::Range;

use nalgebra::DVector;
use rand::SeedableRng;
use rand_distr::{Distribution, Exp1};
use rand_pcg::Pcg64Mcg;

use super::fit::{Fit, gram};
use super::model::{Base, dot, mean_square};
use super::score::{effective_observations, scale_free};
use super::segments::{Segment, Segments};
use super::settings::Settings;
use super::settings::conventions::ENDS_95;
use super::settings::solver::{DRAWS, SAME};

/// Corrected residual of a fit by cross-validation: each block is predicted from the fit on the other folds, to first
/// order.
pub(crate) fn cross_validated(segments: &Segments, base: &Base, fit: &Fit) -> Vec<f64> {
    let mut out = fit.corrected.clone();
    let n_eff = effective_observations(segments, &fit.corrected);
    let weight = n_eff / fit.square_sum().max(f64::MIN_POSITIVE);
    let hessian = scale_free(base, fit, n_eff).hessian;
    let columns: Vec<Vec<f64>> = fit.columns.iter().map(|c| segments.corrected(c)).collect();
    let gradient = &fit.gradient * weight;
    let Some(whole) = hessian.clone().cholesky().map(|c| c.solve(&gradient)) else {
        return out;
    };
    let folds = base.settings.folds;
    // Segments are assigned to folds in turn; if there are fewer, each is cut into as many blocks as there are folds.
    let parts = if segments.segments.len() < folds {
        folds
    } else {
        1
    };
    let cut = |segment: &Segment, j: usize| segment.at + j * segment.len() / parts;
    let blocks: Vec<Range<usize>> = (segments.segments.iter())
        .flat_map(|segment| (0..parts).map(move |j| cut(segment, j)..cut(segment, j + 1)))
        .collect();
    for fold in 0..folds {
        let held: Vec<usize> = (blocks.iter().skip(fold).step_by(folds))
            .flat_map(Range::clone)
            .collect();
        let of_held = |column: &Vec<f64>| -> Vec<f64> { held.iter().map(|k| column[*k]).collect() };
        let own: Vec<Vec<f64>> = columns.iter().map(of_held).collect();
        let r = of_held(&fit.corrected);
        let mut without = &hessian - gram(&own) * weight;
        let right = &gradient - DVector::from_fn(own.len(), |i, _| weight * dot(&own[i], &r));
        for k in 0..without.nrows() {
            without[(k, k)] += SAME * hessian[(k, k)];
        }
        let Some(step) = without.cholesky().map(|c| c.solve(&right) - &whole) else {
            continue;
        };
        for (j, k) in held.iter().enumerate() {
            out[*k] -= (own.iter().zip(step.iter()))
                .map(|(c, s)| c[j] * s)
                .sum::<f64>();
        }
    }
    out
}

/// Shares of the nominal reducible error of nested models, with bootstrap draws.
#[derive(Debug, Clone)]
pub(crate) struct Shares {
    /// RMS error in counts of each model.
    pub rms: Vec<f64>,
    /// Reducible mean square of each model relative to the nominal's: 1 for the nominal, the last is unexplained.
    left: Vec<f64>,
    draws: Vec<Vec<f64>>,
}

impl Shares {
    /// Shares of nested models on segments, nominal first, above each noise floor in counts RMS.
    pub fn new(
        segments: &Segments,
        models: &[Vec<f64>],
        floors: &[f64],
        settings: &Settings,
    ) -> Self {
        let is_by_run = segments.runs.len() >= settings.folds;
        let units = if is_by_run {
            segments.runs.len()
        } else {
            segments.segments.len()
        };
        let mut squares = vec![vec![0.0; models.len()]; units];
        let mut samples = vec![0.0; units];
        for (k, segment) in segments.segments.iter().enumerate() {
            let unit = if is_by_run { segment.run } else { k };
            samples[unit] += segment.len() as f64;
            for (m, model) in models.iter().enumerate() {
                let r = &model[segment.range()];
                squares[unit][m] += dot(r, r);
            }
        }
        let left = |weights: &[f64]| -> Vec<f64> {
            let n: f64 = weights.iter().zip(&samples).map(|(w, n)| w * n).sum();
            let mean = |m: usize| -> f64 {
                let sums = weights.iter().zip(&squares).map(|(w, s)| w * s[m]);
                sums.sum::<f64>() / n.max(f64::MIN_POSITIVE)
            };
            let reducible = |m: usize| (mean(m) - floors[m] * floors[m]).max(0.0);
            let nominal = reducible(0);
            let relative = |m: usize| {
                if nominal > 0.0 {
                    reducible(m) / nominal
                } else {
                    0.0
                }
            };
            (0..models.len()).map(relative).collect()
        };
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let draws = (0..DRAWS)
            .map(|_| {
                let weights: Vec<f64> = (0..units).map(|_| Exp1.sample(&mut random)).collect();
                left(&weights)
            })
            .collect();
        Self {
            rms: models.iter().map(|r| mean_square(r).sqrt()).collect(),
            left: left(&vec![1.0; units]),
            draws,
        }
    }

    /// RMS error of model `m`, with its 95 % interval.
    pub fn left(&self, m: usize) -> (f64, f64, f64) {
        self.interval(|left| left[m])
    }

    /// Share removed from model `from` to model `to`.
    pub fn between(&self, from: usize, to: usize) -> (f64, f64, f64) {
        self.interval(|left| left[from] - left[to])
    }

    fn interval(&self, of: impl Fn(&[f64]) -> f64) -> (f64, f64, f64) {
        let mut drawn: Vec<f64> = self.draws.iter().map(|left| of(left)).collect();
        drawn.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let k = (share * (drawn.len().max(1) - 1) as f64).round() as usize;
            drawn.get(k).copied().unwrap_or(f64::NAN)
        };
        let value = of(&self.left);
        let [lo, hi] = ENDS_95.map(at);
        (value, lo.min(value), hi.max(value))
    }
}
