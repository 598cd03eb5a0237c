//! Messages of a host: IDENTIFY, CONFIGURE, PROFILE, CHUNK, START, STOP, ALIVE.

use crate::MessageError;
use crate::crc::{CRC_START, crc16};
use crate::fields::{Body, Fields};
use crate::frame::{RawFrame, encode_frame};

/// Frame types of a host's messages.
pub mod kind {
    /// Request of a HELLO.
    pub const IDENTIFY: u8 = 0x81;
    /// Sample time, and the meaning of zero volts.
    pub const CONFIGURE: u8 = 0x82;
    /// Announcement of a profile with its number of segments.
    pub const PROFILE: u8 = 0x83;
    /// A part of the profile.
    pub const CHUNK: u8 = 0x84;
    /// Start of a recording.
    pub const START: u8 = 0x85;
    /// End of a recording.
    pub const STOP: u8 = 0x86;
    /// The host is alive.
    pub const ALIVE: u8 = 0x87;
}

/// Most segments in one CHUNK.
pub const CHUNK_SEGMENTS: usize = 12;

/// One held command of a profile: 4 bytes on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ProfileSegment {
    /// Duration in samples; the last segment's command is held after it.
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
    /// A chunk of the segments; `None` for no segments or more than [`CHUNK_SEGMENTS`].
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
    /// Request of a HELLO.
    Identify,
    /// Configuration of sampling.
    Configure {
        /// Sample time in microseconds.
        sample_time_us: u32,
        /// A command of 0 opens the motor's circuit (coast) instead of shorting it (brake).
        coast_at_zero: bool,
    },
    /// Announcement of a profile in chunks.
    Profile {
        /// Number of segments.
        segments: u16,
        /// [`profile_crc`] of all segments.
        crc: u16,
    },
    /// A part of the profile.
    Chunk(Chunk),
    /// Start of a recording.
    Start {
        /// Number of samples; 0 is unlimited.
        samples: u32,
    },
    /// End of the recording; the motor is switched off.
    Stop,
    /// The host is alive. A recording board without a frame for 0.5 s stops the motor.
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

    /// Parses a host's frame.
    ///
    /// # Errors
    /// An unknown type, or a wrong length.
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

    /// Encodes the frame, ending 0 included, into `output`; returns its length, or `None` if `output` is too short
    /// ([`crate::MAX_WIRE`] always suffices).
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
