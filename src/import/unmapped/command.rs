//! The command of a log: its column, its kind, and its full drive.

use super::super::cells::value_after;
use super::super::map_command::CommandSection;
use super::super::unwrap::profile;
use super::decide::Decision;
use super::file_name::commands_of;
use super::given::{Steps, expected};
use super::pulses::pulse;
use super::sum::Sum;
use super::unclear::Unclear;
use super::units::{Role, unit_of};
use crate::plain::short;

/// Numbers of full drive: timers of 8, 10, 12 and 16 bits.
pub(super) const FULL_DRIVES: [f64; 4] = [255.0, 1023.0, 4095.0, 65_535.0];
/// Up to this number a command may be in percent as well as relative to 255.
pub(super) const PERCENT: f64 = 100.0;
/// Largest voltage of motors in V; in mV it is more than ten times this.
pub(super) const MOST_VOLTS: f64 = 100.0;
/// Largest initial rest relative to the log that may be the motor's dead time.
const SHORT_REST: f64 = 0.1;
/// Words before a command in comment lines.
const WORDS: [&str; 5] = ["pwm", "duty", "voltage", "command", "cmd"];

/// Names of a voltage.
const VOLTAGES: &[&str] = &["voltage", "spannung", "voltaje", "uq", "vq"];

/// Message for `--command-limit` without a sum.
pub(super) const LIMIT_OF_A_SUM: &str = "--command-limit is given, and --command is no sum of columns\nhint: leave --command-limit out, or give a sum such as --command 2*goal-2*position:V";

/// The command's column, and its unit.
struct Found {
    section: CommandSection,
    unit: &'static str,
    /// The largest magnitude.
    most: f64,
    full: Option<f64>,
    column: Option<usize>,
    words: String,
    /// Command of every row, if it is not in a single column.
    of_rows: Option<Vec<f64>>,
}

impl Decision<'_> {
    pub(super) fn command(&mut self, motion: Option<usize>) -> Result<(), Unclear> {
        let is_sum = (self.given.command.as_ref()).is_some_and(|text| text.contains('*'));
        if self.given.command_limit.is_some() && !is_sum {
            return Err(Unclear::Conflict(LIMIT_OF_A_SUM));
        }
        let questions = self.missing.len();
        let Some(found) = self.find_command(motion)? else {
            return Ok(());
        };
        let Found {
            mut section,
            unit,
            most,
            full,
            column,
            mut words,
            of_rows,
        } = found;
        if section.recorded == Some(false) {
            self.understand("command", None, None, words);
            self.map.command = Some(section);
            return Ok(());
        }
        let is_asked = self.missing.len() > questions;
        section.unit = Some(unit.to_owned());
        if unit == "pwm" {
            match self.full_drive(most, full) {
                Some((full, how)) => {
                    section.full = Some(full);
                    words.push_str(&format!("; {} is full drive{how}", short(full)));
                }
                None => {
                    let proposed = FULL_DRIVES
                        .into_iter()
                        .find(|full| *full >= most)
                        .unwrap_or(most);
                    let why = format!(
                        "the number that is full drive (255 of analogWrite); the largest of the log is {}",
                        short(most)
                    );
                    self.ask("--pwm-full", short(proposed), why);
                }
            }
        }
        if matches!(unit, "pwm" | "percent" | "share") {
            if let Some(supply) = self.supply()? {
                words.push_str(&format!("; a share of {supply}"));
            }
        } else if self.given.supply.is_some() {
            self.supply()?;
        }
        let place = self.understood.len();
        if let Some(command) = column
            && let Some((at, level, reverse)) = self.direction(command, motion)?
        {
            section.direction = Some(self.column_ref(at));
            section.reverse = Some(reverse);
            self.reverse = level.map(|level| (at, level));
        }
        let full = match unit {
            "pwm" => section.full,
            "percent" => Some(PERCENT),
            "share" => Some(1.0),
            _ => None,
        };
        // For pulses the width at standstill.
        let mut centre =
            (section.offset.zip(section.scale)).map_or(0.0, |(offset, scale)| -offset / scale);
        if let (Some(command), Some(motion), Some(full)) = (column, motion, full)
            && section.direction.is_none()
            && section.scale.is_none()
            && self.given.direction.is_none()
            && self.given.unsigned.is_none()
            && let Some(found) = self.centre(command, motion, full)
        {
            let (scale, offset, how) = Self::about_centre(found);
            (section.scale, section.offset) = (Some(scale), Some(offset));
            words.push_str(&how);
            centre = found;
        }
        let directions = self.understood.split_off(place);
        if is_asked {
            self.used.extend(column);
        } else {
            self.understand("command", column, Some(unit), words);
        }
        self.understood.extend(directions);
        self.map.command = Some(section);
        let signed = column.map(|command| self.signed(command));
        self.commands = of_rows.or(signed).map(|mut commands| {
            commands.iter_mut().for_each(|command| *command -= centre);
            commands
        });
        if let (Some(command), Some(motion)) = (column, motion) {
            self.sign(command, motion);
        } else if self.given.unsigned == Some(true) {
            self.map.rows.unsigned = Some(true);
        }
        Ok(())
    }

    /// The given command, else the only column with such a name, else that of comment lines.
    fn find_command(&mut self, motion: Option<usize>) -> Result<Option<Found>, Unclear> {
        let given = self.given;
        if let Some(text) = &given.command {
            if text == "none" {
                let section = CommandSection {
                    recorded: Some(false),
                    ..CommandSection::default()
                };
                let words = "neither logged nor known".to_owned();
                return Ok(Some(Found {
                    section,
                    unit: "V",
                    most: 0.0,
                    full: None,
                    column: None,
                    words,
                    of_rows: None,
                }));
            }
            if let Some(steps) = Steps::parse(text)? {
                let most = steps
                    .points
                    .iter()
                    .fold(0.0, |most: f64, (_, value)| most.max(value.abs()));
                let of_rows = (self.times_s.as_ref()).map(|times_s| {
                    let first_s = times_s.first().copied().unwrap_or(0.0);
                    let at = |t_s: &f64| profile(&steps.points, false, t_s - first_s);
                    times_s.iter().map(at).collect()
                });
                let section = CommandSection {
                    points: Some(steps.points),
                    ..CommandSection::default()
                };
                let words = format!("{text}, as given");
                return Ok(Some(Found {
                    section,
                    unit: steps.unit,
                    most,
                    full: None,
                    column: None,
                    words,
                    of_rows,
                }));
            }
            if let Some(sum) = Sum::parse(text, |name| self.find(name).is_some())? {
                return self.sum(&sum).map(Some);
            }
            let (at, unit) = self.given_column("--command", Role::Command, text)?;
            return Ok(self.command_column(at, unit));
        }
        let mut candidates = self.beside_used(self.candidates(Role::Command));
        let supply = (candidates.iter().copied())
            .find(|&at| motion.is_some_and(|motion| self.is_constant_both_ways(at, motion)));
        candidates.retain(|at| Some(*at) != supply);
        // A constant column is not the command if another one varies.
        let pulses = (0..self.survey.columns.len()).find(|&at| self.is_pulses(at));
        if candidates.len() > 1 || pulses.is_some() {
            candidates.retain(|&at| self.column(at).lowest() != self.column(at).highest());
        }
        match candidates.as_slice() {
            [at] => return Ok(self.command_column(*at, None)),
            [] => {}
            several => {
                let first = several[0];
                self.which("--command", "command", several);
                return Ok(self.tentatively(|decision| decision.command_column(first, None)));
            }
        }
        if let Some(found) = self.commented() {
            return Ok(Some(found));
        }
        if let Some(at) = pulses {
            return Ok(self.command_column(at, None));
        }
        let unclear = self.candidates(Role::CommandOrSupply);
        let doubt = match (supply, unclear.first()) {
            (Some(at), _) => format!(
                "{} is {} in every row while the shaft turns both ways, as a supply is; ",
                self.name(at),
                short(self.column(at).highest())
            ),
            (None, Some(&at)) => format!(
                "{} may be what was commanded or the supply; ",
                self.name(at)
            ),
            (None, None) => String::new(),
        };
        let (proposed, named) = self.command_of_file_name(motion);
        let from = match (&proposed, named.len() > 1) {
            (Some(_), _) => "the file's name says how much, and the first motion when; ".to_owned(),
            (None, true) => format!("the file's name may say {}; ", named.join(" or ")),
            (None, false) => String::new(),
        };
        let current = (self.candidates(Role::Current).first()).map_or_else(String::new, |&at| {
            format!("; of a current loop: {}:A", self.flag_name(at))
        });
        let free: Vec<String> = (0..self.survey.columns.len())
            .filter(|at| !self.used.contains(at) && self.column(*at).is_numeric())
            .map(|at| self.name(at))
            .collect();
        let among = match free.is_empty() {
            true => String::new(),
            false => format!(" of {}", free.join(", ")),
        };
        let why = format!(
            "{doubt}no column is named as a command; {from}a column: COLUMN:UNIT{among}; known steps: 6V@0.5s{current}; not known: none; \
             a share of full drive (pwm, percent) needs --supply too"
        );
        let is_share = (proposed.as_ref()).is_some_and(|steps| steps.contains(['%', 'p']));
        self.ask(
            "--command",
            proposed.unwrap_or_else(|| "COLUMN:UNIT".to_owned()),
            why,
        );
        if is_share {
            self.tentatively(|decision| decision.supply())?;
        }
        Ok(None)
    }

    /// The given sum of columns.
    fn sum(&mut self, sum: &Sum) -> Result<Found, Unclear> {
        let limit = self.given.command_limit;
        let mut total = vec![0.0; self.survey.rows];
        for (factor, name) in &sum.terms {
            let (at, _) = self.given_column("--command", Role::Reference, name)?;
            for (sum, number) in total.iter_mut().zip(&self.column(at).numbers) {
                *sum += factor * number;
            }
            // A position may be a term, and remains a position.
            if !self.used.contains(&at) {
                self.used.push(at);
            }
        }
        if let Some(limit) = limit {
            total
                .iter_mut()
                .for_each(|sum| *sum = sum.clamp(-limit, limit));
        }
        let most = (total.iter().filter(|x| x.is_finite())).fold(0.0, |most, x| x.abs().max(most));
        let section = sum.section(limit, |name| {
            let at = self.find(name).unwrap_or_default();
            Ok(self.column_ref(at))
        })?;
        let held_to = limit.map_or_else(String::new, |limit| format!(", held to {}", short(limit)));
        let terms: Vec<String> = (sum.terms.iter())
            .map(|(factor, name)| format!("{} times `{name}`", short(*factor)))
            .collect();
        Ok(Found {
            section,
            unit: sum.unit,
            most,
            full: None,
            column: None,
            words: format!("{} in {}{held_to}", terms.join(" plus "), sum.unit),
            of_rows: Some(total),
        })
    }

    fn command_column(&mut self, at: usize, given_unit: Option<&'static str>) -> Option<Found> {
        if given_unit.is_none() && self.is_pulses(at) {
            let unit = self.ask_pulses(at);
            return self.tentatively(|decision| decision.command_column(at, Some(unit)));
        }
        let column = self.column(at);
        let (name, most) = (self.name(at), column.most());
        let facts = &self.name_facts[at];
        let is_word = |list: &[&str]| facts.words.iter().any(|word| list.contains(&word.as_str()));
        let is_share = most <= 1.0 && !column.is_whole();
        let by_numbers = || {
            let is_drive = is_word(&["pwm", "duty", "dutycycle"]);
            if is_drive && is_share {
                Some("share")
            } else if facts.full.is_some() || (is_drive && column.is_whole() && most > PERCENT) {
                Some("pwm")
            } else if is_word(VOLTAGES) && most <= MOST_VOLTS {
                Some("V")
            } else if is_word(VOLTAGES) && most > 10.0 * MOST_VOLTS {
                Some("mV")
            } else {
                None
            }
        };
        let named = facts.unit.map(|unit| {
            if unit == "pwm" && is_share {
                "share"
            } else {
                unit
            }
        });
        let full = facts.full.or(self.given.pwm_full);
        let by_full = self.given.pwm_full.map(|_| "pwm");
        let Some(unit) = given_unit.or(named).or_else(by_numbers).or(by_full) else {
            let flag = self.flag_name(at);
            let proposed = match (
                is_word(&["duty", "dutycycle", "throttle"]),
                most > MOST_VOLTS,
            ) {
                (true, false) => "percent",
                (_, true) => "pwm",
                (false, false) => "V",
            };
            let why = format!("{name} names no unit; {}", expected(Role::Command));
            self.ask("--command", format!("{flag}:{proposed}"), why);
            return self.tentatively(|decision| decision.command_column(at, Some(proposed)));
        };
        let mut section = CommandSection {
            column: Some(self.column_ref(at)),
            ..CommandSection::default()
        };
        let mut words = format!("{name} in {unit}");
        let unit = match pulse(unit) {
            Some((rest_us, full_us)) => {
                section.scale = Some(1.0 / full_us);
                section.offset = Some(-rest_us / full_us);
                words.push_str(&format!(", pulses of {rest_us} µs at standstill"));
                "share"
            }
            None => unit,
        };
        Some(Found {
            section,
            unit,
            most,
            full,
            column: Some(at),
            words,
            of_rows: None,
        })
    }

    /// `# Step 2/5 | PWM = 120`.
    fn commented(&self) -> Option<Found> {
        let comments = &self.survey.comments;
        let (word, most, unit) = WORDS.into_iter().find_map(|word| {
            let values = || (comments.iter()).filter_map(|comment| value_after(comment, word));
            let most = values().map(|(number, _)| number.abs()).reduce(f64::max)?;
            let (_, first) = values().next()?;
            let is_same = values().all(|(_, unit)| unit == first);
            let unit = unit_of(Role::Command, &first).filter(|_| is_same);
            Some((word, most, unit))
        })?;
        let unit = match (word, unit) {
            ("pwm", Some("percent")) => "percent",
            ("pwm", _) => "pwm",
            (_, Some(unit)) => unit,
            ("voltage", None) if most <= MOST_VOLTS => "V",
            _ => return None,
        };
        let section = CommandSection {
            comment: Some(word.to_owned()),
            ..CommandSection::default()
        };
        let words = format!("the number after `{word}` in comment lines, in {unit}");
        Some(Found {
            section,
            unit,
            most,
            full: None,
            column: None,
            words,
            of_rows: None,
        })
    }

    /// Command in the file's name, from the last row at rest on; and all candidates.
    fn command_of_file_name(&self, motion: Option<usize>) -> (Option<String>, Vec<String>) {
        let commands = commands_of(self.file_name);
        let proposed = match (commands.as_slice(), motion) {
            ([command], Some(motion)) => {
                let onset_s = self.onset_s(motion).unwrap_or(0.0);
                Some(format!(
                    "{command}@{}s",
                    (onset_s * 1000.0).floor() / 1000.0
                ))
            }
            _ => None,
        };
        (proposed, commands)
    }

    /// Time of the last row before the motion begins, relative to the first row in s; 0 if the log begins with the
    /// step.
    fn onset_s(&self, motion: usize) -> Option<f64> {
        let numbers = &self.column(motion).numbers;
        let first = numbers.iter().find(|number| number.is_finite())?;
        let moves = (numbers.iter()).position(|number| number.is_finite() && number != first)?;
        let rests = moves.checked_sub(1)?;
        let times_s = self.times_s.as_ref()?;
        let (first_s, last_s) = (times_s.first()?, times_s.last()?);
        let (onset_s, length_s) = (times_s[rests] - first_s, last_s - first_s);
        (onset_s >= SHORT_REST * length_s).then_some(onset_s)
    }
}
