//! Errors of reading a file of another format.

use thiserror::Error;

/// Why a file cannot be read as a table.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FormatError {
    /// A known format that is not supported.
    #[error("it is {what}, which is not read\nhint: {remedy}")]
    NotRead {
        /// The format.
        what: &'static str,
        /// How to convert it.
        remedy: &'static str,
    },
    /// The program was built without its reader.
    #[error(
        "it is {what}, which this program was built without\n\
         hint: cargo install --path . --features formats; or save the same table as CSV"
    )]
    NotBuilt {
        /// The format.
        what: &'static str,
    },
    /// A damaged file.
    #[error(
        "it is {what}, and cannot be read: {why}\nhint: copy or save it once more: it is damaged or cut short; or save its table as CSV"
    )]
    Broken {
        /// The format.
        what: &'static str,
        /// The error.
        why: String,
    },
    /// No table of numbers.
    #[error(
        "it is {what} without a table of numbers{why}\nhint: save the signals in it as CSV, a line of names and one row per sample"
    )]
    Nothing {
        /// The format.
        what: &'static str,
        /// Content found instead; empty or begins with `: `.
        why: String,
    },
    /// Too large.
    #[error("it is {what} with more than {most} {of}\nhint: cut it into parts")]
    TooMuch {
        /// The format.
        what: &'static str,
        /// The limit.
        most: u64,
        /// Its unit.
        of: &'static str,
    },
}
