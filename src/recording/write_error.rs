//! Errors of writing a run file, with their remedies.

use std::io;
use std::path::PathBuf;

use crate::hint::of_system;
use crate::plain::shown;

/// Why a run file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file cannot be created.
    #[error("cannot create {}: {source}{}", shown(path), system_hint(source))]
    Create {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// The path cannot be a new file.
    #[error(
        "{} {what}, and a recording needs a file of its own\nhint: name a file that does not exist yet",
        shown(path)
    )]
    NoFile {
        /// The path.
        path: PathBuf,
        /// Its kind.
        what: &'static str,
    },
    /// Another program changed the length of the file; nothing more is appended.
    #[error(
        "{} was changed by another program while it was written: of {written_bytes} bytes with {rows} rows it has {found_bytes}\nhint: find out which other program writes there, and record again",
        shown(path)
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// Rows that were written to it.
        rows: u64,
        /// Bytes written.
        written_bytes: u64,
        /// Bytes found.
        found_bytes: u64,
    },
    /// A write error; the file ends with a complete row.
    #[error(
        "cannot write {} any further: {source}; it holds {rows} whole rows{}",
        shown(path),
        system_hint(source)
    )]
    Append {
        /// The file.
        path: PathBuf,
        /// Complete rows in it.
        rows: u64,
        /// Cause.
        source: io::Error,
    },
    /// The file or its directory was deleted during the recording.
    #[error(
        "{} vanished while it was written\nhint: everything up to then is in {}",
        shown(path),
        shown(rescued)
    )]
    Vanished {
        /// The file.
        path: PathBuf,
        /// Path of its rows.
        rescued: PathBuf,
    },
    /// The header cannot be written as TOML.
    #[error("the run's header is no TOML")]
    Header(#[from] toml::ser::Error),
}

/// Hint for a system error, on a line of its own.
fn system_hint(error: &io::Error) -> String {
    let hint = match error.kind() {
        io::ErrorKind::NotFound => {
            Some("its folder does not exist: make it, or name another with -o")
        }
        _ => of_system(error),
    };
    hint.map_or(String::new(), |hint| format!("\nhint: {hint}"))
}
