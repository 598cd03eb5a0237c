//! Parameters in units of the command, if no torque is known.
//!
//! Voltage and counts determine a torque only times R/Kt, in V, and an inductance only over R, in s. A value in N m,
//! ohm or H would depend on an assumed resistance.

use super::model::Base;
use super::report::{CommandInterval, Interval, NominalSource};
use crate::motor::{CommandKind, Parameters};

/// Factors from SI to units of the command.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CommandUnits {
    kind: CommandKind,
    /// Command per torque of 1 N m.
    per_nm: f64,
    resistance_ohm: f64,
}

impl CommandUnits {
    /// `None` if torques are known, or stated by the handout.
    pub fn new(base: &Base, source: NominalSource) -> Option<Self> {
        let is_stated = source != NominalSource::Fit && !base.motor.resistance_assumed;
        let is_known = base.torque_identifiable || is_stated || base.kind == CommandKind::Torque;
        (!is_known).then(|| Self::with(base.kind, &base.motor.parameters))
    }

    fn with(kind: CommandKind, motor: &Parameters) -> Self {
        Self {
            kind,
            per_nm: kind.per_nm(motor),
            resistance_ohm: motor.resistance_ohm,
        }
    }

    /// An interval in units of the command; `None` for a value that is independent of resistance and torque constant.
    pub fn of(self, interval: &Interval) -> Option<CommandInterval> {
        let (factor, unit) = self.of_unit(interval.unit)?;
        Some(CommandInterval {
            value: factor * interval.value,
            lo95: factor * interval.lo95,
            hi95: factor * interval.hi95,
            unit,
            reference: interval.reference.map(|value| factor * value),
        })
    }

    /// Factor and new unit of a value in this unit.
    fn of_unit(self, unit: &str) -> Option<(f64, &'static str)> {
        let resistance_ohm = self.resistance_ohm;
        Some(match (self.kind, unit) {
            (CommandKind::Voltage, "N m") => (self.per_nm, "V"),
            (CommandKind::Voltage, "N m s/rad") => (self.per_nm, "V s/rad"),
            (CommandKind::Voltage, "N m s^2/rad^2") => (self.per_nm, "V s^2/rad^2"),
            (CommandKind::Voltage, "kg m^2") => (self.per_nm, "V s^2/rad"),
            (CommandKind::Voltage, "A") => (resistance_ohm, "V"),
            (CommandKind::Voltage, "ohm") => (1.0 / resistance_ohm, "of the winding's"),
            (CommandKind::Voltage, "H") => (1.0 / resistance_ohm, "s"),
            (CommandKind::Voltage, "1/W") => (1.0 / resistance_ohm, "1/V^2"),
            (CommandKind::Current, "N m") => (self.per_nm, "A"),
            (CommandKind::Current, "N m s/rad") => (self.per_nm, "A s/rad"),
            (CommandKind::Current, "N m s^2/rad^2") => (self.per_nm, "A s^2/rad^2"),
            (CommandKind::Current, "kg m^2") => (self.per_nm, "A s^2/rad"),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::catalogue::catalogue;
    use crate::motor::{ActiveEffect, Motor};

    /// Each parameter of each effect has the same value in these units for any resistance.
    #[test]
    fn parameters_in_units_of_the_command_do_not_depend_on_the_resistance() {
        for kind in catalogue() {
            let mut motor = Motor::default();
            let effect = ActiveEffect::from_keys(kind.id, [], &motor.parameters);
            motor.effects.set(effect.expect("an effect"));
            let values = |motor: &Motor| -> Vec<f64> {
                let units = CommandUnits::with(CommandKind::Voltage, &motor.parameters);
                let effects = motor.effects.iter();
                let of = |(value, unit): (f64, &str)| {
                    value * units.of_unit(unit).map_or(1.0, |(factor, _)| factor)
                };
                effects
                    .flat_map(|effect| effect.parameters())
                    .map(|(parameter, value)| of((value, parameter.unit)))
                    .collect()
            };
            let other = motor.with_resistance(3.1);
            for (one, other) in values(&motor).iter().zip(values(&other)) {
                assert!((one - other).abs() <= 1e-12 * one.abs(), "{}", kind.id);
            }
        }
    }
}
