//! Identifiable parameters of a motor, from a fit.

use super::fit::Fit;
use super::intervals::{covariance, interval_of};
use super::model::Base;
use super::report::{Identifiable, Interval, KnownTorque, MotorFileValues, NominalSource};
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
    let drag = |p: &Parameters| drag(p, base.kind).max(f64::MIN_POSITIVE);
    let speed = |p: &Parameters| 1.0 / (drag(p) * per_nm(p)).max(f64::MIN_POSITIVE);
    let mechanical = |p: &Parameters| p.inertia_kg_m2 / drag(p);
    let friction = |p: &Parameters| p.coulomb_friction_nm * per_nm(p);
    let electrical = |p: &Parameters| p.inductance_h / p.resistance_ohm;
    let is_voltage = base.kind == CommandKind::Voltage;
    let given = &base.motor.parameters;
    let motor = fit.model.motor(&fit.x);
    let has_torque =
        base.torque_identifiable || (source == NominalSource::Given && !motor.resistance_assumed);
    let is_limited = |key: &str| {
        let parameters = fit.model.parameters.iter().zip(&fit.x);
        (parameters.filter(|(parameter, _)| parameter.id.key() == key))
            .any(|(parameter, x)| parameter.is_at_bound(*x))
    };
    Identifiable {
        speed_per_volt: of(speed_unit, &speed),
        time_constant_s: of("s", &mechanical),
        friction_v: Interval {
            at_bound: is_limited("coulomb_friction_nm"),
            ..of(command_unit, &friction)
        },
        electrical_time_constant_s: is_voltage.then(|| of("s", &electrical)),
        motor_file: (source == NominalSource::Given && base.reference.is_none()).then(|| {
            MotorFileValues {
                speed_per_volt: speed(given),
                time_constant_s: mechanical(given),
                friction_v: friction(given),
                electrical_time_constant_s: is_voltage.then(|| electrical(given)),
            }
        }),
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
