//! Reference of a command that is a share, and direction of the encoder.

use super::super::map_file::FieldSection;
use super::command::{FULL_DRIVES, MOST_VOLTS, PERCENT};
use super::decide::Decision;
use super::given::{expected, number_and_rest};
use super::marks::Marks;
use super::unclear::Unclear;
use super::units::Role;
use crate::plain::short;

/// Least number of rows with backward drive and forward counts that is significant.
const BACKWARDS: usize = 5;
/// A braked motor loses more than 2 % of its speed from the first half of a braking to its last quarter.
const SLOWED: f64 = 0.98;

impl Decision<'_> {
    /// The number of full drive, and its source.
    pub(super) fn full_drive(&self, most: f64, named: Option<f64>) -> Option<(f64, String)> {
        if let Some(full) = self.given.pwm_full.or(named) {
            return Some((full, String::new()));
        }
        if let Some(at) = (0..self.survey.columns.len()).find(|at| self.is_period(*at, most)) {
            let how = format!(", as {} is (--pwm-full says another)", self.name(at));
            return Some((self.column(at).highest(), how));
        }
        if FULL_DRIVES.contains(&most) {
            return Some((most, ", the largest there is".to_owned()));
        }
        let is_byte = most > PERCENT && most < FULL_DRIVES[0];
        is_byte.then(|| {
            let how = ", as of analogWrite (--pwm-full says another)";
            (FULL_DRIVES[0], how.to_owned())
        })
    }

    /// Whether a column is the constant period of a pulse width, such as `pwm_period` beside `pwm_duty`.
    fn is_period(&self, at: usize, most: f64) -> bool {
        let (column, words) = (self.column(at), &self.name_facts[at].words);
        let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
        let is_constant = column.is_numeric() && column.lowest() == column.highest();
        is_constant
            && column.highest() >= most
            && column.highest() > 0.0
            && has(&["pwm", "duty", "timer"])
            && has(&["period", "top", "max", "range"])
    }

    /// The supply of a share: as text, or requested.
    pub(super) fn supply(&mut self) -> Result<Option<String>, Unclear> {
        // A bare number is in volts, not a column number; a column number has a unit.
        if let Some(text) = &self.given.supply
            && let Some((volts, "" | "V" | "v")) = number_and_rest(text)
        {
            self.map.supply_v = Some(volts);
            if let [one] = self.candidates(Role::Supply).as_slice() {
                self.measured_supply(*one, None);
            }
            return Ok(Some(format!("{} V", short(volts))));
        }
        let (at, unit) = match &self.given.supply {
            Some(text) => self.given_column("--supply", Role::Supply, text)?,
            None => match self.candidates(Role::Supply).as_slice() {
                [one] => (*one, None),
                _ => {
                    let why = "supply of the driver in V: the command is a share of it".to_owned();
                    self.ask("--supply", "VOLTS".to_owned(), why);
                    return Ok(None);
                }
            },
        };
        let Some(factor) = self.measured_supply(at, unit) else {
            let flag = self.flag_name(at);
            let why = format!(
                "{} names no unit; {}",
                self.name(at),
                expected(Role::Supply)
            );
            self.ask("--supply", format!("{flag}:V"), why);
            return Ok(None);
        };
        let mut volts: Vec<f64> = self
            .column(at)
            .numbers
            .iter()
            .map(|x| x * factor)
            .filter(|x| x.is_finite())
            .collect();
        volts.sort_by(f64::total_cmp);
        let middle = volts[volts.len() / 2];
        self.map.supply_v = Some(middle);
        Ok(Some(format!(
            "{}, {} V in the middle",
            self.name(at),
            short(middle)
        )))
    }

    /// Uses a column as the measured supply; returns its volts per unit, if known.
    fn measured_supply(&mut self, at: usize, given_unit: Option<&'static str>) -> Option<f64> {
        let column = self.column(at);
        let by_numbers = || match column.most() {
            most if most <= MOST_VOLTS => Some("V"),
            most if most > 10.0 * MOST_VOLTS => Some("mV"),
            _ => None,
        };
        let unit = given_unit
            .or(self.name_facts[at].unit)
            .or_else(by_numbers)?;
        self.map.supply = Some(FieldSection::of(self.column_ref(at), unit));
        self.understand(
            "supply",
            Some(at),
            Some(unit),
            format!("{} in {unit}, measured", self.name(at)),
        );
        Some(if unit == "mV" { 1e-3 } else { 1.0 })
    }

    /// Determines whether the encoder has a direction.
    pub(super) fn sign(&mut self, command: usize, motion: usize) {
        match self.given.unsigned {
            Some(unsigned) => {
                self.map.rows.unsigned = unsigned.then_some(true);
                if unsigned {
                    self.understand(
                        "rows",
                        None,
                        None,
                        "the sign of the motion is the command's".to_owned(),
                    );
                }
            }
            None if self.reverse.is_some() && self.is_without_sign(command, motion) => {
                self.map.rows.unsigned = Some(true);
                let words = format!("{} has no sign: it is the command's", self.name(motion));
                self.understand("rows", None, None, words);
            }
            None if self.is_without_sign(command, motion) => {
                let why = format!(
                    "{} never goes backwards, though the command does: an encoder of one channel, whose sign is the command's; \
                     or --unsigned=false",
                    self.name(motion)
                );
                self.ask("--unsigned", String::new(), why);
            }
            None => {}
        }
    }

    /// Whether the motion lacks a sign: it continues, without just slowing down, under an opposing command. A braked
    /// motor comes to rest; an encoder with one channel keeps counting up.
    fn is_without_sign(&self, command: usize, motion: usize) -> bool {
        let commands = self.signed(command);
        let rates = self.rates(motion);
        let has_sign = self.column(motion).lowest() < 0.0 || rates.iter().any(|rate| *rate < 0.0);
        if has_sign || !commands.iter().any(|u| *u > 0.0) {
            return false;
        }
        let rows: Vec<(f64, f64)> = commands.into_iter().zip(rates).collect();
        let turns_on = |rows_of: &[(f64, f64)]| {
            let mean = |rows: &[(f64, f64)]| {
                rows.iter().map(|(_, rate)| rate).sum::<f64>() / rows.len() as f64
            };
            let length = rows_of.len();
            let (first, last) = (&rows_of[..length / 2], &rows_of[length - length / 4..]);
            mean(last) > 0.0 && mean(last) >= SLOWED * mean(first)
        };
        rows.chunk_by(|a, b| (a.0 < 0.0) == (b.0 < 0.0))
            .filter(|rows_of| rows_of[0].0 < 0.0 && rows_of.len() > BACKWARDS)
            .any(turns_on)
    }

    /// The command's numbers, with the sign of a column of directions.
    pub(super) fn signed(&self, command: usize) -> Vec<f64> {
        let numbers = &self.column(command).numbers;
        let Some((at, reverse)) = self.reverse else {
            return numbers.clone();
        };
        let signed =
            |(u, level): (&f64, Option<usize>)| if level == Some(reverse) { -u } else { *u };
        (numbers.iter())
            .zip(Marks::of(self.column(at)).rows)
            .map(signed)
            .collect()
    }
}
