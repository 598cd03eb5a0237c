//! Why a log without a mapping cannot be imported as it stands, and the command line with which it can.

use thiserror::Error;

use super::super::MapError;
use super::super::cells::shortened;

/// What has to be said of a log.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Missing {
    /// The flag that says it, with a value as an example.
    pub flag: String,
    /// What is missing, and why it is not known.
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
    /// Something has to be said.
    #[error("{} to be said of this log:\n{}\n{}all of it said:\n  {line}", things(.missing.len()), listed(.missing), capitals(.missing))]
    Missing {
        /// What.
        missing: Vec<Missing>,
        /// The finished command line.
        line: String,
        /// Its flags with their values.
        flags: Vec<(&'static str, String)>,
    },
    /// A flag names a column that is not there.
    #[error("{flag} {column}: there is no such column; there are: {found}")]
    NoColumn {
        /// The flag.
        flag: &'static str,
        /// What it says.
        column: String,
        /// The columns that there are.
        found: String,
    },
    /// A column of words.
    #[error("{flag} {column}: the column holds no numbers")]
    NoNumbers {
        /// The flag.
        flag: &'static str,
        /// The column.
        column: String,
    },
    /// A flag has a unit that its quantity cannot have.
    #[error("{flag}: `{unit}` is no unit of it; it is one of {expected}")]
    Unit {
        /// The flag.
        flag: &'static str,
        /// The unit.
        unit: String,
        /// What it may be.
        expected: &'static str,
    },
    /// A column whose unit is not said, where no log is looked at.
    #[error(
        "{flag} {column}: beside a mapping its unit is to be said, as in {column}:UNIT; it is one of {expected}"
    )]
    NoUnit {
        /// The flag.
        flag: &'static str,
        /// The column.
        column: String,
        /// What the unit may be.
        expected: &'static str,
    },
    /// A flag that cannot be read.
    #[error("{flag} {text}: cannot be read; it is {expected}")]
    Form {
        /// The flag.
        flag: &'static str,
        /// What it says.
        text: String,
        /// What it may say.
        expected: &'static str,
    },
    /// Flags that exclude each other.
    #[error("{0}")]
    Conflict(&'static str),
    /// The mapping cannot be written as one.
    #[error("the mapping cannot be written: {0}")]
    Unwritten(String),
    /// What was said and found makes no mapping.
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

fn things(count: usize) -> String {
    match count {
        1 => "one thing has".to_owned(),
        count => format!("{count} things have"),
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
