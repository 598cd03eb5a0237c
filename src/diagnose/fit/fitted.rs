//! A model with numbers, and what it leaves.

use nalgebra::{DMatrix, DVector};

use super::{Model, Starts, less_start, sensitivities};
use crate::diagnose::noise::{Noise, Surroundings, Whitener};
use crate::diagnose::pieces::Pieces;
use crate::motor::fit::ParameterId;
use crate::motor::{CommandKind, Motor};

/// A fitted model.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub model: Model,
    pub x: Vec<f64>,
    pub noise: Noise,
    pub around: Surroundings,
    /// What the simulation of the pieces is expanded about.
    pub starts: Starts,
    /// Recorded less predicted, in counts.
    pub residual: Vec<f64>,
    /// The same less what the errors of the pieces' starts make.
    pub shown: Vec<f64>,
    /// `residual` whitened.
    pub white: Vec<f64>,
    /// Whitened derivatives.
    pub columns: Vec<Vec<f64>>,
    pub log_det: Vec<f64>,
    /// Half the squares of each stretch with its determinant.
    pub stretch_cost: Vec<f64>,
    pub prior: f64,
    /// `J'J + P`.
    pub hessian: DMatrix<f64>,
    /// `J'J` of each stretch.
    pub stretch_hessian: Vec<DMatrix<f64>>,
    /// `J'r` of each stretch.
    pub stretch_gradient: Vec<DVector<f64>>,
    /// Scores of stretches, each predicted from the others.
    pub elpd: Vec<f64>,
}

impl Fit {
    /// Negative logarithm of likelihood and prior.
    pub fn cost(&self) -> f64 {
        self.stretch_cost.iter().sum::<f64>() + self.prior
    }

    /// Score of what was not fitted, less what the prior says against the numbers.
    pub fn score(&self) -> f64 {
        self.elpd.iter().sum::<f64>() - self.prior
    }

    /// What it predicts, in counts from each piece's first sample.
    pub fn predicted(&self, pieces: &Pieces) -> Vec<f64> {
        residual(pieces, &self.residual)
    }

    /// Mean square of the position error in counts^2, less what the measured starts of the pieces make of it.
    pub fn mean_square(&self) -> f64 {
        mean_square(&self.shown)
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

/// A fit at these numbers without scores.
pub(super) fn whitened(
    pieces: &Pieces,
    model: &Model,
    x: Vec<f64>,
    (noise, around, starts): (Noise, Surroundings, Starts),
    whitener: &Whitener,
) -> Option<Fit> {
    let (predicted, columns) = sensitivities(pieces, model, &x, &starts)?;
    let residual = residual(pieces, &predicted);
    let white = whitener.whiten(&residual);
    let columns = whitener.whiten_all(&columns);
    let n = columns.len();
    let mut stretch_hessian = Vec::new();
    let mut stretch_gradient = Vec::new();
    let mut stretch_cost = Vec::new();
    let mut hessian = model.precision.clone();
    for (stretch, log_det) in pieces.stretches.iter().zip(&whitener.log_det) {
        let range = stretch.samples.clone();
        let h = DMatrix::from_fn(n, n, |i, j| {
            dot(&columns[i][range.clone()], &columns[j][range.clone()])
        });
        let g = DVector::from_fn(n, |i, _| {
            dot(&columns[i][range.clone()], &white[range.clone()])
        });
        stretch_cost.push(0.5 * (dot(&white[range.clone()], &white[range]) + log_det));
        hessian += &h;
        stretch_hessian.push(h);
        stretch_gradient.push(g);
    }
    let prior = model.prior(&x);
    Some(Fit {
        model: model.clone(),
        x,
        noise,
        around,
        starts,
        shown: less_start(pieces, around.time_constant_s, &residual),
        residual,
        white,
        columns,
        log_det: whitener.log_det.clone(),
        stretch_cost,
        prior,
        hessian,
        stretch_hessian,
        stretch_gradient,
        elpd: Vec::new(),
    })
}

/// Sum of the squares of each stretch.
pub(super) fn squares_of(pieces: &Pieces, column: &[f64]) -> Vec<f64> {
    let ranges = (pieces.stretches.iter()).map(|stretch| stretch.samples.clone());
    ranges
        .map(|range| dot(&column[range.clone()], &column[range]))
        .collect()
}

pub(super) fn mean_square(values: &[f64]) -> f64 {
    dot(values, values) / values.len().max(1) as f64
}

pub(crate) fn residual(pieces: &Pieces, predicted: &[f64]) -> Vec<f64> {
    pieces
        .counts
        .iter()
        .zip(predicted)
        .map(|(seen, p)| seen - p)
        .collect()
}

/// Sum of products, in eight sums beside each other: one does not wait for the other.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, a_rest) = a[..n].as_chunks::<8>();
    let (b, b_rest) = b[..n].as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Standard error of a sum over pieces, by how its parts scatter.
pub(crate) fn error_of_sum(parts: &[f64]) -> f64 {
    let n = parts.len();
    let mean = parts.iter().sum::<f64>() / n as f64;
    let variance = parts.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n.max(2) - 1) as f64;
    (variance * n as f64).sqrt()
}
