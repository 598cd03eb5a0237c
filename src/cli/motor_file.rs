//! Reading of a motor file: missing values are the lab handout's, which is reported.

use std::path::Path;

use super::{Failure, Output};
use crate::motor::{Motor, Parameters, read_motor_and_lacking};
use crate::plain::shown;

/// Reads a motor file and reports the values that are the handout's because the file lacks them: in a message, and in
/// the document of the command.
pub(super) fn motor_file(path: &Path, output: &Output) -> Result<Motor, Failure> {
    let (motor, lacking) =
        read_motor_and_lacking(path).map_err(|error| Failure::input(error).at(path))?;
    say(path, &lacking, output);
    Ok(motor)
}

/// Reports the parameters that this file leaves to the handout.
pub(super) fn say(path: &Path, lacking: &[&'static str], output: &Output) {
    if lacking.is_empty() {
        return;
    }
    let handout = Parameters::default();
    let values: Vec<(&str, f64)> = (lacking.iter())
        .filter_map(|key| Some((*key, handout.get(key)?)))
        .collect();
    let defaults: Vec<String> = values
        .iter()
        .map(|(key, value)| format!("{key} = {value}"))
        .collect();
    if !output.filled(path, &values) {
        return;
    }
    output.message(&format!(
        "{} lacks parameters; the lab handout's are used: {} (`motorlab motor --template` writes a whole file)",
        shown(path),
        defaults.join(", "),
    ));
}
