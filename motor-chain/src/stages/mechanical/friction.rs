//! Effects of friction: each changes the friction law of the mechanical stage.

use super::{LoadFractions, StribeckCurve};
use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// Coulomb friction differs from the nominal motor's.
pub(crate) struct CoulombFriction;

impl Effect for CoulombFriction {
    const KIND: EffectKind = EffectKind {
        id: ids::COULOMB_FRICTION,
        stage: Stage::Mechanical,
        summary: "Coulomb friction differs from the nominal motor's",
        equation: "Tf sgn(w), holds the shaft up to Tf",
        source: "Coulomb; lab handout",
        excited_by: "any command",
        confounded_with: &[ids::VOLTAGE_DROP],
        parameters: &[EffectParameter::new(
            "torque_nm",
            "N m",
            (0.5, 5.0),
            Scale::CoulombTorque,
            Prior::LogUniform,
        )
        .away_from(1.0, 0.15)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.coulomb_nm = values[0];
    }
}

/// Viscous friction differs from the nominal motor's.
pub(crate) struct ViscousFriction;

impl Effect for ViscousFriction {
    const KIND: EffectKind = EffectKind {
        id: ids::VISCOUS_FRICTION,
        stage: Stage::Mechanical,
        summary: "viscous friction differs from the nominal motor's",
        equation: "b w",
        source: "lab handout",
        excited_by: "coasting, several levels",
        confounded_with: &["torque_constant_nm_per_a"],
        parameters: &[EffectParameter::new(
            "coefficient_nm_s_per_rad",
            "N m s/rad",
            (1.0, 10.0),
            Scale::ViscousCoefficient,
            Prior::LogUniform,
        )
        .away_from(1.0, 0.15)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.viscous_nm_s_per_rad = values[0];
    }
}

/// Viscous friction differs by direction.
pub(crate) struct AsymmetricViscous;

impl Effect for AsymmetricViscous {
    const KIND: EffectKind = EffectKind {
        id: ids::ASYMMETRIC_VISCOUS,
        stage: Stage::Mechanical,
        summary: "viscous friction differs by direction",
        equation: "b (1 + ratio) w forward, b (1 - ratio) w in reverse",
        source: "direction-dependent friction (Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 1994)",
        excited_by: "both directions, several levels",
        confounded_with: &[ids::ASYMMETRIC_FRICTION],
        parameters: &[EffectParameter::new(
            "ratio",
            "",
            (-0.8, 0.8),
            Scale::Absolute,
            Prior::Uniform,
        )
        .away_from(0.0, 0.05)
        .possible(-1.0, 1.0)
        .defaulting_to(0.3)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.viscous_asymmetry = Some(values[0]);
    }
}

/// Friction is larger at low speed.
pub(crate) struct Stribeck;

impl Effect for Stribeck {
    const KIND: EffectKind = EffectKind {
        id: ids::STRIBECK,
        stage: Stage::Mechanical,
        summary: "friction is larger at low speed",
        equation: "Tf + extra_torque_nm exp(-(w / stribeck_speed_rad_s)^2); breakaway at Tf + extra_torque_nm",
        source: "Stribeck curve (Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 1994)",
        excited_by: "breakaway, crawling",
        confounded_with: &[ids::DEAD_ZONE],
        parameters: &[
            EffectParameter::new(
                "extra_torque_nm",
                "N m",
                (0.3, 4.0),
                Scale::CoulombTorque,
                Prior::LogUniform,
            ),
            EffectParameter::new(
                "stribeck_speed_rad_s",
                "rad/s",
                (0.02, 0.4),
                Scale::NoLoadSpeed,
                Prior::LogUniform,
            )
            .possible(1e-6, f64::MAX),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.stribeck = Some(StribeckCurve {
            extra_nm: values[0],
            speed_rad_s: values[1],
        });
    }
}

/// Friction differs by direction.
pub(crate) struct AsymmetricFriction;

impl Effect for AsymmetricFriction {
    const KIND: EffectKind = EffectKind {
        id: ids::ASYMMETRIC_FRICTION,
        stage: Stage::Mechanical,
        summary: "friction differs by direction",
        equation: "Tf (1 + ratio) forward, Tf (1 - ratio) in reverse",
        source: "Armstrong-Helouvry 1994",
        excited_by: "both directions",
        confounded_with: &[ids::GRAVITY_LOAD],
        parameters: &[EffectParameter::new(
            "ratio",
            "",
            (-0.8, 0.8),
            Scale::Absolute,
            Prior::Uniform,
        )
        .away_from(0.0, 0.05)
        .possible(-1.0, 1.0)
        .defaulting_to(0.3)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.asymmetry = values[0];
    }
}

/// Static friction exceeds Coulomb friction.
pub(crate) struct StaticFriction;

impl Effect for StaticFriction {
    const KIND: EffectKind = EffectKind {
        id: ids::STATIC_FRICTION,
        stage: Stage::Mechanical,
        summary: "static friction exceeds sliding friction",
        equation: "holds the shaft up to torque_nm, brakes with Tf as soon as it moves; nothing beside presliding, which never holds",
        source: "Karnopp, Computer simulation of stick-slip friction (1985)",
        excited_by: "starts from rest at low levels",
        confounded_with: &[ids::STRIBECK, ids::DEAD_ZONE],
        parameters: &[EffectParameter::new(
            "torque_nm",
            "N m",
            (1.1, 4.0),
            Scale::CoulombTorque,
            Prior::LogUniform,
        )],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.static_nm = Some(values[0]);
    }
}

/// Friction builds up over an angle.
pub(crate) struct Presliding;

impl Effect for Presliding {
    const KIND: EffectKind = EffectKind {
        id: ids::PRESLIDING,
        stage: Stage::Mechanical,
        summary: "friction builds up over an angle",
        equation: "dF/dt = sigma (w - |w| F / T), sigma = Tf / break_in_angle_rad; F replaces the sliding friction T sgn(w)",
        source: "Dahl, A solid friction model (1968)",
        excited_by: "small reversals",
        confounded_with: &[ids::BACKLASH, ids::COMPLIANCE],
        parameters: &[EffectParameter::new(
            "break_in_angle_rad",
            "rad",
            (0.5, 10.0),
            Scale::Count,
            Prior::LogUniform,
        )
        .possible(1e-9, f64::MAX)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.break_in_angle_rad = Some(values[0]);
    }
}

/// Friction grows with the transmitted torque.
pub(crate) struct LoadFriction;

impl Effect for LoadFriction {
    const KIND: EffectKind = EffectKind {
        id: ids::LOAD_FRICTION,
        stage: Stage::Mechanical,
        summary: "friction grows with the transmitted torque",
        equation: "Tf + c |tau_m|; c = driving_fraction where tau_m w >= 0, else driven_fraction; at rest the larger of driving_fraction and what moving so would meet",
        source: "load-dependent gear friction (Rhoban BAM)",
        excited_by: "braking against driving",
        confounded_with: &["torque_constant_nm_per_a"],
        parameters: &[
            EffectParameter::new(
                "driving_fraction",
                "",
                (0.0, 0.5),
                Scale::Absolute,
                Prior::Uniform,
            )
            .possible(0.0, 0.99)
            .defaulting_to(0.2),
            EffectParameter::new(
                "driven_fraction",
                "",
                (0.0, 0.5),
                Scale::Absolute,
                Prior::Uniform,
            )
            .possible(0.0, 0.99)
            .defaulting_to(0.3),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.mechanical.load_friction = Some(LoadFractions {
            driving: values[0],
            driven: values[1],
        });
    }
}
