//! The board's side of a serial line, for virtual boards and replayed logs.

use std::io;
use std::time::Duration;

/// State of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Readiness {
    /// A program has the far end open.
    pub connected: bool,
    /// Bytes can be read.
    pub readable: bool,
    /// Bytes can be written.
    pub writable: bool,
}

/// The near end of a line; a program opens the far end.
pub trait BoardSide {
    /// Waits up to `patience` for bytes to read, or with `to_write` for room to write.
    ///
    /// # Errors
    /// The line failed.
    fn wait(&self, patience: Duration, to_write: bool) -> io::Result<Readiness>;

    /// Reads the available bytes; 0 if there are none.
    ///
    /// # Errors
    /// The line failed.
    fn read_some(&mut self, buffer: &mut [u8]) -> io::Result<usize>;

    /// Writes as much as there is room for.
    ///
    /// # Errors
    /// The line failed.
    fn write_some(&mut self, bytes: &[u8]) -> io::Result<usize>;

    /// Discards unread bytes in both directions.
    fn discard(&mut self);

    /// Before the line is closed: gives a reader a short time to read `outgoing` and the bytes in transit.
    ///
    /// # Errors
    /// The line failed.
    fn let_it_drain(&mut self, outgoing: &mut Vec<u8>, connected: bool) -> io::Result<()>;
}
