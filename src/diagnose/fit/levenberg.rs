//! Levenberg and Marquardt's fit of whitened residuals with prior rows (Marquardt, 1963).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fitted::{Fit, dot, residual, surroundings};
use super::folds::finished;
use super::{Model, response, sensitivities};
use crate::diagnose::noise::{Noise, Whitener, likeliest};
use crate::diagnose::pieces::Pieces;
use crate::motor::CommandKind;

/// Most steps of a fit under one noise: a fit that settles takes six.
const MOST_STEPS: usize = 20;
/// A fit ends with a step that gains less than so many nats: a fortieth of what decides.
const ENOUGH: f64 = 0.1;
/// Most times that the noise is found anew: it stands still after two.
const ROUNDS: usize = 4;

/// Fits a model from the likeliest of some starts, with the noise that is found on the way.
pub(crate) fn fit(
    pieces: &Pieces,
    model: &Model,
    kind: CommandKind,
    starts: &[Vec<f64>],
) -> Option<Fit> {
    let begun = (starts.par_iter()).filter_map(|start| {
        let mut x = start.clone();
        model.clamp(&mut x);
        let at = At::new(pieces, model, x)?;
        let around = surroundings(pieces, model, &at.x, kind);
        let noise = likeliest(pieces, &around, &at.residual);
        let whitener = Whitener::new(pieces, &around, noise);
        let e = whitener.whiten(&at.residual);
        let determinants = whitener.log_det.iter().sum::<f64>();
        let cost = 0.5 * (dot(&e, &e) + determinants) + model.prior(&at.x);
        Some((cost, at, noise))
    });
    let begun: Vec<(f64, At, Noise)> = begun.collect();
    let (_, mut at, mut noise) = (begun.into_iter()).min_by(|a, b| a.0.total_cmp(&b.0))?;
    for round in 0..ROUNDS {
        let around = surroundings(pieces, model, &at.x, kind);
        let whitener = Whitener::new(pieces, &around, noise);
        at = minimise(pieces, model, &whitener, at)?;
        let around = surroundings(pieces, model, &at.x, kind);
        let found = likeliest(pieces, &around, &at.residual);
        if found == noise && round > 0 {
            break;
        }
        noise = found;
    }
    finished(pieces, model, kind, at.x, noise)
}

/// Numbers, and what they leave.
#[derive(Debug, Clone)]
pub(super) struct At {
    pub x: Vec<f64>,
    /// Recorded less predicted, in counts.
    pub residual: Vec<f64>,
}

impl At {
    pub fn new(pieces: &Pieces, model: &Model, x: Vec<f64>) -> Option<Self> {
        let residual = residual(pieces, &response(pieces, &model.motor(&x))?);
        Some(Self { x, residual })
    }
}

/// The numbers that cost least under a noise, from some on.
pub(super) fn minimise(
    pieces: &Pieces,
    model: &Model,
    whitener: &Whitener,
    mut at: At,
) -> Option<At> {
    let n = at.x.len();
    let mut damping = 1e-3;
    let cost_of = |at: &At| -> f64 {
        let white = whitener.whiten(&at.residual);
        0.5 * dot(&white, &white) + model.prior(&at.x)
    };
    let mut cost = cost_of(&at);
    if !cost.is_finite() {
        return None;
    }
    for _ in 0..MOST_STEPS {
        let Some((predicted, columns)) = sensitivities(pieces, model, &at.x) else {
            break;
        };
        let white = whitener.whiten(&residual(pieces, &predicted));
        let columns = whitener.whiten_all(&columns);
        let d = DVector::from_column_slice(&at.x) - &model.mean;
        let hessian =
            DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j])) + &model.precision;
        let gradient = DVector::from_fn(n, |i, _| dot(&columns[i], &white)) - &model.precision * d;
        let mut gained = 0.0;
        let mut done = false;
        for _ in 0..8 {
            let mut damped = hessian.clone();
            for k in 0..n {
                damped[(k, k)] += damping * hessian[(k, k)].max(1e-9);
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else {
                damping *= 10.0;
                continue;
            };
            let mut next: Vec<f64> = (at.x.iter())
                .zip(step.iter())
                .map(|(x, s)| x + s.clamp(-1.5, 1.5))
                .collect();
            model.clamp(&mut next);
            let next = At::new(pieces, model, next);
            let then = next.as_ref().map_or(f64::INFINITY, cost_of);
            if let Some(next) = next.filter(|_| then < cost) {
                gained = cost - then;
                (at, cost) = (next, then);
                damping = (damping * 0.2).max(1e-9);
                done = true;
                break;
            }
            damping *= 6.0;
        }
        if !done || gained < ENOUGH {
            break;
        }
    }
    Some(at)
}
