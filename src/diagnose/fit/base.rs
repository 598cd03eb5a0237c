//! The motor of a diagnosis, and which of its numbers runs may tell.

use super::then::Then;
use crate::diagnose::settings::LEAST_RATE;
use crate::motor::catalogue::{EffectParameter, Scale};
use crate::motor::{CommandKind, Motor};

/// Keys of the base numbers.
pub(crate) const BASE: [&str; 6] = [
    "inertia_kg_m2",
    "back_emf_v_s_per_rad",
    "coulomb_friction_nm",
    "viscous_friction_nm_s_per_rad",
    "inductance_h",
    "torque_constant_nm_per_a",
];
/// Those of them that a command in volts alone depends on.
pub(super) const BACK_EMF: usize = 1;
pub(super) const INDUCTANCE: usize = 4;
/// That of them that only known torques tell.
pub(super) const TORQUE_CONSTANT: usize = 5;
/// Effects that set a base number free, and which.
const FREEING: [(&str, usize); 3] = [
    ("inertia", 0),
    ("coulomb_friction", 2),
    ("viscous_friction", 3),
];

/// What is the same for all models of a diagnosis.
#[derive(Debug, Clone)]
pub(crate) struct Base {
    pub motor: Motor,
    pub kind: CommandKind,
    pub sample_time_s: f64,
    /// Error of the clock as the host saw it, with its standard deviation.
    pub clock: Option<(f64, f64)>,
    /// Whether the times are those of arrivals at the host.
    pub is_host_timed: bool,
    /// Whether a load or a disc is known in one of the runs: a torque in N m.
    pub knows_torque: bool,
    /// What reference runs say of the motor, which is theirs then.
    pub then: Option<Then>,
}

impl Base {
    /// The same motor in the runs of another base.
    pub fn for_runs_of(self, other: &Self) -> Self {
        let mut motor = self.motor;
        motor.parameters.counts_per_rev = other.motor.parameters.counts_per_rev;
        motor.parameters.supply_v = other.motor.parameters.supply_v;
        Self {
            motor,
            then: self.then,
            ..other.clone()
        }
    }

    /// Keys of the base numbers that such runs may tell.
    pub fn told(&self) -> &'static [&'static str] {
        match self.knows_torque {
            true => &BASE,
            false => &BASE[..TORQUE_CONSTANT],
        }
    }

    /// The base number that an effect sets free; none where the motor has none of it, so that the effect brings its own.
    pub fn frees(&self, id: &str) -> Option<usize> {
        let k = freed_by(id)?;
        let value = self.motor.parameters.get(BASE[k])?;
        (value > 0.0).then_some(k)
    }
}

pub(super) fn freed_by(id: &str) -> Option<usize> {
    let found = FREEING.iter().find(|(freeing, _)| *freeing == id);
    found.map(|(_, number)| *number)
}

/// Range in SI, for the run's own sample time.
pub(crate) fn range_of(parameter: &EffectParameter, base: &Base) -> (f64, f64) {
    if parameter.key == "max_rate_hz" {
        let top = Scale::TopRate.of(&base.motor.parameters, base.sample_time_s);
        return (LEAST_RATE * top, top);
    }
    let (lo, hi) = parameter.range(&base.motor.parameters, base.sample_time_s);
    (lo.min(hi), lo.max(hi))
}
