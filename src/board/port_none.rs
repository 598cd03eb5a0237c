//! In a page, ports are not opened by path: the user selects one in the browser, and the page passes its bytes on.

use std::io::{self, Read, Write};
use std::path::Path;

use super::location::SerialLine;
use super::open_error::OpenError;

/// No port exists.
#[derive(Debug)]
pub enum Port {}

impl Port {
    /// Always an error.
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
