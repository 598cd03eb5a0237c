//! The catalogue of effects of the signal chain.
//!
//! An effect is one small type in the file of its stage, with one line of registration here; the motor file's
//! `[effects.<id>]`, the virtual board, the documentation's table and the diagnosis read it from [`catalogue`].

pub mod ids;

use std::fmt;

use serde::Serialize;

pub use crate::active::{ActiveEffect, EffectError, Effects};
pub use crate::effect_parameter::{Absent, EffectParameter, Prior, Scale};

use crate::chain::Chain;
use crate::scalar::Scalar;
use crate::stages::mechanical::{friction, load};
use crate::stages::{command, driver, electrical, sensor, timing, transmission};

/// Largest number of parameters of one effect.
pub const MAX_PARAMETERS: usize = 5;

/// A stage of the signal chain, in the order of the signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Command and its arrival time.
    Command,
    /// The bridge and its supply.
    Driver,
    /// Winding and torque constant.
    Electrical,
    /// Inertia, friction, load.
    Mechanical,
    /// Transmission between motor and load.
    Transmission,
    /// The encoder.
    Sensor,
    /// Sampling times of the encoder.
    Timing,
}

impl Stage {
    /// Every stage, in the chain's order.
    pub const ALL: [Self; 7] = [
        Self::Command,
        Self::Driver,
        Self::Electrical,
        Self::Mechanical,
        Self::Transmission,
        Self::Sensor,
        Self::Timing,
    ];

    /// The stage's name in files and in JSON.
    pub fn id(self) -> &'static str {
        match self {
            Self::Command => "command",
            Self::Driver => "driver",
            Self::Electrical => "electrical",
            Self::Mechanical => "mechanical",
            Self::Transmission => "transmission",
            Self::Sensor => "sensor",
            Self::Timing => "timing",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// Description of an effect.
#[derive(Debug, Clone, Copy)]
pub struct EffectKind {
    /// Its id in files and in JSON.
    pub id: &'static str,
    /// Its stage.
    pub stage: Stage,
    /// Description in one line.
    pub summary: &'static str,
    /// Its equation.
    pub equation: &'static str,
    /// Source of the equation.
    pub source: &'static str,
    /// Commands that excite it.
    pub excited_by: &'static str,
    /// Ids and names of effects and parameters with a similar response.
    pub confounded_with: &'static [&'static str],
    /// Its parameters, in order.
    pub parameters: &'static [EffectParameter],
    /// Whether it differs between two runs with the same command.
    pub random: bool,
}

/// An effect as its stage defines it.
pub(crate) trait Effect {
    /// Description of it.
    const KIND: EffectKind;

    /// Adds the effect with these values to the chain.
    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>);
}

macro_rules! registry {
    (once: $($stage:ident :: $effect:ident),*; again: $($id:literal = $stage2:ident :: $effect2:ident),*) => {
        static CATALOGUE: &[EffectKind] = &[$(<$stage::$effect as Effect>::KIND),*];

        static AGAIN: &[EffectKind] = &[$(EffectKind { id: $id, ..<$stage2::$effect2 as Effect>::KIND }),*];

        /// Adds effect number `index` with these values to the chain.
        pub(crate) fn install<S: Scalar>(index: usize, values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
            let installers = [
                $(<$stage::$effect as Effect>::install::<S>,)*
                $(<$stage2::$effect2 as Effect>::install::<S>),*
            ];
            installers[index](values, chain);
        }
    };
}

registry! {
    once:
    command::TransportDelay,
    command::CommandOffset,
    command::DeadZone,
    command::AsymmetricDeadZone,
    driver::VoltageDrop,
    driver::AsymmetricVoltageDrop,
    driver::SupplySag,
    driver::SupplyError,
    driver::AsymmetricGain,
    driver::CurrentLimit,
    driver::CoastAtZero,
    driver::PwmFreewheel,
    electrical::Inductance,
    electrical::WindingHeating,
    electrical::MagnetWeakening,
    electrical::TorqueRipple,
    friction::CoulombFriction,
    friction::ViscousFriction,
    friction::AsymmetricViscous,
    load::Inertia,
    friction::Stribeck,
    friction::AsymmetricFriction,
    friction::StaticFriction,
    friction::Presliding,
    friction::LoadFriction,
    load::QuadraticDrag,
    load::GravityLoad,
    load::ConstantLoad,
    load::Cogging,
    transmission::Backlash,
    transmission::Compliance,
    transmission::SlippingClutch,
    sensor::ResolutionError,
    sensor::MissedCounts,
    sensor::EdgeRateLoss,
    sensor::EncoderEccentricity,
    sensor::SpeedFilter,
    timing::SampleJitter,
    timing::ClockError;
    // Effects periodic in the angle can be used twice, with different orders.
    again:
    "torque_ripple#2" = electrical::TorqueRipple,
    "cogging#2" = load::Cogging
}

/// Every effect, in the order of the signal chain.
pub fn catalogue() -> &'static [EffectKind] {
    CATALOGUE
}

/// Second instances of effects: the same law with an id of its own, `cogging#2`. Their indices follow the
/// catalogue's.
pub fn again() -> &'static [EffectKind] {
    AGAIN
}

/// The effect with this index, of the catalogue or of [`again`].
pub fn kind(index: usize) -> &'static EffectKind {
    match index.checked_sub(CATALOGUE.len()) {
        None => &CATALOGUE[index],
        Some(second) => &AGAIN[second],
    }
}

/// The effect with this id, and its index.
pub fn find(id: &str) -> Option<(usize, &'static EffectKind)> {
    CATALOGUE
        .iter()
        .chain(AGAIN)
        .enumerate()
        .find(|(_, kind)| kind.id == id)
}
