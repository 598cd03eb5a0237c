//! `virtual:?effect=backlash&gap_rad=0.02&seed=7`: a virtual board and its motor as a port name.
//!
//! Keys after `effect=ID` are that effect's parameters; the others are the motor file, its parameters, and properties
//! of the board and its line.

use std::path::PathBuf;
use std::time::Duration;

use super::{Failure, Output, motor_file};
use crate::board::{Pace, VirtualBoard, VirtualBoardOptions};
use crate::motor::catalogue::{EffectError, EffectKind, find};
use crate::motor::{
    ActiveEffect, Motor, MotorFileError, Parameters, Plant, SimulationError, nearest_name,
};
use crate::recording::CommandKind;

/// Prefix of such a word.
pub(super) const PREFIX: &str = "virtual:";

/// Correction of a port that is almost a virtual board's name.
pub(super) fn nearly(port: &str) -> Option<Failure> {
    let rest = port.strip_prefix("virtual")?;
    let is_word = rest.is_empty() || rest.starts_with(['?', '=', '/']);
    let keys = rest.trim_start_matches(['?', '=', '/', ':']);
    (is_word && !std::path::Path::new(port).exists()).then(|| {
        let meant = if keys.is_empty() { "" } else { "?" };
        Failure::wrong(
            format!("there is no port {port}"),
            format!(
                "a virtual board has a colon after its name: did you mean 'virtual:{meant}{keys}'?"
            ),
        )
    })
}

/// Keys of the board and its line, with their meaning.
pub(super) const BOARD_KEYS: [(&str, &str); 18] = [
    ("motor", "motor file"),
    (
        "seed",
        "seed of the motor's random effects and of the line's faults",
    ),
    ("speed", "1 (real time), a factor, or max"),
    (
        "clock_ppm",
        "how much faster the board's clock runs, in parts per million",
    ),
    ("micros_start", "the board's micros() at power-on"),
    ("counter_bits", "32 or 16"),
    ("boot_ms", "time from reset to HELLO"),
    ("banner", "text before HELLO"),
    ("name", "what the board calls itself"),
    ("boot_id", "number of the first reset"),
    ("drop", "probability that a byte is lost"),
    ("flip", "probability that a bit of a byte is flipped"),
    ("duplicate", "probability that a byte arrives twice"),
    (
        "stall",
        "probability that the line stands still before a byte",
    ),
    ("stall_ms", "how long it then stands still"),
    ("split", "1: every byte comes by itself"),
    ("silent_after", "bytes after which the line falls silent"),
    ("hang_up_after", "bytes after which the board is unplugged"),
];

/// A specification of a virtual board.
#[derive(Debug, Clone)]
pub(super) struct VirtualSpec {
    /// The motor on the bench.
    pub motor: Motor,
    /// Its motor file, if there is one, and the keys missing in it.
    file: Option<(PathBuf, Vec<&'static str>)>,
    /// Seed of its random effects.
    pub seed: u64,
    /// The board and its line.
    pub options: VirtualBoardOptions,
}

#[derive(Debug, thiserror::Error)]
pub(super) enum SpecError {
    #[error(
        "'{0}' is no `key=value`\nhint: a virtual board is named like virtual:?effect=backlash&seed=7"
    )]
    NotAPair(String),
    #[error(
        "a virtual board has no key '{key}'\nhint: {}`motorlab virtual --help` lists them",
        hint(nearest)
    )]
    UnknownKey {
        key: String,
        nearest: Option<&'static str>,
    },
    #[error(
        "{key}={value}: expected {expected}\nhint: `motorlab virtual --help` lists the keys of a virtual board with their values"
    )]
    Value {
        key: String,
        value: String,
        expected: &'static str,
    },
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(transparent)]
    Motor(#[from] MotorFileError),
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    #[error("the line to a virtual board cannot be opened: {0}")]
    Line(#[from] std::io::Error),
}

fn hint(nearest: &Option<&'static str>) -> String {
    nearest.map_or(String::new(), |name| format!("did you mean '{name}'? "))
}

impl VirtualSpec {
    /// Parses the text after `virtual:`.
    pub(super) fn parse(text: &str) -> Result<Self, SpecError> {
        let pairs = pairs(text.strip_prefix('?').unwrap_or(text))?;
        let mut spec = Self {
            motor: Motor::default(),
            file: None,
            seed: 0,
            options: VirtualBoardOptions::default(),
        };
        // The file first: other keys override its values.
        if let Some((_, path)) = pairs.iter().find(|(key, _)| key == "motor") {
            let path = PathBuf::from(path);
            let (motor, lacking) = crate::motor::read_motor_and_lacking(&path)?;
            spec.motor = motor;
            spec.file = Some((path, lacking));
        }
        let mut effects: Vec<(String, Vec<(String, f64)>)> = Vec::new();
        for (key, value) in &pairs {
            let belongs = effects.last().and_then(|(id, _)| find(id));
            let of_effect = belongs
                .is_some_and(|(_, kind)| kind.parameters.iter().any(|known| known.key == key));
            match key.as_str() {
                "effect" => effects.push((value.clone(), Vec::new())),
                _ if of_effect => {
                    let number = number(key, value)?;
                    if let Some((_, given)) = effects.last_mut() {
                        given.push((key.clone(), number));
                    }
                }
                _ => spec.set(key, value, belongs.map(|(_, kind)| kind))?,
            }
        }
        for (id, given) in &effects {
            let given = given.iter().map(|(key, value)| (key.as_str(), *value));
            let effect = ActiveEffect::from_keys(id, given, &spec.motor.parameters)?;
            spec.motor.effects.set(effect);
        }
        Ok(spec)
    }

    fn set(
        &mut self,
        key: &str,
        value: &str,
        effect: Option<&EffectKind>,
    ) -> Result<(), SpecError> {
        let VirtualBoardOptions {
            firmware, faults, ..
        } = &mut self.options;
        match key {
            "motor" => {}
            "seed" => {
                self.seed = whole(key, value)?;
                faults.seed = self.seed;
            }
            "speed" => self.options.pace = pace(value)?,
            "clock_ppm" => firmware.clock_ppm = clock_ppm(key, value)?,
            "micros_start" => firmware.micros_at_start = whole(key, value)? as u32,
            "counter_bits" => {
                firmware.counts_16_bit = match value {
                    "16" => true,
                    "32" => false,
                    _ => return Err(wrong(key, value, "16 or 32")),
                }
            }
            "boot_ms" => self.options.boot = Duration::from_millis(whole(key, value)?),
            "banner" => self.options.banner = value.replace("\\n", "\r\n"),
            "name" => firmware.name = value.to_owned(),
            "boot_id" => firmware.boot_id = whole(key, value)? as u32,
            "drop" => faults.drop = probability(key, value)?,
            "flip" => faults.flip = probability(key, value)?,
            "duplicate" => faults.duplicate = probability(key, value)?,
            "stall" => faults.stall = probability(key, value)?,
            "stall_ms" => faults.stall_for = Duration::from_millis(whole(key, value)?),
            "split" => faults.split = value == "1",
            "silent_after" => faults.silent_after = Some(whole(key, value)?),
            "hang_up_after" => faults.hang_up_after = Some(whole(key, value)?),
            _ => match self.motor.parameters.get_mut(key) {
                Some(parameter) => *parameter = number(key, value)?,
                None => {
                    return Err(SpecError::UnknownKey {
                        key: key.to_owned(),
                        nearest: nearest_key(key, effect),
                    });
                }
            },
        }
        Ok(())
    }

    /// The same, after reporting the missing values of its motor file.
    pub(super) fn with_reported_gaps(self, output: &Output) -> Self {
        if let Some((path, lacking)) = &self.file {
            motor_file::say(path, lacking, output);
        }
        self
    }

    /// Plugs the board in for this program, with its motor at rest; messages call it `name`.
    pub(super) fn plug_in(self, name: &str) -> Result<VirtualBoard, SpecError> {
        let plant = Plant::new(&self.motor, CommandKind::Voltage, self.seed)?;
        Ok(VirtualBoard::in_process(name, plant, self.options)?)
    }

    /// Plugs the board in at a port for other programs.
    #[cfg(unix)]
    pub(super) fn offer(self) -> Result<VirtualBoard, SpecError> {
        let plant = Plant::new(&self.motor, CommandKind::Voltage, self.seed)?;
        Ok(VirtualBoard::spawn(plant, self.options)?)
    }
}

/// The known key most similar to `key`; the parameters of the effect before it come first.
fn nearest_key(key: &str, effect: Option<&EffectKind>) -> Option<&'static str> {
    let of_effect = effect.map_or(&[][..], |kind| kind.parameters);
    let others = BOARD_KEYS.iter().map(|(name, _)| *name).chain(["effect"]);
    nearest_name(key, of_effect.iter().map(|parameter| parameter.key))
        .or_else(|| nearest_name(key, others.chain(Parameters::KEYS)))
}

fn wrong(key: &str, value: &str, expected: &'static str) -> SpecError {
    SpecError::Value {
        key: key.to_owned(),
        value: value.to_owned(),
        expected,
    }
}

fn number(key: &str, value: &str) -> Result<f64, SpecError> {
    let number = value.parse::<f64>().ok().filter(|n| n.is_finite());
    number.ok_or_else(|| wrong(key, value, "a number"))
}

/// Largest rate error of a clock: ten times that of any resonator.
const MOST_PPM: f64 = 500_000.0;

fn clock_ppm(key: &str, value: &str) -> Result<f64, SpecError> {
    let ppm = number(key, value)?;
    match ppm.abs() <= MOST_PPM {
        true => Ok(ppm),
        false => Err(wrong(
            key,
            value,
            "parts per million from -500000 to 500000",
        )),
    }
}

fn whole(key: &str, value: &str) -> Result<u64, SpecError> {
    value
        .parse()
        .map_err(|_| wrong(key, value, "a whole number"))
}

fn probability(key: &str, value: &str) -> Result<f64, SpecError> {
    let probability = number(key, value)?;
    if (0.0..=1.0).contains(&probability) {
        Ok(probability)
    } else {
        Err(wrong(key, value, "a probability from 0 to 1"))
    }
}

fn pace(value: &str) -> Result<Pace, SpecError> {
    match value {
        "max" => Ok(Pace::AsFastAsPossible),
        "1" => Ok(Pace::RealTime),
        factor => match factor.parse::<f64>() {
            Ok(factor) if factor > 0.0 && factor.is_finite() => Ok(Pace::Times(factor)),
            _ => Err(wrong("speed", value, "1, a factor, or max")),
        },
    }
}

/// Splits `a=1&b=2` and decodes `%xx` as in a URL.
fn pairs(text: &str) -> Result<Vec<(String, String)>, SpecError> {
    text.split('&')
        .filter(|pair| !pair.is_empty())
        .map(|pair| {
            let (key, value) = pair
                .split_once('=')
                .ok_or_else(|| SpecError::NotAPair(pair.to_owned()))?;
            Ok((key.to_owned(), unescape(value)))
        })
        .collect()
}

fn unescape(value: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = value.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let escaped = (first == b'%')
            .then(|| std::str::from_utf8(after.get(..2)?).ok())
            .flatten()
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match escaped {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
