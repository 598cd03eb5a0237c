//! Sign of the gain from command to speed, independent of loads.
//!
//! Input: a run in equal time bins. Output: the gain over its standard error. The mean speeds follow the mean
//! commands as in [`response`](super::response) with an unbalanced load of sine and cosine of the angle: `v[k] = a
//! v[k-1] + b u[k] + c u[k-1] + d + e sin(theta) + f cos(theta)`. The gain `b + c` has the sign of the wiring;
//! falling loads, coasting and braking controllers are in `a`, `d`, `e` and `f`. Least squares with its standard
//! errors (Ljung, System Identification, 1999, appendix II).

use std::f64::consts::TAU;

use nalgebra::{SMatrix, SVector};

use super::response::{bins, scale};
use crate::recording::Run;

/// Coefficients `a`, `b`, `c`, `d`, `e`, `f`.
const COEFFICIENTS: usize = 6;
/// Fewest bins, six for each coefficient.
const LEAST_BINS: usize = 40;
/// Least standard deviation of the command as a share of its largest. Under a constant current, noise of the command
/// is a response to the shaft (current controller against back EMF).
const VARIES: f64 = 0.2;
/// Least coefficient of determination.
const EXPLAINED: f64 = 0.5;
/// Eigenvalues below this share of the largest belong to collinear directions, which are left out.
const COLLINEAR: f64 = 1e-10;

/// The gain from command to speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gain {
    /// The gain over its standard error.
    pub over_error: f64,
}

pub(super) fn gain(run: &Run) -> Option<Gain> {
    let cut = bins(run)?;
    let rows = cut.speed.len().checked_sub(1)?;
    if rows < LEAST_BINS {
        return None;
    }
    let (by_speed, by_command) = (scale(&cut.speed), scale(&cut.command));
    let largest = 1.0 / by_command;
    let mean = cut.command.iter().sum::<f64>() / cut.command.len() as f64;
    let spread = cut.command.iter().map(|u| (u - mean).powi(2)).sum::<f64>();
    if (spread / cut.command.len() as f64).sqrt() < VARIES * largest {
        return None;
    }
    let row = |k: usize| {
        let middle = 0.5 * (cut.position[k - 1] + cut.position[k]);
        let (sine, cosine) = (middle / run.counts_per_rev * TAU).sin_cos();
        SVector::<f64, COEFFICIENTS>::from([
            by_speed * cut.speed[k - 1],
            by_command * cut.command[k],
            by_command * cut.command[k - 1],
            1.0,
            sine,
            cosine,
        ])
    };
    let mut normal = SMatrix::<f64, COEFFICIENTS, COEFFICIENTS>::zeros();
    let mut right = SVector::<f64, COEFFICIENTS>::zeros();
    let mut sum = 0.0;
    for k in 1..=rows {
        let (x, y) = (row(k), by_speed * cut.speed[k]);
        normal += x * x.transpose();
        right += x * y;
        sum += y;
    }
    if !normal.iter().all(|value| value.is_finite()) {
        return None;
    }
    // Collinear columns (angle and constant over a short travel) share their effect.
    let eigen = normal.symmetric_eigen();
    let least = COLLINEAR * eigen.eigenvalues.max();
    let mut inverse = SMatrix::<f64, COEFFICIENTS, COEFFICIENTS>::zeros();
    let of_gain = SVector::<f64, COEFFICIENTS>::from([0.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    for (value, vector) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value > least {
            inverse += vector * vector.transpose() / *value;
        } else if vector.dot(&of_gain).abs() > 1e-3 {
            return None;
        }
    }
    let fit = inverse * right;
    let (mut residual, mut variance) = (0.0, 0.0);
    for k in 1..=rows {
        let y = by_speed * cut.speed[k];
        residual += (y - row(k).dot(&fit)).powi(2);
        variance += (y - sum / rows as f64).powi(2);
    }
    let error =
        (residual / (rows - COEFFICIENTS) as f64 * of_gain.dot(&(inverse * of_gain))).sqrt();
    let over_error = of_gain.dot(&fit) / error;
    (residual <= (1.0 - EXPLAINED) * variance && over_error.is_finite())
        .then_some(Gain { over_error })
}
