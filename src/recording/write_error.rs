//! Why a run file cannot be written, and what to do about it.

use std::io;
use std::path::PathBuf;

/// Why a run file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file cannot be made.
    #[error("cannot create {path}: {source}{}", advice(source))]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Writing failed on the way; the file ends with a whole row.
    #[error(
        "cannot write {path} any further: {source}; it holds {rows} whole rows{}",
        advice(source)
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
    #[error("{path} vanished while it was written; everything up to then is in {rescued}")]
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

/// What to do about the commonest failures.
fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            " (free some room, or name a file on another disk with -o)"
        }
        io::ErrorKind::FileTooLarge => " (the limit on file sizes was reached: see `ulimit -f`)",
        io::ErrorKind::ReadOnlyFilesystem | io::ErrorKind::PermissionDenied => {
            " (name a file in a directory that you may write to with -o)"
        }
        io::ErrorKind::NotFound => " (its directory is not there)",
        _ => "",
    }
}
