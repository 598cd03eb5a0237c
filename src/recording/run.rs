//! A run in memory, column by column, in SI.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What the command column commands; it names the column in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandKind {
    /// `command_v`: volts asked of the driver.
    #[default]
    Voltage,
    /// `command_a`: amperes, of an axis with current control.
    Current,
    /// `command_nm`: newton metres, of an axis with torque control.
    Torque,
}

impl CommandKind {
    /// The column of a run file that carries this kind of command.
    pub fn column(self) -> &'static str {
        match self {
            Self::Voltage => "command_v",
            Self::Current => "command_a",
            Self::Torque => "command_nm",
        }
    }
}

/// What a board says of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Flags {
    /// The sample was taken late because the one before was not finished.
    pub overrun: bool,
    /// Frames before this one were dropped because the line was full.
    pub dropped: bool,
    /// Both encoder channels changed at once: an edge was missed.
    pub encoder_error: bool,
    /// The command was limited by the supply.
    pub saturated: bool,
}

/// One recorded or simulated run. All columns that are there have the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// Where it was read from, if it was.
    pub path: Option<PathBuf>,
    /// Every header key of the file as TOML, known or not.
    pub header: toml::Table,
    /// Nominal sample time in s.
    pub sample_time_s: f64,
    /// Encoder counts per revolution (x4 decoded).
    pub counts_per_rev: f64,
    /// Driver supply in V, if the header has it.
    pub supply_v: Option<f64>,
    /// What `command` commands.
    pub command_kind: CommandKind,
    /// Device time of each sample in s, from the first row.
    pub t_s: Vec<f64>,
    /// Command in force from each sample until the next (V, A or N m by `command_kind`).
    pub command: Vec<f64>,
    /// Encoder counts, unwrapped.
    pub counts: Vec<i64>,
    /// The device's sample numbers, unwrapped.
    pub seq: Option<Vec<u64>>,
    /// Host's monotonic arrival times in s; a diagnostic, never the time base.
    pub host_t_s: Option<Vec<f64>>,
    /// Speeds as recorded in rad/s; `None` in row 0.
    pub velocity_rad_s: Option<Vec<Option<f64>>>,
    /// What the board says of each sample.
    pub flags: Option<Vec<Flags>>,
    /// Measured supply in V.
    pub measured_supply_v: Option<Vec<f64>>,
    /// Measured motor current in A.
    pub measured_current_a: Option<Vec<f64>>,
    /// The file says that the recording was ended properly.
    pub complete: bool,
}

impl Run {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.counts.len()
    }

    /// Whether the run has no sample at all.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }
}
