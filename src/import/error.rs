//! Errors of an import, and reasons for rejected rows.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::lines::{MAX_LINE_BYTES, MOST_LINE_BYTES};
use crate::plain::shown;
use crate::recording::WriteError;

/// Errors of a mapping file.
#[derive(Debug, Error)]
pub enum MapError {
    /// The file cannot be read.
    #[error("{}: {source}", shown(path))]
    Io {
        /// The mapping file.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// It is not TOML, or has an unknown key.
    #[error("line {line}: {message}\nhint: docs/reference/import.md lists the keys of a mapping")]
    Toml {
        /// Line, from 1.
        line: usize,
        /// Message of the TOML reader.
        message: String,
    },
    /// A missing key.
    #[error("{section} lacks `{key}`\nhint: {why}")]
    Missing {
        /// The section.
        section: &'static str,
        /// The key.
        key: &'static str,
        /// Purpose.
        why: &'static str,
    },
    /// An invalid value.
    #[error(
        "{section}: `{key}` is {found}, but must be {expected}\nhint: correct `{key}` in the mapping; docs/reference/import.md lists its keys"
    )]
    Value {
        /// The section.
        section: &'static str,
        /// The key.
        key: &'static str,
        /// Its value.
        found: String,
        /// Expected value.
        expected: String,
    },
    /// An unknown key of `differs`, or an impossible value.
    #[error("[differs]: {0}")]
    Differs(#[source] crate::motor::KnownError),
    /// Keys that exclude each other.
    #[error("{section}: {what}")]
    Conflict {
        /// The section.
        section: &'static str,
        /// Keys that exclude each other.
        what: &'static str,
    },
    /// An error in a file.
    #[error("{}: {error}", shown(path))]
    InFile {
        /// The file.
        path: PathBuf,
        /// The error.
        error: Box<MapError>,
    },
}

impl MapError {
    /// The file and its line, if known.
    pub fn place(&self) -> (Option<&Path>, Option<u64>) {
        match self {
            Self::Io { path, .. } => (Some(path), None),
            Self::InFile { path, error } => (Some(path), error.place().1),
            Self::Toml { line, .. } => (None, Some(*line as u64)),
            _ => (None, None),
        }
    }
}

/// Why a log cannot be imported.
#[derive(Debug, Error)]
#[error("{file}: {problem}", file = shown(file))]
pub struct ImportError {
    /// The log, as given.
    pub file: String,
    /// Error.
    pub problem: ImportProblem,
}

/// Errors of a log. Lines are counted from 1.
#[derive(Debug, Error)]
pub enum ImportProblem {
    /// The log cannot be opened or read, or its compressed data are damaged.
    #[error("cannot be read beyond line {line}: {source}")]
    Read {
        /// The last line read.
        line: u64,
        /// Cause.
        source: io::Error,
    },
    /// It is not text.
    #[error("is no text: {0}")]
    NoText(&'static str),
    /// A line without an end.
    #[error(
        "line {line} is longer than {MOST_LINE_BYTES} bytes: this is no log of text lines\nhint: save it as CSV, one row per sample"
    )]
    EndlessLine {
        /// The line.
        line: u64,
    },
    /// A column of the mapping is missing.
    #[error("line {line} names no column `{column}`\nhint: {nearest}the columns are {found}")]
    NoSuchColumn {
        /// Line of the column names.
        line: u64,
        /// The column in the mapping.
        column: String,
        /// A similar name.
        nearest: String,
        /// The existing names.
        found: String,
    },
    /// A column number is out of range.
    #[error(
        "line {line} has {found} columns, and the mapping asks for column {column}\nhint: correct the number in the mapping (the first is 1), or its `delimiter`"
    )]
    NoSuchNumber {
        /// The line.
        line: u64,
        /// The column in the mapping, from 1.
        column: usize,
        /// Number of columns.
        found: usize,
    },
    /// A column name for a log without names.
    #[error(
        "the mapping asks for column `{0}` by name, but says `names = false`\nhint: give its number (the first is 1)"
    )]
    NameWithoutNames(String),
    /// No row is usable.
    #[error("{}", no_rows(.rows, .first))]
    NoRows {
        /// Number of rows.
        rows: u64,
        /// The first of them with its reason.
        first: Option<Box<BadRow>>,
    },
    /// The first rows are all rejected.
    #[error(
        "the first {rows} rows cannot be used, so the mapping does not fit this log; the first of them: {first}\n\
         hint: correct the mapping at that column, or let the import find it: leave --map out"
    )]
    AllBad {
        /// Number of rows.
        rows: u64,
        /// The first of them with its reason.
        first: Box<BadRow>,
    },
    /// Too many runs.
    #[error(
        "line {line} would begin run {runs}: `split_by` names a column that changes too often\nhint: name another column under [rows], or leave `split_by` out"
    )]
    TooManyRuns {
        /// The line.
        line: u64,
        /// Number of runs.
        runs: usize,
    },
    /// The clock restarts more often than the default limit.
    #[error(
        "line {line}: the clock begins anew and would begin run {runs} of this log, so its column may be no clock\n\
         hint: name the clock, as --time COLUMN:UNIT or --time 10ms for rows 10 ms apart; where the log does hold so many \
         recordings: --runs 1000"
    )]
    ClockFalls {
        /// The line.
        line: u64,
        /// Number of runs.
        runs: usize,
    },
    /// A pause longer than a run file may have.
    #[error(
        "line {line}: time leaps from {before} s to {after} s\nhint: a recording with a gap of more than an hour is two: cut the log there"
    )]
    TimeJumps {
        /// The line.
        line: u64,
        /// Time of the previous row.
        before: f64,
        /// Time of this row.
        after: f64,
    },
    /// More rows than a run file may have.
    #[error(
        "line {line} is beyond {rows} rows, as many as a run has\nhint: cut the log into parts, or give [rows] a `split_by` or `every`"
    )]
    TooLong {
        /// The line.
        line: u64,
        /// Most rows of a run.
        rows: u64,
    },
    /// A sample time that no run file may have.
    #[error(
        "the samples come every {sample_time_s} s, which lies outside {range}\nhint: correct the unit of the time: --time COLUMN:UNIT, or `unit` under [time] of the mapping"
    )]
    SampleTime {
        /// The median step.
        sample_time_s: f64,
        /// Valid range.
        range: String,
    },
    /// The run cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The file of rejected rows cannot be written.
    #[error("the file of rejected rows {path} cannot be written: {source}", path = shown(path))]
    Rejected {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
}

impl ImportProblem {
    /// Line of the error in the log, if known.
    pub fn line(&self) -> Option<u64> {
        match self {
            Self::Read { line, .. }
            | Self::EndlessLine { line }
            | Self::NoSuchColumn { line, .. }
            | Self::NoSuchNumber { line, .. }
            | Self::TooManyRuns { line, .. }
            | Self::ClockFalls { line, .. } => Some(*line),
            Self::AllBad { first, .. }
            | Self::NoRows {
                first: Some(first), ..
            } => Some(first.line),
            _ => None,
        }
    }
}

fn no_rows(rows: &u64, first: &Option<Box<BadRow>>) -> String {
    match first {
        Some(first) => format!(
            "none of its {rows} rows can be used; the first of them: {first}\n\
             hint: name the columns and units yourself, such as --position COLUMN:UNIT, or correct the mapping"
        ),
        None => "has no rows\nhint: record again, or name another log".to_owned(),
    }
}

/// A rejected row with its reason.
#[derive(Debug, Clone, PartialEq, Eq, Error, serde::Serialize)]
#[error("line {line}: {why}")]
pub struct BadRow {
    /// Line of the log.
    pub line: u64,
    /// Error in it.
    pub why: String,
}

#[derive(Debug, Clone, PartialEq, Error)]
pub(super) enum RowProblem {
    #[error("the line is longer than {MAX_LINE_BYTES} bytes")]
    TooLong,
    #[error("{found} cells where the columns are {expected}")]
    CellCount { found: usize, expected: usize },
    #[error("column {column}: `{found}` is not a finite number")]
    NotANumber { column: String, found: String },
    #[error(
        "column {column} is empty; where signals come at different rates, `empty = \"hold\"` under [rows] holds the command until its next value"
    )]
    Empty { column: String },
    #[error("no comment line before it has a number after `{0}`")]
    NoComment(String),
    #[error("time goes from {before} s to {after} s; it must rise from row to row")]
    TimeNotRising { before: f64, after: f64 },
    #[error("the {what} in SI is {value}, which lies outside {range}")]
    Implausible {
        what: &'static str,
        value: String,
        range: String,
    },
}
