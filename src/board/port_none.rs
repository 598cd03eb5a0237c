//! A page opens no port by its path: the browser asks its user for one, and the page hands its bytes on.

use std::io::{self, Read, Write};
use std::path::Path;

use super::location::SerialLine;
use super::open_error::OpenError;

/// There is none.
#[derive(Debug)]
pub enum Port {}

impl Port {
    /// Says so.
    pub fn open(path: &Path, _: u32) -> Result<Self, OpenError> {
        Err(OpenError::failed(path, "a page opens no port by its path"))
    }
}

impl SerialLine for Port {
    fn try_clone(&self) -> io::Result<Box<dyn SerialLine>> {
        match *self {}
    }
}

impl Read for Port {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        match *self {}
    }
}

impl Write for Port {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        match *self {}
    }

    fn flush(&mut self) -> io::Result<()> {
        match *self {}
    }
}
