//! How many nats each candidate gains, to second order: the score test (Rao, 1948), with the direction that an effect can have.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{Candidate, Shape};
use crate::diagnose::fit::{Base, Fit, Model, dot};
use crate::diagnose::noise::{Noise, Whitener};
use crate::diagnose::pieces::Pieces;

use crate::diagnose::settings::MOST_STRETCH;

/// A candidate whitened, with what is needed of it.
#[derive(Debug)]
enum Ready {
    Columns {
        white: Vec<Vec<f64>>,
        /// `H^-1 J'D`.
        solved: DMatrix<f64>,
        /// What the host says for it, in nats.
        host: f64,
        /// `D'D - D'J H^-1 J'D`.
        schur: DMatrix<f64>,
        is_pair: bool,
    },
    /// There as it is or not at all, with the base as it is: another encoder's column is far beyond what the base gives way to in a line.
    Whole { white: Vec<f64>, square: f64 },
    Scatter {
        column: Vec<f64>,
        whitener: Whitener,
    },
    Frees {
        precision: DMatrix<f64>,
        inverse: DMatrix<f64>,
    },
}

/// Share of a column's square below which a difference of two squares is no number: a hundred times what [`inverted`] adds.
const LAST_DIGITS: f64 = 1e-12;

/// Candidates against one fit, under one noise.
#[derive(Debug)]
pub(crate) struct Screen {
    ready: Vec<Ready>,
    columns: Vec<Vec<f64>>,
    precision: DMatrix<f64>,
    inverse: DMatrix<f64>,
    pub whitener: Whitener,
}

/// What a candidate gains, and with which coefficients.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Gain {
    pub nats: f64,
    pub coefficients: (f64, f64),
}

impl Screen {
    pub fn new(
        pieces: &Pieces,
        base: &Base,
        fit: &Fit,
        columns: &[Vec<f64>],
        candidates: &[Candidate],
        noise: Noise,
    ) -> Self {
        let whitener = Whitener::new(pieces, &fit.around, noise);
        let columns: Vec<Vec<f64>> = columns.par_iter().map(|c| whitener.whiten(c)).collect();
        let n = columns.len();
        let precision = fit.model.precision_as_unlikely(&fit.x);
        let jj = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]));
        let inverse = inverted(&(&jj + &precision));
        let ready = (candidates.par_iter())
            .map(|candidate| match &candidate.shape {
                Shape::One(column) => {
                    let host = match base.clock {
                        Some((seen, sd)) if candidate.member.id() == "clock_error" => {
                            0.5 * (seen / sd).powi(2)
                        }
                        _ => 0.0,
                    };
                    let white = whitener.whiten(column);
                    if candidate.member.is_whole() {
                        let square = dot(&white, &white);
                        return Ready::Whole { white, square };
                    }
                    columns_ready(&columns, &inverse, vec![white], false, host)
                }
                Shape::Pair(pair, _) => {
                    let white = pair.iter().map(|c| whitener.whiten(c)).collect();
                    columns_ready(&columns, &inverse, white, true, 0.0)
                }
                Shape::Scatter(column, around, noise) => Ready::Scatter {
                    column: column.clone(),
                    whitener: Whitener::new(pieces, around, *noise),
                },
                Shape::Frees => {
                    let mut members = fit.model.members.clone();
                    members.push(candidate.member.clone());
                    let freed = Model::new(base, members).precision_as_unlikely(&fit.x);
                    Ready::Frees {
                        inverse: inverted(&(&jj + &freed)),
                        precision: freed,
                    }
                }
            })
            .collect();
        Self {
            ready,
            columns,
            precision,
            inverse,
            whitener,
        }
    }

    /// Gains of all candidates for a residual in counts and a distance `x - mean` from what is plausible.
    pub fn gains(
        &self,
        residual: &[f64],
        distance: &DVector<f64>,
        is_recording: bool,
    ) -> Vec<Gain> {
        let white = &self.whitener.whiten(residual);
        let cost = cost_of(&self.whitener, white);
        let n = self.columns.len();
        let jr = DVector::from_fn(n, |i, _| dot(&self.columns[i], white));
        let g = &jr - &self.precision * distance;
        let solved = &self.inverse * &g;
        let least = 0.5 * (&self.precision * distance).dot(distance) - 0.5 * g.dot(&solved);
        (self.ready.iter())
            .map(|ready| match ready {
                Ready::Columns {
                    white: columns,
                    solved: against,
                    schur,
                    is_pair,
                    host,
                } => {
                    let t: Vec<f64> = (columns.iter().enumerate())
                        .map(|(k, column)| dot(column, white) - against.column(k).dot(&g))
                        .collect();
                    let mut gain = gain_of(&t, schur, *is_pair);
                    if is_recording && *host > 0.0 {
                        // A whole start, which the host has measured.
                        gain.nats = *host + t[0] - 0.5 * schur[(0, 0)];
                    }
                    gain
                }
                Ready::Whole {
                    white: column,
                    square,
                } => Gain {
                    nats: (dot(column, white) - 0.5 * square).max(0.0),
                    coefficients: (1.0, 0.0),
                },
                Ready::Scatter { column, whitener } => {
                    let then = cost_of(whitener, &whitener.whiten(&less(residual, column)));
                    Gain {
                        nats: cost - then,
                        coefficients: (1.0, 0.0),
                    }
                }
                Ready::Frees { precision, inverse } => {
                    let g = &jr - precision * distance;
                    let then =
                        0.5 * (precision * distance).dot(distance) - 0.5 * g.dot(&(inverse * &g));
                    Gain {
                        nats: least - then,
                        coefficients: (1.0, 0.0),
                    }
                }
            })
            .collect()
    }
}

/// Negative logarithm of the likelihood of a whitened residual.
fn cost_of(whitener: &Whitener, white: &[f64]) -> f64 {
    0.5 * (dot(white, white) + whitener.log_det.iter().sum::<f64>())
}

fn less(residual: &[f64], column: &[f64]) -> Vec<f64> {
    residual.iter().zip(column).map(|(r, x)| r - x).collect()
}

fn columns_ready(
    columns: &[Vec<f64>],
    inverse: &DMatrix<f64>,
    white: Vec<Vec<f64>>,
    is_pair: bool,
    host: f64,
) -> Ready {
    let q = white.len();
    let jd = DMatrix::from_fn(columns.len(), q, |i, k| dot(&columns[i], &white[k]));
    let solved = inverse * &jd;
    let own = DMatrix::from_fn(q, q, |i, j| dot(&white[i], &white[j]));
    let mut schur = &own - jd.transpose() * &solved;
    // What other numbers make up but for the last digits says nothing.
    if (0..q).any(|k| schur[(k, k)] < LAST_DIGITS * own[(k, k)]) {
        schur.fill(0.0);
    }
    Ready::Columns {
        white,
        solved,
        schur,
        is_pair,
        host,
    }
}

/// Gain for projections `t` of the residual on columns with this Schur complement.
pub(crate) fn gain_of(t: &[f64], schur: &DMatrix<f64>, is_pair: bool) -> Gain {
    // A column of less than a hundredth of a whitened unit says nothing.
    const LEAST: f64 = 1e-4;
    if is_pair {
        let det = schur[(0, 0)] * schur[(1, 1)] - schur[(0, 1)].powi(2);
        if det <= 1e-6 * schur[(0, 0)] * schur[(1, 1)] || schur[(0, 0)] <= LEAST {
            return Gain::default();
        }
        let a = (schur[(1, 1)] * t[0] - schur[(0, 1)] * t[1]) / det;
        let b = (schur[(0, 0)] * t[1] - schur[(0, 1)] * t[0]) / det;
        return Gain {
            nats: 0.5 * (a * t[0] + b * t[1]),
            coefficients: (a, b),
        };
    }
    let s = schur[(0, 0)];
    if s <= LEAST || t[0] <= 0.0 {
        return Gain::default();
    }
    let a = (t[0] / s).min(MOST_STRETCH);
    Gain {
        nats: a * t[0] - 0.5 * a * a * s,
        coefficients: (a, 0.0),
    }
}

fn inverted(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.nrows();
    let mut m = matrix.clone();
    for k in 0..n {
        m[(k, k)] *= 1.0 + 1e-14;
        m[(k, k)] += 1e-12;
    }
    m.try_inverse().unwrap_or_else(|| DMatrix::zeros(n, n))
}
