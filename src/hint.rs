//! Errors with hints: one text of what is wrong and where, then on a separate line `hint: ` and a remedy, where there
//! is one.

use std::error::Error;
use std::fmt::{self, Display};
use std::io;

/// Separator between an error and its hint.
const HINT: &str = "\nhint: ";

/// Splits an error into message and hint.
pub fn parted(error: &str) -> (&str, Option<&str>) {
    match error.split_once(HINT) {
        Some((what, hint)) => (what, Some(hint)),
        None => (error, None),
    }
}

/// An error and its hint on one line, for lists.
pub fn on_one_line(error: &str) -> String {
    match parted(error) {
        (what, Some(hint)) => format!("{what}; {hint}"),
        (what, None) => what.to_owned(),
    }
}

/// An error that always has a hint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hinted {
    what: String,
    hint: String,
}

impl Hinted {
    /// The error (what is wrong and where) and the hint (the remedy).
    pub fn new(what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            hint: hint.into(),
        }
    }
}

impl Display for Hinted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{HINT}{}", self.what, self.hint)
    }
}

impl Error for Hinted {}

/// An error with its context: a file, a flag, or the failed action. The hint is the error's, or that of the system
/// error.
#[derive(Debug)]
pub struct In<E> {
    place: String,
    error: E,
}

impl<E: Error> In<E> {
    /// `PLACE: ERROR`.
    pub fn new(place: impl Into<String>, error: E) -> Self {
        Self {
            place: place.into(),
            error,
        }
    }
}

impl<E: Error> Display for In<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.error)
    }
}

impl<E: Error + 'static> Error for In<E> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        Some(&self.error)
    }
}

/// Hint for a system error that does not depend on the program.
pub fn of_system(error: &io::Error) -> Option<&'static str> {
    Some(match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "make room on this disk, or name a file on another one"
        }
        io::ErrorKind::FileTooLarge => {
            "the limit on file sizes is reached: `ulimit -f` shows it; raise it, or record less"
        }
        io::ErrorKind::ReadOnlyFilesystem => "this disk is read-only: name a file on another one",
        io::ErrorKind::PermissionDenied => {
            "change the permissions of the file or of its folder, or name a file in a folder of your own"
        }
        io::ErrorKind::IsADirectory => "it is a folder: name a file in it",
        io::ErrorKind::NotADirectory => {
            "a part of the path is a file and not a folder: name another path"
        }
        io::ErrorKind::InvalidFilename => {
            "the name is too long, or has characters that this system does not allow: name another file"
        }
        io::ErrorKind::ResourceBusy => "close the program that has it open, then try again",
        io::ErrorKind::InvalidData => {
            "it is not a text file in UTF-8: name another file, or save it as UTF-8"
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_separated_from_its_hint_wherever_it_is_quoted() {
        let inner = Hinted::new("no motor", "--motor FILE");
        let outer = In::new("a.csv", inner);
        assert_eq!(outer.to_string(), "a.csv: no motor\nhint: --motor FILE");
        assert_eq!(
            parted(&outer.to_string()),
            ("a.csv: no motor", Some("--motor FILE"))
        );
        assert_eq!(parted("no motor"), ("no motor", None));
        assert_eq!(
            on_one_line(&outer.to_string()),
            "a.csv: no motor; --motor FILE"
        );
    }
}
