//! Numbers that the likelihood knows through the filter: the variance of rounding, the share of edges lost by chance,
//! the spread of samples taken late.
//!
//! None moves the prediction, or not that alone: `d ln L/dq = -1/2 d/dq sum (ln S_k(q) + e_k(q)^2/S_k(q))`, by differences,
//! with the innovations `e` and their variances `S` of the filter.

use rayon::prelude::*;

use super::fit::{Fit, log_likelihood};
use super::hypothesis::Hypothesis;
use super::noise::{NoiseLevel, Whitener};
use super::problem::Problem;

/// Step of the logarithm of a noise's number, for differences.
const STEP: f64 = 0.05;

/// Share of the curvature by a noise's number that its interval believes: the filter takes rounding as white and
/// losses as even, and neither is quite so.
pub(super) const INFORMATION: f64 = 0.25;

impl Problem<'_> {
    /// The share of rounding's variance that makes what a fit leaves likeliest. Beside the tones of an even turn less
    /// is left than 1/12, and how much less depends on how evenly the shaft turned.
    pub fn likeliest_rounding(&self, fit: &Fit) -> f64 {
        let likelihood = |share: f64| {
            let level = NoiseLevel {
                rounding: share,
                ..self.noise(&fit.hypothesis, &fit.p, fit.wander)
            };
            let whiteners = Whitener::all(self.runs, &self.responses, &level);
            log_likelihood(&self.whitened(&fit.predictions, &whiteners), &whiteners)
        };
        let shares: Vec<f64> = (5..=20).map(|k| 0.05 * f64::from(k)).collect();
        let best = shares
            .into_par_iter()
            .map(|share| (share, likelihood(share)));
        let best = best.max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(1.0, |best| best.0)
    }

    /// Slope and curvature of the log-likelihood by each number of a noise, through the filter alone: by differences,
    /// the predictions as they are.
    pub fn noise_curvature(
        &self,
        hypothesis: &Hypothesis,
        p: &[f64],
        wander: f64,
        predictions: &[Vec<f64>],
        r: &[f64],
        whiteners: &[Whitener],
    ) -> Vec<(usize, f64, f64)> {
        let at = |k: usize, step: f64| {
            let mut moved = p.to_vec();
            moved[k] += step;
            let whiteners = self.whiteners(&self.noise(hypothesis, &moved, wander));
            log_likelihood(&self.whitened(predictions, &whiteners), &whiteners)
        };
        let here = log_likelihood(r, whiteners);
        let of = |k: usize| {
            let (less, more) = (at(k, -STEP), at(k, STEP));
            let slope = (more - less) / (2.0 * STEP);
            let curvature = (2.0 * here - less - more) / (STEP * STEP);
            // No step goes farther than a unit of the logarithm.
            (k, slope, curvature.max(slope.abs()))
        };
        hypothesis.noise_numbers().map(of).collect()
    }
}
