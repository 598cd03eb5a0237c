//! Dense output: the state within a step.
//!
//! Angles by quintic Hermite interpolation of angle, speed and acceleration at both ends, other states by cubic
//! Hermite interpolation of value and rate: weighted sums with weights that depend on the position only. If
//! parameters move the position as well, the state is shifted along its rate. An encoder needs one angle, and seldom
//! its speed.

use crate::integrator::dynamics::{ONE_BODY, TH1};
use crate::scalar::Scalar;

/// Shifts a state along its rate.
pub(crate) fn shift<S: Scalar, const N: usize>(y: &mut [S; N], rate: &[S; N], by_s: S) {
    for (value, slope) in y.iter_mut().zip(rate) {
        *value += *slope * by_s;
    }
}

/// A state and its rate.
pub(crate) type End<'a, S, const N: usize> = (&'a [S; N], &'a [S; N]);

/// A position within a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DenseOutput {
    /// As a share of the step.
    x: f64,
    span_s: f64,
}

impl DenseOutput {
    /// At share `x` of a step of `span_s`.
    #[inline(always)]
    pub(crate) fn at(x: f64, span_s: f64) -> Self {
        Self { x, span_s }
    }

    /// State variable `k`, an angle, from the weights of the increment, both speeds and both accelerations.
    #[inline(always)]
    fn angle<S: Scalar, const N: usize>(
        &self,
        k: usize,
        (y0, rate0): End<'_, S, N>,
        (y1, rate1): End<'_, S, N>,
    ) -> S {
        let (x, rest, h, h2) = (self.x, 1.0 - self.x, self.span_s, self.span_s * self.span_s);
        let x2 = x * x;
        let x3 = x2 * x;
        y0[k]
            + ((y1[k] - y0[k]) * (x3 * (10.0 + x * (6.0 * x - 15.0)))
                + (y0[k + 1] * (h * (x + x3 * (x * (8.0 - 3.0 * x) - 6.0)))
                    + y1[k + 1] * (h * x3 * (x * (7.0 - 3.0 * x) - 4.0)))
                + (rate0[k + 1] * (h2 * 0.5 * x2 * rest * rest * rest)
                    + rate1[k + 1] * (h2 * 0.5 * x3 * rest * rest)))
    }

    /// Another state variable, from the weights of the increment and both rates.
    #[inline(always)]
    fn other<S: Scalar, const N: usize>(
        &self,
        k: usize,
        (y0, rate0): End<'_, S, N>,
        (y1, rate1): End<'_, S, N>,
    ) -> S {
        let (x, rest, h, x2) = (self.x, 1.0 - self.x, self.span_s, self.x * self.x);
        y0[k]
            + ((y1[k] - y0[k]) * (x2 * (3.0 - 2.0 * x))
                + (rate0[k] * (h * x * rest * rest) + rate1[k] * (-h * x2 * rest)))
    }

    #[inline(always)]
    fn state<S: Scalar, const N: usize>(&self, start: End<'_, S, N>, end: End<'_, S, N>) -> [S; N] {
        let mut out = *start.0;
        for (k, slot) in out.iter_mut().enumerate() {
            *slot = if is_angle::<N>(k) {
                self.angle(k, start, end)
            } else {
                self.other(k, start, end)
            };
        }
        out
    }

    /// The state there if parameters move the position by `by_s`, which is 0 in value.
    pub(crate) fn moved<S: Scalar, const N: usize>(
        &self,
        start: End<'_, S, N>,
        end: End<'_, S, N>,
        by_s: S,
    ) -> [S; N] {
        let (x, rest) = (self.x, 1.0 - self.x);
        let slope = [
            6.0 * x * rest / self.span_s,
            rest * (1.0 - 3.0 * x),
            x * (3.0 * x - 2.0),
        ];
        let ((y0, rate0), (y1, rate1)) = (start, end);
        let mut out = self.state(start, end);
        let mut rate = out;
        for k in 0..N {
            rate[k] = if is_angle::<N>(k) {
                out[k + 1]
            } else {
                (y1[k] - y0[k]) * slope[0] + (rate0[k] * slope[1] + rate1[k] * slope[2])
            };
        }
        shift(&mut out, &rate, by_s);
        out
    }
}

/// State at a sample; each variable is computed on demand.
#[derive(Debug)]
pub(crate) enum Sample<'a, S, const N: usize> {
    /// The end of a step.
    At(&'a [S; N]),
    /// A position between two ends.
    DenseOutput(DenseOutput, End<'a, S, N>, End<'a, S, N>),
    /// A position that depends on parameters.
    Moved([S; N]),
}

impl<S: Scalar, const N: usize> Sample<'_, S, N> {
    #[inline(always)]
    pub(crate) fn state(&self) -> [S; N] {
        match self {
            Self::At(y) => **y,
            Self::DenseOutput(place, start, end) => place.state(*start, *end),
            Self::Moved(y) => *y,
        }
    }

    /// State variable `k`, an angle.
    #[inline(always)]
    pub(crate) fn angle(&self, k: usize) -> S {
        match self {
            Self::At(y) => y[k],
            Self::DenseOutput(place, start, end) => place.angle(k, *start, *end),
            Self::Moved(y) => y[k],
        }
    }

    /// Its speed.
    #[inline(always)]
    pub(crate) fn speed(&self, k: usize) -> S {
        match self {
            Self::At(y) => y[k + 1],
            Self::DenseOutput(place, start, end) => place.other(k + 1, *start, *end),
            Self::Moved(y) => y[k + 1],
        }
    }
}

/// Whether a state variable is an angle; the next one is its speed.
#[inline(always)]
fn is_angle<const N: usize>(k: usize) -> bool {
    k == TH1 || (N > ONE_BODY && k == N - 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;

    /// An angle that is a polynomial of fourth degree has a speed of third degree: both are exact, and so is their
    /// derivative by the position.
    #[test]
    fn the_interpolation_is_exact_for_polynomials() {
        let speed = |t: f64| 3.0 + t * (-5.0 + t * (7.0 + 11.0 * t));
        let angle = |t: f64| t * (3.0 + t * (-2.5 + t * (7.0 / 3.0 + 2.75 * t)));
        let acceleration = |t: f64| -5.0 + t * (14.0 + 33.0 * t);
        let state = |t: f64| [angle(t), speed(t), 0.0].map(Dual::<1>::from);
        let rate = |t: f64| [speed(t), acceleration(t), 0.0].map(Dual::<1>::from);
        let span_s = 0.7;
        let (y0, rate0, y1, rate1) = (state(0.0), rate(0.0), state(span_s), rate(span_s));
        for x in [0.0, 0.001, 0.3, 0.77, 1.0] {
            let by_s = Dual { v: 0.0, d: [1.0] };
            let t = x * span_s;
            let found = DenseOutput::at(x, span_s).moved((&y0, &rate0), (&y1, &rate1), by_s);
            let expected = [(angle(t), speed(t)), (speed(t), acceleration(t))];
            for (found, (value, slope)) in found.iter().zip(expected) {
                assert!((found.v - value).abs() < 1e-12, "{x}: {found:?}");
                assert!((found.d[0] - slope).abs() < 1e-12, "{x}: {found:?}");
            }
        }
    }
}
