//! Columns of coefficients that nobody knows beside a named model: what they gain, with everything linear marginalised.
//!
//! The named model gives way linearly (columns `J`, prior `P`), each coefficient has a Gaussian prior of variance 1 in its
//! unit, so that the evidence beside the named model's is `ln B = 1/2 b' S^-1 b - 1/2 ln|S|`,
//! `S = C'C + I - C'J (J'J + P)^-1 J'C`, `b = C'(r - J dp)`, with the whitened columns `C` and the step
//! `dp = (J'J + P)^-1 (J'r - P (p - c))` that the named model would still take itself, none at its optimum.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::fit::{Fit, normal_equations};
use super::sums::{dot, gram};

/// The columns of the named model, the factors of `J'J + P`, and the step to its optimum.
pub(super) struct Named {
    jacobian: Vec<Vec<f64>>,
    factors: Cholesky<f64, Dyn>,
    step: DVector<f64>,
}

impl Named {
    /// Of a fit that leaves `r`. Numbers that stand beyond the edge of their range give way little against it.
    pub fn new(fit: &Fit, jacobian: Vec<Vec<f64>>, r: &[f64]) -> Option<Self> {
        let (_, slope) = normal_equations(&fit.hypothesis, &jacobian, r, &fit.p);
        let edge = |k: usize| {
            let (outside, edge) = fit.hypothesis.outside(k, &fit.p);
            if outside == 0.0 {
                0.0
            } else {
                1.0 / (edge * edge)
            }
        };
        let normal = gram(&jacobian, |i, j| {
            fit.hypothesis.precision(i, j) + if i == j { edge(i) } else { 0.0 }
        });
        let factors = normal.cholesky()?;
        Some(Self {
            step: factors.solve(&slope),
            factors,
            jacobian,
        })
    }
}

/// What columns come to beside a named model.
pub(super) struct Solved {
    /// Logarithm of the Bayes factor against none of them.
    pub log_gain: f64,
    /// Their likeliest coefficients.
    coefficients: DVector<f64>,
    /// By how much the numbers of the named model give way.
    given_way: Option<DVector<f64>>,
}

impl Solved {
    /// What both leave of a whitened residual.
    pub fn left(&self, residual: &[f64], columns: &[Vec<f64>], named: Option<&Named>) -> Vec<f64> {
        let mut left = residual.to_vec();
        let mut take = |columns: &[Vec<f64>], by: &DVector<f64>| {
            for (column, share) in columns.iter().zip(by.iter()) {
                for (left, x) in left.iter_mut().zip(column) {
                    *left -= share * x;
                }
            }
        };
        take(columns, &self.coefficients);
        if let (Some(named), Some(given_way)) = (named, &self.given_way) {
            take(&named.jacobian, given_way);
        }
        left
    }
}

/// Columns beside a named model, which goes to its own optimum first.
pub(super) struct Beside<'a> {
    /// `C'C - C'J (J'J + P)^-1 J'C`.
    shared: DMatrix<f64>,
    b: DVector<f64>,
    named: Option<(&'a Named, DMatrix<f64>)>,
}

impl<'a> Beside<'a> {
    /// These columns beside a named model that leaves `r`.
    pub fn new(r: &[f64], columns: &[Vec<f64>], named: Option<&'a Named>) -> Self {
        let mut shared = gram(columns, |_, _| 0.0);
        let mut b = DVector::from_fn(columns.len(), |k, _| dot(&columns[k], r));
        let named = named.map(|named| {
            let cross = DMatrix::from_fn(named.jacobian.len(), columns.len(), |i, j| {
                dot(&named.jacobian[i], &columns[j])
            });
            let answer = named.factors.solve(&cross);
            shared -= cross.transpose() * &answer;
            b -= cross.transpose() * &named.step;
            (named, answer)
        });
        Self { shared, b, named }
    }

    /// With a prior of this size.
    pub fn solved(&self, size: f64) -> Option<Solved> {
        let n = self.b.len();
        let schur = &self.shared * (size * size) + DMatrix::identity(n, n);
        let cholesky = schur.cholesky()?;
        let half_log_determinant: f64 = cholesky.l_dirty().diagonal().iter().map(|x| x.ln()).sum();
        let coefficients = cholesky.solve(&self.b) * (size * size);
        let given_way =
            |(named, answer): &(&Named, DMatrix<f64>)| &named.step - answer * &coefficients;
        Some(Solved {
            log_gain: 0.5 * coefficients.dot(&self.b) - half_log_determinant,
            given_way: self.named.as_ref().map(given_way),
            coefficients,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Mul;

    use super::*;

    /// Logarithm of a Gaussian density with mean nought, from its covariance.
    fn log_density(r: &[f64], covariance: DMatrix<f64>) -> f64 {
        let r = DVector::from_column_slice(r);
        let log_determinant = covariance.determinant().ln();
        let squares = r.dot(&covariance.try_inverse().expect("regular").mul(&r));
        -0.5 * (squares + log_determinant)
    }

    /// Of a linear model the Bayes factor is that of two Gaussian densities of the data with everything marginalised, from
    /// wherever the named model's numbers start and whatever the size of the columns' prior.
    #[test]
    fn the_gain_is_that_of_the_marginal_densities() {
        const SIZE: f64 = 0.3;
        let n = 12;
        let wave = |k: f64| (0..n).map(|i| (k * i as f64).sin()).collect::<Vec<f64>>();
        let (jacobian, columns) = (
            vec![wave(0.3), wave(0.9)],
            vec![wave(0.5), wave(1.7), wave(2.6)],
        );
        let r: Vec<f64> = (0..n).map(|i| 3.0 * (0.4 * i as f64).cos() + 0.2).collect();
        let precision = 4.0;
        let normal = gram(&jacobian, |i, j| if i == j { precision } else { 0.0 });
        let factors = normal.cholesky().expect("regular");
        let slope = DVector::from_fn(2, |i, _| dot(&jacobian[i], &r));
        let spread = |columns: &[Vec<f64>], variance: f64| {
            DMatrix::from_fn(n, n, |i, k| {
                variance * columns.iter().map(|c| c[i] * c[k]).sum::<f64>()
            })
        };
        let named = DMatrix::identity(n, n) + spread(&jacobian, 1.0 / precision);
        let expected =
            log_density(&r, &named + spread(&columns, SIZE * SIZE)) - log_density(&r, named);
        let named = Named {
            step: factors.solve(&slope),
            jacobian,
            factors,
        };
        let found = Beside::new(&r, &columns, Some(&named)).solved(SIZE);
        let gain = found.expect("solved").log_gain;
        assert!((gain - expected).abs() < 1e-9, "{gain} {expected}");
    }
}
