//! The motor of a diagnosis, and which of its parameters are identifiable from the runs.

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
/// Places of some of them.
pub(super) const INERTIA: usize = 0;
const COULOMB: usize = 2;
pub(super) const VISCOUS: usize = 3;
/// Those of them that only a voltage-driven motor has.
pub(super) const BACK_EMF: usize = 1;
pub(super) const INDUCTANCE: usize = 4;
/// That of them that is identifiable only with a known torque.
pub(super) const TORQUE_CONSTANT: usize = 5;
/// Effects that widen the prior of a base parameter, and which.
const FREEING: [(&str, usize); 3] = [
    (ids::INERTIA, INERTIA),
    (ids::COULOMB_FRICTION, COULOMB),
    (ids::VISCOUS_FRICTION, VISCOUS),
];

/// Data that all models of a diagnosis share.
#[derive(Debug, Clone)]
pub(crate) struct Base {
    pub motor: Motor,
    pub kind: CommandKind,
    pub sample_time_s: f64,
    /// Error of the board clock against the host clock, with its standard deviation.
    pub clock: Option<(f64, f64)>,
    /// Whether the time stamps are arrivals at the host.
    pub is_host_timed: bool,
    /// Whether torques are identifiable in N m: a load or a disc is known in one of the runs.
    pub torque_identifiable: bool,
    /// Posterior of the reference runs, whose motor this is then.
    pub reference: Option<ReferencePosterior>,
    /// Longest time in s from a command to the first motion after rest.
    pub dead_time_s: f64,
    pub settings: Settings,
}

impl Base {
    /// The same runs with a motor and a prior that reference runs determined.
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

    /// The base parameter whose prior an effect widens; none where the motor has none of it, so that the effect brings its own.
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

/// Plausible range of an effect's parameter in SI, for the runs' sample time.
pub(crate) fn range_of(parameter: &EffectParameter, base: &Base) -> (f64, f64) {
    if parameter.key == "max_rate_hz" {
        let top = Scale::TopRate.of(&base.motor.parameters, base.sample_time_s);
        return (base.settings.least_rate_share * top, top);
    }
    let (lo, hi) = parameter.range(&base.motor.parameters, base.sample_time_s);
    let hi = match parameter.key {
        // As long as the recording shows: from the first command to the first motion.
        "delay_s" => hi.max(base.settings.beyond_range * base.dead_time_s),
        _ => hi,
    };
    (lo.min(hi), lo.max(hi))
}
