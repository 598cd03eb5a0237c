//! Quantity that a command sets: a voltage, a current or a torque.

use serde::{Deserialize, Serialize};

use crate::Parameters;

/// Quantity that the command column sets; it names the column in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandKind {
    /// `command_v`: voltage set at the driver.
    #[default]
    Voltage,
    /// `command_a`: amperes, of an axis with current control.
    Current,
    /// `command_nm`: newton metres, of an axis with torque control.
    Torque,
}

impl CommandKind {
    /// The command, in its unit, that holds a torque of 1 N m at rest: `R/Kt`, `1/Kt` or 1.
    pub fn per_nm(self, parameters: &Parameters) -> f64 {
        match self {
            Self::Voltage => parameters.resistance_ohm / parameters.torque_constant_nm_per_a,
            Self::Current => 1.0 / parameters.torque_constant_nm_per_a,
            Self::Torque => 1.0,
        }
    }

    /// The column of a run file that carries this kind of command.
    pub fn column(self) -> &'static str {
        match self {
            Self::Voltage => "command_v",
            Self::Current => "command_a",
            Self::Torque => "command_nm",
        }
    }
}
