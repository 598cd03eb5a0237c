//! One step of the equations in a mode.
//!
//! Where they are affine, `y(h) = E y + h phi1 n` is exact; else Krogstad's scheme of order 4. Products leave out what is
//! 0 or 1 by the equations' structure: nothing in the linear part of a rigid motor depends on its angle, the angle's
//! own row has no `n`, and torques bend the rows of speeds alone, the back EMF that of the current.
//!
//! Krogstad, Generalized integrating factor methods for stiff PDEs, J. Comput. Phys. 203 (2005).

use super::dynamics::{CUR, ONE_BODY, TH1, W1};
use super::engine::Engine;
use super::ladder::{Matrix, add, apply};
use super::scalar::Scalar;

/// `E y`.
#[inline(always)]
pub(super) fn advance<S: Scalar, const N: usize>(e: &Matrix<S, N>, y: &[S; N]) -> [S; N] {
    if N > ONE_BODY {
        return apply(e, y);
    }
    let mut out = push(e, y);
    out[TH1] = y[TH1] + out[TH1];
    out
}

/// `P n`.
#[inline(always)]
pub(super) fn push<S: Scalar, const N: usize>(p: &Matrix<S, N>, n: &[S; N]) -> [S; N] {
    if N > ONE_BODY {
        return apply(p, n);
    }
    let mut out = [S::zero(); N];
    for (row, slot) in out.iter_mut().enumerate() {
        let mut sum = p[row][W1] * n[W1];
        for column in W1 + 1..N {
            sum += p[row][column] * n[column];
        }
        *slot = sum;
    }
    out
}

/// `A y` of a machine that is not held in place by its angle.
#[inline(always)]
pub(super) fn linear<S: Scalar, const N: usize>(a: &Matrix<S, N>, y: &[S; N]) -> [S; N] {
    if N > ONE_BODY {
        return apply(a, y);
    }
    push(a, y)
}

impl<S: Scalar, const N: usize> Engine<S, N> {
    /// The rate of change of the state now, and the part of it that is not linear, `A y + n` and `n`.
    #[inline(always)]
    pub(super) fn rate_in_parts(&self) -> ([S; N], [S; N]) {
        let a = &self.ladders[self.ladder].1.a;
        let n = if self.straight {
            self.constant
        } else {
            self.machine.rest(&self.mode, a, &self.constant, &self.y)
        };
        (add(linear(a, &self.y), &n), n)
    }

    /// The state after a step on rung `l`, and an estimate of its error.
    #[inline(always)]
    pub(super) fn propagate(&self, l: usize) -> ([S; N], f64) {
        if self.straight {
            let rung = self.ladders[self.ladder].1.rung(l);
            let forced = push(&rung.p1, &self.constant);
            return (add(advance(&rung.e, &self.y), &forced), 0.0);
        }
        self.propagate_curved(l)
    }

    /// The same where the mode's equations are not affine.
    #[inline(never)]
    fn propagate_curved(&self, l: usize) -> ([S; N], f64) {
        let ladder = &self.ladders[self.ladder].1;
        let rest = |y: &[S; N]| self.machine.rest(&self.mode, &ladder.a, &self.constant, y);
        let (rung, half) = (ladder.rung(l), ladder.rung(l + 1));
        let y = &self.y;
        let n0 = match &self.end_rate {
            Some(end) if end.now == self.now => end.bent,
            _ => rest(y),
        };
        let u2 = add(advance(&half.e, y), &push(&half.p1, &n0));
        let n2 = rest(&u2);
        let mut d = [S::zero(); N];
        for k in W1..N {
            d[k] = (n2[k] - n0[k]) * 2.0;
        }
        let u3 = add(u2, &self.push_bend(&half.p2, &d));
        let n3 = rest(&u3);
        let base = add(advance(&rung.e, y), &push(&rung.p1, &n0));
        for k in W1..N {
            d[k] = (n3[k] - n0[k]) * 2.0;
        }
        let u4 = add(base, &self.push_bend(&rung.p2, &d));
        let n4 = rest(&u4);
        let mut bend = [S::zero(); N];
        for k in W1..N {
            let middle = n2[k] + n3[k];
            d[k] = middle * 2.0 - n0[k] * 3.0 - n4[k];
            bend[k] = (n0[k] - middle + n4[k]) * 4.0;
        }
        let curved = self.push_bend(&rung.p3, &bend);
        let next = add(add(base, &self.push_bend(&rung.p2, &d)), &curved);
        let mut error = 0.0_f64;
        for (row, curved) in curved.iter().enumerate().skip(W1) {
            let mut gap = 0.0;
            for column in W1..N {
                gap += rung.p2[row][column].value() * (n3[column].value() - n2[column].value());
            }
            error = error.max(curved.value().abs()).max(gap.abs());
        }
        (next, error)
    }

    /// `P d` for a difference of two `n(y)`.
    #[inline(always)]
    fn push_bend(&self, p: &Matrix<S, N>, d: &[S; N]) -> [S; N] {
        if !self.machine.bent_by_torques {
            return push(p, d);
        }
        let mut out = [S::zero(); N];
        for (row, slot) in out.iter_mut().enumerate() {
            *slot = p[row][W1] * d[W1];
            if self.machine.bends_current {
                *slot += p[row][CUR] * d[CUR];
            }
            if N > ONE_BODY {
                *slot += p[row][N - 1] * d[N - 1];
            }
        }
        out
    }
}
