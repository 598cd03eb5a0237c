//! Effects of inertia and load: torques that depend on angle, speed or neither.

use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;
use crate::stages::electrical::{Wave, Waves};

/// The inertia differs from the nominal motor's.
pub(crate) struct Inertia;

impl Effect for Inertia {
    const KIND: EffectKind = EffectKind {
        id: ids::INERTIA,
        stage: Stage::Mechanical,
        summary: "the inertia differs from the nominal motor's",
        equation: "J dw/dt",
        source: "lab handout",
        excited_by: "steps",
        confounded_with: &["resistance_ohm"],
        parameters: &[EffectParameter::new(
            "inertia_kg_m2",
            "kg m^2",
            (0.3, 4.0),
            Scale::Inertia,
            Prior::LogUniform,
        )
        .away_from(1.0, 0.15)
        .possible(1e-12, f64::MAX)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.inertia_kg_m2 = values[0];
    }
}

/// Drag grows with the square of the speed.
pub(crate) struct QuadraticDrag;

impl Effect for QuadraticDrag {
    const KIND: EffectKind = EffectKind {
        id: ids::QUADRATIC_DRAG,
        stage: Stage::Mechanical,
        summary: "drag grows with the square of the speed",
        equation: "c w |w|, c = coefficient_nm_s2_per_rad2",
        source: "turbulent drag",
        excited_by: "many levels",
        confounded_with: &[ids::VISCOUS_FRICTION],
        parameters: &[EffectParameter::new(
            "coefficient_nm_s2_per_rad2",
            "N m s^2/rad^2",
            (0.1, 2.0),
            Scale::DragAtTopSpeed,
            Prior::LogUniform,
        )],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.drag = Some(values[0]);
    }
}

/// An unbalanced load.
pub(crate) struct GravityLoad;

impl Effect for GravityLoad {
    const KIND: EffectKind = EffectKind {
        id: ids::GRAVITY_LOAD,
        stage: Stage::Mechanical,
        summary: "an unbalanced load",
        equation: "torque_nm sin(theta + phase_rad) against positive rotation",
        source: "m g l sin(theta)",
        excited_by: "both directions, slowly",
        confounded_with: &[ids::ENCODER_ECCENTRICITY, ids::ASYMMETRIC_FRICTION],
        parameters: &[
            EffectParameter::new(
                "torque_nm",
                "N m",
                (0.3, 5.0),
                Scale::CoulombTorque,
                Prior::LogUniform,
            )
            // An arm may need nearly the whole motor torque, even with little friction.
            .or_up_to(0.7, Scale::StallTorque),
            EffectParameter::phase("phase_rad"),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.gravity = Some(Wave {
            amplitude: values[0],
            cycles_per_rev: S::from(1.0),
            phase_rad: values[1],
        });
    }
}

/// A constant torque.
pub(crate) struct ConstantLoad;

impl Effect for ConstantLoad {
    const KIND: EffectKind = EffectKind {
        id: ids::CONSTANT_LOAD,
        stage: Stage::Mechanical,
        summary: "a constant load torque",
        equation: "torque_nm against positive rotation, at rest too",
        source: "a weight on a drum, a constant-force spring",
        excited_by: "both directions",
        confounded_with: &[ids::ASYMMETRIC_FRICTION],
        parameters: &[EffectParameter::new(
            "torque_nm",
            "N m",
            (-3.0, 3.0),
            Scale::CoulombTorque,
            Prior::Uniform,
        )
        .away_from(0.0, 0.1)
        .possible(-f64::MAX, f64::MAX)
        .defaulting_to_scaled(0.5)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.load_nm = Some(values[0]);
    }
}

/// The magnets pull the rotor into detents.
pub(crate) struct Cogging;

impl Effect for Cogging {
    const KIND: EffectKind = EffectKind {
        id: ids::COGGING,
        stage: Stage::Mechanical,
        summary: "the magnets pull the rotor into detents",
        equation: "tau_m + torque_nm sin(cycles_per_rev theta + phase_rad)",
        source: "detent torque of slotted permanent-magnet motors",
        excited_by: "crawling",
        confounded_with: &[ids::TORQUE_RIPPLE],
        parameters: &[
            EffectParameter::new(
                "torque_nm",
                "N m",
                (0.3, 4.0),
                Scale::CoulombTorque,
                Prior::LogUniform,
            ),
            EffectParameter::new(
                "cycles_per_rev",
                "",
                (2.0, 30.0),
                Scale::Absolute,
                Prior::Uniform,
            )
            .defaulting_to(12.0),
            EffectParameter::phase("phase_rad"),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let wave = Wave {
            amplitude: values[0],
            cycles_per_rev: values[1],
            phase_rad: values[2],
        };
        chain.mechanical.cogging = Some(Waves::with(chain.mechanical.cogging, wave));
    }
}
