//! Rows of a run file and their format.

use std::io::Write;

use super::{CommandKind, Flags, velocity_rad_s};

/// Optional columns of a run file besides time, command and counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Columns {
    /// Quantity that the command column sets.
    pub command: CommandKind,
    /// `seq`: sample numbers of the device.
    pub seq: bool,
    /// `host_t_s`: arrival times.
    pub host: bool,
    /// `flags`: errors reported by the device.
    pub flags: bool,
    /// `supply_v`: measured supply.
    pub supply: bool,
    /// `current_a`: measured motor current.
    pub current: bool,
}

impl Columns {
    /// The columns of a board without sensors.
    pub fn recorded(command: CommandKind) -> Self {
        Self {
            command,
            seq: true,
            host: true,
            flags: true,
            supply: false,
            current: false,
        }
    }
}

/// A time and its format.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Time {
    /// Microseconds, written exactly with six decimals.
    Micros(i64),
    /// Seconds, written so that they read back as the same number.
    Seconds(f64),
}

/// One sample. Missing values of an existing column are empty cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The device's sample number, unwrapped.
    pub seq: Option<u64>,
    /// Device time since the first row.
    pub time: Time,
    /// Host's monotonic arrival time.
    pub host: Option<Time>,
    /// Command in force from this sample until the next, in V, A or N m.
    pub command: f64,
    /// Encoder counts, unwrapped.
    pub counts: i64,
    /// Flags of the device.
    pub flags: Flags,
    /// Measured supply in V.
    pub supply_v: Option<f64>,
    /// Measured motor current in A.
    pub current_a: Option<f64>,
}

/// Formats rows, with the speed from the previous row.
#[derive(Debug)]
pub(super) struct RowFormatter {
    columns: Columns,
    counts_per_rev: f64,
    sample_time_s: f64,
    before: Option<(Option<u64>, i64)>,
}

impl RowFormatter {
    /// A formatter for these columns and this header (`counts_per_rev`, `sample_time_s`).
    pub(super) fn new(columns: Columns, header: &toml::Table) -> Self {
        let number = |key: &str| match header.get(key) {
            Some(toml::Value::Float(value)) => *value,
            Some(toml::Value::Integer(value)) => *value as f64,
            _ => f64::NAN,
        };
        Self {
            columns,
            counts_per_rev: number("counts_per_rev"),
            sample_time_s: number("sample_time_s"),
            before: None,
        }
    }

    /// Appends the column names.
    pub(super) fn push_names(&self, buffer: &mut Vec<u8>) {
        let columns = &self.columns;
        let names = [
            (columns.seq, "seq"),
            (true, "t_s"),
            (columns.host, "host_t_s"),
            (true, columns.command.column()),
            (true, "counts"),
            (true, "velocity_rad_s"),
            (columns.flags, "flags"),
            (columns.supply, "supply_v"),
            (columns.current, "current_a"),
        ];
        let present: Vec<&str> = names
            .into_iter()
            .filter_map(|(there, name)| there.then_some(name))
            .collect();
        buffer.extend_from_slice(present.join(",").as_bytes());
        buffer.push(b'\n');
    }

    /// Appends one row; returns its speed in rad/s.
    pub(super) fn push_row(&mut self, buffer: &mut Vec<u8>, row: &Row) -> Option<f64> {
        let speed = self.speed_rad_s(row);
        self.before = Some((row.seq, row.counts));
        let mut line = Line::new(buffer);
        if self.columns.seq {
            line.cell(row.seq);
        }
        line.time(Some(row.time));
        if self.columns.host {
            line.time(row.host);
        }
        line.cell(Some(row.command));
        line.cell(Some(row.counts));
        line.cell(speed);
        if self.columns.flags {
            line.cell(Some(row.flags));
        }
        if self.columns.supply {
            line.cell(row.supply_v);
        }
        if self.columns.current {
            line.cell(row.current_a);
        }
        line.end();
        speed
    }

    fn speed_rad_s(&self, row: &Row) -> Option<f64> {
        let (seq_before, counts_before) = self.before?;
        let elapsed = match (seq_before, row.seq) {
            (Some(before), Some(seq)) => seq.checked_sub(before).filter(|&n| n > 0)?,
            _ => 1,
        };
        let delta = row.counts as f64 - counts_before as f64;
        let speed = velocity_rad_s(delta, elapsed, self.counts_per_rev, self.sample_time_s);
        speed.is_finite().then_some(speed)
    }
}

/// A line under construction; writing to memory cannot fail.
struct Line<'a> {
    buffer: &'a mut Vec<u8>,
    first: bool,
}

impl<'a> Line<'a> {
    fn new(buffer: &'a mut Vec<u8>) -> Self {
        Self {
            buffer,
            first: true,
        }
    }

    fn separate(&mut self) {
        if !std::mem::take(&mut self.first) {
            self.buffer.push(b',');
        }
    }

    /// Numbers have the standard library's format: the shortest decimals that read back as the same number, without
    /// an exponent.
    fn cell(&mut self, value: Option<impl std::fmt::Display>) {
        self.separate();
        if let Some(value) = value {
            let _ = write!(self.buffer, "{value}");
        }
    }

    fn time(&mut self, time: Option<Time>) {
        match time {
            Some(Time::Micros(micros)) => {
                self.separate();
                let sign = if micros < 0 { "-" } else { "" };
                let micros = micros.unsigned_abs();
                let (seconds, rest) = (micros / 1_000_000, micros % 1_000_000);
                let _ = write!(self.buffer, "{sign}{seconds}.{rest:06}");
            }
            Some(Time::Seconds(seconds)) => self.cell(Some(seconds)),
            None => self.separate(),
        }
    }

    fn end(self) {
        self.buffer.push(b'\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_exponent() {
        let values = [
            (-0.0, "-0"),
            (1.0, "1"),
            (-4.5, "-4.5"),
            (0.1, "0.1"),
            (1.0 / 3.0, "0.3333333333333333"),
            (-2.5e-9, "-0.0000000025"),
            (1e17, "100000000000000000"),
        ];
        for (value, expected) in values {
            let mut buffer = Vec::new();
            Line::new(&mut buffer).cell(Some(value));
            assert_eq!(String::from_utf8(buffer).expect("text"), expected);
        }
    }
}
