//! Errors of an import without a mapping, with the command line that succeeds.

use thiserror::Error;

use super::super::MapError;
use super::super::cells::shortened;

/// A missing fact.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Missing {
    /// Its flag, with an example of a value.
    pub flag: String,
    /// The fact, and why it is unknown.
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
    /// Not text.
    #[error("{0}")]
    NoText(String),
    /// Missing facts.
    #[error("this log lacks {}:\n{}\nhint: {}complete command:\n  {line}", facts(.missing.len()), listed(.missing), capitals(.missing))]
    Missing {
        /// The facts.
        missing: Vec<Missing>,
        /// The complete command line.
        line: String,
        /// Its flags with their values.
        flags: Vec<(&'static str, String)>,
    },
    /// A flag names a missing column.
    #[error("{flag} {column}: there is no such column\nhint: the columns are {found}")]
    NoColumn {
        /// The flag.
        flag: &'static str,
        /// The column.
        column: String,
        /// The existing columns.
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
    /// A flag has an impossible unit.
    #[error("{flag}: `{unit}` is no unit of it\nhint: it is one of {expected}")]
    Unit {
        /// The flag.
        flag: &'static str,
        /// The unit.
        unit: String,
        /// Possible units.
        expected: &'static str,
    },
    /// A column without a unit, if there is no log to examine.
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
    /// An invalid value of a flag.
    #[error("{flag} {text}: cannot be read\nhint: it is {expected}")]
    Form {
        /// The flag.
        flag: &'static str,
        /// The value.
        text: String,
        /// Possible values.
        expected: &'static str,
    },
    /// Flags that exclude each other.
    #[error("{0}")]
    Conflict(&'static str),
    /// The mapping cannot be written.
    #[error("the mapping cannot be written: {0}")]
    Unwritten(String),
    /// The given and derived facts make no valid mapping.
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
