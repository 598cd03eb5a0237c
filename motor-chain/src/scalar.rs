//! The scalar type of the chain's equations: `f64`, or a dual number with derivatives by `D` parameters (forward-mode
//! automatic differentiation).
//!
//! `(v, d) + (w, e) = (v + w, d + e)`, `(v, d) (w, e) = (v w, v e + w d)`, `f(v, d) = (f(v), f'(v) d)`. Comparisons
//! use the value only: the mode is not differentiated, its time of change is.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::sine::sin_cos;

/// A real number, possibly with derivatives.
pub trait Scalar:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + PartialEq
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
{
    /// Number of derivatives carried.
    const DERIVATIVES: usize;

    /// The value without its derivatives.
    fn value(self) -> f64;
    /// Derivative number `k`.
    fn derivative(self, k: usize) -> f64;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Exponential function.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;

    /// Whether it is 0 for all parameters.
    #[inline(always)]
    fn is_nought(self) -> bool {
        self == Self::zero()
    }
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::from(0.0)
    }
    /// Sine.
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
    /// -1, or +1 for a non-negative value.
    #[inline(always)]
    fn sign(self) -> f64 {
        if self.value() < 0.0 { -1.0 } else { 1.0 }
    }
}

impl Scalar for f64 {
    const DERIVATIVES: usize = 0;

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn derivative(self, _k: usize) -> f64 {
        0.0
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f64::ln(self)
    }
}

/// A value with its derivatives with respect to `D` parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const D: usize> {
    /// Value.
    pub v: f64,
    /// Derivatives.
    pub d: [f64; D],
}

impl<const D: usize> Dual<D> {
    /// Parameter `k` itself: derivative 1 by `k`, 0 by the others.
    pub fn parameter(v: f64, k: usize) -> Self {
        let mut d = [0.0; D];
        d[k] = 1.0;
        Self { v, d }
    }

    #[inline(always)]
    fn map(self, v: f64, slope: f64) -> Self {
        // A loop: `[f64; D]::map` is not inlined for wide duals.
        let mut d = self.d;
        for slot in &mut d {
            *slot *= slope;
        }
        Self { v, d }
    }

    #[inline(always)]
    fn zip(self, other: Self, v: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut d = [0.0; D];
        for (k, slot) in d.iter_mut().enumerate() {
            *slot = f(self.d[k], other.d[k]);
        }
        Self { v, d }
    }
}

impl<const D: usize> From<f64> for Dual<D> {
    #[inline(always)]
    fn from(v: f64) -> Self {
        Self { v, d: [0.0; D] }
    }
}

impl<const D: usize> Neg for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(-self.v, -1.0)
    }
}

impl<const D: usize> Add for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.zip(o, self.v + o.v, |a, b| a + b)
    }
}

impl<const D: usize> Sub for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.zip(o, self.v - o.v, |a, b| a - b)
    }
}

// The product rule contains a sum.
#[allow(clippy::suspicious_arithmetic_impl)]
impl<const D: usize> Mul for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.zip(o, self.v * o.v, |a, b| a * o.v + self.v * b)
    }
}

impl<const D: usize> Div for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let (inverse, ratio) = (1.0 / o.v, self.v / o.v);
        self.zip(o, ratio, |a, b| (a - ratio * b) * inverse)
    }
}

impl<const D: usize> Add<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, o: f64) -> Self {
        self.v += o;
        self
    }
}

impl<const D: usize> Sub<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, o: f64) -> Self {
        self.v -= o;
        self
    }
}

impl<const D: usize> Mul<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        self.map(self.v * o, o)
    }
}

impl<const D: usize> Div<f64> for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: f64) -> Self {
        self.map(self.v / o, 1.0 / o)
    }
}

impl<const D: usize> AddAssign for Dual<D> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<const D: usize> SubAssign for Dual<D> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<const D: usize> Scalar for Dual<D> {
    const DERIVATIVES: usize = D;

    #[inline(always)]
    fn value(self) -> f64 {
        self.v
    }
    #[inline(always)]
    fn derivative(self, k: usize) -> f64 {
        self.d[k]
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = sin_cos(self.v);
        (self.map(s, c), self.map(c, -s))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = self.v.exp();
        self.map(e, e)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.map(self.v.ln(), 1.0 / self.v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dual_numbers_give_the_analytic_derivatives() {
        let x = Dual::<2>::parameter(0.7, 0);
        let y = Dual::<2>::parameter(1.3, 1);
        let f = (x * y + 2.0).exp() / (x.sin() + y) - x.abs() * 3.0;
        // d/dx and d/dy of exp(x y + 2)/(sin x + y) - 3 x
        let (e, q) = ((0.7_f64 * 1.3 + 2.0).exp(), 0.7_f64.sin() + 1.3);
        assert!((f.v - (e / q - 2.1)).abs() < 1e-12);
        assert!((f.d[0] - (1.3 * e / q - e * 0.7_f64.cos() / (q * q) - 3.0)).abs() < 1e-12);
        assert!((f.d[1] - (0.7 * e / q - e / (q * q))).abs() < 1e-12);
    }
}
