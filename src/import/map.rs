//! Mappings: quantity and unit of each column of a log.
//!
//! A value in SI is `(number * scale + offset) * unit`. docs/reference/import.md explains every key.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::MapError;
use super::cells::{Separator, number, without_groups};
use super::clock::Counts;
use super::error::RowProblem;
use super::map_file::MapFile;
use crate::recording::{CommandKind, Integration};

/// Longest mapping file in bytes.
const MOST_BYTES: u64 = 1 << 20;

/// A mapping, checked as far as possible without the log.
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
    /// Most runs made by restarts of the clock.
    pub(super) most_runs: Option<usize>,
    /// Decimation: one sample per this many rows.
    pub(super) every: u64,
    /// The encoder has no direction: the sign of the motion is the command's.
    pub(super) unsigned: bool,
}

/// Format of the log.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    pub separator: Option<Separator>,
    pub decimal_comma: bool,
    /// The mark between groups of three digits.
    pub thousands: Option<u8>,
    pub comment: String,
    pub skip_lines: u64,
    /// `None`: names, unless the first line is numeric and the mapping uses no names.
    pub names: Option<bool>,
    pub unit_lines: u64,
}

impl Shape {
    /// A cell as a finite number; `column` is used in the message.
    pub fn number(&self, cell: &[u8], column: &str) -> Result<f64, RowProblem> {
        match self.thousands {
            Some(mark) => number(&without_groups(cell, mark), self.decimal_comma, column),
            None => number(cell, self.decimal_comma, column),
        }
    }
}

/// A column, by its name or its number (from 1).
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
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

/// A column with the conversion to its unit.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub column: ColumnRef,
    pub scale: f64,
    pub offset: f64,
    /// Range of a counter that wraps, in the column's units.
    pub wrap: Option<f64>,
}

impl Field {
    /// The converted value of a number.
    pub fn value(&self, number: f64) -> f64 {
        number * self.scale + self.offset
    }
}

/// Source of time in s.
#[derive(Debug, Clone)]
pub(super) enum TimeSource {
    Column {
        field: Field,
        /// The column of its fraction, such as `nanosec` beside `sec`.
        fraction: Option<Field>,
        counts: Counts,
    },
    /// Row number times the mapping's sample time.
    RowNumber,
}

/// Source of the command in V, A or N m.
#[derive(Debug, Clone)]
pub(super) enum CommandSource {
    Number(CommandNumber),
    /// A profile: value by time.
    Profile {
        points: Vec<(f64, f64)>,
        line: bool,
    },
    NotRecorded,
}

/// A command in the log.
#[derive(Debug, Clone)]
pub(super) struct CommandNumber {
    pub from: NumberFrom,
    pub scale: f64,
    pub offset: f64,
    /// Full drive, if the command is a share of it: in V, or 1 for a measured supply.
    pub most: Option<f64>,
    /// A share of full drive times the supply measured in the same row.
    pub of_measured_supply: bool,
    /// The column of its direction, and the number or word for backwards.
    pub direction: Option<(ColumnRef, Backwards)>,
}

/// Source of a number in a row.
#[derive(Debug, Clone)]
pub(super) enum NumberFrom {
    Column(ColumnRef),
    /// A sum of factors times columns, clamped to the magnitude `limit`.
    Sum {
        terms: Vec<Term>,
        limit: Option<f64>,
    },
    /// The number after this word in the last comment line.
    Comment(String),
}

/// One term of a sum.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Term {
    pub column: ColumnRef,
    pub factor: f64,
}

impl NumberFrom {
    /// Its columns.
    pub fn columns(&self) -> Vec<&ColumnRef> {
        match self {
            Self::Column(column) => vec![column],
            Self::Sum { terms, .. } => terms.iter().map(|term| &term.column).collect(),
            Self::Comment(_) => Vec::new(),
        }
    }
}

/// Value of a direction column for a backward command.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub(super) enum Backwards {
    Number(f64),
    Word(String),
}

/// Source of the position in counts.
#[derive(Debug, Clone)]
pub(super) enum PositionSource {
    Column(Field),
    /// Counts since the previous row, which are summed.
    Increments(Field),
    /// Speed in counts/s, which is integrated.
    Speed {
        field: Field,
        rule: Integration,
        /// Time constant in s of the interpolation between rows; linear without one.
        curve: Option<f64>,
        /// Resolution of the log in counts/s.
        resolution: Option<f64>,
    },
    NotRecorded,
}

impl Map {
    /// The same for the text of a [`Table`](super::Table), ignoring keys for text files.
    #[must_use]
    pub fn for_table(mut self) -> Self {
        self.shape = Shape {
            separator: Some(Separator::Byte(b',')),
            decimal_comma: false,
            thousands: None,
            comment: String::new(),
            skip_lines: 0,
            names: Some(true),
            unit_lines: 0,
        };
        self
    }

    /// Whether a column is referred to by name.
    pub(super) fn asks_for_names(&self) -> bool {
        let measured = [&self.current, &self.supply];
        let columns = [
            self.time_column(),
            self.time_fraction().map(|field| &field.column),
            self.motion_column(),
            self.split_by.as_ref(),
            self.direction().map(|(column, _)| column),
        ];
        (columns.into_iter().flatten())
            .chain(self.command_columns())
            .chain(measured.into_iter().flatten().map(|field| &field.column))
            .any(|column| matches!(column, ColumnRef::Name(_)))
    }

    pub(super) fn time_column(&self) -> Option<&ColumnRef> {
        match &self.time {
            TimeSource::Column { field, .. } => Some(&field.column),
            TimeSource::RowNumber => None,
        }
    }

    /// The column of the fraction of the time, such as `nanosec` beside `sec`.
    pub(super) fn time_fraction(&self) -> Option<&Field> {
        match &self.time {
            TimeSource::Column { fraction, .. } => fraction.as_ref(),
            TimeSource::RowNumber => None,
        }
    }

    /// Whether the clock column is the time since the previous row.
    pub(super) fn counts_time_since_row_before(&self) -> bool {
        matches!(&self.time, TimeSource::Column { counts, .. } if *counts == Counts::SinceRowBefore)
    }

    /// Columns of the command or of its terms.
    pub(super) fn command_columns(&self) -> Vec<&ColumnRef> {
        match &self.command {
            CommandSource::Number(number) => number.from.columns(),
            CommandSource::Profile { .. } | CommandSource::NotRecorded => Vec::new(),
        }
    }

    /// The word of comment lines before the command.
    pub(super) fn command_word(&self) -> Option<&str> {
        match &self.command {
            CommandSource::Number(CommandNumber {
                from: NumberFrom::Comment(word),
                ..
            }) => Some(word),
            _ => None,
        }
    }

    /// The column of the direction, and the value for backwards.
    pub(super) fn direction(&self) -> Option<(&ColumnRef, &Backwards)> {
        match &self.command {
            CommandSource::Number(number) => {
                let (column, reverse) = number.direction.as_ref()?;
                Some((column, reverse))
            }
            CommandSource::Profile { .. } | CommandSource::NotRecorded => None,
        }
    }

    /// The column of the position or the speed.
    pub(super) fn motion_column(&self) -> Option<&ColumnRef> {
        match &self.position {
            PositionSource::Column(field)
            | PositionSource::Increments(field)
            | PositionSource::Speed { field, .. } => Some(&field.column),
            PositionSource::NotRecorded => None,
        }
    }

    /// Reads a mapping file.
    ///
    /// # Errors
    /// It cannot be read, is not TOML, or has invalid values; the message names section and key.
    pub fn read(path: &Path) -> Result<Self, MapError> {
        Self::from_toml(&Self::text(path)?).map_err(|error| Self::in_file(path, error))
    }

    /// The text of a mapping file.
    ///
    /// # Errors
    /// It cannot be read, or is too long.
    pub fn text(path: &Path) -> Result<String, MapError> {
        read_bounded(path).map_err(|source| MapError::Io {
            path: path.to_owned(),
            source,
        })
    }

    /// Adds the file to an error.
    pub fn in_file(path: &Path, error: MapError) -> MapError {
        MapError::InFile {
            path: path.to_owned(),
            error: Box::new(error),
        }
    }

    /// Parses the text of a mapping file.
    ///
    /// # Errors
    /// As [`Map::read`].
    pub fn from_toml(text: &str) -> Result<Self, MapError> {
        MapFile::parse(text)?.checked()
    }
}

/// The file's text, unless it is too long.
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
