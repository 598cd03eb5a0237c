//! Which hypotheses these runs cannot tell apart.
//!
//! The separation of `i` from `j` is what is left of the difference of their predictions when `j`'s
//! numbers may give way, in standard deviations of the noise:
//! `D^2 = min over dp of |W (x_i - x_j - J_j dp)|^2 + dp' P dp` (a linear re-fit from `j`'s best fit).
//! Below [`TIE`] the two are one class.

use nalgebra::DVector;

use super::fit::Fit;
use super::noise::{Carried, Whitener};
use super::problem::Problem;
use super::sums::{dot, gram};

/// Separation below which two hypotheses are not told apart.
pub(super) const TIE: f64 = 3.0;

/// The separation of `truth` from `rival`.
pub(super) fn separation(problem: &Problem<'_>, truth: &Fit, rival: &Fit) -> Option<f64> {
    let level = problem.noise(&truth.hypothesis, &truth.p, truth.wander);
    let whiteners = problem.whiteners(&level);
    let columns = problem.jacobian(&rival.hypothesis, &rival.p, &whiteners)?;
    let r = whitened_difference(truth, rival, &whiteners);
    left_after(&r, &columns, |i, j| rival.hypothesis.precision(i, j))
}

/// The difference of two fits' predictions, whitened, all runs end to end.
pub(super) fn whitened_difference(one: &Fit, other: &Fit, whiteners: &[Whitener]) -> Vec<f64> {
    let mut all = Vec::new();
    let mut carried = Carried::default();
    let predictions = one.predictions.iter().zip(&other.predictions);
    for ((x, y), whitener) in predictions.zip(whiteners) {
        let mut difference: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
        whitener.whiten_on(&mut carried, &mut difference);
        all.extend(difference);
    }
    all
}

/// The size of what is left of a whitened difference when the columns' numbers, known as well as
/// `precision` says, may give way.
pub(super) fn left_after(
    r: &[f64],
    columns: &[Vec<f64>],
    precision: impl Fn(usize, usize) -> f64,
) -> Option<f64> {
    let ridge = |i: usize, j: usize| if i == j { 1e-12 } else { 0.0 };
    let normal = gram(columns, |i, j| precision(i, j) + ridge(i, j));
    let right = DVector::from_fn(columns.len(), |k, _| dot(&columns[k], r));
    let gain = normal.cholesky()?.solve(&right).dot(&right);
    Some((dot(r, r) - gain).max(0.0).sqrt())
}
