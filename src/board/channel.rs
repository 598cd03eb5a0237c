//! A serial line within this process, between the board's thread and the recorder's.
//!
//! It behaves as a port: one opener at a time, the board sees opening and closing, a read waits for
//! [`READ_PATIENCE`], and after the board has gone it returns the queued bytes and then 0 bytes.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::READ_PATIENCE;
use super::board_side::{BoardSide, Readiness};
use super::location::SerialLine;
use super::open_error::OpenError;

/// Capacity in bytes of each direction, after which a writer waits: about that of a Linux pseudo-terminal
/// (convention).
const CAPACITY: usize = 16_384;

/// Makes a line with the name `name` in messages; returns the board's side and the far end.
pub fn channel(name: impl Into<PathBuf>) -> (ChannelBoard, Channel) {
    let line = Arc::new(Shared::default());
    let channel = Channel {
        name: name.into(),
        line: Arc::clone(&line),
    };
    (ChannelBoard(line), channel)
}

#[derive(Debug, Default)]
struct State {
    to_board: VecDeque<u8>,
    from_board: VecDeque<u8>,
    /// Open handles of the far end.
    handles: usize,
    /// The far end was closed since the board last checked.
    was_closed: bool,
    is_gone: bool,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A page has one thread, and checks again in its next turn.
    #[cfg(target_family = "wasm")]
    fn wait_until(&self, _: Duration, _: impl FnMut(&State) -> bool) -> MutexGuard<'_, State> {
        self.lock()
    }

    /// Waits until a condition holds, up to `patience`.
    #[cfg(not(target_family = "wasm"))]
    fn wait_until(
        &self,
        patience: Duration,
        mut asked: impl FnMut(&State) -> bool,
    ) -> MutexGuard<'_, State> {
        let waited = self
            .changed
            .wait_timeout_while(self.lock(), patience, |state| !asked(state));
        waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// The unopened far end of a line within this process.
#[derive(Debug, Clone)]
pub struct Channel {
    name: PathBuf,
    line: Arc<Shared>,
}

impl Channel {
    /// Its name in messages.
    pub fn name(&self) -> &Path {
        &self.name
    }

    pub(super) fn is_there(&self) -> bool {
        !self.line.lock().is_gone
    }

    /// Opens it exclusively.
    pub(super) fn open(&self) -> Result<ChannelLine, OpenError> {
        let mut state = self.line.lock();
        if state.is_gone {
            return Err(OpenError::NotFound {
                path: self.name.clone(),
                known: Vec::new(),
            });
        }
        if state.handles > 0 {
            return Err(OpenError::Busy {
                path: self.name.clone(),
                holder: "this program".to_owned(),
                advice: "close the first connection before opening a second one".to_owned(),
            });
        }
        state.handles = 1;
        self.line.changed.notify_all();
        Ok(ChannelLine(Arc::clone(&self.line)))
    }
}

#[derive(Debug)]
pub(super) struct ChannelLine(Arc<Shared>);

impl SerialLine for ChannelLine {
    fn try_clone(&self) -> io::Result<Box<dyn SerialLine>> {
        self.0.lock().handles += 1;
        Ok(Box::new(Self(Arc::clone(&self.0))))
    }
}

impl Read for ChannelLine {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut state = self.0.wait_until(READ_PATIENCE, |state| {
            state.is_gone || !state.from_board.is_empty()
        });
        if state.from_board.is_empty() && !state.is_gone {
            return Err(io::ErrorKind::TimedOut.into());
        }
        let count = state.from_board.read(buffer)?;
        self.0.changed.notify_all();
        Ok(count)
    }
}

impl Write for ChannelLine {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.0.wait_until(READ_PATIENCE, |state| {
            state.is_gone || state.to_board.len() < CAPACITY
        });
        if state.is_gone {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let room = CAPACITY - state.to_board.len();
        if room == 0 {
            return Err(io::ErrorKind::TimedOut.into());
        }
        let count = room.min(bytes.len());
        state.to_board.extend(&bytes[..count]);
        self.0.changed.notify_all();
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for ChannelLine {
    fn drop(&mut self) {
        let mut state = self.0.lock();
        state.handles -= 1;
        if state.handles == 0 {
            state.was_closed = true;
            state.to_board.clear();
            state.from_board.clear();
            self.0.changed.notify_all();
        }
    }
}

/// The board's side of a line within this process; dropping it unplugs the board.
#[derive(Debug)]
pub struct ChannelBoard(Arc<Shared>);

impl BoardSide for ChannelBoard {
    fn wait(&self, patience: Duration, to_write: bool) -> io::Result<Readiness> {
        let has_room = |state: &State| state.from_board.len() < CAPACITY;
        let mut state = self.0.wait_until(patience, |state| {
            let is_open = state.handles > 0 && !state.was_closed;
            !is_open || !state.to_board.is_empty() || (to_write && has_room(state))
        });
        // Closed and opened again since the last check counts as closed.
        let was_closed = std::mem::take(&mut state.was_closed);
        Ok(Readiness {
            connected: state.handles > 0 && !was_closed,
            readable: !state.to_board.is_empty(),
            writable: has_room(&state),
        })
    }

    fn read_some(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.0.lock().to_board.read(buffer)?;
        self.0.changed.notify_all();
        Ok(count)
    }

    fn write_some(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.0.lock();
        let room = CAPACITY.saturating_sub(state.from_board.len());
        let count = room.min(bytes.len());
        state.from_board.extend(&bytes[..count]);
        self.0.changed.notify_all();
        Ok(count)
    }

    /// Closing empties the line; its content belongs to the present opener.
    fn discard(&mut self) {}

    /// Bytes in this line outlive the board, so that all of them are written at once.
    fn let_it_drain(&mut self, outgoing: &mut Vec<u8>, connected: bool) -> io::Result<()> {
        if connected {
            self.0.lock().from_board.extend(outgoing.drain(..));
        }
        Ok(())
    }
}

impl Drop for ChannelBoard {
    fn drop(&mut self) {
        self.0.lock().is_gone = true;
        self.0.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Duration = Duration::ZERO;

    #[test]
    fn bytes_pass_both_ways_and_the_board_sees_opening_and_closing() {
        let (mut board, far) = channel("virtual:");
        assert!(!board.wait(NOW, false).expect("a look").connected);
        let mut line = far.open().expect("it opens");
        let mut second = line.try_clone().expect("a second handle");
        second.write_all(b"who?").expect("room");
        let ready = board.wait(NOW, true).expect("a look");
        assert!(ready.connected && ready.readable && ready.writable);
        let mut buffer = [0; 8];
        assert_eq!(board.read_some(&mut buffer).expect("bytes"), 4);
        assert_eq!(board.write_some(b"me").expect("room"), 2);
        assert_eq!(line.read(&mut buffer).expect("bytes"), 2);
        drop(line);
        assert!(board.wait(NOW, false).expect("a look").connected);
        drop(second);
        // Opened again before the board has checked: it was closed nevertheless.
        let _line = far.open().expect("it opens again");
        assert!(!board.wait(NOW, false).expect("a look").connected);
        assert!(board.wait(NOW, false).expect("a look").connected);
    }

    #[test]
    fn bytes_sent_before_a_board_disconnects_can_still_be_read() {
        let (mut board, far) = channel("virtual:");
        let mut line = far.open().expect("it opens");
        let mut outgoing = vec![7; 3];
        board
            .let_it_drain(&mut outgoing, true)
            .expect("it takes all");
        drop(board);
        let mut buffer = [0; 8];
        assert_eq!(line.read(&mut buffer).expect("bytes"), 3);
        assert_eq!(line.read(&mut buffer).expect("no error"), 0);
        let error = line.write(b"who?").expect_err("nobody is there");
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
        assert!(!far.is_there());
        drop(line);
        assert!(matches!(far.open(), Err(OpenError::NotFound { .. })));
    }

    #[test]
    fn a_second_reader_is_refused_and_a_full_buffer_blocks_its_writer() {
        let (mut board, far) = channel("virtual:");
        let mut line = far.open().expect("it opens");
        assert!(matches!(far.open(), Err(OpenError::Busy { .. })));
        let all = vec![1; CAPACITY + 1];
        assert_eq!(board.write_some(&all).expect("room"), CAPACITY);
        assert!(!board.wait(NOW, true).expect("a look").writable);
        assert_eq!(line.read(&mut [0; 10]).expect("bytes"), 10);
        assert_eq!(board.write_some(&all).expect("room"), 10);
        assert_eq!(line.write(&all).expect("room"), CAPACITY);
        let error = line.write(&all).expect_err("no room");
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
    }
}
