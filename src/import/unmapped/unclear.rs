//! Why a log without a mapping cannot be imported as it stands, and the command line with which it can.

use thiserror::Error;

use super::super::MapError;
use super::super::cells::shortened;

/// Facts that a log lacks.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Missing {
    /// The flag that says it, with a value as an example.
    pub flag: String,
    /// Missing facts, and why they are not known.
    pub why: String,
}

/// Why a log cannot be imported without a mapping.
#[derive(Debug, Error)]
pub enum Unclear {
    /// No rows of numbers.
    #[error(
        "no table of numbers was found in its first lines{}\n\
         hint: a log is text in columns, one row a sample, such as CSV with a line of names `time_ms,pwm,counts`; \
         other programs save their tables so, and docs/reference/import.md lists the forms that are read", began(.0)
    )]
    NoTable(Vec<String>),
    /// No text at all.
    #[error("{0}")]
    NoText(String),
    /// Facts are missing.
    #[error("this log lacks {}:\n{}\nhint: {}complete command:\n  {line}", facts(.missing.len()), listed(.missing), capitals(.missing))]
    Missing {
        /// What.
        missing: Vec<Missing>,
        /// The finished command line.
        line: String,
        /// Its flags with their values.
        flags: Vec<(&'static str, String)>,
    },
    /// A flag names a column that is not there.
    #[error("{flag} {column}: there is no such column\nhint: the columns are {found}")]
    NoColumn {
        /// The flag.
        flag: &'static str,
        /// Meaning.
        column: String,
        /// The columns that there are.
        found: String,
    },
    /// A column of words.
    #[error("{flag} {column}: the column holds no numbers\nhint: name another column")]
    NoNumbers {
        /// The flag.
        flag: &'static str,
        /// The column.
        column: String,
    },
    /// A flag has a unit that its quantity cannot have.
    #[error("{flag}: `{unit}` is no unit of it\nhint: it is one of {expected}")]
    Unit {
        /// The flag.
        flag: &'static str,
        /// The unit.
        unit: String,
        /// Possible values.
        expected: &'static str,
    },
    /// A column whose unit is not said, where no log is looked at.
    #[error(
        "{flag} {column}: with a mapping its unit is needed\nhint: as in {column}:UNIT; the unit is one of {expected}"
    )]
    NoUnit {
        /// The flag.
        flag: &'static str,
        /// The column.
        column: String,
        /// Possible units.
        expected: &'static str,
    },
    /// A flag that cannot be read.
    #[error("{flag} {text}: cannot be read\nhint: it is {expected}")]
    Form {
        /// The flag.
        flag: &'static str,
        /// Meaning.
        text: String,
        /// Possible meanings.
        expected: &'static str,
    },
    /// Flags that exclude each other.
    #[error("{0}")]
    Conflict(&'static str),
    /// The mapping cannot be written as one.
    #[error("the mapping cannot be written: {0}")]
    Unwritten(String),
    /// The given and detected facts make no mapping.
    #[error(transparent)]
    Map(#[from] MapError),
}

fn began(lines: &[String]) -> String {
    match lines.first() {
        None => " (it is empty)".to_owned(),
        Some(line) => {
            format!(", which begin `{}`", shortened(line))
        }
    }
}

fn facts(count: usize) -> String {
    match count {
        1 => "one fact".to_owned(),
        count => format!("{count} facts"),
    }
}

fn capitals(missing: &[Missing]) -> &'static str {
    let is_capitals = |word: &str| word.len() > 3 && word.chars().all(|c| c.is_ascii_uppercase());
    let is_open = |one: &Missing| one.flag.split([' ', ':']).any(is_capitals);
    match missing.iter().any(is_open) {
        true => "capitals are to be filled in; ",
        false => "units and times are proposals; ",
    }
}

fn listed(missing: &[Missing]) -> String {
    let lines: Vec<String> = missing
        .iter()
        .map(|one| format!("  {}  {}", one.flag, one.why))
        .collect();
    lines.join("\n")
}
