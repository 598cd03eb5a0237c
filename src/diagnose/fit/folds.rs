//! Scores: what fits on the other folds predict, without these fits.

use nalgebra::DVector;
use rayon::prelude::*;

use super::fitted::{Fit, residual, squares_of, surroundings, whitened};
use super::{Model, Starts, response};
use crate::diagnose::noise::{Noise, Whitener};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::FOLDS;
use crate::motor::CommandKind;

/// Shares of a step that are tried until one lowers the cost.
const SHARES: [f64; 2] = [1.0, 0.3];

/// A fit at numbers that are settled.
pub(crate) fn finished(
    pieces: &Pieces,
    model: &Model,
    kind: CommandKind,
    x: Vec<f64>,
    noise: Noise,
    starts: Starts,
) -> Option<Fit> {
    let around = surroundings(pieces, model, &x, kind);
    let whitener = Whitener::new(pieces, &around, noise);
    let mut fit = whitened(pieces, model, x, (noise, around, starts), &whitener)?;
    let predicted = out_of_fold(pieces, &fit, &whitener, &|left| whitener.whiten(left));
    fit.elpd = scores(pieces, &fit, &squares_of(pieces, &predicted));
    Some(fit)
}

/// Scores of stretches: Student's t with as many degrees of freedom as the stretch has looks.
fn scores(pieces: &Pieces, fit: &Fit, squares: &[f64]) -> Vec<f64> {
    (pieces.stretches.iter().zip(squares).zip(&fit.log_det))
        .map(|((stretch, squares), log_det)| {
            let n = pieces.weight[stretch.samples.clone()].iter().sum::<f64>();
            -n * (squares.max(0.0) / n).ln_1p() - 0.5 * log_det
        })
        .collect()
}

/// Recorded less predicted as it is `seen`, each stretch predicted by one Gauss-Newton step from the fit on the other folds, simulated. A step that does
/// not lower the cost of what it was taken on is none.
pub(super) fn out_of_fold(
    pieces: &Pieces,
    fit: &Fit,
    whitener: &Whitener,
    seen: &(dyn Fn(&[f64]) -> Vec<f64> + Sync),
) -> Vec<f64> {
    let mut out = seen(&fit.residual);
    if pieces.stretches.len() < 2 || fit.columns.is_empty() {
        return out;
    }
    let whole = squares_of(pieces, &fit.white);
    let held = held(fit);
    let without: Vec<Option<Vec<f64>>> = (0..FOLDS.min(pieces.stretches.len()))
        .into_par_iter()
        .map(|fold| {
            let left = left_without(pieces, fit, whitener, (fold, &whole, &held));
            left.map(|left| seen(&left))
        })
        .collect();
    for stretch in &pieces.stretches {
        if let Some(left) = &without[stretch.fold] {
            let samples = stretch.samples.clone();
            out[samples.clone()].copy_from_slice(&left[samples]);
        }
    }
    out
}

/// Numbers that no step moves: what nothing depends on smoothly, and what is pulled beyond what is plausible.
fn held(fit: &Fit) -> Vec<bool> {
    let pull: DVector<f64> = fit.stretch_gradient.iter().sum::<DVector<f64>>()
        - &fit.model.precision * (DVector::from_column_slice(&fit.x) - &fit.model.mean);
    let numbers = fit.model.numbers.iter().enumerate();
    numbers
        .map(|(k, number)| {
            !number.smooth
                || (fit.x[k] <= number.lo && pull[k] < 0.0)
                || (fit.x[k] >= number.hi && pull[k] > 0.0)
        })
        .collect()
}

/// Recorded less predicted after a step without one fold; none where no step lowers the cost of the others.
fn left_without(
    pieces: &Pieces,
    fit: &Fit,
    whitener: &Whitener,
    (fold, whole, held): (usize, &[f64], &[bool]),
) -> Option<Vec<f64>> {
    let n = fit.columns.len();
    let trained = |squares: &[f64], x: &[f64]| -> f64 {
        let pairs = pieces.stretches.iter().zip(squares);
        let others = pairs.filter(|(stretch, _)| stretch.fold != fold);
        0.5 * others.map(|(_, s)| s).sum::<f64>() + fit.model.normal_prior(x)
    };
    let mut hessian = fit.hessian.clone();
    let mut gradient = DVector::zeros(n);
    for (k, stretch) in pieces.stretches.iter().enumerate() {
        if stretch.fold == fold {
            hessian -= &fit.stretch_hessian[k];
            gradient += &fit.stretch_gradient[k];
        }
    }
    for k in (0..n).filter(|k| held[*k]) {
        hessian.row_mut(k).fill(0.0);
        hessian.column_mut(k).fill(0.0);
        hessian[(k, k)] = 1.0;
        gradient[k] = 0.0;
    }
    for k in 0..n {
        hessian[(k, k)] += 1e-6 * fit.hessian[(k, k)].max(1e-12);
    }
    let solved = hessian.cholesky()?.solve(&gradient);
    let before = trained(whole, &fit.x);
    SHARES.iter().find_map(|share| {
        let moved = fit.x.iter().zip(solved.iter());
        let mut x: Vec<f64> = moved.map(|(x, s)| x - share * s).collect();
        fit.model.clamp(&mut x);
        let predicted = response(pieces, &fit.model.motor(&x), &fit.starts)?;
        let left = residual(pieces, &predicted);
        let then = squares_of(pieces, &whitener.whiten(&left));
        (trained(&then, &x) < before).then_some(left)
    })
}

/// Score of numbers that nothing was fitted to, under a fit's noise.
pub(crate) fn score_at(pieces: &Pieces, fit: &Fit, x: &[f64]) -> Option<f64> {
    let whitener = Whitener::new(pieces, &fit.around, fit.noise);
    let predicted = response(pieces, &fit.model.motor(x), &fit.starts)?;
    let white = whitener.whiten(&residual(pieces, &predicted));
    let squares = squares_of(pieces, &white);
    let score: f64 = scores(pieces, fit, &squares).iter().sum();
    Some(score - fit.model.prior(x))
}
