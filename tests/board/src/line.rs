//! The board's serial port at a pseudo-terminal, for programs that open serial ports.
//!
//! Opening it resets the board, as DTR does. In real time the board's clock follows the wall clock. In *held* time
//! the board stands still while it has nothing to do, runs as fast as possible while it records, and receives ALIVE
//! every 100 ms of its own time, independent of the host's program: the same commands then give the bitwise same
//! recording on any machine.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, Read};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use firmware_protocol::host_message::kind as host_kind;
use firmware_protocol::{
    ALIVE_INTERVAL_MS, BoardFields, BoardMessage, FrameDecoder, HostMessage, MAX_WIRE,
};
use motorlab::board::BoardSide;
use motorlab::board::faults::{Faults, FaultyPort};
use motorlab::board::pty::Pty;

use crate::board::Board;
use crate::mcu::{CLOCK_HZ, McuError};

/// Rate of the board's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pace {
    /// That of the wall clock.
    RealTime,
    /// Only while there is something to do, then as fast as possible.
    #[default]
    Held,
}

/// Properties of the line.
#[derive(Debug, Clone, Default)]
pub struct LineOptions {
    /// How the board's time passes.
    pub pace: Pace,
    /// Faults on the bytes from the board.
    pub faults: Faults,
    /// Faults on the bytes to the board.
    pub faults_to_board: Faults,
    /// CSV file of the true events of the latest recording.
    pub truth: Option<PathBuf>,
    /// The board's micros() at the start of a recording, if it is to be changed.
    pub micros_at_start: Option<u32>,
    /// Time in s after START at which the board is reset.
    pub reset_after_s: Option<f64>,
}

/// Why the line ended.
#[derive(Debug, thiserror::Error)]
pub enum LineError {
    /// The processor stopped.
    #[error(transparent)]
    Mcu(#[from] McuError),
    /// The pseudo-terminal or the truth's file failed.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Most bytes that wait for the host, after which the board waits.
const MOST_OUTGOING: usize = 4096;
/// Largest lead of real time over the board.
const MOST_BEHIND: u64 = CLOCK_HZ / 10;
/// A step of board time.
const STEP: u64 = CLOCK_HZ / 1000;
/// Time that a board runs after a reset, and after a message, before it is held.
const AFTER_RESET: u64 = CLOCK_HZ / 5;
const AFTER_MESSAGE: u64 = CLOCK_HZ / 50;

struct Faulty {
    queue: Queue,
    port: FaultyPort<Queue>,
}

#[derive(Clone, Default)]
struct Queue(Rc<RefCell<VecDeque<u8>>>);

impl Read for Queue {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.borrow_mut().read(buffer)
    }
}

impl Faulty {
    fn new(faults: Faults) -> Self {
        let queue = Queue::default();
        Self {
            port: FaultyPort::new(queue.clone(), faults),
            queue,
        }
    }

    fn pass(&mut self, bytes: &[u8], into: &mut Vec<u8>) {
        self.queue.0.borrow_mut().extend(bytes);
        let mut buffer = [0; 256];
        loop {
            match self.port.read(&mut buffer) {
                Ok(count) if count > 0 => into.extend_from_slice(&buffer[..count]),
                Err(error) if error.kind() == io::ErrorKind::TimedOut => {}
                _ => return,
            }
        }
    }
}

/// A board whose serial port is a pseudo-terminal.
pub struct Line {
    board: Board,
    pty: Pty,
    options: LineOptions,
    from_board: Faulty,
    to_board: Faulty,
    outgoing: Vec<u8>,
    connected: bool,
    /// Bytes of the host that the board has not received yet.
    said: Vec<u8>,
    /// The last message to the board, and whether it has responded.
    told: (Vec<u8>, bool),
    decoder: FrameDecoder,
    /// Board time up to which a held board runs.
    runs_until: u64,
    recording: bool,
    started: u64,
    said_alive: u64,
    /// Wall time and board time at the start of real time.
    origin: (Instant, u64),
}

impl Line {
    /// Puts the board's serial port at `pty`.
    pub fn new(board: Board, pty: Pty, options: LineOptions) -> Self {
        Self {
            origin: (Instant::now(), board.cycle()),
            from_board: Faulty::new(options.faults),
            to_board: Faulty::new(options.faults_to_board),
            board,
            pty,
            options,
            outgoing: Vec::new(),
            connected: false,
            said: Vec::new(),
            told: (Vec::new(), false),
            decoder: FrameDecoder::new(),
            runs_until: 0,
            recording: false,
            started: 0,
            said_alive: 0,
        }
    }

    /// Runs until `stop`; returns the board.
    pub fn run(mut self, stop: &AtomicBool) -> Result<Board, LineError> {
        while !stop.load(Ordering::Relaxed) {
            let ready = self.pty.wait(self.patience(), !self.outgoing.is_empty())?;
            if ready.connected != self.connected {
                self.plug(ready.connected)?;
            }
            if !self.connected {
                // A hang-up returns at once, whatever the timeout of `wait`.
                thread::sleep(Duration::from_millis(2));
            } else if ready.readable {
                let mut buffer = [0; 1024];
                let count = self.pty.read_some(&mut buffer)?;
                self.said.extend_from_slice(&buffer[..count]);
            }
            match self.options.pace {
                Pace::RealTime => self.follow_wall()?,
                Pace::Held if self.connected => self.go_on()?,
                Pace::Held => {}
            }
            let sent = self.pty.write_some(&self.outgoing)?;
            self.outgoing.drain(..sent);
        }
        self.pty.let_it_drain(&mut self.outgoing, self.connected)?;
        self.write_truth()?;
        Ok(self.board)
    }

    fn patience(&self) -> Duration {
        match self.options.pace {
            Pace::RealTime => Duration::from_millis(1),
            Pace::Held if self.may_go_on() => Duration::ZERO,
            Pace::Held => Duration::from_millis(20),
        }
    }

    fn may_go_on(&self) -> bool {
        let to_do = self.recording || self.board.cycle() < self.runs_until;
        to_do && self.outgoing.len() < MOST_OUTGOING
    }

    /// Handles opening and closing of the line.
    fn plug(&mut self, connected: bool) -> Result<(), LineError> {
        self.connected = connected;
        if connected {
            self.reset();
        } else {
            self.outgoing.clear();
            self.said.clear();
            self.pty.discard();
            self.write_truth()?;
        }
        Ok(())
    }

    fn reset(&mut self) {
        self.board.reset();
        self.board.take_sent();
        self.said.clear();
        self.told = (Vec::new(), false);
        self.decoder.reset();
        self.recording = false;
        self.runs_until = self.board.cycle() + AFTER_RESET;
    }

    fn write_truth(&self) -> Result<(), LineError> {
        if let Some(path) = &self.options.truth {
            // Renamed when complete: after a kill there is the old or the new one.
            let mut part = path.clone().into_os_string();
            part.push(".part");
            let file = std::fs::File::create(&part)?;
            self.board.truth().write_csv(io::BufWriter::new(file))?;
            std::fs::rename(&part, path)?;
        }
        Ok(())
    }

    /// Real time: bytes of the host arrive now.
    fn follow_wall(&mut self) -> Result<(), LineError> {
        let said = std::mem::take(&mut self.said);
        for frame in said.split_inclusive(|&byte| byte == 0) {
            self.tell(frame);
        }
        let passed = self.origin.0.elapsed().as_secs_f64() * CLOCK_HZ as f64;
        let mut until = self.origin.1 + passed as u64;
        // On a slow machine the board's time falls behind, and does not catch up.
        if until > self.board.cycle() + MOST_BEHIND {
            until = self.board.cycle() + MOST_BEHIND;
            self.origin = (Instant::now(), until);
        }
        while self.board.cycle() < until {
            self.step(until.min(self.board.cycle() + STEP))?;
        }
        Ok(())
    }

    /// Held time: one message at a time, and during a recording as fast as the host reads.
    fn go_on(&mut self) -> Result<(), LineError> {
        for _ in 0..50 {
            if self.recording || self.board.cycle() >= self.runs_until {
                self.tell_next();
            }
            if !self.may_go_on() {
                return Ok(());
            }
            let now = self.board.cycle();
            let every = u64::from(ALIVE_INTERVAL_MS) * 2 / 3 * STEP;
            if self.recording && now >= self.said_alive + every {
                self.said_alive = now;
                let mut wire = [0; MAX_WIRE];
                let length = HostMessage::Alive.encode(&mut wire).unwrap_or(0);
                self.board.receive(&wire[..length]);
            }
            self.step(now + STEP)?;
        }
        Ok(())
    }

    /// Passes the host's next message to a held board. IDENTIFY is not needed after a reset, and the frequency of
    /// ALIVE depends on the wall clock: neither is passed on. Nor is a message that the host repeats while its
    /// response is in transit, on a line without losses.
    fn tell_next(&mut self) {
        let Some(end) = self.said.iter().position(|&byte| byte == 0) else {
            return;
        };
        let frame: Vec<u8> = self.said.drain(..=end).collect();
        if frame.len() == 1
            || matches!(
                parse(&frame),
                Some(HostMessage::Alive | HostMessage::Identify)
            )
        {
            return;
        }
        let faultless = [self.options.faults, self.options.faults_to_board]
            .into_iter()
            .all(|faults| Faults { seed: 0, ..faults } == Faults::default());
        if faultless && self.told == (frame.clone(), true) {
            return;
        }
        self.told = (frame.clone(), false);
        self.tell(&frame);
        self.runs_until = self.board.cycle() + AFTER_MESSAGE;
    }

    fn tell(&mut self, frame: &[u8]) {
        if matches!(parse(frame), Some(HostMessage::Start { .. })) && !self.recording {
            self.board.clear_truth();
            self.started = self.board.cycle();
            self.said_alive = self.started;
            if let Some(micros) = self.options.micros_at_start {
                self.board.poke("timer0_overflow_count", micros >> 10);
            }
        }
        let mut hurt = Vec::new();
        self.to_board.pass(frame, &mut hurt);
        self.board.receive(&hurt);
    }

    /// Advances board time and sends the board's bytes to the line.
    fn step(&mut self, until: u64) -> Result<(), LineError> {
        self.board.run_until(until)?;
        for sent in self.board.take_sent() {
            self.from_board.pass(&[sent.byte], &mut self.outgoing);
            let Some(Ok(frame)) = self.decoder.push(sent.byte) else {
                continue;
            };
            match BoardMessage::parse(frame, BoardFields::default()) {
                Ok(BoardMessage::Ack { of, .. }) => {
                    self.told.1 = true;
                    self.recording |= of == host_kind::START;
                }
                Ok(BoardMessage::Nak { .. }) => self.told.1 = true,
                Ok(BoardMessage::End { .. }) => {
                    self.recording = false;
                    self.runs_until = until + AFTER_MESSAGE;
                    self.write_truth()?;
                }
                _ => {}
            }
        }
        let reset_at = self
            .options
            .reset_after_s
            .map(|after_s| self.started + (after_s * CLOCK_HZ as f64) as u64);
        if self.recording && reset_at.is_some_and(|at| self.board.cycle() >= at) {
            self.options.reset_after_s = None;
            self.reset();
        }
        Ok(())
    }
}

fn parse(frame: &[u8]) -> Option<HostMessage> {
    let mut decoder = FrameDecoder::new();
    for &byte in frame {
        if let Some(decoded) = decoder.push(byte) {
            return decoded.ok().and_then(|raw| HostMessage::parse(raw).ok());
        }
    }
    None
}
