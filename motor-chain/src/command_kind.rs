//! Quantity of a command: a voltage, a current or a torque.

use serde::{Deserialize, Serialize};

use crate::Parameters;

/// Quantity of the command column, which determines its name in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandKind {
    /// `command_v`: voltage set at the driver.
    #[default]
    Voltage,
    /// `command_a`: current of a current-controlled axis in A.
    Current,
    /// `command_nm`: torque of a torque-controlled axis in N m.
    Torque,
}

impl CommandKind {
    /// Command per torque at rest, in its unit per N m: `R/Kt`, `1/Kt` or 1.
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
