//! Stage 1, the command: dead zone and arrival time.
//!
//! `u(t) = dead_zone(command(t - delay + offset))`.

use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// Changes of the command between board and driver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Command<S> {
    /// Delay from the board's clock tick to the driver, in s.
    pub delay_s: S,
    /// Delay of the logged commands relative to the driver, in s.
    pub ahead_s: S,
    /// Largest command without an effect.
    pub dead_zone: Option<S>,
    /// Largest commands without an effect, forward and back.
    pub zones: Option<[S; 2]>,
}

impl<S: Scalar> Command<S> {
    pub(crate) fn nominal() -> Self {
        Self {
            delay_s: S::zero(),
            ahead_s: S::zero(),
            dead_zone: None,
            zones: None,
        }
    }

    pub(crate) fn pass(&self, command: f64) -> f64 {
        let within = |threshold: &S| command.abs() <= threshold.value();
        let zone = |zones: &[S; 2]| within(&zones[usize::from(command < 0.0)]);
        if self.dead_zone.as_ref().is_some_and(within) || self.zones.as_ref().is_some_and(zone) {
            0.0
        } else {
            command
        }
    }
}

/// Longest plausible delay in s: for radio links and web servers in the loop; servos on a busy bus have 0.07 to 0.2
/// s.
const LONGEST_DELAY_S: f64 = 0.3;

/// The command reaches the driver late.
pub(crate) struct TransportDelay;

impl Effect for TransportDelay {
    const KIND: EffectKind = EffectKind {
        id: ids::TRANSPORT_DELAY,
        stage: Stage::Command,
        summary: "the command reaches the driver late",
        equation: "u(t - delay_s)",
        source: "lab handout part 2, delay from sampling",
        excited_by: "reversals, at a short sample time",
        confounded_with: &[ids::INDUCTANCE, ids::COMMAND_OFFSET],
        parameters: &[EffectParameter::new(
            "delay_s",
            "s",
            (0.1, 3.0),
            Scale::SampleTime,
            Prior::LogUniform,
        )
        .or_up_to(5.0, Scale::TimeConstant)
        .at_most(LONGEST_DELAY_S)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.command.delay_s = values[0];
    }
}

/// The logged commands are late.
pub(crate) struct CommandOffset;

impl Effect for CommandOffset {
    const KIND: EffectKind = EffectKind {
        id: ids::COMMAND_OFFSET,
        stage: Stage::Command,
        summary: "the logged command is late: the motor moves before the command changes in the log",
        equation: "u(t + offset_s), from the start on what stands offset_s later",
        source: "logs that note a command when it is confirmed, or beside the next sample",
        excited_by: "steps and reversals",
        confounded_with: &[ids::TRANSPORT_DELAY],
        parameters: &[EffectParameter::new(
            "offset_s",
            "s",
            (0.1, 5.0),
            Scale::SampleTime,
            Prior::Uniform,
        )
        .defaulting_to_scaled(1.0)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.command.ahead_s = values[0];
    }
}

/// Small commands have no effect.
pub(crate) struct DeadZone;

impl Effect for DeadZone {
    const KIND: EffectKind = EffectKind {
        id: ids::DEAD_ZONE,
        stage: Stage::Command,
        summary: "small commands have no effect",
        equation: "u -> 0 where |u| <= threshold_v, else u unchanged",
        source: "H-bridges with a minimum pulse width",
        excited_by: "slow ramps, low levels",
        confounded_with: &[ids::STRIBECK, ids::COULOMB_FRICTION],
        parameters: &[EffectParameter::new(
            "threshold_v",
            "V",
            (0.05, 0.4),
            Scale::Supply,
            Prior::Uniform,
        )
        .not_smooth()],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.command.dead_zone = Some(values[0]);
    }
}

/// Small commands have no effect, with a threshold that differs by direction.
pub(crate) struct AsymmetricDeadZone;

impl Effect for AsymmetricDeadZone {
    const KIND: EffectKind = EffectKind {
        id: ids::ASYMMETRIC_DEAD_ZONE,
        stage: Stage::Command,
        summary: "small commands have no effect, with a threshold that differs by direction",
        equation: "u -> 0 where -negative_v <= u <= positive_v, else u unchanged",
        source: "dead zones with left and right break points (Tao, Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, 1996)",
        excited_by: "slow ramps and low levels, both directions",
        confounded_with: &[ids::DEAD_ZONE, ids::ASYMMETRIC_FRICTION],
        parameters: &[
            EffectParameter::new(
                "positive_v",
                "V",
                (0.05, 0.4),
                Scale::Supply,
                Prior::Uniform,
            )
            .defaulting_to_scaled(0.1)
            .not_smooth(),
            EffectParameter::new(
                "negative_v",
                "V",
                (0.05, 0.4),
                Scale::Supply,
                Prior::Uniform,
            )
            .defaulting_to_scaled(0.25)
            .not_smooth(),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.command.zones = Some([values[0], values[1]]);
    }
}
