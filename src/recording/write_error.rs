//! Why a run file cannot be written, and what to do about it.

use std::io;
use std::path::PathBuf;

use crate::plain::shown;

/// Why a run file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file cannot be made.
    #[error("cannot create {}: {source}{}", shown(path), advice(source))]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// There can be no new file under this name.
    #[error(
        "{} {what}, and a recording needs a file of its own; name a file that is not there yet",
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
        "{} was changed by another program while it was written: of {written_bytes} bytes with {rows} rows it has {found_bytes}; see what else writes there, and record again",
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
    #[error(
        "{} vanished while it was written; everything up to then is in {}",
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

/// Remedies of the commonest failures.
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
