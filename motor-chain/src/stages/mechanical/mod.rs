//! Stage 4, the mechanics: inertia, friction, load.
//!
//! `J dw/dt = tau_m + cogging - gravity - load - drag - b (1 + r_b sgn w) w - friction`. Friction in direction `s`
//! has the level `T(s) = Tf (1 + r s) + dT exp(-(w/ws)^2) + c |tau_m|`; at rest it balances the net torque up to that
//! level, or up to the larger breakaway level. With presliding it approaches the level as Dahl's `F(theta)`.

pub(crate) mod friction;
pub(crate) mod load;

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
    /// Static friction torque in N m, if it exceeds Coulomb's.
    pub static_nm: Option<S>,
    /// Extra friction at low speed.
    pub stribeck: Option<StribeckCurve<S>>,
    /// Relative asymmetry r of the Coulomb torque.
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
    /// A constant torque against positive rotation, in N m.
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

/// Ratios of friction to motor torque.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LoadFractions<S> {
    /// For a driving motor.
    pub driving: S,
    /// For a driven motor.
    pub driven: S,
}

impl<S: Scalar> LoadFractions<S> {
    /// The ratio for a torque of this sign in the direction of motion.
    #[inline(always)]
    pub(crate) fn share(&self, along: f64) -> S {
        if along >= 0.0 {
            self.driving
        } else {
            self.driven
        }
    }

    /// The ratio at rest against breakaway in a direction with this sign of the torque. If friction is larger when
    /// driven than when driving, a torque that broke it away would stop it at once: it stays at rest (Filippov 1988).
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
    /// Coulomb level in N m in direction `s` (+1 or -1), without terms of speed or torque.
    #[inline(always)]
    pub(crate) fn coulomb(&self, s: f64) -> S {
        self.coulomb_nm * (self.asymmetry * s + 1.0)
    }

    /// Breakaway level in N m in direction `s` at the motor torque `torque_nm`.
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
