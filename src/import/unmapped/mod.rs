//! Import without a mapping: names, numbers and a few flags determine it.
//!
//! [`understand`] reads the beginning of a log and returns a mapping as in a mapping file, or one error with all
//! missing facts and the complete command line. Facts that affect the verdict and follow neither from names nor from
//! values are requested.

mod centred;
mod clock;
mod clock_column;
mod clock_unit;
mod clock_units;
mod column;
mod column_names;
mod command;
mod commas;
mod decide;
mod direction;
mod drive;
mod file_name;
mod follows;
mod given;
mod grid;
mod marks;
mod motion;
mod name_words;
mod names;
mod over;
mod pulses;
mod readings;
mod seconds;
mod speed;
mod stated;
mod sum;
mod survey;
mod table;
mod thousands;
mod turns;
mod unclear;
mod units;

pub use decide::Understood;
pub use given::GivenFlags;
pub use over::map_over;
pub use unclear::{Missing, Unclear};
pub(super) use units::is_known;
pub use units::is_spelling_of;

use super::Map;
use super::lines::lines;
use super::map_file::MapFile;
use super::table::Table;
use crate::plain::quoted;

/// Bytes at the beginning of a log that are read.
pub const HEAD_BYTES: u64 = 4 << 20;

/// Message for an integration rule without a speed.
const NO_SPEED: &str =
    "--integrate is given, and no speed is read\nhint: --speed COLUMN:UNIT names one";

/// Interpretation of a log.
#[derive(Debug)]
pub struct Reading {
    /// The decisions.
    pub understood: Vec<Understood>,
    /// Further notes.
    pub notes: Vec<String>,
    /// The mapping, or the missing facts.
    pub map: Result<Ready, Unclear>,
}

/// A complete mapping.
#[derive(Debug)]
pub struct Ready {
    /// In memory.
    pub map: Map,
    /// As a mapping file.
    pub toml: String,
}

impl Ready {
    /// From a mapping file's content.
    fn of(file: MapFile) -> Result<Self, Unclear> {
        let toml = toml::to_string(&file).map_err(|error| Unclear::Unwritten(error.to_string()))?;
        let map = file.checked()?;
        Ok(Self { map, toml })
    }
}

/// Makes a mapping from a log's beginning (complete if `is_whole`) and the given facts. `command` is the command line
/// so far, to which the error about missing facts adds flags.
pub fn understand(
    head: &[u8],
    is_whole: bool,
    file_name: &str,
    given: &GivenFlags,
    command: &str,
) -> Reading {
    if let Err(problem) = lines(head) {
        return Reading {
            understood: Vec::new(),
            notes: Vec::new(),
            map: Err(Unclear::NoText(problem.to_string())),
        };
    }
    let survey = match survey::survey(head, is_whole) {
        Ok(survey) => survey,
        Err(first_lines) => {
            return Reading {
                understood: Vec::new(),
                notes: Vec::new(),
                map: Err(Unclear::NoTable(first_lines)),
            };
        }
    };
    decided(&survey, file_name, given, command)
}

/// The same for a table, whose format is known. A mapping by column names fits it regardless of its keys for text
/// files.
pub fn understand_table(
    table: &Table,
    file_name: &str,
    given: &GivenFlags,
    command: &str,
) -> Reading {
    let survey = survey::of_table(table);
    let mut reading = decided(&survey, file_name, given, command);
    reading.notes.splice(0..0, table.notes.iter().cloned());
    reading
}

fn decided(survey: &survey::Survey, file_name: &str, given: &GivenFlags, command: &str) -> Reading {
    let mut decision = decide::Decision::new(survey, given, file_name);
    let decided = decision.decide();
    let map = decided.and_then(|()| match decision.missing.is_empty() {
        true if given.integrate.is_some() && decision.map.speed.is_none() => {
            Err(Unclear::Conflict(NO_SPEED))
        }
        true => {
            let mut file = decision.map.clone();
            // The line of names is found by the names: another log may have another banner.
            if file.clone().checked()?.asks_for_names() {
                file.file.skip_lines = 0;
            }
            Ready::of(file)
        }
        false => Err(Unclear::Missing {
            missing: decision.missing.clone(),
            line: finished(command, &decision.line),
            flags: decision.line.clone(),
        }),
    });
    Reading {
        understood: decision.understood,
        notes: decision.notes,
        map,
    }
}

fn finished(command: &str, flags: &[(&'static str, String)]) -> String {
    let mut line = command.to_owned();
    for (flag, value) in flags {
        line.push(' ');
        line.push_str(flag);
        if !value.is_empty() {
            line.push(' ');
            line.push_str(&quoted(value));
        }
    }
    line
}
