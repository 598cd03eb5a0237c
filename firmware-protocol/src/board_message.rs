//! Messages of a board: HELLO, ACK, NAK, DATA, END, TEXT; validated from raw frames.

use crate::fields::{Body, Fields};
use crate::frame::{RawFrame, encode_frame};
use crate::{MAGIC, MessageError, ShortText};

/// Frame types of a board's messages.
pub mod kind {
    /// Identity of the board.
    pub const HELLO: u8 = 0x01;
    /// A host message was accepted.
    pub const ACK: u8 = 0x02;
    /// A host message was refused.
    pub const NAK: u8 = 0x03;
    /// One sample.
    pub const DATA: u8 = 0x04;
    /// End of the recording.
    pub const END: u8 = 0x05;
    /// Text for the user.
    pub const TEXT: u8 = 0x06;
}

/// Optional fields of a board's samples and the width of its counter; the bits of HELLO's `fields`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BoardFields {
    /// DATA ends with the measured motor current.
    pub current: bool,
    /// DATA ends with the measured supply (after the current, if there are both).
    pub supply: bool,
    /// The counter has 16 bits and wraps there; the host unwraps it.
    pub counts_16_bit: bool,
}

impl BoardFields {
    /// The bits on the wire.
    pub const fn bits(self) -> u8 {
        self.current as u8 | (self.supply as u8) << 1 | (self.counts_16_bit as u8) << 2
    }

    /// From the bits on the wire; bits of a later version are ignored.
    pub const fn from_bits(bits: u8) -> Self {
        Self {
            current: bits & 1 != 0,
            supply: bits & 2 != 0,
            counts_16_bit: bits & 4 != 0,
        }
    }
}

/// Identity and properties of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hello {
    /// Version of its protocol.
    pub protocol_version: u8,
    /// Version of its firmware, major and minor.
    pub firmware_version: (u8, u8),
    /// Changes with each reset.
    pub boot_id: u32,
    /// Sample time in force, in microseconds.
    pub sample_time_us: u32,
    /// Shortest possible sample time in microseconds.
    pub shortest_sample_time_us: u16,
    /// Counts per revolution of its encoder, x4 decoded.
    pub counts_per_rev: u32,
    /// Driver supply in mV.
    pub supply_mv: u16,
    /// Fields of its samples.
    pub fields: BoardFields,
    /// Largest number of segments of a profile.
    pub max_segments: u16,
    /// Name, such as `uno`.
    pub name: ShortText,
}

/// Flags of one sample; the bits of DATA's flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SampleFlags {
    /// The sample was late: the previous one was not finished, or its timer match was missed.
    pub overrun: bool,
    /// Frames before this one were dropped, because the send buffer was full.
    pub dropped: bool,
    /// Both encoder channels changed at once since the last sample: counts are missing.
    pub encoder_error: bool,
    /// The command was limited by the supply.
    pub saturated: bool,
}

impl SampleFlags {
    /// The bits on the wire.
    pub const fn bits(self) -> u8 {
        self.overrun as u8
            | (self.dropped as u8) << 1
            | (self.encoder_error as u8) << 2
            | (self.saturated as u8) << 3
    }

    /// From the bits on the wire; bits of a later version are ignored.
    pub const fn from_bits(bits: u8) -> Self {
        Self {
            overrun: bits & 1 != 0,
            dropped: bits & 2 != 0,
            encoder_error: bits & 4 != 0,
            saturated: bits & 8 != 0,
        }
    }
}

/// One sample as received, with wrapped counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sample {
    /// Sample number modulo 2^16, from 0 at START; samples dropped by the board are counted.
    pub sequence: u16,
    /// The board's `micros()` when the counter was read, modulo 2^32.
    pub time_us: u32,
    /// Encoder counts; of a 16-bit board modulo 2^16, sign-extended.
    pub counts: i32,
    /// Command in force from this sample on, in mV.
    pub command_mv: i16,
    /// Flags of the board.
    pub flags: SampleFlags,
    /// Measured current in mA, if the board has the sensor.
    pub current_ma: Option<i16>,
    /// Measured supply in mV, if the board has the sensor.
    pub supply_mv: Option<u16>,
}

/// Reason for the end of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum EndReason {
    /// The requested samples were taken.
    Complete = 0,
    /// STOP was received.
    Stopped = 1,
    /// No message of the host for half a second.
    LinkLost = 2,
}

/// Reason of a refused host message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Refusal {
    /// Unknown type of message.
    Unknown = 1,
    /// Wrong length of the body.
    Length = 2,
    /// Wrong state: recording, or not ready to.
    State = 3,
    /// Sample time too short, or zero.
    SampleTime = 4,
    /// More segments than the board's memory, or a chunk beyond the announced number.
    ProfileTooLong = 5,
    /// A chunk is missing before this one.
    ChunkOrder = 6,
    /// Wrong CRC of the profile: upload it again.
    ProfileCrc = 7,
}

impl Refusal {
    const ALL: [Self; 7] = [
        Self::Unknown,
        Self::Length,
        Self::State,
        Self::SampleTime,
        Self::ProfileTooLong,
        Self::ChunkOrder,
        Self::ProfileCrc,
    ];
}

impl core::fmt::Display for Refusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Unknown => "it does not know this message",
            Self::Length => "the message has the wrong length",
            Self::State => "it cannot do that now",
            Self::SampleTime => "it cannot keep this sample time",
            Self::ProfileTooLong => "the profile has more segments than it holds",
            Self::ChunkOrder => "a part of the profile is missing",
            Self::ProfileCrc => "the profile arrived damaged",
        })
    }
}

/// A validated message of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardMessage {
    /// Identity; sent after a reset, and in response to IDENTIFY.
    Hello(Hello),
    /// The host message of type `of` was accepted.
    Ack {
        /// Type of the accepted message.
        of: u8,
        /// For a profile chunk: index of the next expected segment; else 0.
        detail: u16,
    },
    /// The host message of type `of` was refused.
    Nak {
        /// Type of the refused message.
        of: u8,
        /// Reason.
        reason: Refusal,
    },
    /// One sample.
    Data(Sample),
    /// The recording has ended and the motor is off.
    End {
        /// Samples taken, dropped ones included.
        taken: u32,
        /// Samples that could not be sent.
        dropped: u32,
        /// Reason.
        reason: EndReason,
    },
    /// Text for the user.
    Text(ShortText),
}

impl BoardMessage {
    /// Parses a frame of a board whose samples have `fields` (those of its HELLO).
    ///
    /// # Errors
    /// An unknown type, a wrong length, or an invalid value.
    pub fn parse(raw: RawFrame<'_>, fields: BoardFields) -> Result<Self, MessageError> {
        let wrong_length = MessageError::Length { kind: raw.kind };
        let mut body = Fields(raw.body);
        let message = match raw.kind {
            kind::HELLO => return parse_hello(raw),
            kind::ACK => (|| {
                Some(Self::Ack {
                    of: body.u8()?,
                    detail: body.u16()?,
                })
            })(),
            kind::NAK => {
                let (of, reason) = body.u8().zip(body.u8()).ok_or(wrong_length)?;
                let reason = *Refusal::ALL
                    .get(usize::from(reason).wrapping_sub(1))
                    .ok_or(MessageError::Value { kind: raw.kind })?;
                Some(Self::Nak { of, reason })
            }
            kind::DATA => parse_data(&mut body, fields).map(Self::Data),
            kind::END => {
                let taken = body.u32().ok_or(wrong_length)?;
                let dropped = body.u32().ok_or(wrong_length)?;
                let reason = match body.u8().ok_or(wrong_length)? {
                    0 => EndReason::Complete,
                    1 => EndReason::Stopped,
                    2 => EndReason::LinkLost,
                    _ => return Err(MessageError::Value { kind: raw.kind }),
                };
                Some(Self::End {
                    taken,
                    dropped,
                    reason,
                })
            }
            kind::TEXT => return Ok(Self::Text(ShortText::new(raw.body))),
            unknown => return Err(MessageError::Unknown { kind: unknown }),
        };
        if body.rest().is_empty() {
            message.ok_or(wrong_length)
        } else {
            Err(wrong_length)
        }
    }

    /// Encodes the frame, ending 0 included, into `output`; returns its length, or `None` if `output` is too short
    /// ([`crate::MAX_WIRE`] always suffices).
    pub fn encode(&self, output: &mut [u8]) -> Option<usize> {
        let body = Body::new();
        let (kind, body) = match self {
            Self::Hello(hello) => (kind::HELLO, hello_body(hello)),
            Self::Ack { of, detail } => (kind::ACK, body.put(&[*of]).put(&detail.to_le_bytes())),
            Self::Nak { of, reason } => (kind::NAK, body.put(&[*of, *reason as u8])),
            Self::Data(sample) => (kind::DATA, data_body(sample)),
            Self::End {
                taken,
                dropped,
                reason,
            } => (
                kind::END,
                body.put(&taken.to_le_bytes())
                    .put(&dropped.to_le_bytes())
                    .put(&[*reason as u8]),
            ),
            Self::Text(text) => (kind::TEXT, body.put(text.as_bytes())),
        };
        encode_frame(kind, body.as_slice(), output)
    }
}

fn parse_hello(raw: RawFrame<'_>) -> Result<BoardMessage, MessageError> {
    let mut body = Fields(raw.body);
    let wrong_length = MessageError::Length { kind: raw.kind };
    if body.bytes::<4>().ok_or(wrong_length)? != MAGIC {
        return Err(MessageError::Magic);
    }
    let protocol_version = body.u8().ok_or(wrong_length)?;
    if protocol_version != crate::PROTOCOL_VERSION {
        return Err(MessageError::Version {
            found: protocol_version,
        });
    }
    let hello = (|| {
        Some(Hello {
            protocol_version,
            firmware_version: (body.u8()?, body.u8()?),
            boot_id: body.u32()?,
            sample_time_us: body.u32()?,
            shortest_sample_time_us: body.u16()?,
            counts_per_rev: body.u32()?,
            supply_mv: body.u16()?,
            fields: BoardFields::from_bits(body.u8()?),
            max_segments: body.u16()?,
            name: ShortText::new(body.rest()),
        })
    })();
    hello.map(BoardMessage::Hello).ok_or(wrong_length)
}

fn hello_body(hello: &Hello) -> Body {
    Body::new()
        .put(&MAGIC)
        .put(&[hello.protocol_version])
        .put(&[hello.firmware_version.0, hello.firmware_version.1])
        .put(&hello.boot_id.to_le_bytes())
        .put(&hello.sample_time_us.to_le_bytes())
        .put(&hello.shortest_sample_time_us.to_le_bytes())
        .put(&hello.counts_per_rev.to_le_bytes())
        .put(&hello.supply_mv.to_le_bytes())
        .put(&[hello.fields.bits()])
        .put(&hello.max_segments.to_le_bytes())
        .put(hello.name.as_bytes())
}

fn parse_data(body: &mut Fields<'_>, fields: BoardFields) -> Option<Sample> {
    Some(Sample {
        sequence: body.u16()?,
        time_us: body.u32()?,
        counts: body.i32()?,
        command_mv: body.i16()?,
        flags: SampleFlags::from_bits(body.u8()?),
        current_ma: if fields.current {
            Some(body.i16()?)
        } else {
            None
        },
        supply_mv: if fields.supply {
            Some(body.u16()?)
        } else {
            None
        },
    })
}

fn data_body(sample: &Sample) -> Body {
    let body = Body::new()
        .put(&sample.sequence.to_le_bytes())
        .put(&sample.time_us.to_le_bytes())
        .put(&sample.counts.to_le_bytes())
        .put(&sample.command_mv.to_le_bytes())
        .put(&[sample.flags.bits()]);
    let body = match sample.current_ma {
        Some(current_ma) => body.put(&current_ma.to_le_bytes()),
        None => body,
    };
    match sample.supply_mv {
        Some(supply_mv) => body.put(&supply_mv.to_le_bytes()),
        None => body,
    }
}
