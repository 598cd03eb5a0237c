//! A fit around which the numbers of the base give way linearly.
//!
//! With the whitened residual `r`, the base's columns `B` and its prior `P`, what is left once the base has given way is
//! `r'r - b' N^-1 b`, `N = B'B + P`, `b = B'r - P p`. A column `d` beside it gains `(d'r - (B'd)' N^-1 b)^2 / (d'd - (B'd)' N^-1 B'd)`
//! squares with the magnitude that suits it best.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::fit::Fit;
use super::hypothesis::{BASE, Hypothesis};
use super::problem::{Columns, Problem};
use super::sums::{dot, gram};

/// A point around which the base gives way linearly.
pub(super) struct Anchor {
    /// What is fitted there.
    pub hypothesis: Hypothesis,
    /// Its numbers.
    pub p: Vec<f64>,
    /// Whitened residual there.
    pub residual: Vec<f64>,
    /// Whitened columns of the base.
    pub base: Vec<Vec<f64>>,
    /// Sums of their products, with the prior and a little ridge; its factor, where it has one.
    pub normal: DMatrix<f64>,
    pub factor: Option<Cholesky<f64, Dyn>>,
    /// Products of the base with the residual, less the pull of its prior.
    pub right: DVector<f64>,
    /// What is left there after the base has given way linearly.
    pub left: f64,
}

impl Anchor {
    /// At a fit whose prediction has these derivatives by the base, run by run.
    pub fn new(problem: &Problem<'_>, fit: &Fit, derivatives: Vec<Columns>) -> Self {
        let residual = problem.innovations(fit);
        let base = problem.whitened_base(fit, derivatives);
        let noise = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
        let whiteners = problem.whiteners(&noise);
        let determinants: f64 = whiteners.iter().map(|w| w.log_determinant).sum();
        let normal = normal(&base, &fit.hypothesis);
        let right = DVector::from_iterator(
            base.len(),
            (base.iter().enumerate())
                .map(|(k, column)| dot(column, &residual) - pull(&fit.hypothesis, &fit.p, k)),
        );
        let mut anchor = Self {
            left: 0.0,
            factor: normal.clone().cholesky(),
            normal,
            right,
            hypothesis: fit.hypothesis.clone(),
            p: fit.p.clone(),
            residual,
            base,
        };
        anchor.left = anchor.left_over(&anchor.residual, &fit.p) + determinants;
        anchor
    }

    /// Squares that a column gains whose whole leaves `r`, with the magnitude that suits it best, above nought.
    pub fn gain_along(&self, r: &[f64]) -> f64 {
        let column: Vec<f64> = self.residual.iter().zip(r).map(|(a, b)| a - b).collect();
        let Some(factor) = &self.factor else {
            return f64::INFINITY;
        };
        let shared = DVector::from_fn(self.base.len(), |k, _| dot(&self.base[k], &column));
        let given = factor.solve(&shared);
        let along = dot(&column, &self.residual) - given.dot(&self.right);
        let size = dot(&column, &column) - given.dot(&shared);
        along.max(0.0).powi(2) / size.max(1e-12)
    }

    /// What is left of `r` in squares after the base, whose numbers are the first of `p`, has given way linearly, at the price
    /// of its prior.
    pub fn left_over(&self, r: &[f64], p: &[f64]) -> f64 {
        let mut priced = dot(r, r);
        let right = DVector::from_fn(self.base.len(), |i, _| {
            let pull = pull(&self.hypothesis, p, i);
            priced += p[i] * pull;
            dot(&self.base[i], r) - pull
        });
        match &self.factor {
            Some(factor) => priced - factor.solve(&right).dot(&right),
            None => priced,
        }
    }
}

/// Products of the base with itself, with its prior, which is that of every set, and a little ridge.
fn normal(base: &Columns, hypothesis: &Hypothesis) -> DMatrix<f64> {
    let mut normal = gram(base, |i, j| hypothesis.precision(i, j));
    for i in 0..base.len() {
        normal[(i, i)] += 1e-9 * normal[(i, i)] + 1e-12;
    }
    normal
}

/// How the prior pulls number `k` of the base.
fn pull(hypothesis: &Hypothesis, p: &[f64], k: usize) -> f64 {
    (0..BASE).map(|j| hypothesis.precision(k, j) * p[j]).sum()
}
