//! A speed without a position: counts are reconstructed from its steps.

use std::f64::consts::TAU;

use super::super::map_file::SpeedSection;
use super::decide::Decision;
use super::given::expected;
use super::grid::step_of;
use super::motion::{FINEST, ODRIVE, WHOLE, whole};
use super::names::is_frequency;
use super::units::{EITHER_PER_S, Role};
use crate::plain::{rounded_to, short};
use crate::recording::Integration;
use crate::recording::speed_rule::{INSTANT, MEAN, Row, rule};

/// Residual of a first-order motor relative to the largest speed below which it explains the speed: a filter in the
/// sketch leaves more.
const PERFECT: f64 = 2e-3;
/// Largest usual counts per revolution, gears included: larger ones derived from a speed are the rounding of its
/// numbers.
const MOST_USUAL: f64 = 100_000.0;
/// Rounding relative to the largest speed that is immaterial: the usual relevant error is a hundred times as large.
const IMMATERIAL: f64 = 1e-4;
/// Tolerance of a step that is a power of ten: it is estimated from many levels.
const ROUND: f64 = 1e-5;
/// Definition of an electrical speed, and its conversion to the shaft's.
const ELECTRICAL: &str = "as many times the shaft's as the motor has pole pairs: --save-map map.toml, there `scale` = 1 / pole pairs \
                          under [speed], then --map map.toml";
/// Least number of levels of a fine speed without steps.
const LEVELS: usize = 50;

impl Decision<'_> {
    pub(super) fn speed(
        &mut self,
        at: usize,
        given_unit: Option<&'static str>,
        step_s: Option<f64>,
    ) {
        let column = self.column(at);
        let name = self.name(at);
        let named = given_unit.or(self.name_facts[at].unit);
        let is_either = named == Some(EITHER_PER_S);
        let by_steps = || self.unit_of_steps(at, step_s).filter(|_| is_either);
        let Some(unit) = named.filter(|_| !is_either).or_else(by_steps) else {
            let flag = self.flag_name(at);
            let is_word = |of: &str| self.name_facts[at].words.iter().any(|word| word == of);
            let usual = match (is_word("omega") || is_word("ω"), is_word(ODRIVE)) {
                _ if is_frequency(&self.name_facts[at].words) => "counts/s",
                (true, _) => "rad/s",
                (_, true) => "rev/s",
                _ => "rpm",
            };
            let (proposed, why) = match is_either {
                _ if self.name_facts[at].is_electrical => (
                    "rpm",
                    format!(
                        "{name} is the electrical speed, {ELECTRICAL}; {name} as it stands is that of one pole pair"
                    ),
                ),
                true => (
                    "rad/s",
                    format!("{name} may be radians or revolutions a second: rad/s or rev/s"),
                ),
                false => (
                    usual,
                    format!("{name} names no unit; {}", expected(Role::Speed)),
                ),
            };
            self.ask("--speed", format!("{flag}:{proposed}"), why);
            self.tentatively(|decision| decision.speed(at, Some(proposed), step_s));
            return;
        };
        if self.name_facts[at].is_electrical {
            self.notes.push(format!(
                "{name} is taken as the shaft's speed, and is the electrical one by its name, {ELECTRICAL}"
            ));
        }
        if matches!(unit, "m/s" | "cm/s" | "mm/s" | "km/h") {
            self.travel(at, unit);
        }
        let rev_s = match unit {
            "rpm" => Some(1.0 / 60.0),
            "rev/s" => Some(1.0),
            "rad/s" => Some(1.0 / TAU),
            "deg/s" => Some(1.0 / 360.0),
            _ => None,
        };
        let step = column.step();
        let by_rows = match step {
            Some(_) => None,
            None => self.step_by_rows(at, step_s),
        };
        // One count in a sample time, or in the time since the previous row.
        let turns = match (step, step_s, by_rows) {
            (Some(step), Some(step_s), _) => Some(step * step_s),
            (None, _, Some(travel)) => Some(travel),
            _ => None,
        };
        let found = turns
            .zip(rev_s)
            .map(|(turns, rev_s)| whole(1.0 / (turns * rev_s)));
        let found = found.filter(|counts| (1.0..=FINEST).contains(counts));
        // Steps of a rounded number, or of a drive's units, are no counts.
        let given = self
            .given
            .counts_per_rev
            .or(self.name_facts[at].counts_per_rev);
        let is_round = step.is_some_and(is_power_of_ten);
        let (found, doubted) = match found {
            Some(counts) if counts > MOST_USUAL => (None, Some(counts)),
            Some(counts) if is_round && given.is_none() => (None, Some(counts)),
            Some(counts) if given.is_some_and(|given| !is_whole_multiple(counts, given)) => {
                self.notes.push(format!(
                    "the steps of {name} are those of {} counts per revolution in a row, not of {}: its numbers are rounded",
                    short(counts),
                    short(given.unwrap_or(counts))
                ));
                (None, Some(counts))
            }
            found => (found, None),
        };
        let why = match (doubted, step) {
            (Some(counts), Some(step)) if counts <= MOST_USUAL => format!(
                "steps of {name} of {} are the rounding of its numbers, or those of {} counts per revolution; counts of the encoder in one turn, \
                 all four edges counted",
                short(step),
                short(counts)
            ),
            (Some(counts), Some(step)) => format!(
                "steps of {name} of {} would be those of {} counts per revolution, more than encoders have; counts of the encoder in one turn, \
                 all four edges counted",
                short(step),
                short(counts)
            ),
            _ => format!(
                "{name} shows no steps to read it off; counts of the encoder in one turn, all four edges counted"
            ),
        };
        if step.is_none() || step_s.is_some() {
            self.counts_per_rev(found, why);
        }
        let has_steps = (step.is_some() || by_rows.is_some()) && doubted.is_none();
        self.is_difference = has_steps || self.given.integrate.is_some();
        // Encoders give differences of position; a filter adds its lag. Without steps the motion decides, see
        // `integration`.
        let rule = self.given.integrate.unwrap_or(Integration::Backward);
        self.map.speed = Some(SpeedSection {
            column: self.column_ref(at),
            unit: unit.to_owned(),
            scale: None,
            offset: None,
            integrate: rule,
            time_constant_s: None,
            resolution: self.resolution(at, step.filter(|_| doubted.is_some())),
        });
        let how = match (step, by_rows) {
            (Some(step), _) => format!("in steps of {}", short(step)),
            (None, Some(_)) => "of whole counts from row to row".to_owned(),
            (None, None) => "without steps".to_owned(),
        };
        let how = match self.is_difference {
            true => format!("{how}; summed up to a position ({})", rule.name()),
            false => how,
        };
        self.understand(
            "speed",
            Some(at),
            Some(unit),
            format!("{name} in {unit}, {how}"),
        );
        if let (Some(found), Some(step_s)) = (found, step_s) {
            match given {
                None => {
                    let words = format!(
                        "{} counts per revolution, read off: one count in {} s is a step of the speed. The encoder's number, or a multiple of it \
                         where the sketch averages several rows",
                        short(found),
                        short(step_s)
                    );
                    self.understand("counts_per_rev", None, None, words);
                }
                Some(given) if (given / found - 1.0).abs() > WHOLE => {
                    let times = found / given;
                    let is_mean = times > 1.5 && (times - times.round()).abs() < WHOLE * times;
                    let how = match is_mean {
                        true => format!(
                            ", as the mean of {} samples has: a filter, the effect `speed_filter`",
                            times.round()
                        ),
                        false => String::new(),
                    };
                    self.notes.push(format!(
                        "the steps of {name} are those of {} counts per revolution in {} s, not of {}{how}",
                        short(found),
                        short(step_s),
                        short(given)
                    ));
                }
                Some(_) => {}
            }
        }
    }

    /// Integration of a speed without steps: by the rule with the smaller residual for a first-order motor.
    pub(super) fn integration(&mut self, at: usize) {
        let Some(unit) = self.map.speed.as_ref().map(|speed| speed.unit.clone()) else {
            return;
        };
        if self.is_difference {
            return;
        }
        let rule = rule(&self.rows_of_motor(at));
        let (integrate, words) = match &rule {
            Some(found) => (found.integration(), format!("; {}", found.words(&unit))),
            None => {
                let words = format!(
                    "; taken as {INSTANT}, which the motion does not show \
                     (--integrate backward: {MEAN})"
                );
                (Integration::Trapezoid, words)
            }
        };
        if let Some(speed) = &mut self.map.speed {
            speed.integrate = integrate;
            speed.time_constant_s = rule.and_then(|found| found.curve_s());
        }
        if let Some(understood) = self.understood.iter_mut().find(|one| one.what == "speed") {
            understood.words.push_str(&words);
        }
        let column = self.column(at);
        let is_motor = rule.is_some_and(|found| found.left <= PERFECT * column.most());
        if !is_motor && column.is_fine() && column.levels().len() >= LEVELS {
            self.notes.push(format!(
                "{} lacks the steps that counts in a sample time make: it is filtered, or timed between edges. \
                 A filter delays it: the effect `speed_filter`",
                self.name(at)
            ));
        }
    }

    /// Resolution of the speeds: their steps, if those are no counts, or the last digit; `None` if it is immaterial.
    fn resolution(&self, at: usize, step: Option<f64>) -> Option<f64> {
        let column = self.column(at);
        let resolution = step.unwrap_or(2.0 * column.rounding());
        (resolution > IMMATERIAL * column.most()).then(|| rounded_to(resolution, 6))
    }

    /// Rows with a time, a command and a speed.
    fn rows_of_motor(&self, at: usize) -> Vec<Row> {
        let (Some(times_s), Some(commands)) = (&self.times_s, &self.commands) else {
            return Vec::new();
        };
        let is_unsigned = self.map.rows.unsigned == Some(true);
        let (mut held, mut sign) = (0.0, 1.0);
        let mut rows = Vec::with_capacity(times_s.len());
        for ((t_s, command), speed) in times_s.iter().zip(commands).zip(&self.column(at).numbers) {
            // The command in force until here.
            let way = sign;
            if command.is_finite() {
                held = *command;
                sign = if held == 0.0 { sign } else { held.signum() };
            }
            if t_s.is_finite() && speed.is_finite() {
                let speed = if is_unsigned {
                    speed.abs() * way
                } else {
                    *speed
                };
                rows.push(Row {
                    t_s: *t_s,
                    command: held,
                    speed,
                });
            }
        }
        rows
    }

    /// Of revolutions and radians per second the one in which the steps are those of the given counts.
    fn unit_of_steps(&self, at: usize, step_s: Option<f64>) -> Option<&'static str> {
        let turns = self.column(at).step()? * step_s?;
        let counts = self.given.counts_per_rev?;
        [("rev/s", 1.0), ("rad/s", TAU)]
            .into_iter()
            .find(|(_, turn)| (turns * counts / turn - 1.0).abs() < WHOLE)
            .map(|(unit, _)| unit)
    }

    /// The travel of one count if speeds were computed with the measured time: speed times time has steps.
    fn step_by_rows(&self, at: usize, step_s: Option<f64>) -> Option<f64> {
        let times_s = self.times_s.as_ref()?;
        let speeds = self.column(at);
        let travels: Vec<f64> = (times_s.windows(2).zip(speeds.numbers.iter().skip(1)))
            .map(|(pair, speed)| speed * (pair[1] - pair[0]))
            .collect();
        step_of(&travels, speeds.rounding() * step_s?)
    }
}

/// 1, 10, 0.1: the usual rounding of numbers, and rarely one count per row.
fn is_power_of_ten(step: f64) -> bool {
    let power = 10_f64.powi(step.log10().round() as i32);
    (step / power - 1.0).abs() < ROUND
}

/// Whether one is an integral multiple of the other: counts of one channel or four, and the mean of several rows.
fn is_whole_multiple(found: f64, given: f64) -> bool {
    let times = f64::max(found / given, given / found);
    (times - times.round()).abs() < WHOLE * times
}
