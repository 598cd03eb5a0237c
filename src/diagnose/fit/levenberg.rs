//! Levenberg and Marquardt's fit of whitened residuals with prior rows (Marquardt, 1963).

use nalgebra::{DMatrix, DVector};

use super::{Model, less_start, response, sensitivities};
use crate::diagnose::noise::{Noise, Surroundings, Whitener, likeliest};
use crate::diagnose::pieces::Pieces;
use crate::motor::fit::ParameterId;
use crate::motor::{CommandKind, Motor};

/// Most steps of a fit under one noise: a fit that settles takes six.
const MOST_STEPS: usize = 20;
/// A fit ends with a step that gains less than so many nats: a fortieth of what decides.
const ENOUGH: f64 = 0.1;
/// Most times that the noise is found anew: it stands still after two.
const ROUNDS: usize = 4;

/// A fitted model.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub model: Model,
    pub x: Vec<f64>,
    pub noise: Noise,
    pub around: Surroundings,
    /// Recorded less predicted, in counts.
    pub residual: Vec<f64>,
    /// The same less what the errors of the pieces' starts make.
    pub shown: Vec<f64>,
    /// `residual` whitened.
    pub white: Vec<f64>,
    /// Whitened derivatives.
    pub columns: Vec<Vec<f64>>,
    pub log_det: Vec<f64>,
    /// Half the squares of each piece with its determinant.
    pub piece_cost: Vec<f64>,
    pub prior: f64,
    /// `J'J + P`.
    pub hessian: DMatrix<f64>,
    /// `J'J` of each piece.
    pub piece_hessian: Vec<DMatrix<f64>>,
    /// `J'r` of each piece.
    pub piece_gradient: Vec<DVector<f64>>,
    /// Scores of pieces, each predicted from the others.
    pub elpd: Vec<f64>,
}

impl Fit {
    /// Negative logarithm of likelihood and prior.
    pub fn cost(&self) -> f64 {
        self.piece_cost.iter().sum::<f64>() + self.prior
    }

    /// Score of what was not fitted, less what the prior says against the numbers.
    pub fn score(&self) -> f64 {
        self.elpd.iter().sum::<f64>() - self.prior
    }

    /// What it predicts, in counts from each piece's first sample.
    pub fn predicted(&self, pieces: &Pieces) -> Vec<f64> {
        residual(pieces, &self.residual)
    }

    /// Position error in counts RMS, less what the measured starts of the pieces make of it.
    pub fn rms(&self) -> f64 {
        (self.shown.iter().map(|r| r * r).sum::<f64>() / self.shown.len().max(1) as f64).sqrt()
    }
}

/// Surroundings of a motor for the filter.
pub(crate) fn surroundings(
    pieces: &Pieces,
    model: &Model,
    x: &[f64],
    kind: CommandKind,
) -> Surroundings {
    let motor = model.motor(x);
    let p = &motor.parameters;
    let per_rad = 1.0 / pieces.runs[0].rad;
    let largest =
        (pieces.runs.iter().flat_map(|run| &run.command)).fold(1e-9_f64, |m, u| m.max(u.abs()));
    let coupling = p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm;
    let (drag, torque) = match kind {
        CommandKind::Voltage => (
            p.viscous_friction_nm_s_per_rad + coupling,
            p.torque_constant_nm_per_a * largest / p.resistance_ohm,
        ),
        CommandKind::Current => (
            p.viscous_friction_nm_s_per_rad,
            p.torque_constant_nm_per_a * largest,
        ),
        CommandKind::Torque => (p.viscous_friction_nm_s_per_rad, largest),
    };
    Surroundings {
        time_constant_s: (p.inertia_kg_m2 / drag.max(1e-12)).clamp(1e-4, 100.0),
        stall_counts_s2: torque / p.inertia_kg_m2 * per_rad,
        jitter_s: jitter_s(&motor).hypot(pieces.arrivals_s),
        loss: loss(&motor),
    }
}

/// By up to how many seconds samples of a motor are late.
pub(crate) fn jitter_s(motor: &Motor) -> f64 {
    number_of(motor, "sample_jitter", "spread_s")
}

/// Share of edges that a motor loses by chance.
pub(crate) fn loss(motor: &Motor) -> f64 {
    number_of(motor, "missed_counts", "probability")
}

fn number_of(motor: &Motor, id: &str, key: &str) -> f64 {
    let number = ParameterId::effect(id, key);
    number.and_then(|id| id.get(motor)).unwrap_or(0.0)
}

/// Fits a model from the likeliest of some starts, with the noise that is found on the way.
pub(crate) fn fit(
    pieces: &Pieces,
    model: &Model,
    kind: CommandKind,
    starts: &[Vec<f64>],
) -> Option<Fit> {
    let begun = (starts.iter()).filter_map(|start| {
        let mut x = start.clone();
        model.clamp(&mut x);
        let residual = residual(pieces, &response(pieces, &model.motor(&x))?);
        let around = surroundings(pieces, model, &x, kind);
        let noise = likeliest(pieces, &around, &residual);
        let whitener = Whitener::new(pieces, &around, noise);
        let e = whitener.whiten(&residual);
        let cost = 0.5 * (dot(&e, &e) + whitener.log_det.iter().sum::<f64>()) + model.prior(&x);
        Some((cost, x, noise))
    });
    let (_, mut x, mut noise) = begun.min_by(|a, b| a.0.total_cmp(&b.0))?;
    for round in 0..ROUNDS {
        let around = surroundings(pieces, model, &x, kind);
        let whitener = Whitener::new(pieces, &around, noise);
        x = minimise(pieces, model, &whitener, x)?;
        let residual = residual(pieces, &response(pieces, &model.motor(&x))?);
        let around = surroundings(pieces, model, &x, kind);
        let found = likeliest(pieces, &around, &residual);
        if found == noise && round > 0 {
            break;
        }
        noise = found;
    }
    finished(pieces, model, kind, x, noise)
}

/// A fit at numbers that are settled.
pub(crate) fn finished(
    pieces: &Pieces,
    model: &Model,
    kind: CommandKind,
    x: Vec<f64>,
    noise: Noise,
) -> Option<Fit> {
    let around = surroundings(pieces, model, &x, kind);
    let whitener = Whitener::new(pieces, &around, noise);
    let mut fit = whitened(pieces, model, x, (noise, around), &whitener)?;
    let predicted = whitener.whiten(&out_of_fold(pieces, &fit, &whitener));
    fit.elpd = scores(pieces, &fit, &squares_of(pieces, &predicted));
    Some(fit)
}

/// A fit at these numbers without scores.
pub(super) fn whitened(
    pieces: &Pieces,
    model: &Model,
    x: Vec<f64>,
    (noise, around): (Noise, Surroundings),
    whitener: &Whitener,
) -> Option<Fit> {
    let (predicted, columns) = sensitivities(pieces, model, &x)?;
    let residual = residual(pieces, &predicted);
    let white = whitener.whiten(&residual);
    let columns: Vec<Vec<f64>> = columns
        .iter()
        .map(|column| whitener.whiten(column))
        .collect();
    let n = columns.len();
    let mut piece_hessian = Vec::new();
    let mut piece_gradient = Vec::new();
    let mut piece_cost = Vec::new();
    let mut hessian = model.precision.clone();
    for (piece, log_det) in pieces.pieces.iter().zip(&whitener.log_det) {
        let range = pieces.range(piece);
        let h = DMatrix::from_fn(n, n, |i, j| {
            dot(&columns[i][range.clone()], &columns[j][range.clone()])
        });
        let g = DVector::from_fn(n, |i, _| {
            dot(&columns[i][range.clone()], &white[range.clone()])
        });
        piece_cost.push(0.5 * (dot(&white[range.clone()], &white[range]) + log_det));
        hessian += &h;
        piece_hessian.push(h);
        piece_gradient.push(g);
    }
    let prior = model.prior(&x);
    Some(Fit {
        model: model.clone(),
        x,
        noise,
        around,
        shown: less_start(pieces, around.time_constant_s, &residual),
        residual,
        white,
        columns,
        log_det: whitener.log_det.clone(),
        piece_cost,
        prior,
        hessian,
        piece_hessian,
        piece_gradient,
        elpd: Vec::new(),
    })
}

/// Scores of pieces: Student's t with as many degrees of freedom as the piece has looks.
fn scores(pieces: &Pieces, fit: &Fit, squares: &[f64]) -> Vec<f64> {
    (pieces.pieces.iter().zip(squares).zip(&fit.log_det))
        .map(|((piece, squares), log_det)| {
            let n = pieces.weight[pieces.range(piece)].iter().sum::<f64>();
            -n * (squares.max(0.0) / n).ln_1p() - 0.5 * log_det
        })
        .collect()
}

/// Sum of the squares of each piece.
fn squares_of(pieces: &Pieces, column: &[f64]) -> Vec<f64> {
    let ranges = pieces.pieces.iter().map(|piece| pieces.range(piece));
    ranges
        .map(|range| dot(&column[range.clone()], &column[range]))
        .collect()
}

/// Recorded less predicted, each piece predicted by one Gauss-Newton step from the fit on the other folds, simulated. A step that does
/// not lower the cost of what it was taken on is none.
pub(super) fn out_of_fold(pieces: &Pieces, fit: &Fit, whitener: &Whitener) -> Vec<f64> {
    let n = fit.columns.len();
    let mut out = fit.residual.clone();
    let whole = squares_of(pieces, &fit.white);
    let pull: DVector<f64> = fit.piece_gradient.iter().sum::<DVector<f64>>()
        - &fit.model.precision * (DVector::from_column_slice(&fit.x) - &fit.model.mean);
    let is_held = |k: usize| {
        let number = &fit.model.numbers[k];
        !number.smooth
            || (fit.x[k] <= number.lo && pull[k] < 0.0)
            || (fit.x[k] >= number.hi && pull[k] > 0.0)
    };
    for fold in 0..pieces.folds.max(1) {
        let trained = |squares: &[f64], x: &[f64]| -> f64 {
            let others = pieces
                .pieces
                .iter()
                .zip(squares)
                .filter(|(piece, _)| piece.fold != fold);
            0.5 * others.map(|(_, s)| s).sum::<f64>() + fit.model.prior(x)
        };
        if pieces.folds > 1 && n > 0 {
            let mut hessian = fit.hessian.clone();
            let mut gradient = DVector::zeros(n);
            for (k, piece) in pieces.pieces.iter().enumerate() {
                if piece.fold == fold {
                    hessian -= &fit.piece_hessian[k];
                    gradient += &fit.piece_gradient[k];
                }
            }
            for k in (0..n).filter(|k| is_held(*k)) {
                hessian.row_mut(k).fill(0.0);
                hessian.column_mut(k).fill(0.0);
                hessian[(k, k)] = 1.0;
                gradient[k] = 0.0;
            }
            for k in 0..n {
                hessian[(k, k)] += 1e-6 * fit.hessian[(k, k)].max(1e-12);
            }
            if let Some(solved) = hessian.cholesky().map(|c| c.solve(&gradient)) {
                let before = trained(&whole, &fit.x);
                for share in [1.0, 0.3] {
                    let mut x: Vec<f64> = fit
                        .x
                        .iter()
                        .zip(solved.iter())
                        .map(|(x, s)| x - share * s)
                        .collect();
                    fit.model.clamp(&mut x);
                    let Some(predicted) = response(pieces, &fit.model.motor(&x)) else {
                        continue;
                    };
                    let left = residual(pieces, &predicted);
                    let then = squares_of(pieces, &whitener.whiten(&left));
                    if trained(&then, &x) < before {
                        for piece in pieces.pieces.iter().filter(|piece| piece.fold == fold) {
                            out[pieces.range(piece)].copy_from_slice(&left[pieces.range(piece)]);
                        }
                        break;
                    }
                }
            }
        }
    }
    out
}

pub(super) fn minimise(
    pieces: &Pieces,
    model: &Model,
    whitener: &Whitener,
    mut x: Vec<f64>,
) -> Option<Vec<f64>> {
    let n = x.len();
    let mut damping = 1e-3;
    let cost_of = |x: &[f64]| -> f64 {
        let Some(predicted) = response(pieces, &model.motor(x)) else {
            return f64::INFINITY;
        };
        let white = whitener.whiten(&residual(pieces, &predicted));
        0.5 * dot(&white, &white) + model.prior(x)
    };
    let mut cost = cost_of(&x);
    if !cost.is_finite() {
        return None;
    }
    for _ in 0..MOST_STEPS {
        let Some((predicted, columns)) = sensitivities(pieces, model, &x) else {
            break;
        };
        let white = whitener.whiten(&residual(pieces, &predicted));
        let columns: Vec<Vec<f64>> = columns
            .iter()
            .map(|column| whitener.whiten(column))
            .collect();
        let d = DVector::from_column_slice(&x) - &model.mean;
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
            let mut next: Vec<f64> = x
                .iter()
                .zip(step.iter())
                .map(|(x, s)| x + s.clamp(-1.5, 1.5))
                .collect();
            model.clamp(&mut next);
            let then = cost_of(&next);
            if then < cost {
                gained = cost - then;
                (x, cost) = (next, then);
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
    Some(x)
}

pub(crate) fn residual(pieces: &Pieces, predicted: &[f64]) -> Vec<f64> {
    pieces
        .counts
        .iter()
        .zip(predicted)
        .map(|(seen, p)| seen - p)
        .collect()
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Score of numbers that nothing was fitted to, under a fit's noise.
pub(crate) fn score_at(pieces: &Pieces, fit: &Fit, x: &[f64]) -> Option<f64> {
    let whitener = Whitener::new(pieces, &fit.around, fit.noise);
    let predicted = response(pieces, &fit.model.motor(x))?;
    let white = whitener.whiten(&residual(pieces, &predicted));
    let squares = squares_of(pieces, &white);
    let score: f64 = scores(pieces, fit, &squares).iter().sum();
    Some(score - fit.model.prior(x))
}
