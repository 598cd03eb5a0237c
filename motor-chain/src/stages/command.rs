//! Stage 1, the command: what is asked for, and when it arrives.
//!
//! `u(t) = dead_zone(command(t - delay))`.

use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// What happens to the command on its way to the driver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Command<S> {
    /// Time from the board's clock tick to the driver, in s.
    pub delay_s: S,
    /// Commands of at most this magnitude do nothing.
    pub dead_zone: Option<S>,
}

impl<S: Scalar> Command<S> {
    pub(crate) fn nominal() -> Self {
        Self {
            delay_s: S::zero(),
            dead_zone: None,
        }
    }

    /// What reaches the driver when `command` is asked for.
    pub(crate) fn pass(&self, command: f64) -> f64 {
        match self.dead_zone {
            Some(threshold) if command.abs() <= threshold.value() => 0.0,
            _ => command,
        }
    }
}

/// The command reaches the driver late.
pub(crate) struct TransportDelay;

impl Effect for TransportDelay {
    const KIND: EffectKind = EffectKind {
        id: "transport_delay",
        stage: Stage::Command,
        summary: "the command reaches the driver late",
        equation: "u(t - delay_s)",
        source: "lab handout part 2, delay from sampling",
        excited_by: "reversals, at a short sample time",
        confounded_with: &["inductance"],
        parameters: &[EffectParameter::new(
            "delay_s",
            "s",
            (0.1, 3.0),
            Scale::SampleTime,
            Prior::Uniform,
        )],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.command.delay_s = values[0];
    }
}

/// Small commands do nothing.
pub(crate) struct DeadZone;

impl Effect for DeadZone {
    const KIND: EffectKind = EffectKind {
        id: "dead_zone",
        stage: Stage::Command,
        summary: "small commands do nothing",
        equation: "u -> 0 where |u| <= threshold_v, else u unchanged",
        source: "H-bridges with a minimum pulse width",
        excited_by: "slow ramps, low levels",
        confounded_with: &["stribeck", "coulomb_friction"],
        parameters: &[EffectParameter::new(
            "threshold_v",
            "V",
            (0.2, 1.5),
            Scale::Absolute,
            Prior::Uniform,
        )
        .not_smooth()],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.command.dead_zone = Some(values[0]);
    }
}
