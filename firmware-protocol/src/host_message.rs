//! Message of a host: IDENTIFY, CONFIGURE, PROFILE, CHUNK, START, STOP, ALIVE.

use crate::MessageError;
use crate::crc::{CRC_START, crc16};
use crate::fields::{Body, Fields};
use crate::frame::{RawFrame, encode_frame};

/// Frame types of a host's messages.
pub mod kind {
    /// Say HELLO.
    pub const IDENTIFY: u8 = 0x81;
    /// Sample time and what zero volts mean.
    pub const CONFIGURE: u8 = 0x82;
    /// A profile of so many segments follows.
    pub const PROFILE: u8 = 0x83;
    /// A part of the profile.
    pub const CHUNK: u8 = 0x84;
    /// Record.
    pub const START: u8 = 0x85;
    /// Stop recording.
    pub const STOP: u8 = 0x86;
    /// The host is still there.
    pub const ALIVE: u8 = 0x87;
}

/// Most segments that one CHUNK carries.
pub const CHUNK_SEGMENTS: usize = 12;

/// One held command of a profile: 4 bytes on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ProfileSegment {
    /// For how many samples it holds; the last segment's command holds on after them.
    pub samples: u16,
    /// The command in mV.
    pub command_mv: i16,
}

impl ProfileSegment {
    /// The bytes on the wire.
    pub fn to_bytes(self) -> [u8; 4] {
        let [a, b] = self.samples.to_le_bytes();
        let [c, d] = self.command_mv.to_le_bytes();
        [a, b, c, d]
    }
}

/// CRC-16 over the bytes of a whole profile, as PROFILE announces it.
pub fn profile_crc(segments: impl IntoIterator<Item = ProfileSegment>) -> u16 {
    segments
        .into_iter()
        .fold(CRC_START, |crc, segment| crc16(crc, &segment.to_bytes()))
}

/// Up to [`CHUNK_SEGMENTS`] segments of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Chunk {
    /// Index in the profile of the first segment.
    pub first: u16,
    segments: [ProfileSegment; CHUNK_SEGMENTS],
    length: u8,
}

impl Chunk {
    /// A chunk of the segments, or `None` where they are none or more than [`CHUNK_SEGMENTS`].
    pub fn new(first: u16, segments: &[ProfileSegment]) -> Option<Self> {
        if segments.is_empty() {
            return None;
        }
        let mut chunk = Self {
            first,
            length: segments.len() as u8,
            ..Self::default()
        };
        chunk
            .segments
            .get_mut(..segments.len())?
            .copy_from_slice(segments);
        Some(chunk)
    }

    /// Its segments.
    pub fn segments(&self) -> &[ProfileSegment] {
        &self.segments[..usize::from(self.length)]
    }
}

/// A validated message of a host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HostMessage {
    /// Say HELLO.
    Identify,
    /// Sample so, until configured otherwise.
    Configure {
        /// Sample time in microseconds.
        sample_time_us: u32,
        /// A command of 0 opens the motor's circuit (coast) where it otherwise shorts it (brake).
        coast_at_zero: bool,
    },
    /// A profile follows in chunks.
    Profile {
        /// How many segments it has.
        segments: u16,
        /// [`profile_crc`] of them all.
        crc: u16,
    },
    /// A part of the profile.
    Chunk(Chunk),
    /// Record so many samples, or until STOP where that is 0.
    Start {
        /// How many samples.
        samples: u32,
    },
    /// Stop recording; the motor goes off.
    Stop,
    /// The host is still there. A board that records and hears no frame for 0.5 s stops the motor.
    Alive,
}

impl HostMessage {
    /// The frame type of this message.
    pub fn kind(&self) -> u8 {
        match self {
            Self::Identify => kind::IDENTIFY,
            Self::Configure { .. } => kind::CONFIGURE,
            Self::Profile { .. } => kind::PROFILE,
            Self::Chunk(_) => kind::CHUNK,
            Self::Start { .. } => kind::START,
            Self::Stop => kind::STOP,
            Self::Alive => kind::ALIVE,
        }
    }

    /// Reads a host's frame.
    ///
    /// # Errors
    /// An unknown type, a body too short or too long for it.
    pub fn parse(raw: RawFrame<'_>) -> Result<Self, MessageError> {
        let mut body = Fields(raw.body);
        let message = match raw.kind {
            kind::IDENTIFY => Some(Self::Identify),
            kind::CONFIGURE => (|| {
                Some(Self::Configure {
                    sample_time_us: body.u32()?,
                    coast_at_zero: body.u8()? & 1 != 0,
                })
            })(),
            kind::PROFILE => (|| {
                Some(Self::Profile {
                    segments: body.u16()?,
                    crc: body.u16()?,
                })
            })(),
            kind::CHUNK => parse_chunk(&mut body).map(Self::Chunk),
            kind::START => body.u32().map(|samples| Self::Start { samples }),
            kind::STOP => Some(Self::Stop),
            kind::ALIVE => Some(Self::Alive),
            unknown => return Err(MessageError::Unknown { kind: unknown }),
        };
        match message {
            Some(message) if body.rest().is_empty() => Ok(message),
            _ => Err(MessageError::Length { kind: raw.kind }),
        }
    }

    /// Writes the whole frame, ending 0 included, into `output`; its length, or `None` where `output`
    /// is too short ([`crate::MAX_WIRE`] always suffices).
    pub fn encode(&self, output: &mut [u8]) -> Option<usize> {
        let body = match self {
            Self::Identify | Self::Stop | Self::Alive => Body::new(),
            Self::Configure {
                sample_time_us,
                coast_at_zero,
            } => Body::new()
                .put(&sample_time_us.to_le_bytes())
                .put(&[u8::from(*coast_at_zero)]),
            Self::Profile { segments, crc } => Body::new()
                .put(&segments.to_le_bytes())
                .put(&crc.to_le_bytes()),
            Self::Chunk(chunk) => chunk.segments().iter().fold(
                Body::new().put(&chunk.first.to_le_bytes()),
                |body, segment| body.put(&segment.to_bytes()),
            ),
            Self::Start { samples } => Body::new().put(&samples.to_le_bytes()),
        };
        encode_frame(self.kind(), body.as_slice(), output)
    }
}

fn parse_chunk(body: &mut Fields<'_>) -> Option<Chunk> {
    let mut chunk = Chunk {
        first: body.u16()?,
        ..Chunk::default()
    };
    while !body.0.is_empty() {
        let segment = ProfileSegment {
            samples: body.u16()?,
            command_mv: body.i16()?,
        };
        *chunk.segments.get_mut(usize::from(chunk.length))? = segment;
        chunk.length += 1;
    }
    (chunk.length > 0).then_some(chunk)
}
