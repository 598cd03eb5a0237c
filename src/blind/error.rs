//! Errors and refusals.

use std::path::{Path, PathBuf};

use crate::hint::{Hinted, parted};
use crate::plain::shown;

/// Errors of a blind test.
#[derive(Debug, thiserror::Error)]
pub enum BlindError {
    /// A file or directory could not be read or written.
    #[error("{}: {source}", shown(path))]
    File {
        /// The path.
        path: PathBuf,
        /// Message of the operating system.
        source: std::io::Error,
    },
    /// A file has invalid content.
    #[error("{}: {what}", shown(path))]
    Content {
        /// The path.
        path: PathBuf,
        /// The error and its remedy.
        what: String,
    },
    /// The protocol of a blind test is violated; nothing is scored.
    #[error("refused: {0}")]
    Refused(Hinted),
    /// A diagnoser could not be started.
    #[error(
        "the diagnoser '{program}' does not start: {source}\nhint: name a program with --diagnoser, or leave it out for this one"
    )]
    Diagnoser {
        /// Its program.
        program: String,
        /// Message of the operating system.
        source: std::io::Error,
    },
}

/// Hint for a file that this program did not write.
const MADE_BY_MOTORLAB: &str = "a set and its labels are files that `motorlab blind make` or `motorlab blind seal` writes; name those";
/// Hint for a modified set.
const ALTERED: &str = "put the set back from a copy as it was sealed; without one make another: motorlab blind make DIRECTORY";

impl BlindError {
    pub(super) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }

    pub(super) fn content(path: &Path, what: impl ToString) -> Self {
        let what = what.to_string();
        let what = match parted(&what).1 {
            Some(_) => what,
            None => Hinted::new(what, MADE_BY_MOTORLAB).to_string(),
        };
        Self::Content {
            path: path.to_owned(),
            what,
        }
    }

    /// A violation of the rules of a sealed set, with its remedy.
    pub(super) fn refused(what: impl Into<String>, hint: &str) -> Self {
        Self::Refused(Hinted::new(what, hint))
    }

    /// A set or verdict that differs from its sealed state.
    pub(super) fn altered(what: impl Into<String>) -> Self {
        Self::refused(what, ALTERED)
    }

    /// Whether the cause is the file system.
    pub fn is_of_the_system(&self) -> bool {
        matches!(self, Self::File { source, .. } if source.kind() != std::io::ErrorKind::NotFound)
    }
}
