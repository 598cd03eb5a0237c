//! Stage 5, the transmission between motor and load.
//!
//! Rigid: one inertia. With backlash or compliance two, `(1 - f) J` at the motor and `f J` at the load. The load's
//! share of viscous and Coulomb friction is `q f / (1 - f + q f)`: its friction per inertia is `q` times the motor's,
//! 1 if friction is divided as inertia. Between them a spring and a damper `k (theta1 - theta2) + c (w1 - w2)`, or a
//! gap without torque.
//!
//! With both, the spring is in series with the gap: it pushes `k (theta1 - theta2 -+ gap / 2) + c (w1 - w2)` in
//! contact, and releases when it would have to pull (the dead-zone model of Nordin and Gutman). A clutch couples both
//! rigidly up to its capacity, and slips with that torque beyond; beside play or a spring it transmits all torque.
//! Load fraction, division of the friction and side of the encoder are then those of the compliance.

use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// Transmission between motor and load.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Transmission<S> {
    /// Free angle between the flanks, in rad.
    pub gap_rad: Option<S>,
    /// Natural frequency in Hz and damping ratio of two inertias on a spring.
    pub spring: Option<(S, S)>,
    /// Capacity of a clutch in N m.
    pub clutch_nm: Option<S>,
    /// Share f of the inertia on the load side.
    pub load_fraction: S,
    /// Friction per inertia of the load over that of the motor.
    pub load_friction_weight: S,
    /// Whether the encoder is on the load side.
    pub encoder_on_load: bool,
}

impl<S: Scalar> Transmission<S> {
    pub(crate) fn rigid() -> Self {
        Self {
            gap_rad: None,
            spring: None,
            clutch_nm: None,
            load_fraction: S::zero(),
            load_friction_weight: S::from(1.0),
            encoder_on_load: false,
        }
    }

    /// Share of the friction on the load side; bitwise that of the inertia if friction is divided as inertia.
    pub(crate) fn load_friction_share(&self) -> S {
        let (f, more) = (self.load_fraction, self.load_friction_weight - 1.0);
        f + more * f * (-f + 1.0) / (more * f + 1.0)
    }

    pub(crate) fn two_bodies(&self) -> bool {
        self.gap_rad.is_some() || self.spring.is_some() || self.clutch_nm.is_some()
    }
}

/// Share of the load, and side of the encoder: the same keys for backlash and compliance.
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

/// Division of friction and damping: unknown for gear trains, so that it is free if there are two bodies.
const LOAD_FRICTION_WEIGHT: EffectParameter = EffectParameter::new(
    "load_friction_weight",
    "",
    (0.1, 10.0),
    Scale::Absolute,
    Prior::LogUniform,
)
.defaulting_to(1.0);

/// The transmission has play.
pub(crate) struct Backlash;

impl Effect for Backlash {
    const KIND: EffectKind = EffectKind {
        id: ids::BACKLASH,
        stage: Stage::Transmission,
        summary: "the transmission has clearance",
        equation: "free while |theta1 - theta2| < gap_rad / 2, plastic contact at the flanks; the load starts mid-gap",
        source: "Nordin, Gutman, Automatica 2002",
        excited_by: "small reversals",
        confounded_with: &[ids::COMPLIANCE, ids::PRESLIDING],
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
            LOAD_FRICTION_WEIGHT,
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let transmission = &mut chain.transmission;
        transmission.gap_rad = Some(values[0]);
        transmission.clutch_nm = None;
        transmission.load_fraction = values[1];
        transmission.encoder_on_load = values[2].value() >= 0.5;
        transmission.load_friction_weight = values[3];
    }
}

/// The transmission is elastic.
pub(crate) struct Compliance;

impl Effect for Compliance {
    const KIND: EffectKind = EffectKind {
        id: ids::COMPLIANCE,
        stage: Stage::Transmission,
        summary: "the transmission is elastic",
        equation: "torque k (theta1 - theta2) + c (w1 - w2), k = (2 pi f)^2 Jr, c = 2 zeta 2 pi f Jr, Jr = J1 J2 / (J1 + J2)",
        source: "two-mass resonance (Ellis, Control System Design Guide)",
        excited_by: "steps, chirps",
        confounded_with: &[ids::BACKLASH],
        parameters: &[
            EffectParameter::new(
                "frequency_hz",
                "Hz",
                (1.0, 50.0),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .or_up_to(10.0, Scale::TimeConstantAsFrequency)
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
            LOAD_FRICTION_WEIGHT,
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let transmission = &mut chain.transmission;
        transmission.spring = Some((values[0], values[1]));
        transmission.clutch_nm = None;
        transmission.load_fraction = values[2];
        transmission.encoder_on_load = values[3].value() >= 0.5;
        transmission.load_friction_weight = values[4];
    }
}

/// The coupling slips.
pub(crate) struct SlippingClutch;

impl Effect for SlippingClutch {
    const KIND: EffectKind = EffectKind {
        id: ids::SLIPPING_CLUTCH,
        stage: Stage::Transmission,
        summary: "the coupling slips above its torque limit",
        equation: "motor and load move as one while |tau| <= torque_nm, else tau = torque_nm sgn(w1 - w2); nothing beside backlash or compliance",
        source: "Coulomb friction clutch (Karnopp 1985), overload clutches of small gear motors",
        excited_by: "hard starts and reversals",
        confounded_with: &[ids::INERTIA, ids::CURRENT_LIMIT],
        parameters: &[
            EffectParameter::new(
                "torque_nm",
                "N m",
                (0.1, 0.8),
                Scale::StallTorque,
                Prior::Uniform,
            )
            .possible(1e-12, f64::MAX),
            EffectParameter::new(
                "load_share",
                "",
                (0.05, 0.9),
                Scale::Absolute,
                Prior::Uniform,
            )
            .possible(1e-6, 1.0 - 1e-6),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let transmission = &mut chain.transmission;
        if !transmission.two_bodies() {
            transmission.clutch_nm = Some(values[0]);
            transmission.load_fraction = values[1];
        }
    }
}
