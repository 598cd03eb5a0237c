//! Where a board is: at a serial port, or within this process. Both are opened as one and the same kind of line.

use std::fmt;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use super::channel::Channel;
use super::open_error::OpenError;
use super::port::Port;

/// An open serial line. Reading gives 0 bytes when the board is gone, `TimedOut` when it is silent.
pub trait SerialLine: Read + Write + Send + fmt::Debug {
    /// A second handle on the same line, for writing.
    ///
    /// # Errors
    /// The operating system has no more handles.
    fn try_clone(&self) -> io::Result<Box<dyn SerialLine>>;
}

/// Where a board is.
#[derive(Debug, Clone)]
pub enum Location {
    /// At a serial port of this machine.
    Port(PathBuf),
    /// Within this process.
    InProcess(Channel),
}

impl Location {
    /// The port's path; of a board within this process what messages call it.
    pub fn path(&self) -> &Path {
        match self {
            Self::Port(path) => path,
            Self::InProcess(channel) => channel.name(),
        }
    }

    /// Whether there is something to open. On Windows a port is no file, and only opening it tells.
    pub fn is_there(&self) -> bool {
        match self {
            Self::Port(path) => cfg!(windows) || path.exists(),
            Self::InProcess(channel) => channel.is_there(),
        }
    }

    /// Opens the line for this program alone; at a port with `baud` bits per second.
    ///
    /// # Errors
    /// It is not there, or another program has it.
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
