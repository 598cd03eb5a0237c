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
    /// Torques in SI, if they are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub si: Option<KnownTorque>,
}

/// Source of torques in N m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KnownTorque {
    /// `motor_file` or `known_load`.
    pub source: &'static str,
    /// Command per load of 1 N m.
    pub command_per_nm: f64,
}
