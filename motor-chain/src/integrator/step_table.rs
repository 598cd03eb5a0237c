//! Exact propagators of the linear part over steps of `H / 2^l`.
//!
//! `y' = A y + n(t)` has the solution `y(h) = E y + h phi1 n` for a constant `n`, and with `phi0(z) = e^z, phi_k(z) =
//! int_0^1 e^((1-s) z) s^(k-1) / (k-1)! ds` terms in `phi2`, `phi3` for a varying `n`. The series is summed for a
//! step short enough to converge quickly; longer steps follow by scaling and squaring:
//!
//! ```text
//! e^(2z)   = e^z e^z
//! phi1(2z) = (e^z phi1 + phi1) / 2
//! phi2(2z) = (e^z phi2 + phi1 + phi2) / 4
//! phi3(2z) = (e^z phi3 + phi1 / 2 + phi2 + phi3) / 8
//! ```

use crate::scalar::Scalar;

/// Number of halvings of the longest step: events are located to within `H / 2^FINEST`.
pub(crate) const FINEST: usize = 10;

/// A square matrix.
pub(crate) type Matrix<S, const N: usize> = [[S; N]; N];

/// The propagators of one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepMatrices<S, const N: usize> {
    /// `e^(A h)`.
    pub e: Matrix<S, N>,
    /// `h phi1(A h)`.
    pub p1: Matrix<S, N>,
    /// `h phi2(A h)`.
    pub p2: Matrix<S, N>,
    /// `h phi3(A h)`.
    pub p3: Matrix<S, N>,
}

/// `a b`.
#[inline(never)]
fn multiply<S: Scalar, const N: usize>(a: &Matrix<S, N>, b: &Matrix<S, N>) -> Matrix<S, N> {
    let mut c = [[S::zero(); N]; N];
    for i in 0..N {
        for k in 0..N {
            // Uncoupled bodies, and angles without an effect, give many zeros.
            if a[i][k].is_nought() {
                continue;
            }
            for j in 0..N {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// `a y`, with the columns kept in registers.
#[inline(always)]
pub(crate) fn apply<S: Scalar, const N: usize>(a: &Matrix<S, N>, y: &[S; N]) -> [S; N] {
    let mut out = [S::zero(); N];
    for (i, slot) in out.iter_mut().enumerate() {
        let mut sum = a[i][0] * y[0];
        for j in 1..N {
            sum += a[i][j] * y[j];
        }
        *slot = sum;
    }
    out
}

/// Sum of two vectors.
#[inline(always)]
pub(crate) fn add<S: Scalar, const N: usize>(mut a: [S; N], b: &[S; N]) -> [S; N] {
    for k in 0..N {
        a[k] += b[k];
    }
    a
}

#[inline(never)]
fn scaled<S: Scalar, const N: usize>(mut a: Matrix<S, N>, factor: f64) -> Matrix<S, N> {
    for x in a.iter_mut().flatten() {
        *x = *x * factor;
    }
    a
}

#[inline(never)]
fn plus<S: Scalar, const N: usize>(mut a: Matrix<S, N>, b: &Matrix<S, N>) -> Matrix<S, N> {
    for (x, y) in a.iter_mut().flatten().zip(b.iter().flatten()) {
        *x += *y;
    }
    a
}

#[inline(never)]
fn plus_identity<S: Scalar, const N: usize>(mut a: Matrix<S, N>, factor: f64) -> Matrix<S, N> {
    for (i, row) in a.iter_mut().enumerate() {
        row[i] = row[i] + factor;
    }
    a
}

impl<S: Scalar, const N: usize> StepMatrices<S, N> {
    /// From the series, for `|A h|` well below 1.
    fn by_series(a: &Matrix<S, N>, step_s: f64) -> Self {
        let z = scaled(*a, step_s);
        // phi3(z) = sum z^j / (j + 3)!, by Horner's rule.
        let mut p3 = [[S::zero(); N]; N];
        for j in (0..9_u32).rev() {
            let factorial: f64 = (1..=j + 3).map(f64::from).product();
            p3 = plus_identity(multiply(&z, &p3), 1.0 / factorial);
        }
        let p2 = plus_identity(multiply(&z, &p3), 0.5);
        let p1 = plus_identity(multiply(&z, &p2), 1.0);
        let e = plus_identity(multiply(&z, &p1), 1.0);
        Self {
            e,
            p1: scaled(p1, step_s),
            p2: scaled(p2, step_s),
            p3: scaled(p3, step_s),
        }
    }

    /// For twice the step; `phi2` and `phi3` only if `wanted`.
    fn doubled(&self, wanted: bool) -> Self {
        let e = &self.e;
        // With the step as a factor, h phi_k becomes 2 h phi_k(2 z).
        let p1 = plus(multiply(e, &self.p1), &self.p1);
        if !wanted {
            let e = multiply(e, e);
            return Self { e, p1, ..*self };
        }
        let both = plus(self.p1, &self.p2);
        let p2 = scaled(plus(multiply(e, &self.p2), &both), 0.5);
        let tail = plus(plus(scaled(self.p1, 0.5), &self.p2), &self.p3);
        let p3 = scaled(plus(multiply(e, &self.p3), &tail), 0.25);
        Self {
            e: multiply(e, e),
            p1,
            p2,
            p3,
        }
    }
}

/// The propagators of every step from `H` (index 0) to `H / 2^(FINEST + 1)`.
#[derive(Debug, Clone)]
pub(crate) struct StepTable<S, const N: usize> {
    /// `A` itself.
    pub a: Matrix<S, N>,
    /// Whether it belongs to affine equations.
    pub is_affine: bool,
    /// Shortest step first.
    steps: Vec<StepMatrices<S, N>>,
}

impl<S: Scalar, const N: usize> StepTable<S, N> {
    /// For affine equations only `e^(A h)` and `h phi1` are computed.
    pub(crate) fn new(a: &Matrix<S, N>, longest_s: f64, is_affine: bool) -> Self {
        let norm = a
            .iter()
            .map(|row| row.iter().map(|x| x.value().abs()).sum::<f64>())
            .fold(0.0, f64::max);
        let finest_s = longest_s / f64::from(1_u32 << (FINEST + 1));
        let extra = (norm * finest_s / 0.05).log2().ceil().clamp(0.0, 60.0) as i32;
        let mut matrices = StepMatrices::by_series(a, finest_s * 0.5_f64.powi(extra));
        for _ in 0..extra {
            matrices = matrices.doubled(!is_affine);
        }
        let mut steps = Vec::with_capacity(FINEST + 2);
        steps.push(matrices);
        for l in 0..=FINEST {
            steps.push(steps[l].doubled(!is_affine));
        }
        Self {
            a: *a,
            is_affine,
            steps,
        }
    }

    /// The propagators of step `H / 2^l`.
    #[inline(always)]
    pub(crate) fn matrices(&self, l: usize) -> &StepMatrices<S, N> {
        &self.steps[FINEST + 1 - l]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_matrices_are_the_exponential_and_its_integrals() {
        // y' = -1000 y + n: e^-z, (1 - e^-z)/z, ... at h = 0.003 and three halvings, also if stiff
        for rate in [1.0, 1000.0, 3e6] {
            let step_table = StepTable::new(&[[-rate]], 0.003, false);
            for l in [0_usize, 3, FINEST + 1] {
                let h = 0.003 / f64::from(1_u32 << l);
                let z: f64 = -rate * h;
                let matrices = step_table.matrices(l);
                let p1 = if z.abs() < 1e-3 {
                    1.0 + z / 2.0 + z * z / 6.0
                } else {
                    z.exp_m1() / z
                };
                assert!((matrices.e[0][0] - z.exp()).abs() < 1e-12);
                assert!((matrices.p1[0][0] / h - p1).abs() < 1e-9);
                if z.abs() > 1.0 {
                    let p2 = (p1 - 1.0) / z;
                    assert!((matrices.p2[0][0] / h - p2).abs() < 1e-12);
                    assert!((matrices.p3[0][0] / h - (p2 - 0.5) / z).abs() < 1e-12);
                }
            }
        }
    }
}
