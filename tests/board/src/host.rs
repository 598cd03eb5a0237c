//! A host in the same process and in the board's time: deterministic.

use firmware_protocol::{
    ALIVE_INTERVAL_MS, BoardFields, BoardMessage, CHUNK_SEGMENTS, Chunk, FrameDecoder, Hello,
    HostMessage, MAX_WIRE, ProfileSegment, Sample, profile_crc,
};

use crate::board::Board;
use crate::mcu::{CLOCK_HZ, McuError};

/// A message of the board with the cycle of its last byte.
pub type Heard = (u64, BoardMessage);

/// Errors of a conversation with the board.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// The processor stopped.
    #[error(transparent)]
    Mcu(#[from] McuError),
    /// The awaited message did not arrive.
    #[error("the board did not say {what} within {within_s} s; it said {heard:?}")]
    NotHeard {
        /// What.
        what: String,
        /// Time limit in s.
        within_s: f64,
        /// Messages received instead.
        heard: Vec<BoardMessage>,
    },
}

/// A host of a board.
pub struct Host {
    /// The board.
    pub board: Board,
    /// Whether ALIVE is sent as PROTOCOL.md requires.
    pub alive: bool,
    /// Damaged frames and invalid messages.
    pub bad_frames: usize,
    decoder: FrameDecoder,
    heard: Vec<Heard>,
    said_alive: u64,
}

impl Host {
    /// A host of a board that has just been powered up.
    pub fn new(board: Board) -> Self {
        Self {
            board,
            alive: true,
            bad_frames: 0,
            decoder: FrameDecoder::new(),
            heard: Vec::new(),
            said_alive: 0,
        }
    }

    pub fn say(&mut self, message: &HostMessage) {
        let mut wire = [0; MAX_WIRE];
        let length = message.encode(&mut wire).unwrap_or(0);
        self.board.receive(&wire[..length]);
    }

    pub fn run_for(&mut self, duration_s: f64) -> Result<(), McuError> {
        let ends = self.board.cycle() + (duration_s * CLOCK_HZ as f64).round() as u64;
        while self.board.cycle() < ends {
            let now = self.board.cycle();
            let every = u64::from(ALIVE_INTERVAL_MS) * 2 / 3 * CLOCK_HZ / 1000;
            if self.alive && now >= self.said_alive + every {
                self.said_alive = now;
                self.say(&HostMessage::Alive);
            }
            self.board.run_until(ends.min(now + CLOCK_HZ / 1000))?;
            self.listen();
        }
        Ok(())
    }

    fn listen(&mut self) {
        for sent in self.board.take_sent() {
            match self.decoder.push(sent.byte) {
                None => {}
                Some(Ok(frame)) => match BoardMessage::parse(frame, BoardFields::default()) {
                    Ok(message) => self.heard.push((sent.cycle, message)),
                    Err(_) => self.bad_frames += 1,
                },
                Some(Err(_)) => self.bad_frames += 1,
            }
        }
    }

    /// Messages since the last call.
    pub fn take_heard(&mut self) -> Vec<Heard> {
        std::mem::take(&mut self.heard)
    }

    /// Advances until the board sends a message for which `wanted` returns a value; earlier ones are discarded, later
    /// ones are kept.
    pub fn hear<T>(
        &mut self,
        what: &str,
        within_s: f64,
        mut wanted: impl FnMut(&BoardMessage) -> Option<T>,
    ) -> Result<T, HostError> {
        let ends = self.board.cycle() + (within_s * CLOCK_HZ as f64) as u64;
        let mut looked = 0;
        loop {
            while looked < self.heard.len() {
                if let Some(found) = wanted(&self.heard[looked].1) {
                    self.heard.drain(..=looked);
                    return Ok(found);
                }
                looked += 1;
            }
            if self.board.cycle() >= ends {
                return Err(HostError::NotHeard {
                    what: what.to_owned(),
                    within_s,
                    heard: self.heard.iter().map(|heard| heard.1).collect(),
                });
            }
            self.run_for(0.001)?;
        }
    }

    /// Waits for HELLO.
    pub fn hello(&mut self) -> Result<Hello, HostError> {
        self.hear("HELLO", 3.0, |message| match message {
            BoardMessage::Hello(hello) => Some(*hello),
            _ => None,
        })
    }

    /// Sends a message and waits for ACK.
    pub fn ask(&mut self, message: &HostMessage) -> Result<u16, HostError> {
        self.say(message);
        let kind = message.kind();
        self.hear(&format!("ACK of {message:?}"), 0.25, |heard| match heard {
            BoardMessage::Ack { of, detail } if *of == kind => Some(*detail),
            _ => None,
        })
    }

    /// Sets sample time and profile.
    pub fn configure(
        &mut self,
        sample_time_us: u32,
        coast_at_zero: bool,
        profile: &[(u16, i16)],
    ) -> Result<(), HostError> {
        self.ask(&HostMessage::Configure {
            sample_time_us,
            coast_at_zero,
        })?;
        let segments: Vec<ProfileSegment> = profile
            .iter()
            .map(|&(samples, command_mv)| ProfileSegment {
                samples,
                command_mv,
            })
            .collect();
        self.ask(&HostMessage::Profile {
            segments: segments.len() as u16,
            crc: profile_crc(segments.iter().copied()),
        })?;
        let mut first = 0;
        for part in segments.chunks(CHUNK_SEGMENTS) {
            if let Some(chunk) = Chunk::new(first, part) {
                first = self.ask(&HostMessage::Chunk(chunk))?;
            }
        }
        Ok(())
    }

    /// Records this many samples; returns them and END.
    pub fn record(&mut self, samples: u32) -> Result<(Vec<Sample>, BoardMessage), HostError> {
        self.ask(&HostMessage::Start { samples })?;
        self.until_end(3600.0)
    }

    /// Samples until END, and END.
    pub fn until_end(&mut self, within_s: f64) -> Result<(Vec<Sample>, BoardMessage), HostError> {
        let mut samples = Vec::new();
        let end = self.hear("END", within_s, |message| match message {
            BoardMessage::Data(sample) => {
                samples.push(*sample);
                None
            }
            BoardMessage::End { .. } => Some(*message),
            _ => None,
        })?;
        Ok((samples, end))
    }
}
