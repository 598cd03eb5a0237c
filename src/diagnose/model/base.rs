//! The motor of a diagnosis, and the identifiability of its parameters from the runs.

use super::reference::ReferencePosterior;
use crate::diagnose::settings::Settings;
use crate::motor::catalogue::ids;
use crate::motor::catalogue::{EffectParameter, Scale};
use crate::motor::{CommandKind, Motor};

/// Keys of the base parameters.
pub(crate) const BASE: [&str; 6] = [
    "inertia_kg_m2",
    "back_emf_v_s_per_rad",
    "coulomb_friction_nm",
    "viscous_friction_nm_s_per_rad",
    "inductance_h",
    "torque_constant_nm_per_a",
];
/// Indices of some of them.
pub(super) const INERTIA: usize = 0;
const COULOMB: usize = 2;
pub(super) const VISCOUS: usize = 3;
/// Index of the one that only a voltage-driven motor has.
pub(super) const BACK_EMF: usize = 1;
pub(super) const INDUCTANCE: usize = 4;
/// Index of the one that is identifiable only with a known torque.
pub(super) const TORQUE_CONSTANT: usize = 5;
/// Effects that widen the prior of a base parameter, with its index.
const WIDENING: [(&str, usize); 3] = [
    (ids::INERTIA, INERTIA),
    (ids::COULOMB_FRICTION, COULOMB),
    (ids::VISCOUS_FRICTION, VISCOUS),
];

/// Data shared by all models of a diagnosis.
#[derive(Debug, Clone)]
pub(crate) struct Base {
    pub motor: Motor,
    pub kind: CommandKind,
    pub sample_time_s: f64,
    /// Rate error of the board's clock relative to the host's, with its standard deviation.
    pub clock: Option<(f64, f64)>,
    /// Whether the time stamps are arrival times.
    pub is_host_timed: bool,
    /// Whether torques are identifiable in N m: a load or a disc is known in one of the runs.
    pub torque_identifiable: bool,
    /// Posterior of the reference runs, which determines the motor.
    pub reference: Option<ReferencePosterior>,
    /// Longest time in s from a command to the first motion after rest.
    pub dead_time_s: f64,
    pub settings: Settings,
}

impl Base {
    /// The same runs with a motor and a prior from reference runs.
    pub fn after(&self, mut motor: Motor, reference: ReferencePosterior) -> Self {
        let own = self.motor.parameters;
        motor.parameters.counts_per_rev = own.counts_per_rev;
        motor.parameters.supply_v = own.supply_v;
        Self {
            motor,
            reference: Some(reference),
            ..self.clone()
        }
    }

    /// The base parameter whose prior an effect widens; `None` if the motor's value is 0, so that the effect has its
    /// own parameter.
    pub fn frees(&self, id: &str) -> Option<usize> {
        let k = freed_by(id)?;
        let value = self.motor.parameters.get(BASE[k])?;
        (value > 0.0).then_some(k)
    }
}

/// Whether an effect is a change of a base parameter beyond tolerance.
pub(crate) fn is_parameter_change(id: &str) -> bool {
    freed_by(id).is_some()
}

pub(super) fn freed_by(id: &str) -> Option<usize> {
    let found = WIDENING.iter().find(|(widening, _)| *widening == id);
    found.map(|(_, number)| *number)
}

/// Plausible range of an effect's parameter in SI, for the runs' sample time.
pub(crate) fn range_of(parameter: &EffectParameter, base: &Base) -> (f64, f64) {
    if parameter.key == "max_rate_hz" {
        let top = Scale::TopRate.of(&base.motor.parameters, base.sample_time_s);
        return (base.settings.least_rate_share * top, top);
    }
    let (lo, hi) = parameter.range(&base.motor.parameters, base.sample_time_s);
    let hi = match parameter.key {
        // At least the recorded time from the first command to the first motion.
        "delay_s" => hi.max(base.settings.beyond_range * base.dead_time_s),
        _ => hi,
    };
    (lo.min(hi), lo.max(hi))
}
