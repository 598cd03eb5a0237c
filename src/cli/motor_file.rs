//! Reading a motor file that somebody wrote: what it leaves out is the lab handout's, and that is said.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::{Failure, Output};
use crate::motor::{Motor, MotorFileError, Parameters};
use crate::plain::shown;

/// Longest motor file in bytes: a thousand times a whole one.
const MOST_BYTES: u64 = 1 << 20;

/// Reads a motor file and says which numbers are the handout's because the file lacks them: in a message, and in the
/// document that the command prints.
pub(super) fn motor_file(path: &Path, output: &Output) -> Result<Motor, Failure> {
    let (motor, lacking) = read(path).map_err(|error| Failure::input(error).at(path))?;
    say(path, &lacking, output);
    Ok(motor)
}

/// Says which numbers of the motor in this file are the handout's.
pub(super) fn say(path: &Path, lacking: &[&'static str], output: &Output) {
    if lacking.is_empty() {
        return;
    }
    let handout = Parameters::default();
    let values: Vec<(&str, f64)> = (lacking.iter())
        .filter_map(|key| Some((*key, handout.get(key)?)))
        .collect();
    let said: Vec<String> = values
        .iter()
        .map(|(key, value)| format!("{key} = {value}"))
        .collect();
    if !output.filled(path, &values) {
        return;
    }
    output.message(&format!(
        "{} lacks numbers of the motor; the lab handout's stand in: {} (`motorlab motor --template` writes a whole file)",
        shown(path),
        said.join(", "),
    ));
}

/// The motor in a file, and the keys that the file lacks.
pub(super) fn read(path: &Path) -> Result<(Motor, Vec<&'static str>), MotorFileError> {
    let text = bounded(path).map_err(|source| MotorFileError::Io {
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

/// The whole file, unless it is longer than any motor file.
fn bounded(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let file = File::open(path)?.take(MOST_BYTES + 1);
    io::BufReader::new(file).read_to_string(&mut text)?;
    if text.len() as u64 > MOST_BYTES {
        let message = format!("it is longer than {MOST_BYTES} bytes: this is no motor file");
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    Ok(text)
}
