//! Errors and notes of reading a run file.

use std::fmt;
use std::io;

use crate::plain::shown;
use thiserror::Error;

/// Why a run file cannot be read: file, place, remedy.
#[derive(Debug, Error)]
#[error("{file}: {problem}", file = shown(file))]
pub struct ReadError {
    /// The file, or another name of the source.
    pub file: String,
    /// The error.
    pub problem: ReadProblem,
}

/// Error in a run file. Rows are lines of the file, counted from 1.
#[derive(Debug, Error)]
pub enum ReadProblem {
    /// It cannot be opened or read.
    #[error("cannot be read: {0}")]
    Io(io::Error),
    /// The `#` lines are no TOML document.
    #[error(
        "line {line}: the header (the lines that start with #) is not TOML: {message}\nhint: each of them is `# KEY = VALUE`, and a text stands in quotes"
    )]
    HeaderToml {
        /// Line of the file.
        line: usize,
        /// Message of the TOML reader.
        message: String,
    },
    /// A header key is missing.
    #[error("the header lacks `{key}`\nhint: add a line `# {key} = {example}` at the top")]
    MissingKey {
        /// The key.
        key: &'static str,
        /// An example value.
        example: &'static str,
    },
    /// A header key has an invalid value.
    #[error(
        "header key `{key}` is {found}, but must be {expected}\nhint: correct the line `# {key} = ...` at the top of the file"
    )]
    BadKey {
        /// The key.
        key: &'static str,
        /// Its value.
        found: String,
        /// Expected value.
        expected: String,
    },
    /// An unknown `differs` key, or an impossible value.
    #[error("header key `differs`: {0}")]
    Differs(#[source] crate::motor::KnownError),
    /// A format that this version does not read.
    #[error(
        "has format `{0}`, and this version reads `motorlab-run/1`\nhint: read it with the newer motorlab that wrote it"
    )]
    Format(String),
    /// No line of column names.
    #[error(
        "has no rows\nhint: after the header comes a line of column names, such as t_s,command_v,counts"
    )]
    NoColumns,
    /// A required column is missing.
    #[error(
        "line {line} names no column `{column}` (it names: {found})\nhint: `motorlab import` turns other logs into run files"
    )]
    MissingColumn {
        /// Line of the column names.
        line: u64,
        /// The missing column.
        column: &'static str,
        /// The existing columns.
        found: String,
    },
    /// A column is named twice.
    #[error("line {line} names column `{column}` twice\nhint: rename or remove one of them")]
    ColumnTwice {
        /// Line of the column names.
        line: u64,
        /// The column.
        column: String,
    },
    /// A row has more or fewer cells than there are columns.
    #[error(
        "row {row} has {found} cells where the columns are {expected}\nhint: complete the row, or remove it"
    )]
    CellCount {
        /// Line of the file.
        row: u64,
        /// Its number of cells.
        found: usize,
        /// Number of columns.
        expected: usize,
    },
    /// A cell is invalid in its column.
    #[error(
        "row {row}, column `{column}`: `{found}` is not {expected}\nhint: correct the cell, or remove the row"
    )]
    BadCell {
        /// Line of the file.
        row: u64,
        /// The column.
        column: &'static str,
        /// The cell, clipped.
        found: String,
        /// Expected value.
        expected: &'static str,
    },
    /// A number that no motor, encoder or clock gives.
    #[error(
        "row {row}, column `{column}`: {found} lies outside {range}\nhint: check the unit of the column; correct the cell, or remove the row"
    )]
    Implausible {
        /// Line of the file.
        row: u64,
        /// The column.
        column: &'static str,
        /// The number.
        found: String,
        /// Valid range.
        range: String,
    },
    /// Time does not increase.
    #[error(
        "row {row}, column `t_s`: time goes from {before} s to {after} s, and it must rise from row to row\nhint: where two recordings are in one file, cut it there; else remove the row"
    )]
    TimeNotRising {
        /// Line of the file.
        row: u64,
        /// Time of the previous row.
        before: f64,
        /// Time of this row.
        after: f64,
    },
    /// Time jumps.
    #[error(
        "row {row}, column `t_s`: time leaps from {before} s to {after} s\nhint: a recording with a gap of more than an hour is two: cut the file there"
    )]
    TimeJumps {
        /// Line of the file.
        row: u64,
        /// Time of the previous row.
        before: f64,
        /// Time of this row.
        after: f64,
    },
    /// More rows than are read into memory.
    #[error("has more than {rows} rows, as many as are read\nhint: cut it into parts")]
    TooLong {
        /// Most rows read.
        rows: usize,
    },
    /// Only a header and column names.
    #[error(
        "has column names, but not one whole row\nhint: record again; `motorlab replay LOG -o run.csv` makes the run from a raw log"
    )]
    Empty,
}

impl ReadProblem {
    /// Line of the file, if the problem has one.
    pub fn row(&self) -> Option<u64> {
        match self {
            Self::HeaderToml { line, .. } => Some(*line as u64),
            Self::MissingColumn { line, .. } | Self::ColumnTwice { line, .. } => Some(*line),
            Self::CellCount { row, .. }
            | Self::BadCell { row, .. }
            | Self::Implausible { row, .. }
            | Self::TimeNotRising { row, .. }
            | Self::TimeJumps { row, .. } => Some(*row),
            _ => None,
        }
    }
}

/// A note about a run that was read.
#[derive(Debug, Clone, PartialEq)]
pub enum ReadNote {
    /// The last row was incomplete, as after a crash, and ignored.
    TornTail {
        /// Line of the file.
        row: u64,
    },
    /// The header has no `complete = true`: samples are missing, or the recording ended irregularly.
    NotComplete,
    /// The header has no `sample_time_s`: the median step of `t_s` is used.
    SampleTimeGuessed {
        /// The value used.
        sample_time_s: f64,
    },
    /// The header has `timing = "host"`: times are arrival times.
    HostTimed,
    /// The first row's time was not 0 and is used as the origin.
    OriginShifted {
        /// The first row's time.
        first_s: f64,
    },
    /// Unknown columns.
    ColumnsLeftOut {
        /// Their names.
        names: Vec<String>,
    },
}

impl fmt::Display for ReadNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TornTail { row } => write!(f, "row {row} is torn off and was left out"),
            Self::NotComplete => f.write_str("not everything that was asked for is in it, or the recording did not end properly (no `complete = true`); all whole rows were read"),
            Self::SampleTimeGuessed { sample_time_s } => write!(
                f,
                "the header has no sample_time_s; took the median step of t_s, {sample_time_s} s"
            ),
            Self::HostTimed => f.write_str(
                "its timing is the host's (`timing = \"host\"`), late by milliseconds and bunched: not to be trusted from sample to sample",
            ),
            Self::OriginShifted { first_s } => {
                write!(f, "time begins at {first_s} s; took that as the origin")
            }
            Self::ColumnsLeftOut { names } => {
                let shown = &names[..names.len().min(20)];
                write!(f, "columns without a meaning here were left out: {}", shown.join(", "))?;
                match names.len() - shown.len() {
                    0 => Ok(()),
                    more => write!(f, " and {more} more"),
                }
            }
        }
    }
}
