//! The unknown as a model like the others: a torque of many shapes, by regression (Ebers, Steele, Kutz: discrepancy modelling, 2022).

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::nulls::residual_by_chance;
use crate::diagnose::fit::{Fit, Starts, dot, residual};
use crate::diagnose::noise::Whitener;
use crate::diagnose::pieces::{Piece, Pieces};
use crate::diagnose::screening::filter;
use crate::diagnose::settings::{LEAST_GAIN, NULLS, RIDGE, SHAPE_ORDERS};

/// What a flexible torque gains on pieces that it was not fitted to.
#[derive(Debug, Clone)]
pub(crate) struct Unknown {
    pub gain: f64,
    pub by_chance: Vec<f64>,
    /// Largest mean square of a piece, whitened, and what chance makes of it.
    pub worst: f64,
    pub worst_by_chance: Vec<f64>,
}

impl Unknown {
    /// The most that chance made.
    pub fn chance(&self) -> f64 {
        self.by_chance
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// The same with the piece predicted worst of others than those that were searched.
    pub fn with_worst_of(self, pieces: &Pieces, fit: &Fit) -> Option<Self> {
        let whitener = Whitener::new(pieces, &fit.around, fit.noise);
        let motor = fit.model.motor(&fit.x);
        let (_, left) = Starts::of(pieces, &motor, fit.around.time_constant_s)?;
        // What is predicted is what is seen less what is left.
        let predicted = residual(pieces, &left);
        let worst = |residual: &[f64]| {
            let white = whitener.whiten(residual);
            let of_piece = |piece| mean_square(pieces, piece, &white);
            pieces.pieces.iter().map(of_piece).fold(0.0, f64::max)
        };
        let by_chance = |seed: u64| {
            let mut random = Pcg64Mcg::seed_from_u64(0x776f_7273 ^ seed);
            let (around, noise) = (&fit.around, fit.noise);
            worst(&residual_by_chance(
                pieces,
                &predicted,
                around,
                noise,
                &mut random,
            ))
        };
        Some(Self {
            worst: worst(&left),
            worst_by_chance: (0..NULLS as u64).into_par_iter().map(by_chance).collect(),
            ..self
        })
    }

    /// Logarithm of the odds that the piece that is predicted worst is no chance: even where it is beyond the worst that chance made by
    /// as much as that is beyond what chance makes mostly.
    pub fn worst_beyond(&self) -> f64 {
        let mut by_chance: Vec<f64> = self.worst_by_chance.iter().map(|w| w.ln()).collect();
        by_chance.sort_by(f64::total_cmp);
        let (Some(most), median) = (by_chance.last(), by_chance.get(by_chance.len() / 2)) else {
            return f64::NEG_INFINITY;
        };
        let spread = most - median.unwrap_or(most);
        LEAST_GAIN * ((self.worst.ln() - most) / spread.max(f64::MIN_POSITIVE) - 1.0)
    }

    /// Whether it is beyond all that chance made: the gain, or the piece that is predicted worst.
    pub fn is_there(&self) -> bool {
        (self.gain > self.chance() && self.gain > LEAST_GAIN) || self.worst_beyond() > 0.0
    }
}

/// Mean square of a piece over its looks, whitened.
fn mean_square(pieces: &Pieces, piece: &Piece, white: &[f64]) -> f64 {
    let range = pieces.range(piece);
    let looks = pieces.weight[range.clone()].iter().sum::<f64>().max(1.0);
    dot(&white[range.clone()], &white[range]) / looks
}

fn shapes(pieces: &Pieces, fit: &Fit) -> Vec<Vec<f64>> {
    let top = pieces.runs.iter().fold(1.0, |m, run| f64::max(m, run.top));
    let largest = pieces
        .runs
        .iter()
        .flat_map(|run| &run.command)
        .fold(1e-9_f64, |m, u| m.max(u.abs()));
    type Law = Box<dyn Fn(f64, f64, f64, f64) -> f64 + Sync>;
    let mut laws: Vec<Law> = Vec::new();
    for order in 1..=SHAPE_ORDERS {
        let n = order as f64;
        laws.push(Box::new(move |a, _, _, _| (n * a).sin()));
        laws.push(Box::new(move |a, _, _, _| (n * a).cos()));
        laws.push(Box::new(move |a, w, _, _| (n * a).sin() * sign(w)));
        laws.push(Box::new(move |a, w, _, _| (n * a).cos() * sign(w)));
    }
    laws.push(Box::new(|_, _, _, _| 1.0));
    laws.push(Box::new(|_, w, _, _| w));
    laws.push(Box::new(|_, w, _, _| w * w.abs()));
    laws.push(Box::new(|_, w, _, _| w * w));
    laws.push(Box::new(|_, w, _, _| w * w * w));
    // From a crawl to a third of the top speed: where friction bends (Armstrong-Helouvry, Dupont, Canudas de Wit, 1994).
    for speed in [0.02, 0.08, 0.3] {
        laws.push(Box::new(move |_, w, _, _| {
            sign(w) * (-(w / speed).powi(2)).exp()
        }));
        laws.push(Box::new(move |_, w, _, _| (-(w / speed).powi(2)).exp()));
    }
    laws.push(Box::new(|_, _, u, _| u));
    laws.push(Box::new(|_, _, u, _| u * u.abs()));
    laws.push(Box::new(|_, _, u, _| u * u));
    laws.push(Box::new(|_, _, u, _| sign(u)));
    laws.push(Box::new(|_, w, u, _| sign(u * w)));
    for power in 1..=2 {
        laws.push(Box::new(move |_, w, _, t| sign(w) * t.powi(power)));
        laws.push(Box::new(move |_, w, _, t| w * t.powi(power)));
        laws.push(Box::new(move |_, _, u, t| u * t.powi(power)));
    }
    (laws.into_par_iter())
        .map(|law| {
            let mut out = Vec::with_capacity(pieces.len);
            for piece in &pieces.pieces {
                let run = &pieces.runs[piece.run];
                let last = run.t_s.last().copied().unwrap_or(1.0).max(1e-9);
                let at = |k: usize| {
                    law(
                        (run.first_counts + run.counts[k]) * run.rad,
                        run.speed[k] / top,
                        run.command[k] / largest,
                        run.t_s[k] / last,
                    )
                };
                filter(pieces, piece, fit.around.time_constant_s, at, &mut out);
            }
            out
        })
        .collect()
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

pub(crate) fn unknown(pieces: &Pieces, fit: &Fit) -> Unknown {
    let whitener = Whitener::new(pieces, &fit.around, fit.noise);
    let mut columns: Vec<Vec<f64>> = (shapes(pieces, fit).into_par_iter())
        .map(|c| whitener.whiten(&c))
        .collect();
    columns.extend(fit.columns.iter().cloned());
    for column in &mut columns {
        let length = dot(column, column).sqrt();
        if length > 1e-9 {
            column.iter_mut().for_each(|v| *v /= length);
        }
    }
    let n = columns.len();
    let by_fold: Vec<DMatrix<f64>> = (0..pieces.folds.max(1))
        .map(|fold| {
            let mut h = DMatrix::zeros(n, n);
            for piece in pieces.pieces.iter().filter(|piece| piece.fold == fold) {
                let range = pieces.range(piece);
                for i in 0..n {
                    for j in 0..=i {
                        let v = dot(&columns[i][range.clone()], &columns[j][range.clone()]);
                        h[(i, j)] += v;
                        if i != j {
                            h[(j, i)] += v;
                        }
                    }
                }
            }
            h
        })
        .collect();
    let total: DMatrix<f64> = by_fold.iter().sum();
    let solvers: Vec<_> = by_fold
        .iter()
        .map(|h| (&total - h + DMatrix::identity(n, n) * RIDGE).cholesky())
        .collect();
    let ask = |white: &[f64]| -> (f64, f64) {
        let by_piece: Vec<DVector<f64>> = (pieces.pieces.iter())
            .map(|piece| {
                let range = pieces.range(piece);
                DVector::from_fn(n, |i, _| {
                    dot(&columns[i][range.clone()], &white[range.clone()])
                })
            })
            .collect();
        let mut sum: DVector<f64> = DVector::zeros(n);
        for g in &by_piece {
            sum += g;
        }
        let (mut gain, mut worst) = (0.0, 0.0_f64);
        for (fold, solver) in solvers.iter().enumerate() {
            let members = || {
                pieces
                    .pieces
                    .iter()
                    .enumerate()
                    .filter(move |(_, piece)| piece.fold == fold)
            };
            let mut g = sum.clone();
            for (k, _) in members() {
                g -= &by_piece[k];
            }
            let Some(beta) = solver.as_ref().map(|s| s.solve(&g)) else {
                continue;
            };
            for (_, piece) in members() {
                let range = pieces.range(piece);
                let looks = pieces.weight[range.clone()].iter().sum::<f64>().max(1.0);
                let before = dot(&white[range.clone()], &white[range.clone()]);
                worst = worst.max(before / looks);
                if pieces.folds < 2 {
                    continue;
                }
                let mut left = white[range.clone()].to_vec();
                for (column, beta) in columns.iter().zip(beta.iter()) {
                    for (left, shape) in left.iter_mut().zip(&column[range.clone()]) {
                        *left -= beta * shape;
                    }
                }
                let after = dot(&left, &left);
                gain += looks * ((before / looks).ln_1p() - (after / looks).ln_1p());
            }
        }
        (gain, worst)
    };
    let (gain, worst) = ask(&fit.white);
    let predicted = fit.predicted(pieces);
    let chance: Vec<(f64, f64)> = (0..NULLS as u64)
        .into_par_iter()
        .map(|seed| {
            let mut random = Pcg64Mcg::seed_from_u64(0x756e_6b00 ^ seed);
            let residual =
                residual_by_chance(pieces, &predicted, &fit.around, fit.noise, &mut random);
            ask(&whitener.whiten(&residual))
        })
        .collect();
    Unknown {
        gain,
        by_chance: chance.iter().map(|c| c.0).collect(),
        worst,
        worst_by_chance: chance.iter().map(|c| c.1).collect(),
    }
}
