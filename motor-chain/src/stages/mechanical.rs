//! Stage 4, the mechanics: inertia, friction, load.
//!
//! `J dw/dt = tau_m + cogging - gravity - load - drag - b (1 + r_b sgn w) w - friction`. Friction in direction `s` has the level
//! `T(s) = Tf (1 + r s) + dT exp(-(w/ws)^2) + c |tau_m|`; at rest it takes whatever holds the shaft, up to that level,
//! or up to the larger one that it breaks away at. With presliding it approaches that as Dahl's `F(theta)` does.

use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;
use crate::stages::electrical::{Wave, Waves};

/// Inertia, friction and load.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mechanical<S> {
    /// Inertia J in kg m^2.
    pub inertia_kg_m2: S,
    /// Viscous coefficient b in N m s/rad.
    pub viscous_nm_s_per_rad: S,
    /// Relative difference of the viscous coefficient by direction.
    pub viscous_asymmetry: Option<S>,
    /// Coulomb torque Tf in N m.
    pub coulomb_nm: S,
    /// Torque that breaks friction away, where it is more than Coulomb's, in N m.
    pub static_nm: Option<S>,
    /// Extra friction at low speed.
    pub stribeck: Option<StribeckCurve<S>>,
    /// Relative difference r of the Coulomb torque by direction.
    pub asymmetry: S,
    /// Angle over which friction builds up, in rad.
    pub break_in_angle_rad: Option<S>,
    /// Friction that grows with the motor's torque.
    pub load_friction: Option<LoadFractions<S>>,
    /// Drag coefficient in N m s^2/rad^2.
    pub drag: Option<S>,
    /// Gravity's torque, one period a revolution.
    pub gravity: Option<Wave<S>>,
    /// Cogging torque.
    pub cogging: Option<Waves<S>>,
    /// A torque against positive rotation that depends on nothing, in N m.
    pub load_nm: Option<S>,
}

/// `extra exp(-(w / speed)^2)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StribeckCurve<S> {
    /// Torque at rest above Coulomb's, in N m.
    pub extra_nm: S,
    /// Speed at which it has fallen to 1/e, in rad/s.
    pub speed_rad_s: S,
}

impl<S: Scalar> StribeckCurve<S> {
    /// The extra torque at this speed.
    #[inline(always)]
    pub(crate) fn at(&self, speed_rad_s: S) -> S {
        let ratio = speed_rad_s / self.speed_rad_s;
        self.extra_nm * (-(ratio * ratio)).exp()
    }
}

/// Shares of the motor torque that turn into friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LoadFractions<S> {
    /// Where the motor drives the load.
    pub driving: S,
    /// Where the load drives the motor.
    pub driven: S,
}

impl<S: Scalar> LoadFractions<S> {
    /// The share in force where the torque has this sign in the direction of motion.
    #[inline(always)]
    pub(crate) fn share(&self, along: f64) -> S {
        if along >= 0.0 {
            self.driving
        } else {
            self.driven
        }
    }

    /// The share in force at rest against leaving in a direction in which the torque has this sign. Where being driven rubs more than
    /// driving, what drove it at rest would stop it as soon as it moved: it stays (Filippov 1988).
    #[inline(always)]
    pub(crate) fn holding_share(&self, along: f64) -> S {
        let moving = self.share(along);
        if moving.value() > self.driving.value() {
            moving
        } else {
            self.driving
        }
    }
}

impl<S: Scalar> Mechanical<S> {
    /// Coulomb level in N m in direction `s` (+1 or -1), without the part that depends on the speed or the torque.
    #[inline(always)]
    pub(crate) fn coulomb(&self, s: f64) -> S {
        self.coulomb_nm * (self.asymmetry * s + 1.0)
    }

    /// Breakaway level in N m in direction `s` at rest while the motor gives `torque_nm`.
    #[inline(always)]
    pub(crate) fn breakaway(&self, s: f64, torque_nm: S) -> S {
        let mut level = match self.static_nm {
            Some(most) if most.value() > self.coulomb_nm.value() => {
                most * (self.asymmetry * s + 1.0)
            }
            _ => self.coulomb(s),
        };
        if let Some(stribeck) = &self.stribeck {
            level += stribeck.extra_nm;
        }
        if let Some(load) = &self.load_friction {
            level += load.holding_share(s * torque_nm.value()) * torque_nm.abs();
        }
        level
    }
}

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

/// Friction holds more than it brakes.
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
            // An arm may weigh nearly as much as the motor lifts, however little rubs.
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

/// A torque that depends on nothing.
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
