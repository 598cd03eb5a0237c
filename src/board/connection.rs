//! A board on a serial line: find out who it is, tell it what to do, await its samples.
//!
//! ```text
//! port -> reader thread -> bounded channel -> Intake -> Board::next (async)
//! ```
//!
//! Opening a port resets many boards; how long that takes differs (0.8 to 3 s), so the board is asked
//! until it answers instead of waiting for a fixed time.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use firmware_protocol::{
    ALIVE_INTERVAL_MS, BAUD, CHUNK_SEGMENTS, Chunk, EndReason, Hello, HostMessage, MAX_WIRE,
    PROTOCOL_VERSION, ProfileSegment, Refusal, profile_crc,
};
use tokio::time::timeout;

use super::{
    Arrival, Damage, Event, Expectations, Heard, Intake, LineReader, OpenError, Port, Sample,
    longest_gather, rawlog,
};

/// How often a silent board is asked who it is.
const ASK_EVERY: Duration = Duration::from_millis(250);

/// How long an answer may take, and how often a message is sent in all.
const ANSWER_WITHIN: Duration = Duration::from_millis(250);
const ATTEMPTS: u32 = 5;

/// Where a raw log goes.
pub type RawLog = rawlog::Writer<io::BufWriter<std::fs::File>>;

/// How to talk to a board.
#[derive(Debug)]
pub struct BoardOptions {
    /// Bits per second.
    pub baud: u32,
    /// How long a board may take to say who it is: a slow boot loader takes 3 s.
    pub patience: Duration,
    /// Write every byte with its time here.
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

/// What went wrong with a board.
#[derive(Debug, thiserror::Error)]
pub enum BoardError {
    /// The port cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Something else is on the line.
    #[error(
        "{path} is not a motorlab board: {}", heard_instead(heard, *patience_s)
    )]
    NotABoard {
        /// The port.
        path: PathBuf,
        /// What came instead.
        heard: Box<Heard>,
        /// For how long it was asked.
        patience_s: f64,
    },
    /// It speaks another version.
    #[error(
        "the board on {path} speaks protocol version {found}, this program version {PROTOCOL_VERSION}: update the sketch on the board"
    )]
    OtherVersion {
        /// The port.
        path: PathBuf,
        /// The board's version.
        found: u8,
    },
    /// It refused a message.
    #[error("the board on {path} refused {what}: {reason}{}", refusal_advice(*reason, hello))]
    Refused {
        /// The port.
        path: PathBuf,
        /// What it refused.
        what: &'static str,
        /// Why.
        reason: Refusal,
        /// Who it is.
        hello: Box<Hello>,
    },
    /// It does not answer any more.
    #[error("the board on {path} does not answer {what} (asked {ATTEMPTS} times)")]
    NoAnswer {
        /// The port.
        path: PathBuf,
        /// What it was asked.
        what: &'static str,
    },
    /// It went away.
    #[error("the board on {path} was unplugged")]
    Gone {
        /// The port.
        path: PathBuf,
    },
    /// The line failed.
    #[error("the line to {path} failed: {source}")]
    Line {
        /// The port.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The profile does not fit on the wire.
    #[error("the profile commands {command} V, and a board takes -32.767 to 32.767 V")]
    Command {
        /// The command in V.
        command: f64,
    },
}

fn heard_instead(heard: &Heard, patience_s: f64) -> String {
    if heard.total() == 0 {
        return format!(
            "it sent nothing in {patience_s} s (is the motorlab sketch on it, and is this the right port?)"
        );
    }
    let hint = if heard.is_text() {
        "\n  this looks like a sketch that prints text: name its columns, such as --columns t_us,counts"
    } else {
        "\n  is the motorlab sketch on it, and is the baud rate right (--baud)?"
    };
    format!("it sent {heard}{hint}")
}

fn refusal_advice(reason: Refusal, hello: &Hello) -> String {
    match reason {
        Refusal::SampleTime => format!(
            "; its shortest is {} s (--ts)",
            f64::from(hello.shortest_sample_time_us) * 1e-6
        ),
        Refusal::ProfileTooLong => format!("; it holds {} segments", hello.max_segments),
        _ => String::new(),
    }
}

/// What comes from a board that records.
#[derive(Debug)]
pub enum BoardEvent {
    /// A sample.
    Sample(Sample),
    /// The recording is over; the board counts what it took.
    Ended {
        /// Samples taken.
        taken: u32,
        /// Of these, how many it could not send.
        dropped: u32,
        /// Why it is over.
        reason: EndReason,
    },
    /// The board was reset in mid-run.
    Restarted(Hello),
    /// The board went away.
    HungUp,
    /// The line failed.
    Failed(io::Error),
    /// The raw log cannot be written any further.
    LogFailed(io::Error),
}

/// An open, identified board.
#[derive(Debug)]
pub struct Board {
    path: PathBuf,
    hello: Hello,
    reader: LineReader,
    baud: u32,
    /// How long the bytes of samples may gather before they are read.
    gather: Duration,
    line: Arc<Line>,
    intake: Intake,
    events: VecDeque<Event>,
    alive: Option<tokio::task::JoinHandle<()>>,
    over: bool,
    /// What ended the line, until it is told.
    last: Option<BoardEvent>,
}

/// The writing side of the line, with the raw log of both.
#[derive(Debug)]
struct Line {
    port: Mutex<Port>,
    log: Mutex<Option<RawLog>>,
    origin: Instant,
}

impl Line {
    fn say(&self, message: &HostMessage) -> io::Result<()> {
        let mut wire = [0; MAX_WIRE + 1];
        // A leading zero ends whatever noise came before.
        let length = message.encode(&mut wire[1..]).unwrap_or(0);
        let bytes = &wire[..=length];
        let mut port = self.port.lock().unwrap_or_else(PoisonError::into_inner);
        port.write_all(bytes)?;
        self.log(|log, now_us| log.to_board(now_us, bytes))
    }

    fn log(&self, write: impl FnOnce(&mut RawLog, u64) -> io::Result<()>) -> io::Result<()> {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        match log.as_mut() {
            Some(log) => write(log, self.origin.elapsed().as_micros() as u64),
            None => Ok(()),
        }
    }
}

impl Board {
    /// Opens the port for this program alone and asks the board who it is.
    pub async fn open(path: &Path, options: BoardOptions) -> Result<Self, BoardError> {
        let port = Port::open(path, options.baud)?;
        let writer = port.try_clone().map_err(|source| BoardError::Line {
            path: path.to_owned(),
            source,
        })?;
        Self::over(path, port, writer, options).await
    }

    /// As [`Board::open`], reading through something that stands in the line, such as
    /// [`crate::board::faults::FaultyPort`].
    pub async fn over(
        path: &Path,
        incoming: impl Read + Send + 'static,
        outgoing: Port,
        options: BoardOptions,
    ) -> Result<Self, BoardError> {
        let origin = Instant::now();
        let failed = |source| BoardError::Line {
            path: path.to_owned(),
            source,
        };
        let mut reader = LineReader::spawn(incoming, origin).map_err(failed)?;
        let line = Arc::new(Line {
            port: Mutex::new(outgoing),
            log: Mutex::new(options.log),
            origin,
        });
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
                let gone = receive(arrival, &mut intake, &line, &mut events).map_err(failed)?;
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

    /// Who the board is.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// What went wrong on the line so far.
    pub fn damage(&self) -> Damage {
        self.intake.damage()
    }

    /// Host time now in microseconds, on the scale of the samples' arrival times.
    pub fn now_us(&self) -> u64 {
        self.reader.now_us()
    }

    /// Sets the sample time and uploads the profile: for how many samples which command in V.
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
        for piece in segments.chunks(CHUNK_SEGMENTS) {
            let Some(chunk) = Chunk::new(first, piece) else {
                continue;
            };
            first += piece.len() as u16;
            self.request(&HostMessage::Chunk(chunk), first, "a piece of the profile")
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

    /// Starts a recording of so many samples, or until [`Board::stop`] where that is 0. From now on the
    /// board is told that this program is alive.
    pub async fn start(&mut self, samples: u32) -> Result<(), BoardError> {
        self.events.clear();
        self.request(&HostMessage::Start { samples }, 0, "START")
            .await?;
        self.reader.gather(self.gather);
        let line = Arc::clone(&self.line);
        self.alive = Some(tokio::spawn(async move {
            let every = Duration::from_millis(u64::from(ALIVE_INTERVAL_MS) * 2 / 3);
            let mut tick = tokio::time::interval(every);
            tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
            loop {
                tick.tick().await;
                // A line that is gone shows on the reading side.
                let _ = line.say(&HostMessage::Alive);
            }
        }));
        Ok(())
    }

    /// Asks the board to stop; its END comes as an event.
    pub fn stop(&mut self) -> io::Result<()> {
        self.line.say(&HostMessage::Stop)
    }

    /// The next event of a recording; `None` when nothing can follow any more. Safe to cancel.
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
            match receive(arrival, &mut self.intake, &self.line, &mut self.events) {
                Ok(None) => {}
                Ok(last) => {
                    self.over = true;
                    self.last = last;
                    self.silence();
                }
                Err(error) => return Some(BoardEvent::LogFailed(error)),
            }
        }
    }

    /// Hands what the raw log holds to the operating system.
    pub fn flush_log(&self) -> io::Result<()> {
        self.line.log(|log, _| log.flush())
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
            Event::Hello(hello) if hello.boot_id != self.hello.boot_id => {
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

    /// Ends the ALIVE messages; what comes from now on is read as it comes.
    fn silence(&mut self) {
        self.reader.gather(Duration::ZERO);
        if let Some(alive) = self.alive.take() {
            alive.abort();
        }
    }

    /// Sends a message until it is taken.
    async fn request(
        &mut self,
        message: &HostMessage,
        expected: u16,
        what: &'static str,
    ) -> Result<(), BoardError> {
        let path = self.path.clone();
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
                let gone = receive(arrival, &mut self.intake, &self.line, &mut self.events)
                    .map_err(|source| BoardError::Line {
                        path: path.clone(),
                        source,
                    })?;
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

    /// Looks for the answer to a message of `kind` among the events; a sample answers START.
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
            // What was said before is past; what came after (the first samples) stays.
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

/// Takes in one arrival; what ends the line comes back.
fn receive(
    arrival: Option<Arrival>,
    intake: &mut Intake,
    line: &Line,
    events: &mut VecDeque<Event>,
) -> io::Result<Option<BoardEvent>> {
    match arrival {
        Some(Arrival::Bytes { host_us, bytes }) => {
            line.log(|log, _| log.from_board(host_us, &bytes))?;
            intake.push(host_us, &bytes, |event| events.push_back(event));
            Ok(None)
        }
        Some(Arrival::HungUp { host_us }) => {
            line.log(|log, _| log.hang_up(host_us))?;
            Ok(Some(BoardEvent::HungUp))
        }
        Some(Arrival::Failed(error)) => Ok(Some(BoardEvent::Failed(error))),
        None => Ok(Some(BoardEvent::HungUp)),
    }
}

/// A profile as it goes over the wire; holds of more than 65,535 samples are split.
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
