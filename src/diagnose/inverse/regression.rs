//! Weighted least squares of the rows, with a sign constraint on friction terms.

use nalgebra::{DMatrix, DVector};

use super::rows::Row;
use crate::diagnose::robust::student_weights;
use crate::diagnose::settings::solver::{LAST_DIGITS, REWEIGHTED};

/// Normal equations of weighted least squares.
pub(super) struct Normal {
    xx: DMatrix<f64>,
    xy: DVector<f64>,
}

impl Normal {
    pub fn of(columns: &[Vec<f64>], rows: &[Row], weight: &[f64]) -> Self {
        let n = columns.first().map_or(0, Vec::len);
        let mut normal = Self {
            xx: DMatrix::zeros(n, n),
            xy: DVector::zeros(n),
        };
        for ((x, row), w) in columns.iter().zip(rows).zip(weight) {
            for i in 0..n {
                normal.xy[i] += w * x[i] * row.command;
                for j in 0..n {
                    normal.xx[(i, j)] += w * x[i] * x[j];
                }
            }
        }
        normal
    }

    /// Least squares with non-negative coefficients of friction terms: negative ones are removed one by one.
    pub fn solved(&self, brakes: &[bool]) -> Vec<f64> {
        let is_there = |k: &usize| self.xx[(*k, *k)] > 0.0;
        let mut active: Vec<usize> = (0..brakes.len()).filter(is_there).collect();
        loop {
            let n = active.len();
            if n == 0 {
                return vec![0.0; brakes.len()];
            }
            let xx = DMatrix::from_fn(n, n, |i, j| self.xx[(active[i], active[j])]);
            let xy = DVector::from_fn(n, |i, _| self.xy[active[i]]);
            let scale = DVector::from_fn(n, |i, _| xx[(i, i)].sqrt().max(f64::MIN_POSITIVE));
            let scaled = DMatrix::from_fn(n, n, |i, j| {
                xx[(i, j)] / (scale[i] * scale[j]) + if i == j { LAST_DIGITS } else { 0.0 }
            });
            let right = xy.component_div(&scale);
            let solution = scaled.lu().solve(&right).unwrap_or_else(|| right.clone());
            let solution = solution.component_div(&scale);
            let worst = (0..n)
                .filter(|&i| brakes[active[i]] && solution[i] < 0.0)
                .min_by(|&i, &j| (solution[i] * scale[i]).total_cmp(&(solution[j] * scale[j])));
            match worst {
                Some(worst) => {
                    active.remove(worst);
                }
                None => {
                    let mut all = vec![0.0; brakes.len()];
                    for (i, &k) in active.iter().enumerate() {
                        all[k] = solution[i];
                    }
                    return all;
                }
            }
        }
    }
}

fn residuals(columns: &[Vec<f64>], rows: &[Row], coefficients: &[f64]) -> Vec<f64> {
    (columns.iter().zip(rows))
        .map(|(x, row)| row.command - x.iter().zip(coefficients).map(|(x, c)| x * c).sum::<f64>())
        .collect()
}

/// Robust weights from the residuals of the motor alone, iteratively reweighted.
pub(super) fn robust_weights(rows: &[Row], alone: &[Vec<f64>]) -> Vec<f64> {
    let mut weight = vec![1.0; rows.len()];
    for _ in 0..REWEIGHTED {
        let coefficients = Normal::of(alone, rows, &weight).solved(&vec![true; alone[0].len()]);
        weight = student_weights(&residuals(alone, rows, &coefficients));
    }
    weight
}
