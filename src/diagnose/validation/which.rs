//! Which of several: differences over pieces, their standard errors, and weights by the Bayesian bootstrap (Yao et al., 2018).

use rand::SeedableRng;
use rand_distr::{Distribution, Exp1};
use rand_pcg::Pcg64Mcg;

use crate::diagnose::fit::{Fit, error_of_sum};
use crate::diagnose::settings::{TIED_ERRORS, TIED_NATS};

/// Draws of the bootstrap.
const DRAWS: u64 = 400;

/// How a fit stands to the best one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tie {
    pub behind: f64,
    pub error: f64,
    pub weight: f64,
    pub is_tied: bool,
}

impl Tie {
    /// Of a fit that is so many nats behind and no rival.
    pub fn apart(behind: f64) -> Self {
        Self {
            behind,
            error: 0.0,
            weight: 0.0,
            is_tied: false,
        }
    }
}

/// Standing of each of `fits`, the best first, with the smaller model they share as the last.
pub(crate) fn standing(fits: &[&Fit]) -> Vec<Tie> {
    let Some(best) = fits.first() else {
        return Vec::new();
    };
    let n = best.elpd.len();
    let mut weights = vec![0.0; fits.len()];
    let mut random = Pcg64Mcg::seed_from_u64(0x626f_6f74);
    for _ in 0..DRAWS {
        let draw: Vec<f64> = (0..n).map(|_| Exp1.sample(&mut random)).collect();
        let sum: f64 = draw.iter().sum();
        let scores: Vec<f64> = fits
            .iter()
            .map(|fit| {
                let score: f64 = fit
                    .elpd
                    .iter()
                    .zip(&draw)
                    .map(|(e, d): (&f64, &f64)| e * d)
                    .sum();
                score * n as f64 / sum - fit.prior
            })
            .collect();
        let most = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = scores.iter().map(|s| (s - most).exp()).sum();
        for (weight, score) in weights.iter_mut().zip(&scores) {
            *weight += (score - most).exp() / total / DRAWS as f64;
        }
    }
    fits.iter()
        .zip(weights)
        .map(|(fit, weight)| {
            let behind = best.score() - fit.score();
            let each: Vec<f64> = best
                .elpd
                .iter()
                .zip(&fit.elpd)
                .map(|(a, b)| a - b)
                .collect();
            let error = error_of_sum(&each);
            Tie {
                behind,
                error,
                weight,
                is_tied: behind < TIED_NATS || behind < TIED_ERRORS * error,
            }
        })
        .collect()
}
