//! Identifiable parameters of a motor.

use serde::Serialize;

use super::Interval;

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
