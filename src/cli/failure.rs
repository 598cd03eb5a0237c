//! Exit statuses, and the form of error messages.

use std::error::Error;
use std::fmt;
use std::path::Path;
use std::process::ExitCode;

use serde_json::{Value, json};

use super::missing_file;
use crate::blind::BlindError;
use crate::board::ProfileError;
use crate::hint::{Hinted, of_system, parted};
use crate::import::{ImportError, MapError};
use crate::motor::MotorFileError;
use crate::plain::clipped;
use crate::recording::{ReadError, WriteError};

/// Most characters printed of an error and of each cause: some lines of a terminal.
const MOST_CHARACTERS: usize = 1200;

/// Exit status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Success.
    Done = 0,
    /// Success with a shortfall: samples lost, gap above `--fail-above`.
    FellShort = 1,
    /// Wrong use or invalid input.
    BadInput = 2,
    /// The device or the file system failed.
    DeviceFailed = 3,
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        ExitCode::from(status as u8)
    }
}

/// An error with its exit status.
#[derive(Debug)]
pub struct Failure {
    /// Exit status.
    pub status: Status,
    kind: &'static str,
    file: Option<String>,
    row: Option<u64>,
    error: Box<dyn Error + Send + Sync>,
}

impl Failure {
    fn new(status: Status, kind: &'static str, error: Box<dyn Error + Send + Sync>) -> Self {
        Self {
            status,
            kind,
            file: None,
            row: None,
            error,
        }
    }

    /// Wrong use or invalid input, status 2: an error whose text has its hint.
    pub fn input(error: impl Error + Send + Sync + 'static) -> Self {
        Self::input_of(Box::new(error))
    }

    /// Wrong use or invalid input of several kinds, status 2: an error whose text has its hint.
    pub fn input_of(error: Box<dyn Error + Send + Sync>) -> Self {
        Self::new(Status::BadInput, "bad_input", error)
    }

    /// Wrong use or invalid input, status 2, as text and hint.
    pub fn wrong(what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::input(Hinted::new(what, hint))
    }

    /// The device or the file system failed, status 3.
    pub fn device(error: impl Error + Send + Sync + 'static) -> Self {
        Self::new(Status::DeviceFailed, "device_failed", Box::new(error))
    }

    /// The device failed, status 3, as text and hint.
    pub fn failed(what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::device(Hinted::new(what, hint))
    }

    /// Replaces the kind that follows from the exit status.
    pub(super) fn of_kind(self, kind: &'static str) -> Self {
        Self { kind, ..self }
    }

    /// Adds the file.
    pub fn at(self, path: &Path) -> Self {
        let file = Some(path.display().to_string());
        Self { file, ..self }
    }

    /// Adds the row or line of the file, if known.
    pub(super) fn in_row(self, row: Option<u64>) -> Self {
        Self { row, ..self }
    }

    /// The failure as a document: `{"error": {"kind", "message", "file", "row", "remedy"}}`. Unknown file and row are
    /// null; the remedy is the message's hint, or null.
    pub fn document(&self) -> Value {
        let printed = self.to_string();
        let message = printed.strip_prefix("error: ").unwrap_or(&printed);
        let place = self.place();
        let (_, remedy) = parted(message);
        json!({ "error": {
            "kind": self.kind,
            "message": message,
            "file": self.file.clone().or(place.0),
            "row": self.row.or(place.1),
            "remedy": remedy,
        }})
    }

    /// File and line of the first error in the chain that has them.
    fn place(&self) -> (Option<String>, Option<u64>) {
        let mut next: Option<&(dyn Error + 'static)> = Some(self.error.as_ref());
        let known = |path: &Path| Some(path.display().to_string());
        while let Some(error) = next {
            if let Some(read) = error.downcast_ref::<ReadError>() {
                return (Some(read.file.clone()), read.problem.row());
            }
            match error.downcast_ref() {
                Some(MotorFileError::Io { path, .. }) => return (known(path), None),
                Some(MotorFileError::InFile { path, error }) => {
                    return (known(path), line_of(error));
                }
                _ => {}
            }
            if let Some(map) = error.downcast_ref::<MapError>() {
                let (path, line) = map.place();
                return (path.and_then(known), line);
            }
            if let Some(import) = error.downcast_ref::<ImportError>()
                && let Some(line) = import.problem.line()
            {
                return (Some(import.file.clone()), Some(line));
            }
            match error.downcast_ref() {
                Some(ProfileError::Row { path, row, .. }) => return (known(path), Some(*row)),
                Some(
                    ProfileError::Read { path, .. }
                    | ProfileError::TooLong { path }
                    | ProfileError::Empty { path },
                ) => return (known(path), None),
                _ => {}
            }
            if let Some(BlindError::File { path, .. } | BlindError::Content { path, .. }) =
                error.downcast_ref()
            {
                return (known(path), None);
            }
            match error.downcast_ref() {
                // The number of complete rows before it.
                Some(
                    WriteError::Altered { path, rows, .. } | WriteError::Append { path, rows, .. },
                ) => return (known(path), Some(*rows)),
                Some(
                    WriteError::Create { path, .. }
                    | WriteError::NoFile { path, .. }
                    | WriteError::Vanished { path, .. },
                ) => return (known(path), None),
                _ => {}
            }
            next = error.source();
        }
        (None, None)
    }
}

/// Line of an error in a motor file.
fn line_of(error: &MotorFileError) -> Option<u64> {
    match error {
        MotorFileError::Syntax { line, .. }
        | MotorFileError::UnknownKey { line, .. }
        | MotorFileError::WrongValue { line, .. }
        | MotorFileError::Implausible { line, .. }
        | MotorFileError::Effect { line, .. } => Some(*line as u64),
        MotorFileError::Io { .. } | MotorFileError::InFile { .. } => None,
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.error.to_string();
        let (what, hint) = parted(&text);
        let mut printed = what.to_owned();
        let mut hint = hint.map(str::to_owned);
        write!(f, "error: {}", clipped(what, MOST_CHARACTERS))?;
        let mut cause = self.error.source();
        while let Some(error) = cause {
            let text = error.to_string();
            let (because, its_hint) = parted(&text);
            // Many errors already contain the text of their cause.
            if !printed.contains(because) {
                write!(f, "\n  because: {}", clipped(because, MOST_CHARACTERS))?;
                printed.push_str(because);
            }
            let of_system = || error.downcast_ref().and_then(of_system);
            hint = hint.or_else(|| its_hint.or_else(of_system).map(str::to_owned));
            cause = error.source();
        }
        let known = self.file.clone().or_else(|| self.place().0);
        let missing = missing_file::hint(&printed, known.as_deref());
        let itself = || {
            self.error
                .downcast_ref()
                .and_then(of_system)
                .map(str::to_owned)
        };
        match missing.or(hint).or_else(itself) {
            Some(hint) => write!(f, "\nhint: {}", clipped(&hint, MOST_CHARACTERS)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    #[derive(Debug, thiserror::Error)]
    enum Unread {
        #[error("motor.toml: {0}")]
        Telling(#[source] io::Error),
        #[error("cannot read motor.toml")]
        Silent(#[source] io::Error),
    }

    #[test]
    fn a_missing_file_has_a_hint_in_text_and_document() {
        let error = io::Error::from_raw_os_error(2);
        let missing = Failure::input(Unread::Telling(error)).at(Path::new("no-such.motor.toml"));
        let printed = missing.to_string();
        assert!(printed.contains("\nhint: this folder has "), "{printed}");
        let remedy = &missing.document()["error"]["remedy"];
        assert!(
            remedy.as_str().is_some_and(|hint| printed.ends_with(hint)),
            "{remedy}"
        );
    }

    #[test]
    fn a_cause_is_printed_exactly_once() {
        let cause = || io::Error::other("the disk is gone");
        let telling = Failure::input(Unread::Telling(cause())).to_string();
        assert_eq!(telling, "error: motor.toml: the disk is gone");
        let silent = Failure::input(Unread::Silent(cause())).to_string();
        assert_eq!(
            silent,
            "error: cannot read motor.toml\n  because: the disk is gone"
        );
    }
}
