//! The state inside a step, between its two ends.

use super::dynamics::ONE_BODY;
use super::scalar::Scalar;

/// Moves a state along its rate.
pub(super) fn shift<S: Scalar, const N: usize>(y: &mut [S; N], rate: &[S; N], by_s: S) {
    for (value, slope) in y.iter_mut().zip(rate) {
        *value += *slope * by_s;
    }
}

/// The state inside a step: angles by the quintic through angle, speed and acceleration at both ends, the rest by the
/// cubic through value and rate.
#[inline(never)]
pub(super) fn hermite<S: Scalar, const N: usize>(
    y0: &[S; N],
    rate0: &[S; N],
    y1: &[S; N],
    rate1: &[S; N],
    at_s: S,
    span_s: f64,
) -> [S; N] {
    let x = at_s / span_s;
    let (x2, x3) = (x * x, x * x * x);
    let rest = -x + 1.0;
    let mut out = *y0;
    for k in 0..N {
        let rise = y1[k] - y0[k];
        let (a, b) = (rate0[k] * span_s - rise, rise - rate1[k] * span_s);
        out[k] = y0[k] + rise * x + x * rest * (a * rest + b * x);
    }
    for (angle, speed) in [(0, 1), (N - 2, N - 1)] {
        if N <= ONE_BODY && angle != 0 {
            continue;
        }
        let h = span_s;
        let rise = y1[angle] - y0[angle];
        let (v0, v1) = (y0[speed] * h, y1[speed] * h);
        let (a0, a1) = (rate0[speed] * (h * h), rate1[speed] * (h * h));
        // theta = y0 + v0 x + a0 x^2 / 2 + c3 x^3 + c4 x^4 + c5 x^5
        let c3 = rise * 10.0 - v0 * 6.0 - v1 * 4.0 - a0 * 1.5 + a1 * 0.5;
        let c4 = rise * -15.0 + v0 * 8.0 + v1 * 7.0 + a0 * 1.5 - a1;
        let c5 = rise * 6.0 - (v0 + v1) * 3.0 + (a1 - a0) * 0.5;
        out[angle] = y0[angle] + v0 * x + a0 * x2 * 0.5 + x3 * (c3 + c4 * x + c5 * x2);
    }
    out
}
