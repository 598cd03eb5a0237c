//! The board's side of a serial line: what a virtual board and a replayed log need of it.

use std::io;
use std::time::Duration;

/// State of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Readiness {
    /// Some program has the far end open.
    pub connected: bool,
    /// There are bytes to read.
    pub readable: bool,
    /// There is room to write.
    pub writable: bool,
}

/// The near end of a line whose far end some program opens.
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

    /// Throws away what either side has not read yet.
    fn discard(&mut self);

    /// Before the line is closed: gives a reader that is there a little time for `outgoing` and for what is on the way.
    ///
    /// # Errors
    /// The line failed.
    fn let_it_drain(&mut self, outgoing: &mut Vec<u8>, connected: bool) -> io::Result<()>;
}
