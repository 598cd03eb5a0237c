//! What voltage and counts determine of a motor, from a fit.

use super::fit::Fit;
use super::intervals::{covariance, interval_of};
use super::model::Base;
use super::report::{Identifiable, KnownTorque, NominalSource};
use super::segments::{Segments, time_constant_s};
use crate::motor::{CommandKind, Parameters};

/// Speed per unit of the command, time constant, friction in units of the command, L/R, with intervals.
pub(crate) fn identifiable(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
    source: NominalSource,
) -> Identifiable {
    let covariance = covariance(segments, base, fit);
    let of = |unit: &'static str, of: &dyn Fn(&Parameters) -> f64| {
        interval_of(fit, &covariance, unit, |x| {
            of(&fit.model.motor(x).parameters)
        })
    };
    let per_nm = |p: &Parameters| base.kind.per_nm(p);
    let (speed_unit, command_unit) = match base.kind {
        CommandKind::Voltage => ("rad/s/V", "V"),
        CommandKind::Current => ("rad/s/A", "A"),
        CommandKind::Torque => ("rad/s/(N m)", "N m"),
    };
    let back_emf = |p: &Parameters| match base.kind {
        CommandKind::Voltage => p.back_emf_v_s_per_rad,
        _ => 0.0,
    };
    let per_speed = move |p: &Parameters| back_emf(p) + p.viscous_friction_nm_s_per_rad * per_nm(p);
    let tau_unit = |x: &[f64]| {
        let motor = fit.model.motor(x);
        match base.kind {
            CommandKind::Voltage => time_constant_s(&motor),
            _ => {
                let p = &motor.parameters;
                p.inertia_kg_m2 / p.viscous_friction_nm_s_per_rad.max(f64::MIN_POSITIVE)
            }
        }
    };
    let electrical = |p: &Parameters| p.inductance_h / p.resistance_ohm;
    let has_torque = base.torque_identifiable || source == NominalSource::Given;
    let motor = fit.model.motor(&fit.x);
    Identifiable {
        speed_per_volt: of(speed_unit, &|p| 1.0 / per_speed(p).max(f64::MIN_POSITIVE)),
        time_constant_s: interval_of(fit, &covariance, "s", tau_unit),
        friction_v: of(command_unit, &|p| p.coulomb_friction_nm * per_nm(p)),
        electrical_time_constant_s: (base.kind == CommandKind::Voltage)
            .then(|| of("s", &electrical)),
        si: has_torque.then(|| KnownTorque {
            source: if base.torque_identifiable {
                "known_load"
            } else {
                "motor_file"
            },
            command_per_nm: base.kind.per_nm(&motor.parameters),
        }),
    }
}
