//! The browser's serial port: the page passes received bytes in and sends bytes out.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use motorlab::board::SerialLine;
use wasm_bindgen::prelude::*;

/// Most bytes that wait for the recorder: half a minute at 115200 baud. A slower page loses the rest, which the
/// frames show.
const MOST_WAITING: usize = 1 << 19;

/// Received bytes that were not read yet.
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

/// The line opened by the page.
#[derive(Debug)]
pub struct PageLine;

impl PageLine {
    /// Discards earlier bytes.
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
