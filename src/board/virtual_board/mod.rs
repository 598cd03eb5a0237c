//! A virtual board: the wire protocol over a simulated bench.
//!
//! ```text
//! Bench (motor simulation) <- Firmware -> faults -> BoardSide -> whoever opens VirtualBoard::location
//! ```
//!
//! Its line ends within this process or, on Unix, at a pseudo-terminal for other programs. Opening the far end resets
//! it, as DTR does an Arduino. It runs in real time, faster by a factor, or as fast as its reader reads; device time
//! is the same in each case.

mod firmware;
#[cfg(target_family = "wasm")]
mod page;

use std::collections::VecDeque;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use firmware_protocol::{
    BoardMessage, EndReason, FrameDecoder, HostMessage, LINK_TIMEOUT_MS, MAX_WIRE,
};

use firmware::Firmware;
pub use firmware::FirmwareOptions;
#[cfg(target_family = "wasm")]
pub use page::VirtualBoardOnPage;

use super::Bench;
use super::board_side::BoardSide;
use super::channel::channel;
use super::faults::{Faults, FaultyPort};
use super::location::Location;
#[cfg(unix)]
use super::pty::Pty;
use crate::platform::time::Instant;

/// Rate of board time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pace {
    /// As on a real board.
    #[default]
    RealTime,
    /// Faster by this factor.
    Times(f64),
    /// As fast as the reader reads.
    AsFastAsPossible,
}

/// Behaviour of a virtual board.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VirtualBoardOptions {
    /// HELLO and clock of its firmware.
    pub firmware: FirmwareOptions,
    /// Rate of its time.
    pub pace: Pace,
    /// Faults of its line.
    pub faults: Faults,
    /// Time from reset to HELLO: the boot loader.
    pub boot: Duration,
    /// Text printed before HELLO.
    pub banner: String,
}

/// Size of the send buffer in bytes; a frame that does not fit is dropped.
const SEND_BUFFER: usize = 256;

/// Longest wait in one turn, and so the delay with which a stopped board ends.
const TURN: Duration = Duration::from_millis(20);

/// Longest turn that counts. A longer one means that this computer was suspended or overloaded, board and host alike;
/// board time does not advance in it.
const LONGEST_TURN: Duration = Duration::from_millis(50);

/// Polling period for the opening of the port.
const POLL_EVERY: Duration = Duration::from_millis(2);

/// A running virtual board; dropping it unplugs it.
#[derive(Debug)]
pub struct VirtualBoard {
    location: Location,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl VirtualBoard {
    /// Plugs in a board with `bench` at a pseudo-terminal for other programs.
    ///
    /// # Errors
    /// No pseudo-terminal or thread is available.
    #[cfg(unix)]
    pub fn spawn(bench: impl Bench + 'static, options: VirtualBoardOptions) -> io::Result<Self> {
        let pty = Pty::open()?;
        let location = Location::Port(pty.path().to_owned());
        Self::plug_in(pty, location, bench, options)
    }

    /// Plugs in a board with `bench` for this process alone, with the name `name` in messages.
    ///
    /// # Errors
    /// No thread is available.
    pub fn in_process(
        name: &str,
        bench: impl Bench + 'static,
        options: VirtualBoardOptions,
    ) -> io::Result<Self> {
        let (near, far) = channel(name);
        Self::plug_in(near, Location::InProcess(far), bench, options)
    }

    fn plug_in(
        line: impl BoardSide + Send + 'static,
        location: Location,
        bench: impl Bench + 'static,
        options: VirtualBoardOptions,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let thread = thread::Builder::new()
            .name("virtual-board".to_owned())
            .spawn({
                let stop = Arc::clone(&stop);
                move || Running::new(line, bench, options).run(&stop)
            })?;
        Ok(Self {
            location,
            stop,
            thread: Some(thread),
        })
    }

    /// Where it is opened.
    pub fn location(&self) -> &Location {
        &self.location
    }

    /// The serial port to open; for a board within this process its name in messages.
    pub fn path(&self) -> &Path {
        self.location.path()
    }

    /// Whether it has unplugged itself.
    pub fn is_gone(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for VirtualBoard {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Bytes from the firmware to the line's faults.
#[derive(Debug, Clone, Default)]
struct Queue(Arc<Mutex<VecDeque<u8>>>);

impl Queue {
    fn push(&self, bytes: &[u8]) {
        let mut queue = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        queue.extend(bytes);
    }
}

impl Read for Queue {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut queue = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        queue.read(buffer)
    }
}

struct Running<L, B> {
    board_side: L,
    firmware: Firmware<B>,
    options: VirtualBoardOptions,
    queue: Queue,
    line: FaultyPort<Queue>,
    /// Bytes behind the faults that wait for room on the line.
    outgoing: Vec<u8>,
    decoder: FrameDecoder,
    connected: bool,
    hello_at: Option<Instant>,
    started_at: Instant,
    /// How long the host was silent while this board ran.
    silence: Duration,
    turned_at: Instant,
    hung_up: bool,
}

impl<L: BoardSide, B: Bench> Running<L, B> {
    fn new(board_side: L, bench: B, options: VirtualBoardOptions) -> Self {
        let queue = Queue::default();
        let now = Instant::now();
        Self {
            board_side,
            firmware: Firmware::new(bench, options.firmware.clone()),
            line: FaultyPort::new(queue.clone(), options.faults),
            options,
            queue,
            outgoing: Vec::new(),
            decoder: FrameDecoder::new(),
            connected: false,
            hello_at: None,
            started_at: now,
            silence: Duration::ZERO,
            turned_at: now,
            hung_up: false,
        }
    }

    fn run(mut self, stop: &AtomicBool) -> io::Result<()> {
        while !stop.load(Ordering::Relaxed) && !self.hung_up {
            if !self.turn()? {
                thread::sleep(POLL_EVERY);
            }
        }
        self.board_side
            .let_it_drain(&mut self.outgoing, self.connected)
    }

    /// One turn, which waits for the line if there is nothing else to do; returns whether the port is open.
    fn turn(&mut self) -> io::Result<bool> {
        let patience = self.patience();
        let ready = self.board_side.wait(patience, !self.outgoing.is_empty())?;
        if !ready.connected {
            self.nobody_there();
            return Ok(false);
        }
        if !self.connected {
            self.reset();
        }
        self.begin_turn(patience);
        if ready.readable {
            self.listen()?;
        }
        if self.hello_at.is_some_and(|at| at <= Instant::now()) {
            self.hello_at = None;
            self.queue.push(self.options.banner.as_bytes());
            self.say(&self.firmware.hello())?;
        }
        self.take_samples()?;
        self.send()?;
        Ok(true)
    }

    /// Advances the time of the board and of the host's silence, except while this computer stands still. A board
    /// faster than real time counts silence only while it waits for the line, as the host shares its processor.
    fn begin_turn(&mut self, patience: Duration) {
        let turn = self.turned_at.elapsed();
        self.turned_at += turn;
        self.silence += match self.options.pace {
            Pace::RealTime => turn.min(LONGEST_TURN),
            Pace::Times(_) | Pace::AsFastAsPossible => turn.min(patience),
        };
        self.started_at += turn.saturating_sub(LONGEST_TURN);
    }

    /// The port is closed: the motor is off, and queued bytes are discarded.
    fn nobody_there(&mut self) {
        if self.connected {
            self.connected = false;
            let _ = self.firmware.stop(EndReason::LinkLost);
            self.outgoing.clear();
            self.board_side.discard();
        }
    }

    /// Opening the port resets the board.
    fn reset(&mut self) {
        self.connected = true;
        self.firmware.reset();
        self.decoder.reset();
        self.hello_at = Some(Instant::now() + self.options.boot);
    }

    /// Wait for the line if there is nothing else to do.
    fn patience(&self) -> Duration {
        let now = Instant::now();
        let hello = self.hello_at.map(|at| at.saturating_duration_since(now));
        let due = self
            .sample_due()
            .map(|at| at.saturating_duration_since(now));
        let wait = [hello, due].into_iter().flatten().min().unwrap_or(TURN);
        // While bytes wait for room, only room can help.
        let waiting = self.options.pace == Pace::AsFastAsPossible && !self.outgoing.is_empty();
        if waiting { TURN } else { wait.min(TURN) }
    }

    /// When the next sample is due in real time.
    fn sample_due(&self) -> Option<Instant> {
        let true_us = self.firmware.next_sample_true_us()?;
        let faster = match self.options.pace {
            Pace::RealTime => 1.0,
            Pace::Times(factor) => factor,
            Pace::AsFastAsPossible => return Some(self.started_at),
        };
        Some(self.started_at + Duration::from_secs_f64(true_us * 1e-6 / faster))
    }

    fn listen(&mut self) -> io::Result<()> {
        let mut buffer = [0; 1024];
        let count = self.board_side.read_some(&mut buffer)?;
        for &byte in &buffer[..count] {
            let message = match self.decoder.push(byte) {
                Some(Ok(frame)) => HostMessage::parse(frame),
                _ => continue,
            };
            let Ok(message) = message else { continue };
            if self.hello_at.is_some() {
                // In the boot loader.
                continue;
            }
            self.silence = Duration::ZERO;
            let was_recording = self.firmware.is_recording();
            let answer = self.firmware.answer(&message);
            if self.firmware.is_recording() && !was_recording {
                self.started_at = Instant::now();
            }
            if let Some(answer) = answer {
                self.say(&answer)?;
            }
        }
        Ok(())
    }

    fn take_samples(&mut self) -> io::Result<()> {
        if self.firmware.is_recording()
            && self.silence > Duration::from_millis(u64::from(LINK_TIMEOUT_MS))
            && let Some(end) = self.firmware.stop(EndReason::LinkLost)
        {
            return self.say(&end);
        }
        for _ in 0..64 {
            let due = self.sample_due().is_some_and(|at| at <= Instant::now());
            let unhurried = self.options.pace == Pace::AsFastAsPossible;
            if !due || (unhurried && self.outgoing.len() > SEND_BUFFER) {
                break;
            }
            let Some((sample, end)) = self.firmware.take_sample() else {
                break;
            };
            if !unhurried && self.outgoing.len() + MAX_WIRE > SEND_BUFFER {
                self.firmware.sample_was_dropped();
            } else {
                self.say(&sample)?;
            }
            if end.is_some()
                && let Some(end) = self.firmware.last_end()
            {
                self.say(&end)?;
            }
        }
        Ok(())
    }

    /// Sends a message through the line's faults.
    fn say(&mut self, message: &BoardMessage) -> io::Result<()> {
        let mut wire = [0; MAX_WIRE];
        if let Some(length) = message.encode(&mut wire) {
            self.queue.push(&wire[..length]);
        }
        let mut buffer = [0; 1024];
        loop {
            match self.line.read(&mut buffer) {
                Ok(0) => return self.send(),
                Ok(count) => self.outgoing.extend_from_slice(&buffer[..count]),
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                    self.hung_up = true;
                    return self.send();
                }
                Err(error) if error.kind() == io::ErrorKind::TimedOut => {}
                Err(error) => return Err(error),
            }
        }
    }

    fn send(&mut self) -> io::Result<()> {
        let chunk_bytes = if self.options.faults.split { 1 } else { 4096 };
        while !self.outgoing.is_empty() {
            let chunk = &self.outgoing[..chunk_bytes.min(self.outgoing.len())];
            let sent = self.board_side.write_some(chunk)?;
            if sent == 0 {
                break;
            }
            self.outgoing.drain(..sent);
        }
        Ok(())
    }
}
