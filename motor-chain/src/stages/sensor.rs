//! Stage 6, the sensor: the encoder.
//!
//! `counts = floor(N (theta + e sin(theta + phi)) / 2 pi + start)`, each edge possibly lost.
//!
//! If a share of the edges is lost by their rate, `x = N (..) / 2 pi` is replaced by the integral of `kept(|x'|) x'`;
//! for the log of a filtered speed, its integral is quantized. Sensors with memory are in `memory.rs`.

use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// The encoder.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sensor<S> {
    /// Counts per revolution.
    pub counts_per_rev: S,
    /// Amplitude in rad and phase of an eccentric encoder.
    pub eccentricity: Option<(S, S)>,
    /// Probability that an edge is lost.
    pub loss: S,
    /// Edge rate above which edges are lost, in 1/s.
    pub max_rate_hz: Option<S>,
    /// Rate-dependent loss of edges.
    pub rate_loss: Option<RateLoss<S>>,
    /// Time constant in s of the filter of the logged speed.
    pub filter_s: Option<S>,
    /// Whether the filter is updated once per sample, not continuously.
    pub filters_samples: bool,
}

/// `kept = 1 / (1 + (f / f0)^n)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RateLoss<S> {
    /// Rate f0 in 1/s at which half of the edges are lost.
    pub rate_hz: S,
    /// Exponent n.
    pub exponent: S,
}

/// Beyond this many e-foldings the smaller of 1 and `(f / f0)^n` is negligible to sixteen digits.
const FOLDINGS: f64 = 40.0;

impl<S: Scalar> RateLoss<S> {
    /// Share of the edges that is kept at this rate in 1/s.
    pub(crate) fn kept(&self, rate: S) -> S {
        let ratio = rate.abs() / self.rate_hz;
        if ratio.value() <= 0.0 {
            return S::from(1.0);
        }
        let foldings = self.exponent * ratio.ln();
        if foldings.value() < -FOLDINGS {
            S::from(1.0)
        } else if foldings.value() > FOLDINGS {
            (-foldings).exp()
        } else {
            S::from(1.0) / (foldings.exp() + 1.0)
        }
    }
}

/// Most steps of Newton's method for the angle of a shaft, with bisection outside the bracket: forty halve two turns
/// to the rounding error. And its tolerance in rad.
const NEWTON_STEPS: usize = 40;
const NEAR_RAD: f64 = 1e-13;

impl<S: Scalar> Sensor<S> {
    pub(crate) fn nominal(counts_per_rev: S) -> Self {
        Self {
            counts_per_rev,
            eccentricity: None,
            loss: S::zero(),
            max_rate_hz: None,
            rate_loss: None,
            filter_s: None,
            filters_samples: false,
        }
    }

    /// Rate of [`Self::unrounded`] at this angle and speed, in counts/s.
    pub(crate) fn rate(&self, angle_rad: S, speed_rad_s: S) -> S {
        let seen = match &self.eccentricity {
            Some((amplitude, phase)) => {
                let (_, cosine) = (angle_rad + *phase).sin_cos();
                speed_rad_s * (*amplitude * cosine + 1.0)
            }
            None => speed_rad_s,
        };
        self.counts_per_rev * seen / std::f64::consts::TAU
    }

    /// Whether the reading depends on earlier ones.
    #[inline(always)]
    pub(crate) fn remembers(&self) -> bool {
        self.rate_loss.is_some() || self.filter_s.is_some()
    }

    /// Encoder reading before quantization and without loss of edges, in counts.
    #[inline(always)]
    pub(crate) fn unrounded(&self, angle_rad: S) -> S {
        let seen = match &self.eccentricity {
            Some((amplitude, phase)) => angle_rad + *amplitude * (angle_rad + *phase).sin(),
            None => angle_rad,
        };
        self.counts_per_rev * seen / std::f64::consts::TAU
    }

    /// Angle in rad and speed in rad/s of the shaft at this encoder angle (rad at `stated` counts per revolution) and
    /// speed: the inverse of [`Self::unrounded`] and [`Self::rate`]. Encoders with an eccentricity that is not
    /// invertible, and rate-dependent loss of edges, are excluded.
    pub(crate) fn shaft(&self, stated: S, angle_rad: f64, speed_rad_s: f64) -> (S, S) {
        let scale = stated / self.counts_per_rev;
        let (seen_rad, seen_rad_s) = (scale * angle_rad, scale * speed_rad_s);
        let (angle, slope) = match &self.eccentricity {
            Some((amplitude, phase)) if amplitude.value().abs() < 1.0 => {
                let beyond = |angle: S| angle + *amplitude * (angle + *phase).sin() - seen_rad;
                let slope = |angle: S| *amplitude * (angle + *phase).sin_cos().1 + 1.0;
                let (mut angle, reach) = (seen_rad.value(), amplitude.value().abs());
                let (mut low, mut high) = (angle - reach, angle + reach);
                for _ in 0..NEWTON_STEPS {
                    let off = beyond(S::from(angle)).value();
                    if off.abs() < NEAR_RAD {
                        break;
                    }
                    // The reading increases with the angle.
                    *(if off > 0.0 { &mut high } else { &mut low }) = angle;
                    let next = angle - off / slope(S::from(angle)).value();
                    angle = if low < next && next < high {
                        next
                    } else {
                        0.5 * (low + high)
                    };
                }
                // One more Newton step carries the derivatives (implicit function theorem).
                let at = S::from(angle);
                let angle = at - beyond(at) / slope(at).value();
                (angle, slope(angle))
            }
            _ => (seen_rad, S::from(1.0)),
        };
        (angle, seen_rad_s / slope / (-self.loss + 1.0))
    }

    /// Whether the edge rate at this speed exceeds the limit.
    pub(crate) fn too_fast(&self, speed_rad_s: f64) -> bool {
        let rate_hz = speed_rad_s.abs() * self.counts_per_rev.value() / std::f64::consts::TAU;
        self.max_rate_hz.is_some_and(|most| rate_hz > most.value())
    }

    /// Mean share of the kept edges while the speed changes linearly from one value to another.
    pub(crate) fn kept_share(&self, from_rad_s: S, to_rad_s: S) -> S {
        let kept = -self.loss + 1.0;
        let Some(most) = self.max_rate_hz else {
            return kept;
        };
        let limit = most * std::f64::consts::TAU / self.counts_per_rev;
        let (a, b) = (from_rad_s.abs(), to_rad_s.abs());
        let (low, high) = if a.value() < b.value() {
            (a, b)
        } else {
            (b, a)
        };
        if high.value() <= limit.value() {
            kept
        } else if low.value() >= limit.value() {
            S::zero()
        } else {
            // Angle covered below the limit over the total: both are trapezoids of the speed.
            kept * (limit * limit - low * low) / (high * high - low * low)
        }
    }

    /// Whether every edge is counted.
    #[inline(always)]
    pub(crate) fn faithful(&self) -> bool {
        self.loss.value() == 0.0 && self.max_rate_hz.is_none()
    }
}

/// Common counts per revolution (x4) of encoders.
const COMMON_RESOLUTIONS: &[f64] = &[
    100.0, 200.0, 256.0, 360.0, 400.0, 500.0, 512.0, 600.0, 720.0, 800.0, 1000.0, 1024.0, 1200.0,
    1440.0, 2000.0, 2048.0, 2400.0, 4000.0, 4096.0,
];

/// Counts per revolution, or the gear ratio, differ from the nominal values.
pub(crate) struct ResolutionError;

impl Effect for ResolutionError {
    const KIND: EffectKind = EffectKind {
        id: ids::RESOLUTION_ERROR,
        stage: Stage::Sensor,
        summary: "counts per revolution, or the gear ratio, differ from the nominal values",
        equation: "counts_per_rev replaces the file's",
        source: "encoders of the lab's motors",
        excited_by: "any command, with a prior on the motor constant",
        confounded_with: &["torque_constant_nm_per_a", "back_emf_v_s_per_rad"],
        parameters: &[EffectParameter::new(
            "counts_per_rev",
            "1/rev",
            (100.0, 4096.0),
            Scale::Absolute,
            Prior::OneOf(COMMON_RESOLUTIONS),
        )
        .possible(1.0, 1e7)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.sensor.counts_per_rev = values[0];
    }
}

/// Edges of the encoder are lost.
pub(crate) struct MissedCounts;

impl Effect for MissedCounts {
    const KIND: EffectKind = EffectKind {
        id: ids::MISSED_COUNTS,
        stage: Stage::Sensor,
        summary: "edges of the encoder are lost at random",
        equation: "each edge lost with probability p; edges above max_rate_hz lost (0: none)",
        source: "software-decoded encoders at high edge rates",
        excited_by: "high speed, return to a mark",
        confounded_with: &[ids::RESOLUTION_ERROR],
        parameters: &[
            EffectParameter::new(
                "probability",
                "",
                (0.001, 0.05),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .possible(0.0, 1.0),
            EffectParameter::new(
                "max_rate_hz",
                "1/s",
                (0.0, 0.0),
                Scale::Absolute,
                Prior::OneOf(&[0.0]),
            )
            .defaulting_to(0.0)
            .not_smooth(),
        ],
        random: true,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.sensor.loss = values[0];
        chain.sensor.max_rate_hz = (values[1].value() > 0.0).then_some(values[1]);
    }
}

/// A share of the edges is lost that increases with their rate.
pub(crate) struct EdgeRateLoss;

impl Effect for EdgeRateLoss {
    const KIND: EffectKind = EffectKind {
        id: ids::EDGE_RATE_LOSS,
        stage: Stage::Sensor,
        summary: "edges of the encoder are lost, a share that grows with their rate",
        equation: "share lost 1 - 1 / (1 + (f / rate_hz)^exponent), f the edge rate |w| N / 2 pi; deterministic",
        source: "interrupt-driven decoding near its limit: 9, 41 and 87 % lost at 46, 51 and 55 thousand edges/s",
        excited_by: "top speed, return to a mark",
        confounded_with: &[ids::QUADRATIC_DRAG, ids::CURRENT_LIMIT],
        parameters: &[
            EffectParameter::new(
                "rate_hz",
                "1/s",
                (0.7, 1.5),
                Scale::TopRate,
                Prior::LogUniform,
            )
            .possible(1e-6, f64::MAX),
            EffectParameter::new(
                "exponent",
                "",
                (2.0, 40.0),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .possible(1e-3, 1e3),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.sensor.rate_loss = Some(RateLoss {
            rate_hz: values[0],
            exponent: values[1],
        });
    }
}

/// The log has a filtered speed.
pub(crate) struct SpeedFilter;

impl Effect for SpeedFilter {
    const KIND: EffectKind = EffectKind {
        id: ids::SPEED_FILTER,
        stage: Stage::Sensor,
        summary: "the log holds a filtered speed",
        equation: "y = w - time_constant_s y'; counts are the integral of y, rounded",
        source: "first-order low-pass of a speed estimate in firmware",
        excited_by: "steps",
        confounded_with: &[ids::TRANSPORT_DELAY, ids::INDUCTANCE],
        parameters: &[EffectParameter::new(
            "time_constant_s",
            "s",
            (0.001, 0.2),
            Scale::Absolute,
            Prior::LogUniform,
        )
        .possible(1e-6, f64::MAX)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.sensor.filter_s = Some(values[0]);
    }
}

/// The encoder's disc is eccentric.
pub(crate) struct EncoderEccentricity;

impl Effect for EncoderEccentricity {
    const KIND: EffectKind = EffectKind {
        id: ids::ENCODER_ECCENTRICITY,
        stage: Stage::Sensor,
        summary: "the encoder's disc is off its axis",
        equation: "counts of theta + amplitude_rad sin(theta + phase_rad)",
        source: "first harmonic of a code disc off its axis",
        excited_by: "steady turning",
        confounded_with: &[ids::GRAVITY_LOAD],
        parameters: &[
            EffectParameter::new(
                "amplitude_rad",
                "rad",
                (0.3, 6.0),
                Scale::Count,
                Prior::LogUniform,
            ),
            EffectParameter::phase("phase_rad"),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.sensor.eccentricity = Some((values[0], values[1]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inverse and forward, for eccentric encoders with other counts than stated.
    #[test]
    fn the_encoder_reads_the_shafts_position() {
        let stated = 720.0;
        let sensor = |amplitude_rad: f64| Sensor {
            eccentricity: Some((amplitude_rad, 1.3)),
            ..Sensor::nominal(1440.0)
        };
        for amplitude_rad in [0.0, 0.02, 0.6, 0.99] {
            let sensor = sensor(amplitude_rad);
            for shaft_rad in [-40.0, -0.3, 0.0, 2.0, 17.0] {
                let (angle, speed) = sensor.shaft(stated, shaft_rad, 5.0);
                let read_rad = sensor.unrounded(angle) * std::f64::consts::TAU / stated;
                assert!(
                    (read_rad - shaft_rad).abs() < 1e-9,
                    "{amplitude_rad} {shaft_rad}: {read_rad}"
                );
                let read_rad = sensor.rate(angle, speed) * std::f64::consts::TAU / stated;
                assert!(
                    (read_rad - 5.0).abs() < 1e-9,
                    "{amplitude_rad} {shaft_rad}: {read_rad}"
                );
            }
        }
        // If the reading is not invertible, the shaft is set to the angle of an ideal encoder.
        assert_eq!(sensor(1.5).shaft(stated, 2.0, 4.9).0, 1.0);
    }
}
