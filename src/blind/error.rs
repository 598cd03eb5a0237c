//! Errors and refusals.

use std::path::{Path, PathBuf};

use crate::hint::{Hinted, parted};
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

/// Hint for a file of a set that this program did not write.
const MADE_BY_MOTORLAB: &str = "a set and its labels are files that `motorlab blind make` or `motorlab blind seal` writes; name those";
/// Hint for a set that was changed.
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

    /// Something that the rules of a sealed set forbid, and what to do instead.
    pub(super) fn refused(what: impl Into<String>, hint: &str) -> Self {
        Self::Refused(Hinted::new(what, hint))
    }

    /// A set that is not as it was sealed, or verdicts that are not as they were written.
    pub(super) fn altered(what: impl Into<String>) -> Self {
        Self::refused(what, ALTERED)
    }

    /// Whether the file system is to blame and not what was asked or found.
    pub fn is_of_the_system(&self) -> bool {
        matches!(self, Self::File { source, .. } if source.kind() != std::io::ErrorKind::NotFound)
    }
}
