//! Identifiable parameters of a motor.

use serde::Serialize;

use super::{Diagnosis, Interval};
use crate::motor::CommandKind;

/// Identifiable parameters with their 95 % intervals; for a current- or torque-driven axis per ampere or newton
/// metre.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identifiable {
    /// Steady speed per unit of the command.
    pub speed_per_volt: Interval,
    /// Mechanical time constant.
    pub time_constant_s: Interval,
    /// Coulomb friction in V, the unit of the command.
    pub friction_v: Interval,
    /// L/R; `None` for a current- or torque-driven axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub electrical_time_constant_s: Option<Interval>,
    /// The same of the motor file, if one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motor_file: Option<MotorFileValues>,
    /// Torques in SI, if they are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub si: Option<KnownTorque>,
}

impl Diagnosis {
    /// Identifiable parameters: name, value, and the motor file's value if one was given.
    pub fn identifiable_rows(&self) -> Vec<(&'static str, Interval, Option<f64>)> {
        let found = &self.identifiable;
        let file = found.motor_file;
        let given = |of: fn(&MotorFileValues) -> f64| file.as_ref().map(of);
        let (gain, friction) = match self.command_kind {
            CommandKind::Voltage => ("steady speed per volt", "Coulomb friction as a voltage"),
            CommandKind::Current => ("steady speed per ampere", "Coulomb friction as a current"),
            CommandKind::Torque => ("steady speed per newton metre", "Coulomb friction"),
        };
        let mut rows = vec![
            (
                gain,
                found.speed_per_volt,
                given(|file| file.speed_per_volt),
            ),
            (
                "mechanical time constant",
                found.time_constant_s,
                given(|file| file.time_constant_s),
            ),
            (friction, found.friction_v, given(|file| file.friction_v)),
        ];
        // Not identified if it was held at its assumed value.
        let electrical = found.electrical_time_constant_s;
        let electrical = electrical.filter(|one| self.has_torque() || one.lo95 < one.hi95);
        if let Some(electrical) = electrical {
            let given = file.and_then(|file| file.electrical_time_constant_s);
            rows.push(("electrical time constant L/R", electrical, given));
        }
        rows
    }
}

/// Identifiable parameters of the motor file, in the units of [`Identifiable`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotorFileValues {
    /// Steady speed per unit of the command.
    pub speed_per_volt: f64,
    /// Mechanical time constant.
    pub time_constant_s: f64,
    /// Coulomb friction in V, the unit of the command.
    pub friction_v: f64,
    /// L/R; `None` for a current- or torque-driven axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub electrical_time_constant_s: Option<f64>,
}

/// Source of torques in N m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KnownTorque {
    /// `motor_file` or `known_load`.
    pub source: &'static str,
    /// Command per load of 1 N m.
    pub command_per_nm: f64,
}
