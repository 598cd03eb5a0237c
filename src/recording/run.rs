//! A run in memory, in columns and SI units.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::motor::{CommandKind, KnownDifferences};

/// Header key of an imported run: the resolution of its logged speeds, in counts/s.
pub(crate) const SPEED_RESOLUTION: &str = "speed_resolution_counts_s";

/// Flags of a sample, from board and recorder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Flags {
    /// The sample was late because the previous one was not finished.
    pub overrun: bool,
    /// Frames before this one were dropped because the send buffer was full.
    pub dropped: bool,
    /// Both encoder channels changed at once: an edge was missed.
    pub encoder_error: bool,
    /// The command was limited by the supply.
    pub saturated: bool,
    /// The board's time fell back here, or disagrees with the sample numbers.
    #[serde(default)]
    pub time_leap: bool,
    /// The counts changed faster here than any motor can.
    #[serde(default)]
    pub counts_leap: bool,
}

impl Flags {
    /// Name and value of each flag, in the order of a run file.
    fn named(self) -> [(&'static str, bool); 6] {
        [
            ("overrun", self.overrun),
            ("dropped", self.dropped),
            ("encoder_error", self.encoder_error),
            ("saturated", self.saturated),
            ("time_leap", self.time_leap),
            ("counts_leap", self.counts_leap),
        ]
    }
}

/// As in the `flags` column: the names joined by `+` (`overrun+saturated`), empty for none.
impl fmt::Display for Flags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (name, _) in self.named().into_iter().filter(|(_, set)| *set) {
            write!(f, "{separator}{name}")?;
            separator = "+";
        }
        Ok(())
    }
}

/// An unknown word in a `flags` column.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{0}' is no flag\nhint: a sample's flags are overrun, dropped, encoder_error, saturated, time_leap and counts_leap, joined by +"
)]
pub struct UnknownFlag(pub String);

impl FromStr for Flags {
    type Err = UnknownFlag;

    fn from_str(text: &str) -> Result<Self, UnknownFlag> {
        let mut flags = Self::default();
        for word in text.split('+').map(str::trim) {
            match word {
                "" => {}
                "overrun" => flags.overrun = true,
                "dropped" => flags.dropped = true,
                "encoder_error" => flags.encoder_error = true,
                "saturated" => flags.saturated = true,
                "time_leap" => flags.time_leap = true,
                "counts_leap" => flags.counts_leap = true,
                other => return Err(UnknownFlag(other.to_owned())),
            }
        }
        Ok(flags)
    }
}

/// One recorded or simulated run. All existing columns have the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// Path of its file, if it was read from one.
    pub path: Option<PathBuf>,
    /// Every header key of the file as TOML, including unknown ones.
    pub header: toml::Table,
    /// Nominal sample time in s.
    pub sample_time_s: f64,
    /// Encoder counts per revolution (x4 decoded).
    pub counts_per_rev: f64,
    /// Driver supply in V, if it is in the header.
    pub supply_v: Option<f64>,
    /// Quantity that `command` sets.
    pub command_kind: CommandKind,
    /// Device time of each sample in s, from the first row.
    pub t_s: Vec<f64>,
    /// Command in force from each sample until the next (V, A or N m by `command_kind`).
    pub command: Vec<f64>,
    /// Encoder counts, unwrapped.
    pub counts: Vec<i64>,
    /// The device's sample numbers, unwrapped.
    pub seq: Option<Vec<u64>>,
    /// Host's monotonic arrival times in s; for diagnostics, not a time base.
    pub host_t_s: Option<Vec<f64>>,
    /// Recorded speeds in rad/s; `None` in row 0.
    pub velocity_rad_s: Option<Vec<Option<f64>>>,
    /// Flags of each sample.
    pub flags: Option<Vec<Flags>>,
    /// Measured supply in V.
    pub measured_supply_v: Option<Vec<f64>>,
    /// Measured motor current in A.
    pub measured_current_a: Option<Vec<f64>>,
    /// Known differences of this run from the motor file (header keys `differs.KEY`).
    pub known: KnownDifferences,
    /// The recording ended regularly, according to the file.
    pub complete: bool,
}

impl Run {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.counts.len()
    }

    /// The run without these samples (ascending indices); the command before each is held.
    #[must_use]
    pub fn without(&self, samples: &[usize]) -> Self {
        let is_left = |k: usize| samples.binary_search(&k).is_err();
        fn kept<T: Clone>(column: &[T], is_left: impl Fn(usize) -> bool) -> Vec<T> {
            let numbered = column.iter().enumerate();
            numbered
                .filter(|(k, _)| is_left(*k))
                .map(|(_, value)| value.clone())
                .collect()
        }
        fn kept_of<T: Clone>(
            column: &Option<Vec<T>>,
            is_left: impl Fn(usize) -> bool,
        ) -> Option<Vec<T>> {
            column.as_ref().map(|column| kept(column, is_left))
        }
        // A speed is the difference to the previous sample.
        let mut speeds = self.velocity_rad_s.clone();
        for speed in speeds.iter_mut() {
            for k in samples {
                if let Some(after) = speed.get_mut(k + 1) {
                    *after = None;
                }
            }
        }
        Self {
            t_s: kept(&self.t_s, is_left),
            command: kept(&self.command, is_left),
            counts: kept(&self.counts, is_left),
            seq: kept_of(&self.seq, is_left),
            host_t_s: kept_of(&self.host_t_s, is_left),
            velocity_rad_s: kept_of(&speeds, is_left),
            flags: kept_of(&self.flags, is_left),
            measured_supply_v: kept_of(&self.measured_supply_v, is_left),
            measured_current_a: kept_of(&self.measured_current_a, is_left),
            ..self.clone()
        }
    }

    /// Keeps the first `length` samples.
    pub fn truncate(&mut self, length: usize) {
        fn cut<T>(column: &mut Option<Vec<T>>, length: usize) {
            if let Some(column) = column {
                column.truncate(length);
            }
        }
        self.t_s.truncate(length);
        self.command.truncate(length);
        self.counts.truncate(length);
        cut(&mut self.seq, length);
        cut(&mut self.host_t_s, length);
        cut(&mut self.velocity_rad_s, length);
        cut(&mut self.flags, length);
        cut(&mut self.measured_supply_v, length);
        cut(&mut self.measured_current_a, length);
    }

    /// Whether its times are arrival times (header key `timing = "host"`): late by milliseconds and in bursts, unlike
    /// a device's.
    pub fn is_host_timed(&self) -> bool {
        self.header.get("timing").and_then(toml::Value::as_str) == Some("host")
    }

    /// Whether its position is integrated from logged speeds, whose errors accumulate.
    pub fn is_integrated(&self) -> bool {
        self.integration().is_some()
    }

    /// Whether these speeds are means since the previous sample, as differences of positions.
    pub fn is_integrated_backward(&self) -> bool {
        (self.integration()).is_some_and(|rule| rule.ends_with("backward"))
    }

    /// Resolution of the logged speeds from which its position is integrated, in counts/s.
    pub fn speed_resolution_counts_s(&self) -> Option<f64> {
        let imported = self.header.get("imported")?;
        let said = imported.get(SPEED_RESOLUTION)?.as_float();
        said.filter(|said| said.is_finite() && *said > 0.0 && self.is_integrated())
    }

    /// Integration rule of its position, as in the header.
    fn integration(&self) -> Option<&str> {
        let imported = self.header.get("imported");
        let imported = imported.and_then(|imported| imported.get("position"));
        let said = imported.or_else(|| self.header.get("text_position"));
        (said.and_then(toml::Value::as_str)).filter(|said| said.starts_with("integrated"))
    }

    /// Whether its motor is unknown: an imported log, or text lines of a board.
    pub fn is_foreign(&self) -> bool {
        let device = self.header.get("device").and_then(toml::Value::as_str);
        self.header.contains_key("imported") || device == Some("text lines")
    }

    /// Whether the run has no sample at all.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_flags_are_read_back_unchanged() {
        for bits in 0..64_u8 {
            let flags = Flags {
                overrun: bits & 1 != 0,
                dropped: bits & 2 != 0,
                encoder_error: bits & 4 != 0,
                saturated: bits & 8 != 0,
                time_leap: bits & 16 != 0,
                counts_leap: bits & 32 != 0,
            };
            assert_eq!(flags.to_string().parse(), Ok(flags));
        }
        assert_eq!(Flags::default().to_string(), "");
        assert_eq!(
            "overrun+late".parse::<Flags>(),
            Err(UnknownFlag("late".to_owned()))
        );
    }
}
