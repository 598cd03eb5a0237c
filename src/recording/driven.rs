//! Applied drive of the motor in a run, and known differences of the run.

use std::borrow::Cow;

use super::{CommandKind, Run};
use crate::motor::{KnownDifferences, KnownError};

/// Parses `differs.KEY = VALUE` of a header.
///
/// # Errors
/// An unknown key, or an impossible value.
pub fn known_differences(header: &toml::Table) -> Result<KnownDifferences, KnownError> {
    let mut known = KnownDifferences::default();
    let Some(differs) = header.get("differs") else {
        return Ok(known);
    };
    let Some(table) = differs.as_table() else {
        // A value in place of the keys is reported by its own name.
        known.set("differs", f64::NAN)?;
        return Ok(known);
    };
    for (key, value) in table {
        let number = match value {
            toml::Value::Float(number) => *number,
            toml::Value::Integer(number) => *number as f64,
            _ => f64::NAN,
        };
        known.set(key, number)?;
    }
    Ok(known)
}

impl Run {
    /// The command that was applied to the motor. A command in V is a duty cycle times the nominal supply; with a
    /// measured or known supply of this run, the duty cycle applies to that. A reading at the end of an interval is
    /// affected by the interval's current, so that it applies to that interval. Logs whose commands were computed
    /// from the measured supply are unchanged.
    pub fn driving_command(&self) -> Cow<'_, [f64]> {
        let nominal_v = match self.supply_v {
            Some(nominal_v) if self.command_kind == CommandKind::Voltage => nominal_v,
            _ => return Cow::Borrowed(&self.command),
        };
        let imported = self.header.get("imported");
        let is_measured = imported.and_then(|table| table.get("command_supply"));
        if is_measured.and_then(toml::Value::as_str) == Some("measured") {
            return Cow::Borrowed(&self.command);
        }
        match (&self.measured_supply_v, self.known.supply_v()) {
            (Some(measured_v), _) => {
                let mut held_v = nominal_v;
                let mut driving = Vec::with_capacity(self.command.len());
                for (k, command) in self.command.iter().enumerate() {
                    let reading = measured_v.get(k + 1).or(measured_v.get(k)).copied();
                    // Samples may lack the reading.
                    held_v = reading
                        .filter(|v| v.is_finite() && *v > 0.0)
                        .unwrap_or(held_v);
                    driving.push(command * held_v / nominal_v);
                }
                Cow::Owned(driving)
            }
            (None, Some(supply_v)) => {
                let share = supply_v / nominal_v;
                Cow::Owned(self.command.iter().map(|command| command * share).collect())
            }
            (None, None) => Cow::Borrowed(&self.command),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measured_supply_is_applied_once() {
        let mut run = Run {
            supply_v: Some(10.0),
            command: vec![5.0, -5.0, 5.0],
            counts: vec![0; 3],
            t_s: vec![0.0, 1.0, 2.0],
            measured_supply_v: Some(vec![10.0, 8.0, f64::NAN]),
            ..Run::default()
        };
        assert_eq!(*run.driving_command(), [4.0, -4.0, 4.0]);
        run.header = "[imported]\ncommand_supply = 'measured'"
            .parse()
            .expect("TOML");
        assert_eq!(*run.driving_command(), [5.0, -5.0, 5.0]);
        run.header.clear();
        run.measured_supply_v = None;
        assert_eq!(*run.driving_command(), [5.0, -5.0, 5.0]);
        run.known.set("supply_v", 12.0).expect("a supply");
        assert_eq!(*run.driving_command(), [6.0, -6.0, 6.0]);
    }
}
