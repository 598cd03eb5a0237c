//! A board on a serial line: identification, configuration, samples.
//!
//! ```text
//! port -> reader thread -> bounded channel -> Intake -> Board::next (async)
//! ```
//!
//! Opening a port resets many boards; the boot takes 0.8 to 3 s, so that the board is queried until it responds.

use std::collections::VecDeque;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use firmware_protocol::{
    BAUD, CHUNK_SEGMENTS, Chunk, EndReason, Hello, HostMessage, ProfileSegment, Refusal,
    profile_crc,
};

use super::intake::is_same_board;
use super::line::{ALIVE_EVERY, ATTEMPTS, Line};
use super::{
    Arrival, BoardError, Damage, Event, Expectations, Intake, LineReader, Location, RawLog, Sample,
    SerialLine, longest_gather,
};
use crate::platform::time::{Instant, JoinHandle, MissedTickBehavior, interval, spawn, timeout};

/// Query period for a silent board.
const ASK_EVERY: Duration = Duration::from_millis(250);

/// Time limit for a response.
const ANSWER_WITHIN: Duration = Duration::from_millis(250);

/// Settings of the connection to a board.
#[derive(Debug)]
pub struct BoardOptions {
    /// Bits per second.
    pub baud: u32,
    /// Time limit for the HELLO: a slow boot loader takes 3 s.
    pub patience: Duration,
    /// Raw log of all bytes with their times.
    pub log: Option<RawLog>,
}

impl Default for BoardOptions {
    fn default() -> Self {
        Self {
            baud: BAUD,
            patience: Duration::from_secs(6),
            log: None,
        }
    }
}

/// Events of a recording board.
#[derive(Debug)]
pub enum BoardEvent {
    /// A sample.
    Sample(Sample),
    /// The end of the recording, with the board's sample counters.
    Ended {
        /// Samples taken.
        taken: u32,
        /// Samples that it could not send.
        dropped: u32,
        /// Reason.
        reason: EndReason,
    },
    /// Another HELLO during the run; a different `boot_id` means a reset.
    Restarted(Hello),
    /// The board was unplugged.
    HungUp,
    /// The line failed.
    Failed(io::Error),
}

/// An open, identified board.
#[derive(Debug)]
pub struct Board {
    path: PathBuf,
    hello: Hello,
    reader: LineReader,
    baud: u32,
    /// How long bytes may accumulate before they are read.
    gather: Duration,
    line: Arc<Line>,
    intake: Intake,
    events: VecDeque<Event>,
    alive: Option<JoinHandle<()>>,
    over: bool,
    /// The final event, until it is reported.
    last: Option<BoardEvent>,
}

impl Board {
    /// Opens the line exclusively and queries the board's identity.
    pub async fn open(
        location: impl Into<Location>,
        options: BoardOptions,
    ) -> Result<Self, BoardError> {
        let location = location.into();
        let path = location.path();
        let port = location.open(options.baud)?;
        let writer = port.try_clone().map_err(|source| BoardError::Line {
            path: path.to_owned(),
            source,
        })?;
        Self::over(path, port, writer, options).await
    }

    /// As [`Board::open`], with a filter in the line such as [`crate::board::faults::FaultyPort`].
    pub async fn over(
        path: &Path,
        incoming: impl Read + Send + 'static,
        outgoing: Box<dyn SerialLine>,
        options: BoardOptions,
    ) -> Result<Self, BoardError> {
        let origin = Instant::now();
        let failed = |source| BoardError::Line {
            path: path.to_owned(),
            source,
        };
        let mut reader = LineReader::spawn(incoming, origin).map_err(failed)?;
        let line = Arc::new(Line::new(outgoing, options.log, origin));
        let mut intake = Intake::default();
        let mut events = VecDeque::new();
        let until = origin + options.patience;
        loop {
            line.say(&HostMessage::Identify).map_err(failed)?;
            let asked_again = Instant::now() + ASK_EVERY;
            while let Some(left) = asked_again.checked_duration_since(Instant::now()) {
                let Ok(arrival) = timeout(left, reader.next()).await else {
                    break;
                };
                let gone = receive(arrival, &mut intake, &line, &mut events);
                while let Some(event) = events.pop_front() {
                    match event {
                        Event::Hello(hello) => {
                            return Ok(Self {
                                path: path.to_owned(),
                                hello,
                                reader,
                                baud: options.baud,
                                gather: Duration::ZERO,
                                line,
                                intake,
                                events,
                                alive: None,
                                over: false,
                                last: None,
                            });
                        }
                        Event::OtherVersion(found) => {
                            return Err(BoardError::OtherVersion {
                                path: path.to_owned(),
                                found,
                            });
                        }
                        _ => {}
                    }
                }
                if gone.is_some() {
                    return Err(BoardError::Gone {
                        path: path.to_owned(),
                    });
                }
            }
            if Instant::now() >= until {
                return Err(BoardError::NotABoard {
                    path: path.to_owned(),
                    heard: Box::new(intake.heard().clone()),
                    patience_s: options.patience.as_secs_f64(),
                });
            }
        }
    }

    /// The port that it is on.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Overrides the encoder's resolution in counts per revolution.
    pub fn encoder(&mut self, counts_per_rev: f64) {
        self.intake.encoder(counts_per_rev);
    }

    /// The board's HELLO.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Damage on the line so far.
    pub fn damage(&self) -> Damage {
        self.intake.damage()
    }

    /// Host time now in microseconds, on the scale of the samples' arrival times.
    pub fn now_us(&self) -> u64 {
        self.reader.now_us()
    }

    /// Sets the sample time and uploads the profile: pairs of number of samples and command in V.
    pub async fn configure(
        &mut self,
        sample_time_us: u32,
        commands: &[(usize, f64)],
    ) -> Result<(), BoardError> {
        let segments = wire_segments(commands)?;
        let configure = HostMessage::Configure {
            sample_time_us,
            coast_at_zero: false,
        };
        self.request(&configure, 0, "the sample time").await?;
        let announce = HostMessage::Profile {
            segments: segments.len() as u16,
            crc: profile_crc(segments.iter().copied()),
        };
        self.request(&announce, 0, "the profile").await?;
        let mut first = 0_u16;
        for part in segments.chunks(CHUNK_SEGMENTS) {
            let Some(chunk) = Chunk::new(first, part) else {
                continue;
            };
            first += part.len() as u16;
            self.request(&HostMessage::Chunk(chunk), first, "a part of the profile")
                .await?;
        }
        let sample_time = Duration::from_micros(u64::from(sample_time_us));
        self.gather = longest_gather(self.baud, sample_time);
        self.intake.expect(Expectations {
            sample_time_us,
            commands: segments
                .iter()
                .map(|segment| (u64::from(segment.samples), segment.command_mv))
                .collect(),
        });
        Ok(())
    }

    /// Starts a recording of this many samples, or until [`Board::stop`] for 0. From now on ALIVE messages are sent.
    pub async fn start(&mut self, samples: u32) -> Result<(), BoardError> {
        self.events.clear();
        self.request(&HostMessage::Start { samples }, 0, "START")
            .await?;
        self.reader.gather(self.gather);
        let line = Arc::clone(&self.line);
        self.alive = Some(spawn(async move {
            let mut tick = interval(ALIVE_EVERY);
            tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
            loop {
                tick.tick().await;
                line.say_alive();
            }
        }));
        Ok(())
    }

    /// Sends STOP; the END arrives as an event.
    pub fn stop(&mut self) -> io::Result<()> {
        self.line.say(&HostMessage::Stop)
    }

    /// The next event of a recording; `None` at its end. Cancel-safe.
    pub async fn next(&mut self) -> Option<BoardEvent> {
        loop {
            while let Some(event) = self.events.pop_front() {
                if let Some(event) = self.event_for_recorder(event) {
                    return Some(event);
                }
            }
            if self.over {
                return self.last.take();
            }
            let arrival = self.reader.next().await;
            if self.alive.is_some() && self.line.is_quiet() {
                self.line.say_alive();
            }
            match receive(arrival, &mut self.intake, &self.line, &mut self.events) {
                None => {}
                last => {
                    self.over = true;
                    self.last = last;
                    self.silence();
                }
            }
        }
    }

    /// Flushes the raw log to the operating system.
    pub fn flush_log(&self) {
        self.line.log(|log, _| log.flush());
    }

    fn event_for_recorder(&mut self, event: Event) -> Option<BoardEvent> {
        match event {
            Event::Sample(sample) => Some(BoardEvent::Sample(sample)),
            Event::End {
                taken,
                dropped,
                reason,
            } => {
                self.silence();
                Some(BoardEvent::Ended {
                    taken,
                    dropped,
                    reason,
                })
            }
            Event::Hello(hello) => {
                self.silence();
                Some(BoardEvent::Restarted(hello))
            }
            _ => None,
        }
    }

    /// Whether an event is there already.
    pub fn has_more(&self) -> bool {
        !self.events.is_empty()
    }

    /// Ends the ALIVE messages and the accumulation of bytes.
    fn silence(&mut self) {
        self.reader.gather(Duration::ZERO);
        if let Some(alive) = self.alive.take() {
            alive.abort();
        }
    }

    /// Sends a message until it is acknowledged.
    async fn request(
        &mut self,
        message: &HostMessage,
        expected: u16,
        what: &'static str,
    ) -> Result<(), BoardError> {
        let path = self.path.clone();
        let is_first = matches!(message, HostMessage::Configure { .. });
        for _ in 0..ATTEMPTS {
            self.line.say(message).map_err(|source| BoardError::Line {
                path: path.clone(),
                source,
            })?;
            let until = Instant::now() + ANSWER_WITHIN;
            while let Some(left) = until.checked_duration_since(Instant::now()) {
                let Ok(arrival) = timeout(left, self.reader.next()).await else {
                    break;
                };
                let gone = receive(arrival, &mut self.intake, &self.line, &mut self.events);
                if let Some(hello) = self.other_hello() {
                    if !is_first {
                        return Err(BoardError::Restarted { path });
                    }
                    // A late reset caused by opening the port.
                    self.hello = hello;
                }
                if let Some(answer) = self.answer_to(message.kind(), expected) {
                    return answer.map_err(|reason| BoardError::Refused {
                        path,
                        what,
                        reason,
                        hello: Box::new(self.hello),
                    });
                }
                if gone.is_some() {
                    return Err(BoardError::Gone { path });
                }
            }
        }
        Err(BoardError::NoAnswer { path, what })
    }

    /// A HELLO among the events that differs from the previous one.
    fn other_hello(&self) -> Option<Hello> {
        let mut hellos = self.events.iter().filter_map(|event| match event {
            Event::Hello(hello) => Some(*hello),
            _ => None,
        });
        hellos
            .next_back()
            .filter(|hello| !is_same_board(&self.hello, hello))
    }

    /// Searches the events for the response to a message of `kind`; a sample is a response to START.
    fn answer_to(&mut self, kind: u8, expected: u16) -> Option<Result<(), Refusal>> {
        for index in 0..self.events.len() {
            let answer = match self.events[index] {
                Event::Ack { of, detail } if of == kind && detail == expected => Ok(()),
                Event::Nak { of, reason } if of == kind => Err(reason),
                Event::Sample(_) if kind == firmware_protocol::host_message::kind::START => {
                    return Some(Ok(()));
                }
                _ => continue,
            };
            // Earlier events are obsolete; later ones (the first samples) are kept.
            self.events.drain(..=index);
            return Some(answer);
        }
        None
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.silence();
    }
}

/// Processes one arrival; returns an event that ends the line.
fn receive(
    arrival: Option<Arrival>,
    intake: &mut Intake,
    line: &Line,
    events: &mut VecDeque<Event>,
) -> Option<BoardEvent> {
    match arrival {
        Some(Arrival::Bytes { host_us, bytes }) => {
            line.log(|log, _| log.received(host_us, &bytes));
            intake.push(host_us, &bytes, |event| events.push_back(event));
            None
        }
        Some(Arrival::HungUp { host_us }) => {
            line.log(|log, _| log.hang_up(host_us));
            Some(BoardEvent::HungUp)
        }
        Some(Arrival::Failed(error)) => Some(BoardEvent::Failed(error)),
        None => Some(BoardEvent::HungUp),
    }
}

/// The profile in the wire format; holds of more than 65,535 samples are split.
pub fn wire_segments(commands: &[(usize, f64)]) -> Result<Vec<ProfileSegment>, BoardError> {
    let mut segments = Vec::new();
    for &(length, command) in commands {
        let millivolts = (command * 1000.0).round();
        if millivolts.is_nan() || millivolts.abs() > f64::from(i16::MAX) {
            return Err(BoardError::Command { command });
        }
        let mut left = length;
        while left > 0 {
            let samples = left.min(usize::from(u16::MAX));
            segments.push(ProfileSegment {
                samples: samples as u16,
                command_mv: millivolts as i16,
            });
            left -= samples;
        }
    }
    Ok(segments)
}
