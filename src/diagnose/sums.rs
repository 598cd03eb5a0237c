//! Sums of products of columns: `a'b`, and the matrix `C'C` of all pairs of columns.
//!
//! Most of a fit's arithmetic outside the simulation. nalgebra adds with several partial sums, so that an addition need
//! not wait for the one before.

use nalgebra::{DMatrix, DVectorView};

/// `a'b` over the length of the shorter one.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    DVectorView::from_slice(a, n).dot(&DVectorView::from_slice(b, n))
}

/// `C'C + P` of these columns, `P` symmetric and given element by element.
pub(super) fn gram(columns: &[Vec<f64>], precision: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let d = columns.len();
    let mut sums = DMatrix::zeros(d, d);
    for i in 0..d {
        for j in i..d {
            let sum = dot(&columns[i], &columns[j]) + precision(i, j);
            (sums[(i, j)], sums[(j, i)]) = (sum, sum);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of powers: `1 + ... + 100`, `1 + ... + 100^2`.
    #[test]
    fn sums_of_powers() {
        let one = vec![1.0; 100];
        let k: Vec<f64> = (1..=100).map(f64::from).collect();
        let found = gram(&[one, k], |i, j| if i == j { 0.5 } else { 0.0 });
        let expected = DMatrix::from_row_slice(2, 2, &[100.5, 5050.0, 5050.0, 338_350.5]);
        assert_eq!(found, expected);
    }
}
