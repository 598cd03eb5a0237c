//! Stage 7, timing: the true times of the encoder readings.
//!
//! The row of time `t_s` was read at `t_s (1 + relative) + delta`, `delta` uniform in 0 .. spread. A clock error also
//! affects the times of commands.

use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// Times of the encoder readings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Timing<S> {
    /// Real seconds per second of the board's clock.
    pub clock_scale: S,
    /// Largest lateness of a sample, in s.
    pub jitter_s: S,
}

impl<S: Scalar> Timing<S> {
    pub(crate) fn nominal() -> Self {
        Self {
            clock_scale: S::from(1.0),
            jitter_s: S::zero(),
        }
    }
}

/// Samples are late by a random time.
pub(crate) struct SampleJitter;

impl Effect for SampleJitter {
    const KIND: EffectKind = EffectKind {
        id: ids::SAMPLE_JITTER,
        stage: Stage::Timing,
        summary: "samples are taken late by a random time",
        equation: "sampled at t_s + delta, delta uniform in 0 .. spread_s",
        source: "interrupts and busy loops",
        excited_by: "fast turning",
        confounded_with: &["process noise"],
        parameters: &[EffectParameter::new(
            "spread_s",
            "s",
            (0.005, 1.0),
            Scale::SampleTime,
            Prior::LogUniform,
        )
        // The geometric mean of 5 % and all of the sample time: spreads that show at usual resolutions.
        .defaulting_to_scaled(0.2236)],
        random: true,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.timing.jitter_s = values[0];
    }
}

/// The board's clock has a rate error.
pub(crate) struct ClockError;

impl Effect for ClockError {
    const KIND: EffectKind = EffectKind {
        id: ids::CLOCK_ERROR,
        stage: Stage::Timing,
        summary: "the board's clock runs at a wrong rate",
        equation: "real time = t_s (1 + relative), of samples and commands",
        source: "ceramic resonators and wrong timer settings",
        excited_by: "host time stamps",
        confounded_with: &["torque_constant_nm_per_a", ids::INERTIA],
        parameters: &[EffectParameter::new(
            "relative",
            "",
            (-0.1, 0.1),
            Scale::Absolute,
            Prior::Uniform,
        )
        .away_from(0.0, 0.001)
        .possible(-0.9, 10.0)
        .defaulting_to(0.02)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.timing.clock_scale = values[0] + 1.0;
    }
}
