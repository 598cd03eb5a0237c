//! Exit statuses and the one form in which a failure is said.

use std::error::Error;
use std::fmt;
use std::process::ExitCode;

/// Exit status of the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Done = 0,
    /// Done, but what was asked for fell short: samples lost, gap above `--fail-above`.
    FellShort = 1,
    /// Wrong use or bad input.
    BadInput = 2,
    /// The device or the file system failed.
    DeviceFailed = 3,
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        ExitCode::from(status as u8)
    }
}

/// An error with the exit status that it leads to.
#[derive(Debug)]
pub struct Failure {
    /// Exit status.
    pub status: Status,
    error: Box<dyn Error + Send + Sync>,
}

impl Failure {
    /// Wrong use or bad input: status 2.
    pub fn input(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self {
            status: Status::BadInput,
            error: error.into(),
        }
    }

    /// The device or the file system failed: status 3.
    pub fn device(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self {
            status: Status::DeviceFailed,
            error: error.into(),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut said = self.error.to_string();
        write!(f, "error: {said}")?;
        let mut cause = self.error.source();
        while let Some(error) = cause {
            // Many an error has its cause in its own words.
            let because = error.to_string();
            if !said.contains(&because) {
                write!(f, "\n  because: {because}")?;
                said.push_str(&because);
            }
            cause = error.source();
        }
        Ok(())
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
    fn a_cause_is_told_once_and_never_left_out() {
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
