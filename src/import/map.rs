//! A mapping: which column of a log is what, and in which unit.
//!
//! A value in SI is `(number * scale + offset) * unit`. docs/import.md explains every key.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::Deserialize;

use super::MapError;
use super::cells::Separator;
use super::map_file::MapFile;
use crate::recording::CommandKind;

/// Longest mapping file in bytes.
const MOST_BYTES: u64 = 1 << 20;

/// A mapping, checked: everything that can be known without the log.
#[derive(Debug, Clone)]
pub struct Map {
    pub(super) counts_per_rev: f64,
    pub(super) supply_v: Option<f64>,
    pub(super) sample_time_s: Option<f64>,
    pub(super) header: toml::Table,
    pub(super) shape: Shape,
    pub(super) time: TimeSource,
    pub(super) command: CommandSource,
    pub(super) command_kind: CommandKind,
    pub(super) position: PositionSource,
    pub(super) current: Option<Field>,
    pub(super) supply: Option<Field>,
    pub(super) split_by: Option<ColumnRef>,
    /// An empty cell of the command holds its last value; a row without a position only changes the command.
    pub(super) holds: bool,
}

/// How the log is laid out.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    pub separator: Option<Separator>,
    pub decimal_comma: bool,
    pub comment: String,
    pub skip_lines: u64,
    /// `None`: names, unless the first line has numbers only and the mapping asks for no name.
    pub names: Option<bool>,
    pub unit_lines: u64,
}

/// A column, by its name or its number (the first is 1).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "a column is a name, or a number (the first is 1)"
)]
pub(super) enum ColumnRef {
    /// Its number, from 1.
    Number(usize),
    /// Its name.
    Name(String),
}

/// A column and the way from its numbers to the unit wanted.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub column: ColumnRef,
    pub scale: f64,
    pub offset: f64,
    /// A counter that goes round: its range, in the column's own numbers.
    pub wrap: Option<f64>,
}

impl Field {
    /// The value of one number of the column.
    pub fn value(&self, number: f64) -> f64 {
        number * self.scale + self.offset
    }
}

/// Where time comes from, in s.
#[derive(Debug, Clone)]
pub(super) enum TimeSource {
    Column(Field),
    /// Row number times the mapping's sample time.
    RowNumber,
}

/// Where the command comes from, in V, A or N m.
#[derive(Debug, Clone)]
pub(super) enum CommandSource {
    Column(Field),
    /// A share of full drive times the supply measured in the same row.
    OfMeasuredSupply(Field),
    /// Known from elsewhere: value by time.
    Profile {
        points: Vec<(f64, f64)>,
        line: bool,
    },
    NotRecorded,
}

/// Where the position comes from, in counts.
#[derive(Debug, Clone)]
pub(super) enum PositionSource {
    Column(Field),
    /// Speed, in counts a second, summed up.
    Speed {
        field: Field,
        rule: Integration,
    },
    NotRecorded,
}

/// How a speed becomes a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Integration {
    /// The mean of two neighbours holds between them: for a speed of the instant.
    #[default]
    Trapezoid,
    /// A row's speed held since the row before: for a speed that was made from differences of position.
    Backward,
    /// A row's speed held until the row after: for one that was measured under the command of the same row.
    Forward,
}

impl Map {
    /// Whether a column is asked for by its name.
    pub(super) fn asks_for_names(&self) -> bool {
        let measured = [&self.current, &self.supply];
        let columns = [
            self.time_column(),
            self.command_column(),
            self.motion_column(),
            self.split_by.as_ref(),
        ];
        (columns.into_iter().flatten())
            .chain(measured.into_iter().flatten().map(|field| &field.column))
            .any(|column| matches!(column, ColumnRef::Name(_)))
    }

    /// Where the times stand.
    pub(super) fn time_column(&self) -> Option<&ColumnRef> {
        match &self.time {
            TimeSource::Column(field) => Some(&field.column),
            TimeSource::RowNumber => None,
        }
    }

    /// Where the command stands.
    pub(super) fn command_column(&self) -> Option<&ColumnRef> {
        match &self.command {
            CommandSource::Column(field) | CommandSource::OfMeasuredSupply(field) => {
                Some(&field.column)
            }
            CommandSource::Profile { .. } | CommandSource::NotRecorded => None,
        }
    }

    /// Where the position or the speed stands.
    pub(super) fn motion_column(&self) -> Option<&ColumnRef> {
        match &self.position {
            PositionSource::Column(field) | PositionSource::Speed { field, .. } => {
                Some(&field.column)
            }
            PositionSource::NotRecorded => None,
        }
    }

    /// Reads a mapping file.
    ///
    /// # Errors
    /// It cannot be read, is not TOML, or says what cannot be; the message names section and key.
    pub fn read(path: &Path) -> Result<Self, MapError> {
        let text = read_bounded(path).map_err(|source| MapError::Io {
            path: path.to_owned(),
            source,
        })?;
        Self::from_toml(&text).map_err(|error| MapError::InFile {
            path: path.to_owned(),
            error: Box::new(error),
        })
    }

    /// Takes the text of a mapping file.
    ///
    /// # Errors
    /// As [`Map::read`].
    pub fn from_toml(text: &str) -> Result<Self, MapError> {
        MapFile::parse(text)?.checked()
    }
}

/// The whole file, unless it is longer than any mapping.
fn read_bounded(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let file = File::open(path)?;
    file.take(MOST_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MOST_BYTES {
        let message = format!("it is longer than {MOST_BYTES} bytes: this is no mapping file");
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    Ok(text)
}
