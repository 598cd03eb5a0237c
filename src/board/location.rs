//! Location of a board: a serial port, or this process. Both open as the same kind of line.

use std::fmt;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use super::channel::Channel;
use super::open_error::OpenError;
use super::port::Port;

/// An open serial line. Reading returns 0 bytes if the board is gone, `TimedOut` if it is silent.
pub trait SerialLine: Read + Write + Send + fmt::Debug {
    /// A second handle on the same line, for writing.
    ///
    /// # Errors
    /// The operating system has no more handles.
    fn try_clone(&self) -> io::Result<Box<dyn SerialLine>>;
}

/// Location of a board.
#[derive(Debug, Clone)]
pub enum Location {
    /// At a serial port of this machine.
    Port(PathBuf),
    /// Within this process.
    InProcess(Channel),
}

impl Location {
    /// The port's path; for a board within this process its name in messages.
    pub fn path(&self) -> &Path {
        match self {
            Self::Port(path) => path,
            Self::InProcess(channel) => channel.name(),
        }
    }

    /// Whether it exists. On Windows a port is no file, and only opening it shows.
    pub fn is_there(&self) -> bool {
        match self {
            Self::Port(path) => cfg!(windows) || path.exists(),
            Self::InProcess(channel) => channel.is_there(),
        }
    }

    /// Opens the line exclusively; a port with `baud` bits per second.
    ///
    /// # Errors
    /// It does not exist, or another program has it.
    pub fn open(&self, baud: u32) -> Result<Box<dyn SerialLine>, OpenError> {
        Ok(match self {
            Self::Port(path) => Box::new(Port::open(path, baud)?),
            Self::InProcess(channel) => Box::new(channel.open()?),
        })
    }
}

impl From<&Path> for Location {
    fn from(path: &Path) -> Self {
        Self::Port(path.to_owned())
    }
}

impl From<&PathBuf> for Location {
    fn from(path: &PathBuf) -> Self {
        Self::Port(path.clone())
    }
}

impl From<&Location> for Location {
    fn from(location: &Location) -> Self {
        location.clone()
    }
}
