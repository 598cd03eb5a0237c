//! A raw log as a virtual serial device with the behaviour of the recorded board.
//!
//! It responds to the handshake itself, independent of how the host splits its messages, and refuses a sample time
//! that differs from the recorded one. From START on it plays the log's bytes, at their times or faster. A log
//! without a HELLO (a sketch that prints text) is played from the opening on.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use firmware_protocol::{
    BoardFields, BoardMessage, FrameDecoder, HostMessage, MAX_WIRE, Refusal, host_message::kind,
};

use super::board_side::BoardSide;
use super::pty::Pty;
use super::rawlog::Event;

/// Longest wait in one turn, and so the delay with which a stopped device ends.
const TURN: Duration = Duration::from_millis(20);

/// Events of a log for playback.
#[derive(Debug, Clone, Default)]
struct Script {
    /// The HELLO frame.
    hello: Option<Vec<u8>>,
    sample_time_us: Option<u32>,
    /// Bytes of the board from the response to START on, with microseconds from there.
    played: Vec<(u64, Vec<u8>)>,
    hangs_up: bool,
}

impl Script {
    fn new(events: &[(u64, Event)]) -> Self {
        let mut script = Self::default();
        let mut from_board = FrameDecoder::new();
        let mut to_board = FrameDecoder::new();
        let mut started_us = None;
        let first_us = events.first().map_or(0, |(at_us, _)| *at_us);
        for (at_us, event) in events {
            match event {
                Event::ToBoard(bytes) => {
                    for &byte in bytes {
                        match to_board
                            .push(byte)
                            .map(|frame| frame.map(HostMessage::parse))
                        {
                            Some(Ok(Ok(HostMessage::Configure { sample_time_us, .. }))) => {
                                script.sample_time_us = Some(sample_time_us);
                            }
                            Some(Ok(Ok(HostMessage::Start { .. }))) => {
                                started_us = Some(*at_us);
                                script.played.clear();
                            }
                            _ => {}
                        }
                    }
                }
                Event::FromBoard(bytes) => {
                    for &byte in bytes {
                        if let Some(Ok(frame)) = from_board.push(byte)
                            && let Ok(message @ BoardMessage::Hello(_)) =
                                BoardMessage::parse(frame, BoardFields::default())
                        {
                            script.hello = encoded(&message);
                        }
                    }
                    let origin_us = started_us.unwrap_or(first_us);
                    script
                        .played
                        .push((at_us.saturating_sub(origin_us), bytes.clone()));
                }
                Event::HangUp => script.hangs_up = true,
            }
        }
        script
    }
}

fn encoded(message: &BoardMessage) -> Option<Vec<u8>> {
    let mut wire = [0; MAX_WIRE];
    let length = message.encode(&mut wire)?;
    Some(wire[..length].to_vec())
}

/// A device that plays a log; dropping it unplugs it.
#[derive(Debug)]
pub struct ReplayedDevice {
    path: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl ReplayedDevice {
    /// Plugs in a device that plays `events`, `faster` times as fast; `None` is as fast as they are read.
    pub fn spawn(events: &[(u64, Event)], faster: Option<f64>) -> io::Result<Self> {
        let pty = Pty::open()?;
        let path = pty.path().to_owned();
        let stop = Arc::new(AtomicBool::new(false));
        let script = Script::new(events);
        let thread = thread::Builder::new().name("replay".to_owned()).spawn({
            let stop = Arc::clone(&stop);
            move || {
                let mut playing = Playback {
                    pty,
                    script,
                    faster,
                    outgoing: Vec::new(),
                    decoder: FrameDecoder::new(),
                    connected: false,
                    playing: None,
                    over: false,
                };
                playing.run(&stop)
            }
        })?;
        Ok(Self {
            path,
            stop,
            thread: Some(thread),
        })
    }

    /// The serial port to open.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the log has reached its hang-up.
    pub fn is_gone(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for ReplayedDevice {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct Playback {
    pty: Pty,
    script: Script,
    faster: Option<f64>,
    outgoing: Vec<u8>,
    decoder: FrameDecoder,
    connected: bool,
    /// Start of playback, and the index of the next event.
    playing: Option<(Instant, usize)>,
    over: bool,
}

impl Playback {
    fn run(&mut self, stop: &AtomicBool) -> io::Result<()> {
        while !stop.load(Ordering::Relaxed) && !self.over {
            let ready = self.pty.wait(self.patience(), !self.outgoing.is_empty())?;
            if !ready.connected {
                if std::mem::take(&mut self.connected) {
                    self.playing = None;
                    self.outgoing.clear();
                    self.pty.discard();
                }
                thread::sleep(Duration::from_millis(2));
                continue;
            }
            if !self.connected {
                self.connected = true;
                self.decoder.reset();
                match self.script.hello.clone() {
                    Some(hello) => self.outgoing.extend(hello),
                    None => self.playing = Some((Instant::now(), 0)),
                }
            }
            if ready.readable {
                self.listen()?;
            }
            self.play();
            let sent = self.pty.write_some(&self.outgoing)?;
            self.outgoing.drain(..sent);
        }
        self.pty.let_it_drain(&mut self.outgoing, self.connected)
    }

    fn due(&self) -> Option<Duration> {
        let (begun, index) = self.playing?;
        let (at_us, _) = self.script.played.get(index)?;
        let at = match self.faster {
            Some(factor) => {
                Duration::try_from_secs_f64(*at_us as f64 * 1e-6 / factor).unwrap_or(Duration::MAX)
            }
            None => Duration::ZERO,
        };
        Some(at.saturating_sub(begun.elapsed()))
    }

    fn patience(&self) -> Duration {
        if self.outgoing.is_empty() {
            self.due().unwrap_or(TURN).min(TURN)
        } else {
            TURN
        }
    }

    fn play(&mut self) {
        while self.outgoing.len() < 4096 && self.due() == Some(Duration::ZERO) {
            let Some((_, index)) = &mut self.playing else {
                return;
            };
            let bytes = &self.script.played[*index].1;
            *index += 1;
            self.outgoing.extend_from_slice(bytes);
        }
        let played = self.playing.is_some() && self.due().is_none();
        if played && self.outgoing.is_empty() && self.script.hangs_up {
            self.over = true;
        }
    }

    fn listen(&mut self) -> io::Result<()> {
        let mut buffer = [0; 1024];
        let count = self.pty.read_some(&mut buffer)?;
        for &byte in &buffer[..count] {
            let message = match self.decoder.push(byte) {
                Some(Ok(frame)) => HostMessage::parse(frame),
                _ => continue,
            };
            if let Ok(message) = message {
                self.answer(&message);
            }
        }
        Ok(())
    }

    fn answer(&mut self, message: &HostMessage) {
        let of = message.kind();
        let ack = |detail| BoardMessage::Ack { of, detail };
        let answer = match message {
            HostMessage::Identify => {
                let hello = self.script.hello.iter().flatten();
                self.outgoing.extend(hello);
                return;
            }
            HostMessage::Configure { sample_time_us, .. } => {
                let recorded = self.script.sample_time_us.unwrap_or(*sample_time_us);
                if recorded == *sample_time_us {
                    ack(0)
                } else {
                    BoardMessage::Nak {
                        of: kind::CONFIGURE,
                        reason: Refusal::SampleTime,
                    }
                }
            }
            HostMessage::Profile { .. } => ack(0),
            HostMessage::Chunk(chunk) => ack(chunk.first + chunk.segments().len() as u16),
            HostMessage::Start { .. } => {
                // The response to START is in the log.
                self.playing.get_or_insert((Instant::now(), 0));
                return;
            }
            HostMessage::Stop | HostMessage::Alive => return,
        };
        self.outgoing.extend(encoded(&answer).into_iter().flatten());
    }
}
