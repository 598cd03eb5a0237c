//! A motor file: TOML with the nominal parameters, their tolerances and the effects that are part of the model.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::active::{ActiveEffect, EffectError, did_you_mean};
use crate::catalogue::find;
use crate::plausible::{self, Range, Shown};
use crate::synonyms::nearest_name;
use crate::{Effects, Parameters};

/// Characters of a key or a value in a message.
const MOST_SHOWN: usize = 60;

/// Longest motor file in bytes.
const MOST_BYTES: u64 = 1 << 20;

/// A motor: the content of a motor file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motor {
    /// Nominal parameters.
    pub parameters: Parameters,
    /// Relative standard deviation by parameter key.
    pub tolerance: BTreeMap<String, f64>,
    /// Effects that are part of the model.
    pub effects: Effects,
    /// Whether neither the resistance nor a torque was measured.
    pub resistance_assumed: bool,
}

/// Errors of a motor file.
#[derive(Debug, thiserror::Error)]
pub enum MotorFileError {
    /// The file cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// It is not TOML.
    #[error(
        "line {line}: not TOML: {message}\nhint: a line is KEY = NUMBER, such as resistance_ohm = 10.0; `motorlab motor --template -o motor.toml` writes a file to start from"
    )]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Message of the TOML parser.
        message: String,
    },
    /// An unknown key.
    #[error("line {line}: unknown key '{key}'\nhint: {}`motorlab motor --template` prints all keys", did_you_mean(.nearest))]
    UnknownKey {
        /// Line, from 1.
        line: usize,
        /// The key.
        key: String,
        /// The most similar known key.
        nearest: Option<&'static str>,
    },
    /// A value of another type.
    #[error(
        "line {line}: {key} must be {expected}, found {found}\nhint: correct the value; `motorlab motor --template` prints every key with a value"
    )]
    WrongValue {
        /// Line, from 1.
        line: usize,
        /// The key.
        key: String,
        /// Expected value.
        expected: &'static str,
        /// Value found.
        found: String,
    },
    /// A value outside the plausible range.
    #[error("line {line}: {key} = {} cannot be: expected {range}\nhint: the key's name states its unit; convert the value to it", Shown(*.value))]
    Implausible {
        /// Line, from 1.
        line: usize,
        /// The key.
        key: String,
        /// The value.
        value: f64,
        /// Possible values.
        range: Range,
    },
    /// A wrong name or value of an effect.
    #[error("line {line}: {error}")]
    Effect {
        /// Line, from 1.
        line: usize,
        /// The error.
        error: EffectError,
    },
    /// An error in a file.
    #[error("{path}: {error}")]
    InFile {
        /// The file.
        path: PathBuf,
        /// The error.
        error: Box<MotorFileError>,
    },
}

/// Reads a motor file; omitted keys have the lab handout's values.
pub fn read_motor(path: impl AsRef<Path>) -> Result<Motor, MotorFileError> {
    read_motor_and_lacking(path).map(|(motor, _)| motor)
}

/// As [`read_motor`], with the keys of [`Parameters`] that the file omits.
pub fn read_motor_and_lacking(
    path: impl AsRef<Path>,
) -> Result<(Motor, Vec<&'static str>), MotorFileError> {
    let path = path.as_ref();
    let text = read_bounded(path).map_err(|source| MotorFileError::Io {
        path: path.to_owned(),
        source,
    })?;
    let motor = Motor::from_toml(&text).map_err(|error| MotorFileError::InFile {
        path: path.to_owned(),
        error: Box::new(error),
    })?;
    let table: toml::Table = text.parse().unwrap_or_default();
    let lacks = |key: &&str| !table.contains_key(*key);
    Ok((motor, Parameters::KEYS.into_iter().filter(lacks).collect()))
}

/// The file's text, unless it is too long.
fn read_bounded(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let file = File::open(path)?.take(MOST_BYTES + 1);
    io::BufReader::new(file).read_to_string(&mut text)?;
    if text.len() as u64 > MOST_BYTES {
        let message = format!("it is longer than {MOST_BYTES} bytes: this is no motor file");
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    Ok(text)
}

impl Motor {
    /// Reads the text of a motor file.
    pub fn from_toml(text: &str) -> Result<Self, MotorFileError> {
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| {
            let start = e.span().map_or(0, |span| span.start);
            MotorFileError::Syntax {
                line: 1 + text[..start.min(text.len())].matches('\n').count(),
                message: e.message().to_owned(),
            }
        })?;
        let mut motor = Self::default();
        for (key, value) in &table {
            match key.as_str() {
                "tolerance" => motor.read_tolerance(text, value)?,
                "effects" => {}
                "resistance_assumed" => {
                    let line = line_of(text, "", key);
                    motor.resistance_assumed = (value.as_bool())
                        .ok_or_else(|| wrong(line, key, "true or false", value))?;
                }
                _ => {
                    let line = line_of(text, "", key);
                    let slot = motor.parameters.get_mut(key).ok_or_else(|| {
                        let keys = Parameters::KEYS.iter().copied();
                        MotorFileError::UnknownKey {
                            line,
                            key: key.clone(),
                            nearest: nearest_name(
                                key,
                                keys.chain(["tolerance", "effects", "resistance_assumed"]),
                            ),
                        }
                    })?;
                    *slot = number(value, key, line)?;
                }
            }
        }
        motor.check(text)?;
        // Defaults of an effect's keys depend on parameters anywhere in the file: effects are read last.
        if let Some(value) = table.get("effects") {
            motor.read_effects(text, value)?;
        }
        Ok(motor)
    }

    /// The text of a motor file that reads back as this motor.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for line in self.assumptions() {
            let _ = writeln!(text, "# {line}");
        }
        for key in Parameters::KEYS {
            let _ = writeln!(
                text,
                "{key} = {:?}",
                self.parameters.get(key).unwrap_or(0.0)
            );
        }
        if self.resistance_assumed {
            text.push_str("resistance_assumed = true\n");
        }
        if !self.tolerance.is_empty() {
            text.push_str("\n[tolerance]\n");
            for (key, value) in &self.tolerance {
                let _ = writeln!(text, "{key} = {value:?}");
            }
        }
        for effect in self.effects.iter() {
            let id = effect.kind().id;
            // A bare TOML key may not contain `#`.
            let quote = if id.contains('#') { "\"" } else { "" };
            let _ = writeln!(text, "\n[effects.{quote}{id}{quote}]");
            for (parameter, value) in effect.parameters() {
                let _ = writeln!(text, "{} = {value:?}", parameter.key);
            }
        }
        text
    }

    fn read_tolerance(&mut self, text: &str, value: &toml::Value) -> Result<(), MotorFileError> {
        for (key, value) in table_of(text, "tolerance", value)? {
            let line = line_of(text, "tolerance", key);
            if !Parameters::KEYS.contains(&key.as_str()) {
                return Err(MotorFileError::UnknownKey {
                    line,
                    key: format!("tolerance.{key}"),
                    nearest: nearest_name(key, Parameters::KEYS.iter().copied()),
                });
            }
            let sigma = number(value, key, line)?;
            plausible_at(
                line,
                &format!("tolerance.{key}"),
                sigma,
                plausible::TOLERANCE,
            )?;
            self.tolerance.insert(key.clone(), sigma);
        }
        Ok(())
    }

    fn read_effects(&mut self, text: &str, value: &toml::Value) -> Result<(), MotorFileError> {
        for (id, value) in table_of(text, "effects", value)? {
            let section = format!("effects.{id}");
            let line = line_of(text, &section, "");
            let at = |error| MotorFileError::Effect { line, error };
            let given = match value {
                toml::Value::Table(table) => table.clone(),
                toml::Value::Boolean(true) => toml::Table::new(),
                other => return Err(wrong(line, &section, "a table of parameters", other)),
            };
            let mut values = Vec::with_capacity(given.len());
            for (key, value) in &given {
                let line = line_of(text, &section, key);
                values.push((key.as_str(), number(value, key, line)?));
                if let Some((_, kind)) = find(id)
                    && !kind.parameters.iter().any(|p| p.key == key)
                {
                    let known = kind.parameters.iter().map(|p| p.key);
                    return Err(MotorFileError::Effect {
                        line,
                        error: EffectError::UnknownParameter {
                            id: kind.id,
                            key: key.clone(),
                            nearest: nearest_name(key, known),
                        },
                    });
                }
            }
            let effect = ActiveEffect::from_keys(id, values, &self.parameters).map_err(at)?;
            self.effects.set(effect);
        }
        Ok(())
    }

    /// Refuses values outside the plausible ranges.
    fn check(&self, text: &str) -> Result<(), MotorFileError> {
        for key in Parameters::KEYS {
            let value = self.parameters.get(key).unwrap_or(0.0);
            plausible_at(
                line_of(text, "", key),
                key,
                value,
                plausible::of_parameter(key),
            )?;
        }
        Ok(())
    }
}

fn plausible_at(line: usize, key: &str, value: f64, range: Range) -> Result<(), MotorFileError> {
    if range.holds(value) {
        return Ok(());
    }
    let key = key.to_owned();
    Err(MotorFileError::Implausible {
        line,
        key,
        value,
        range,
    })
}

fn table_of<'a>(
    text: &str,
    key: &str,
    value: &'a toml::Value,
) -> Result<&'a toml::Table, MotorFileError> {
    let line = line_of(text, key, "");
    value
        .as_table()
        .ok_or_else(|| wrong(line, key, "a table", value))
}

fn wrong(line: usize, key: &str, expected: &'static str, found: &toml::Value) -> MotorFileError {
    MotorFileError::WrongValue {
        line,
        key: key.to_owned(),
        expected,
        found: shortened(&found.to_string()),
    }
}

/// A text clipped for a message.
fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(MOST_SHOWN).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

fn number(value: &toml::Value, key: &str, line: usize) -> Result<f64, MotorFileError> {
    let number = match value {
        toml::Value::Float(value) => Some(*value),
        toml::Value::Integer(value) => Some(*value as f64),
        _ => None,
    };
    number
        .filter(|value| value.is_finite())
        .ok_or_else(|| wrong(line, key, "a finite number", value))
}

/// Line (from 1) of `key` in `[section]` (both as written in the text), of the section's header for an empty `key`,
/// and 1 if the text has another notation.
fn line_of(text: &str, section: &str, key: &str) -> usize {
    let mut current = String::new();
    for (k, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(name) = line.strip_prefix('[') {
            current = name.split(']').next().unwrap_or("").replace([' ', '"'], "");
            if key.is_empty() && current == section {
                return k + 1;
            }
        } else if let Some((name, _)) = line.split_once('=') {
            let name = name.trim().trim_matches('"');
            let full = if current.is_empty() {
                name.to_owned()
            } else {
                format!("{current}.{name}")
            };
            let asked = match (section.is_empty(), key.is_empty()) {
                (true, _) => key.to_owned(),
                (false, true) => section.to_owned(),
                (false, false) => format!("{section}.{key}"),
            };
            if full == asked {
                return k + 1;
            }
        }
    }
    1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_file_is_the_handouts_motor() {
        let motor = Motor::from_toml("").unwrap();
        assert_eq!(motor, Motor::default());
    }

    #[test]
    fn a_written_motor_is_read_back_unchanged() {
        let mut motor = Motor::default();
        motor.parameters.resistance_ohm = 8.25;
        motor.tolerance.insert("inertia_kg_m2".to_owned(), 0.1);
        motor
            .effects
            .set(ActiveEffect::new("backlash", &[0.02, 0.4, 1.0]).unwrap());
        motor
            .effects
            .set(ActiveEffect::new("coast_at_zero", &[]).unwrap());
        for (id, order) in [("cogging", 7.0), ("cogging#2", 28.0)] {
            let effect = ActiveEffect::new(id, &[0.01, order, 0.5]).unwrap();
            motor.effects.set(effect);
        }
        assert!(motor.to_toml().contains("\n[effects.\"cogging#2\"]\n"));
        assert_eq!(Motor::from_toml(&motor.to_toml()).unwrap(), motor);
    }

    #[test]
    fn an_unknown_key_names_its_line_and_the_nearest_known_one() {
        let error = Motor::from_toml("supply_v = 5\nresistence_ohm = 3").unwrap_err();
        assert_eq!(
            error.to_string(),
            "line 2: unknown key 'resistence_ohm'\nhint: did you mean 'resistance_ohm'? `motorlab motor --template` prints all keys"
        );
        let error = Motor::from_toml("[effects.backlas]\ngap_rad = 0.1").unwrap_err();
        assert!(
            error.to_string().starts_with(
                "line 1: there is no effect 'backlas'\nhint: did you mean 'backlash'?"
            )
        );
        let error = Motor::from_toml("[effects.backlash]\ngap = 0.1").unwrap_err();
        assert_eq!(
            error.to_string(),
            "line 2: effect 'backlash' has no parameter 'gap'\nhint: did you mean 'gap_rad'? `motorlab effects backlash` lists its parameters"
        );
        let error = Motor::from_toml("\n\n[tolerance]\nsuply_v = 0.1").unwrap_err();
        assert_eq!(
            error.to_string(),
            "line 4: unknown key 'tolerance.suply_v'\nhint: did you mean 'supply_v'? `motorlab motor --template` prints all keys"
        );
    }

    #[test]
    fn impossible_values_are_refused_with_their_line() {
        for (text, says) in [
            (
                "supply_v = \"five\"",
                "line 1: supply_v must be a finite number",
            ),
            (
                "\nresistance_ohm = 0",
                "line 2: resistance_ohm = 0 cannot be: expected 1e-6 .. 1000000 ohm",
            ),
            (
                "[tolerance]\nsupply_v = -1",
                "line 2: tolerance.supply_v = -1 cannot be: expected 0 .. 10 (a tolerance is relative",
            ),
            ("supply_v = ", "line 1: not TOML"),
            (
                "[effects.\"cogging#2\"]\n\ntorque_nm = -1",
                "line 1: torque_nm = -1 of effect 'cogging#2' cannot be",
            ),
            (
                "[effects.\"gravity_load#2\"]",
                "line 1: there is no effect 'gravity_load#2'\nhint: did you mean 'gravity_load'?",
            ),
            (
                "[effects.missed_counts]\nprobability = 1.5",
                "line 1: probability = 1.5 of effect 'missed_counts' cannot be",
            ),
        ] {
            let error = Motor::from_toml(text).unwrap_err().to_string();
            assert!(error.starts_with(says), "{error}");
        }
    }
}
