//! Why a file of another form is no log that can be read.

use thiserror::Error;

/// Why a file cannot be read as a table.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FormatError {
    /// A form that is known and not read.
    #[error("it is {what}, which is not read\nhint: {remedy}")]
    NotRead {
        /// The form.
        what: &'static str,
        /// How to make a log of it that is read.
        remedy: &'static str,
    },
    /// The program was built without what reads it.
    #[error(
        "it is {what}, which this program was built without\n\
         hint: cargo install --path . --features formats; or save the same table as CSV"
    )]
    NotBuilt {
        /// The form.
        what: &'static str,
    },
    /// It contradicts its own form.
    #[error(
        "it is {what}, and cannot be read: {why}\nhint: copy or save it once more: it is damaged or cut short; or save its table as CSV"
    )]
    Broken {
        /// The form.
        what: &'static str,
        /// Error.
        why: String,
    },
    /// Nothing in it is a table of numbers.
    #[error(
        "it is {what} without a table of numbers{why}\nhint: save the signals in it as CSV, a line of names and one row per sample"
    )]
    Nothing {
        /// The form.
        what: &'static str,
        /// Content found instead; empty or begins with `: `.
        why: String,
    },
    /// More than a log has.
    #[error("it is {what} with more than {most} {of}\nhint: cut it into parts")]
    TooMuch {
        /// The form.
        what: &'static str,
        /// How many are read.
        most: u64,
        /// Of what.
        of: &'static str,
    },
}
