//! Why a log cannot be imported, and why one of its rows cannot be used.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::lines::{MAX_LINE_BYTES, MOST_LINE_BYTES};
use crate::plain::shown;
use crate::recording::WriteError;

/// Error of a mapping file.
#[derive(Debug, Error)]
pub enum MapError {
    /// It cannot be read.
    #[error("{}: {source}", shown(path))]
    Io {
        /// The mapping file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is not TOML, or has a key that means nothing.
    #[error("line {line}: {message}\nhint: docs/reference/import.md lists the keys of a mapping")]
    Toml {
        /// Line, from 1.
        line: usize,
        /// Message of the TOML reader.
        message: String,
    },
    /// A key that is missing.
    #[error("{section} lacks `{key}`\nhint: {why}")]
    Missing {
        /// The section.
        section: &'static str,
        /// The key.
        key: &'static str,
        /// Purpose.
        why: &'static str,
    },
    /// A value that cannot be.
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
    /// A difference that names nothing, or cannot be.
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
    /// One of the above, in this file.
    #[error("{}: {error}", shown(path))]
    InFile {
        /// The file.
        path: PathBuf,
        /// Error in it.
        error: Box<MapError>,
    },
}

impl MapError {
    /// The file, and the line of it, where they are known.
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
    /// The log, as it was named.
    pub file: String,
    /// Error.
    pub problem: ImportProblem,
}

/// Error of a log. Lines are counted from 1.
#[derive(Debug, Error)]
pub enum ImportProblem {
    /// It cannot be opened or read, or its compressed data are broken.
    #[error("cannot be read beyond line {line}: {source}")]
    Read {
        /// The last line that could be read.
        line: u64,
        /// Why.
        source: io::Error,
    },
    /// It is no text.
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
    /// A column that the mapping names is not there.
    #[error("line {line} names no column `{column}`\nhint: {nearest}the columns are {found}")]
    NoSuchColumn {
        /// Line of the column names.
        line: u64,
        /// The column that the mapping asks for.
        column: String,
        /// A name like it.
        nearest: String,
        /// The names that there are.
        found: String,
    },
    /// A column asked for by its number is not there.
    #[error(
        "line {line} has {found} columns, and the mapping asks for column {column}\nhint: correct the number in the mapping (the first is 1), or its `delimiter`"
    )]
    NoSuchNumber {
        /// The line.
        line: u64,
        /// The column that the mapping asks for, from 1.
        column: usize,
        /// How many there are.
        found: usize,
    },
    /// A column asked for by name where the log has no names.
    #[error(
        "the mapping asks for column `{0}` by name, but says `names = false`\nhint: give its number (the first is 1)"
    )]
    NameWithoutNames(String),
    /// There is no row that can be used.
    #[error("{}", no_rows(.rows, .first))]
    NoRows {
        /// Rows there were.
        rows: u64,
        /// The first of them and why it cannot be used.
        first: Option<Box<BadRow>>,
    },
    /// Nothing but bad rows for long.
    #[error(
        "the first {rows} rows cannot be used, so the mapping does not fit this log; the first of them: {first}\n\
         hint: correct the mapping at that column, or let the import find it: leave --map out"
    )]
    AllBad {
        /// How many.
        rows: u64,
        /// The first of them and why.
        first: Box<BadRow>,
    },
    /// More runs than any log has.
    #[error(
        "line {line} would begin run {runs}: `split_by` names a column that changes too often\nhint: name another column under [rows], or leave `split_by` out"
    )]
    TooManyRuns {
        /// The line.
        line: u64,
        /// How many.
        runs: usize,
    },
    /// The clock begins anew more often than is taken unasked.
    #[error(
        "line {line}: the clock begins anew and would begin run {runs} of this log, so its column may be no clock\n\
         hint: name the clock, as --time COLUMN:UNIT or --time 10ms for rows 10 ms apart; where the log does hold so many \
         recordings: --runs 1000"
    )]
    ClockFalls {
        /// The line.
        line: u64,
        /// How many.
        runs: usize,
    },
    /// A pause longer than a run file may have.
    #[error(
        "line {line}: time leaps from {before} s to {after} s\nhint: a recording with a gap of more than an hour is two: cut the log there"
    )]
    TimeJumps {
        /// The line.
        line: u64,
        /// Time of the row before.
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
        /// Rows of a run.
        rows: u64,
    },
    /// A sample time that no run file may have.
    #[error(
        "the samples come every {sample_time_s} s, which lies outside {range}\nhint: correct the unit of the time: --time COLUMN:UNIT, or `unit` under [time] of the mapping"
    )]
    SampleTime {
        /// The middle one of the steps.
        sample_time_s: f64,
        /// Possible values.
        range: String,
    },
    /// The run cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The file of rejected rows cannot be written.
    #[error("the file of rejected rows {path} cannot be written: {source}", path = shown(path))]
    Rejected {
        /// That file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl ImportProblem {
    /// Line of the log, where one is to blame.
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

/// A row that was left out, and why.
#[derive(Debug, Clone, PartialEq, Eq, Error, serde::Serialize)]
#[error("line {line}: {why}")]
pub struct BadRow {
    /// Line of the log.
    pub line: u64,
    /// Error in it.
    pub why: String,
}

/// Why a row cannot be used.
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
