//! Encoder readings with memory: edges lost by their rate, and the log of a filtered speed.
//!
//! Between two samples `h` apart with known angle and speed, the edge rate is the parabola with these end values and
//! this integral: `kept x'` is integrated over it by five-point Gauss-Legendre quadrature. The result passes the
//! filter: the integral of a low-passed speed is the low-passed angle, `tau q' = x - q`, exact for cubic Hermite
//! interpolation. A filter with one update per sample is exponential smoothing: `q <- x + (q - x) exp(-h/tau)`.

use crate::scalar::Scalar;
use crate::stages::sensor::Sensor;

/// Nodes and weights of Gauss-Legendre quadrature on 0 .. 1.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_45),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// State of an encoder, in counts, counts/s and s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Memory<S> {
    /// Time of the last reading, in real time.
    at_s: S,
    /// Its reading without memory, and the rate.
    unrounded: (S, S),
    /// The part that was kept, and its rate.
    kept: (S, S),
    /// The filter's state.
    filtered: S,
    /// Initial lag of the filter at a steady speed.
    behind: S,
    /// Whether there is no reading yet.
    begins: bool,
}

impl<S: Scalar> Memory<S> {
    /// At time 0, at this angle (rad) and a steady speed (rad/s).
    pub(crate) fn new(sensor: &Sensor<S>, angle_rad: S, speed_rad_s: S) -> Self {
        let unrounded = sensor.unrounded(angle_rad);
        let rate = sensor.rate(angle_rad, speed_rad_s);
        let kept_rate = kept_rate(sensor, rate);
        let behind = match sensor.filter_s {
            Some(tau_s) => tau_s * kept_rate,
            None => S::zero(),
        };
        Self {
            at_s: S::zero(),
            unrounded: (unrounded, rate),
            kept: (unrounded, kept_rate),
            filtered: unrounded - behind,
            behind,
            begins: true,
        }
    }

    /// Sets the (real) start time.
    pub(crate) fn begin_at(&mut self, at_s: S) {
        self.at_s = at_s;
    }

    /// Reading at this angle and speed at `at_s`, before quantization.
    #[inline(never)]
    pub(crate) fn read(
        &mut self,
        sensor: &Sensor<S>,
        (angle_rad, speed_rad_s): (S, S),
        at_s: S,
    ) -> S {
        let h = at_s - self.at_s;
        let unrounded = (
            sensor.unrounded(angle_rad),
            sensor.rate(angle_rad, speed_rad_s),
        );
        let kept = match sensor.rate_loss {
            Some(_) => {
                let by = kept_between(sensor, self.unrounded, unrounded, h);
                (self.kept.0 + by, kept_rate(sensor, unrounded.1))
            }
            None => unrounded,
        };
        if let Some(tau_s) = sensor.filter_s
            && h.value() > 0.0
        {
            self.filtered = if sensor.filters_samples {
                let forgotten = (-h / tau_s).exp();
                if self.begins {
                    // For a steady speed before the start.
                    self.behind = self.kept.1 * h * forgotten / (S::from(1.0) - forgotten);
                    self.filtered = self.kept.0 - self.behind;
                }
                self.begins = false;
                kept.0 + (self.filtered - kept.0) * forgotten
            } else {
                lag(self.filtered, self.kept, kept, h, tau_s)
            };
        }
        (self.at_s, self.unrounded, self.kept) = (at_s, unrounded, kept);
        match sensor.filter_s {
            Some(_) => self.filtered + self.behind,
            None => kept.0,
        }
    }
}

/// Rate of kept edges in 1/s at this edge rate.
fn kept_rate<S: Scalar>(sensor: &Sensor<S>, rate: S) -> S {
    match &sensor.rate_loss {
        Some(loss) => rate * loss.kept(rate),
        None => rate,
    }
}

/// Counts kept between two readings with their rates, `h` s apart.
fn kept_between<S: Scalar>(sensor: &Sensor<S>, (x0, r0): (S, S), (x1, r1): (S, S), h: S) -> S {
    let rise = x1 - x0;
    if h.value() <= 0.0 {
        return rise;
    }
    let middle = (rise / h * 6.0 - r0 - r1) * 0.25;
    let mut sum = S::zero();
    for (s, weight) in GAUSS {
        let rate = r0 * ((1.0 - s) * (1.0 - 2.0 * s))
            + middle * (4.0 * s * (1.0 - s))
            + r1 * (s * (2.0 * s - 1.0));
        sum += kept_rate(sensor, rate) * weight;
    }
    sum * h
}

/// `tau q' = x - q` after `h` s, for cubic Hermite interpolation of `x`.
fn lag<S: Scalar>(q: S, (x0, r0): (S, S), (x1, r1): (S, S), h: S, tau: S) -> S {
    let slope = (x1 - x0) / h;
    let second = (slope * 3.0 - r0 * 2.0 - r1) / h;
    let third = (r0 + r1 - slope * 2.0) / (h * h);
    // The particular solution for a cubic: x and its derivatives times powers of -tau.
    let bend = |t: S| second * 2.0 + third * t * 6.0;
    let left = |x: S, rate: S, t: S| x - tau * (rate - tau * (bend(t) - tau * third * 6.0));
    left(x1, r1, h) + (q - left(x0, r0, S::zero())) * (-h / tau).exp()
}
