//! Stage 5, the transmission: what lies between the motor and the load.
//!
//! Rigid: one inertia. With backlash or compliance two, `(1 - f) J` at the motor and `f J` at the load, and viscous and
//! Coulomb friction split in the same ratio. Between them a spring and a damper
//! `k (theta1 - theta2) + c (w1 - w2)`, or a gap within which neither feels the other.
//!
//! With both the spring is in series with the gap: it pushes `k (theta1 - theta2 -+ gap / 2) + c (w1 - w2)` once a flank is
//! reached, and lets go when it would have to pull (the dead-zone model of Nordin and Gutman). Load fraction and side of
//! the encoder are then those of the compliance.

use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// What lies between motor and load.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Transmission<S> {
    /// Free angle between the flanks, in rad.
    pub gap_rad: Option<S>,
    /// Natural frequency in Hz and damping ratio of two inertias on a spring.
    pub spring: Option<(S, S)>,
    /// Share f of inertia and friction that is the load's.
    pub load_fraction: S,
    /// Whether the encoder sits on the load.
    pub encoder_on_load: bool,
}

impl<S: Scalar> Transmission<S> {
    pub(crate) fn rigid() -> Self {
        Self {
            gap_rad: None,
            spring: None,
            load_fraction: S::zero(),
            encoder_on_load: false,
        }
    }

    /// Whether motor and load are two bodies.
    pub(crate) fn two_bodies(&self) -> bool {
        self.gap_rad.is_some() || self.spring.is_some()
    }
}

/// Share of the load, and which side the encoder sits on: the same keys for backlash and compliance.
const LOAD_FRACTION: EffectParameter = EffectParameter::new(
    "load_fraction",
    "",
    (0.05, 0.9),
    Scale::Absolute,
    Prior::Uniform,
)
.possible(1e-6, 1.0 - 1e-6);
pub(crate) const ENCODER_SIDE: EffectParameter = EffectParameter::new(
    "encoder_side",
    "",
    (0.0, 1.0),
    Scale::Absolute,
    Prior::OneOf(&[0.0, 1.0]),
)
.possible(0.0, 1.0)
.defaulting_to(0.0)
.not_smooth();

/// The transmission has play.
pub(crate) struct Backlash;

impl Effect for Backlash {
    const KIND: EffectKind = EffectKind {
        id: "backlash",
        stage: Stage::Transmission,
        summary: "the transmission has play",
        equation: "free while |theta1 - theta2| < gap_rad / 2, plastic contact at the flanks; the load starts mid-gap",
        source: "Nordin, Gutman, Automatica 2002",
        excited_by: "small reversals",
        confounded_with: &["compliance", "presliding"],
        parameters: &[
            EffectParameter::new(
                "gap_rad",
                "rad",
                (0.5_f64.to_radians(), 10.0_f64.to_radians()),
                Scale::Absolute,
                Prior::LogUniform,
            ),
            LOAD_FRACTION,
            ENCODER_SIDE,
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let transmission = &mut chain.transmission;
        transmission.gap_rad = Some(values[0]);
        transmission.load_fraction = values[1];
        transmission.encoder_on_load = values[2].value() >= 0.5;
    }
}

/// The transmission is elastic.
pub(crate) struct Compliance;

impl Effect for Compliance {
    const KIND: EffectKind = EffectKind {
        id: "compliance",
        stage: Stage::Transmission,
        summary: "the transmission is elastic",
        equation: "torque k (theta1 - theta2) + c (w1 - w2), k = (2 pi f)^2 Jr, c = 2 zeta 2 pi f Jr, Jr = J1 J2 / (J1 + J2)",
        source: "two-mass resonance (Ellis, Control System Design Guide)",
        excited_by: "steps, chirps",
        confounded_with: &["backlash"],
        parameters: &[
            EffectParameter::new(
                "frequency_hz",
                "Hz",
                (1.0, 50.0),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .possible(1e-6, 1e4),
            EffectParameter::new(
                "damping_ratio",
                "",
                (0.005, 0.5),
                Scale::Absolute,
                Prior::LogUniform,
            ),
            LOAD_FRACTION,
            ENCODER_SIDE,
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let transmission = &mut chain.transmission;
        transmission.spring = Some((values[0], values[1]));
        transmission.load_fraction = values[2];
        transmission.encoder_on_load = values[3].value() >= 0.5;
    }
}
