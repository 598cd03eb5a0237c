//! A pseudo-terminal pair: the serial line of a virtual board or a replayed log.
//!
//! The far end is in raw mode from the start (no echo, no CR to LF), so that bytes are not changed before a program
//! has opened it. The kernel buffers some 20 kB; then a writer waits.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::board_side::{BoardSide, Readiness};

/// The near end of a pseudo-terminal; a program opens [`Pty::path`] as the far end.
#[derive(Debug)]
pub struct Pty {
    near: File,
    path: PathBuf,
}

impl Pty {
    /// Opens a pair with the far end at [`Pty::path`].
    pub fn open() -> io::Result<Self> {
        let near: OwnedFd = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&near)?;
        unlockpt(&near)?;
        let name = ptsname(&near, Vec::new())?;
        let path = PathBuf::from(name.to_string_lossy().into_owned());
        let far = open_far(&path)?;
        let mut settings = tcgetattr(&far)?;
        settings.make_raw();
        tcsetattr(&far, OptionalActions::Now, &settings)?;
        let flags = rustix::fs::fcntl_getfl(&near)?;
        rustix::fs::fcntl_setfl(&near, flags | OFlags::NONBLOCK)?;
        rustix::io::fcntl_setfd(&near, rustix::io::FdFlags::CLOEXEC)?;
        Ok(Self {
            near: File::from(near),
            path,
        })
    }

    /// The far end, which any program may open.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Unread bytes of the far end; `None` if unknown.
    fn unread(&self) -> Option<u64> {
        let far = open_far(&self.path).ok()?;
        rustix::io::ioctl_fionread(&far).ok()
    }
}

impl BoardSide for Pty {
    fn wait(&self, patience: Duration, to_write: bool) -> io::Result<Readiness> {
        let mut events = PollFlags::IN;
        if to_write {
            events |= PollFlags::OUT;
        }
        let mut watched = [PollFd::new(&self.near, events)];
        let timeout = Timespec {
            tv_sec: patience.as_secs().min(3600) as i64,
            tv_nsec: patience.subsec_nanos().into(),
        };
        match poll(&mut watched, Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let seen = watched[0].revents();
        Ok(Readiness {
            connected: !seen.contains(PollFlags::HUP),
            readable: seen.contains(PollFlags::IN),
            writable: seen.contains(PollFlags::OUT),
        })
    }

    fn read_some(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.near.read(buffer) {
            Ok(count) => Ok(count),
            Err(error) if would_block_or_closed(&error) => Ok(0),
            Err(error) => Err(error),
        }
    }

    fn write_some(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.near.write(bytes) {
            Ok(count) => Ok(count),
            Err(error) if would_block_or_closed(&error) => Ok(0),
            Err(error) => Err(error),
        }
    }

    fn discard(&mut self) {
        let mut buffer = [0; 4096];
        while self.read_some(&mut buffer).is_ok_and(|count| count > 0) {}
        // Best effort: leftovers are dropped by the next reader as a partial frame.
        let _ = rustix::termios::tcflush(&self.near, rustix::termios::QueueSelector::OFlush);
    }

    /// Closing a pseudo-terminal drops unread bytes: gives a reader up to 0.3 s for `outgoing` and for the bytes in
    /// transit.
    fn let_it_drain(&mut self, outgoing: &mut Vec<u8>, connected: bool) -> io::Result<()> {
        let until = Instant::now() + Duration::from_millis(300);
        while connected && Instant::now() < until {
            let sent = self.write_some(outgoing)?;
            outgoing.drain(..sent);
            match self.unread() {
                // The reader has read everything, or is about to.
                Some(0) if outgoing.is_empty() => {
                    thread::sleep(Duration::from_millis(20));
                    break;
                }
                // Its lock prevents the check: an active reader needs no more time than this.
                None if outgoing.is_empty() => {
                    thread::sleep(Duration::from_millis(100));
                    break;
                }
                _ => {}
            }
            thread::sleep(Duration::from_millis(2));
        }
        Ok(())
    }
}

/// Opens the far end without making it this process's controlling terminal.
fn open_far(path: &Path) -> io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags(OFlags::NOCTTY.bits().cast_signed())
        .open(path)
}

impl AsFd for Pty {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.near.as_fd()
    }
}

/// Would block, or (`EIO`) the far end is not open.
fn would_block_or_closed(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
    ) || error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_pass_unchanged_before_a_program_sets_raw_mode() {
        let mut pty = Pty::open().expect("a pseudo-terminal");
        let every_byte: Vec<u8> = (0..=255).collect();
        let mut far = OpenOptions::new()
            .read(true)
            .write(true)
            .open(pty.path())
            .expect("the far end");
        assert_eq!(pty.write_some(&every_byte).expect("room"), 256);
        let mut read = [0; 256];
        far.read_exact(&mut read).expect("bytes");
        assert_eq!(read[..], every_byte);
        far.write_all(&every_byte).expect("room");
        let ready = pty.wait(Duration::from_secs(5), false).expect("poll");
        assert!(ready.connected && ready.readable);
        assert_eq!(pty.read_some(&mut read).expect("bytes"), 256);
        assert_eq!(read[..], every_byte);
    }

    #[test]
    fn a_closed_far_end_is_reported() {
        let mut pty = Pty::open().expect("a pseudo-terminal");
        let ready = pty.wait(Duration::ZERO, false).expect("poll");
        assert!(!ready.connected);
        let far = OpenOptions::new().read(true).open(pty.path());
        let ready = pty.wait(Duration::ZERO, false).expect("poll");
        assert!(ready.connected);
        drop(far);
        let ready = pty.wait(Duration::ZERO, false).expect("poll");
        assert!(!ready.connected);
        assert_eq!(pty.read_some(&mut [0; 8]).expect("nothing"), 0);
    }
}
