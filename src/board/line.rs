//! The writing side of a serial line, and the raw log of both directions.

use std::io::{self, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use firmware_protocol::{ALIVE_INTERVAL_MS, HostMessage, MAX_WIRE};

use super::{SerialLine, rawlog};
use crate::platform::files::File;
use crate::platform::time::Instant;

/// Most attempts to send a message without a response.
pub(super) const ATTEMPTS: u32 = 5;

/// Period of the ALIVE messages.
pub(super) const ALIVE_EVERY: Duration = Duration::from_millis(ALIVE_INTERVAL_MS as u64 * 2 / 3);

/// A raw log beside a recording. A write error ends the log, not the recording; its owner checks [`LogFailure`] at
/// the end.
#[derive(Debug)]
pub struct RawLog {
    writer: Option<rawlog::Writer<io::BufWriter<File>>>,
    failure: LogFailure,
}

/// Why a raw log ended before its recording; empty if it did not.
pub type LogFailure = Arc<OnceLock<io::Error>>;

impl RawLog {
    /// Begins a log in an empty file.
    ///
    /// # Errors
    /// Its header cannot be written.
    pub fn begin(file: File, header: &toml::Table) -> io::Result<Self> {
        let mut writer = rawlog::Writer::new(io::BufWriter::new(file), header)?;
        writer.flush()?;
        Ok(Self {
            writer: Some(writer),
            failure: LogFailure::default(),
        })
    }

    /// Handle of its write error.
    pub fn failure(&self) -> LogFailure {
        Arc::clone(&self.failure)
    }

    /// Appends bytes that arrived from the board.
    pub fn received(&mut self, at_us: u64, bytes: &[u8]) {
        self.write(|writer| writer.from_board(at_us, bytes));
    }

    pub(super) fn sent(&mut self, at_us: u64, bytes: &[u8]) {
        self.write(|writer| writer.to_board(at_us, bytes));
    }

    /// Appends a hang-up.
    pub fn hang_up(&mut self, at_us: u64) {
        self.write(|writer| writer.hang_up(at_us));
    }

    /// Flushes the log to the operating system.
    pub fn flush(&mut self) {
        self.write(rawlog::Writer::flush);
    }

    fn write(
        &mut self,
        write: impl FnOnce(&mut rawlog::Writer<io::BufWriter<File>>) -> io::Result<()>,
    ) {
        let Some(writer) = &mut self.writer else {
            return;
        };
        if let Err(error) = write(writer) {
            self.writer = None;
            let _ = self.failure.set(error);
        }
    }
}

/// The writing side of the line, shared with the reader.
#[derive(Debug)]
pub(super) struct Line {
    port: Mutex<Box<dyn SerialLine>>,
    log: Mutex<Option<RawLog>>,
    origin: Instant,
    /// Time of the last message in microseconds from `origin`.
    said_us: AtomicU64,
}

impl Line {
    pub(super) fn new(port: Box<dyn SerialLine>, log: Option<RawLog>, origin: Instant) -> Self {
        Self {
            port: Mutex::new(port),
            log: Mutex::new(log),
            origin,
            said_us: AtomicU64::new(0),
        }
    }

    fn now_us(&self) -> u64 {
        self.origin.elapsed().as_micros() as u64
    }

    /// Sends ALIVE. An error shows on the reading side.
    pub(super) fn say_alive(&self) {
        let _ = self.say(&HostMessage::Alive);
    }

    /// Whether an ALIVE is overdue: any thread that notices sends it, because a busy computer may delay one of them.
    pub(super) fn is_quiet(&self) -> bool {
        let silence_us = self
            .now_us()
            .saturating_sub(self.said_us.load(Ordering::Relaxed));
        silence_us > 2 * ALIVE_EVERY.as_micros() as u64
    }

    pub(super) fn say(&self, message: &HostMessage) -> io::Result<()> {
        let mut wire = [0; MAX_WIRE + 1];
        // A leading zero ends preceding noise.
        let length = message.encode(&mut wire[1..]).unwrap_or(0);
        let bytes = &wire[..=length];
        let mut port = self.port.lock().unwrap_or_else(PoisonError::into_inner);
        port.write_all(bytes)?;
        self.said_us.store(self.now_us(), Ordering::Relaxed);
        self.log(|log, now_us| log.sent(now_us, bytes));
        Ok(())
    }

    pub(super) fn log(&self, write: impl FnOnce(&mut RawLog, u64)) {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(log) = log.as_mut() {
            write(log, self.now_us());
        }
    }
}
