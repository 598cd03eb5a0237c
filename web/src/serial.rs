//! The browser's serial port: the page hands bytes in and takes bytes out.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use motorlab::board::SerialLine;
use wasm_bindgen::prelude::*;

/// Bytes that wait for the recorder, at most: half a minute at 115200 baud. A page that is slower loses the rest, and frames tell it.
const MOST_WAITING: usize = 1 << 19;

/// Bytes from the port that were not read yet.
#[derive(Debug, Default)]
struct Arrived {
    bytes: VecDeque<u8>,
    is_gone: bool,
}

static ARRIVED: Mutex<Arrived> = Mutex::new(Arrived {
    bytes: VecDeque::new(),
    is_gone: false,
});

fn arrived() -> MutexGuard<'static, Arrived> {
    ARRIVED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes from the port.
#[wasm_bindgen]
pub fn serial_received(bytes: &[u8]) {
    let mut arrived = arrived();
    let room = MOST_WAITING.saturating_sub(arrived.bytes.len());
    arrived.bytes.extend(&bytes[..bytes.len().min(room)]);
}

/// The device is gone.
#[wasm_bindgen]
pub fn serial_gone() {
    arrived().is_gone = true;
}

/// The line that the page has opened.
#[derive(Debug)]
pub struct PageLine;

impl PageLine {
    /// Forgets what came before.
    pub fn opened() -> Self {
        *arrived() = Arrived::default();
        Self
    }
}

impl SerialLine for PageLine {
    fn try_clone(&self) -> io::Result<Box<dyn SerialLine>> {
        Ok(Box::new(Self))
    }
}

impl Read for PageLine {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut arrived = arrived();
        match arrived.bytes.read(buffer)? {
            0 if !arrived.is_gone => Err(io::ErrorKind::TimedOut.into()),
            count => Ok(count),
        }
    }
}

impl Write for PageLine {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        crate::send_to_port(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
