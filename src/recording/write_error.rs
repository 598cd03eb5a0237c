//! Why a run file cannot be written, and what to do about it.

use std::io;
use std::path::PathBuf;

use crate::hint::of_system;
use crate::plain::shown;

/// Why a run file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file cannot be made.
    #[error("cannot create {}: {source}{}", shown(path), system_hint(source))]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// There can be no new file under this name.
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
    /// Another program has cut or lengthened the file; nothing is appended to it any more.
    #[error(
        "{} was changed by another program while it was written: of {written_bytes} bytes with {rows} rows it has {found_bytes}\nhint: find out which other program writes there, and record again",
        shown(path)
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// Rows that were written to it.
        rows: u64,
        /// Bytes that were.
        written_bytes: u64,
        /// Bytes that it has.
        found_bytes: u64,
    },
    /// Writing failed on the way; the file ends with a whole row.
    #[error(
        "cannot write {} any further: {source}; it holds {rows} whole rows{}",
        shown(path),
        system_hint(source)
    )]
    Append {
        /// The file.
        path: PathBuf,
        /// Whole rows in it.
        rows: u64,
        /// Why.
        source: io::Error,
    },
    /// The file was deleted, or its directory was, while it was written.
    #[error(
        "{} vanished while it was written\nhint: everything up to then is in {}",
        shown(path),
        shown(rescued)
    )]
    Vanished {
        /// The file.
        path: PathBuf,
        /// Where its rows are now.
        rescued: PathBuf,
    },
    /// The header cannot be written as TOML.
    #[error("the run's header is no TOML")]
    Header(#[from] toml::ser::Error),
}

/// Hint for an error of the system, as a line of its own.
fn system_hint(error: &io::Error) -> String {
    let hint = match error.kind() {
        io::ErrorKind::NotFound => {
            Some("its folder does not exist: make it, or name another with -o")
        }
        _ => of_system(error),
    };
    hint.map_or(String::new(), |hint| format!("\nhint: {hint}"))
}
