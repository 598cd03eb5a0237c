//! Identifiable parameters of a motor, from a fit.

use super::fit::Fit;
use super::intervals::{covariance, interval_of};
use super::model::Base;
use super::report::{Identifiable, KnownTorque, NominalSource};
use super::segments::{Segments, drag};
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
    let drag = |p: &Parameters| drag(p, base.kind);
    let least = f64::MIN_POSITIVE;
    let electrical = |p: &Parameters| p.inductance_h / p.resistance_ohm;
    let motor = fit.model.motor(&fit.x);
    let has_torque =
        base.torque_identifiable || (source == NominalSource::Given && !motor.resistance_assumed);
    Identifiable {
        speed_per_volt: of(speed_unit, &|p| 1.0 / (drag(p) * per_nm(p)).max(least)),
        time_constant_s: of("s", &|p| p.inertia_kg_m2 / drag(p).max(least)),
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
