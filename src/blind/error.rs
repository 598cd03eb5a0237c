//! Errors and refusals.

use std::path::{Path, PathBuf};

use crate::plain::shown;

/// Why a blind set was not made, run or scored.
#[derive(Debug, thiserror::Error)]
pub enum BlindError {
    /// A file or directory could not be read or written.
    #[error("{}: {source}", shown(path))]
    File {
        /// Which.
        path: PathBuf,
        /// Message of the operating system.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{}: {what}", shown(path))]
    Content {
        /// Which.
        path: PathBuf,
        /// The error and its remedy.
        what: String,
    },
    /// The protocol of a blind test is violated; nothing is scored.
    #[error("refused: {0}")]
    Refused(String),
    /// A diagnoser could not be started.
    #[error("the diagnoser '{program}' does not start: {source}; say another with --diagnoser")]
    Diagnoser {
        /// Its program.
        program: String,
        /// Message of the operating system.
        source: std::io::Error,
    },
}

impl BlindError {
    pub(super) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }

    pub(super) fn content(path: &Path, what: impl ToString) -> Self {
        Self::Content {
            path: path.to_owned(),
            what: what.to_string(),
        }
    }

    /// Whether the file system is to blame and not what was asked or found.
    pub fn is_of_the_system(&self) -> bool {
        matches!(self, Self::File { source, .. } if source.kind() != std::io::ErrorKind::NotFound)
    }
}
