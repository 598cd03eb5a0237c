//! Frames `COBS(type, body, CRC-16) 0`, and their decoder.
//!
//! A [`RawFrame`] has a right CRC but an unchecked body; the messages of [`crate::board_message`] and
//! [`crate::host_message`] are validated.

use crate::cobs;
use crate::crc::{CRC_START, crc16};

/// Longest body of a frame.
pub const MAX_BODY: usize = 52;
/// Longest frame on the wire: type, body, CRC, the COBS code byte and the ending 0.
pub const MAX_WIRE: usize = 1 + MAX_BODY + 2 + 1 + 1;
/// Longest run of stuffed bytes between two zeros.
const MAX_STUFFED: usize = MAX_WIRE - 1;

/// A frame with a right CRC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawFrame<'a> {
    /// Type of message.
    pub kind: u8,
    /// Body of the message.
    pub body: &'a [u8],
}

/// Why the bytes between two zeros are not a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than any frame.
    TooLong,
    /// Shorter than type and CRC.
    TooShort,
    /// Invalid COBS encoding.
    Stuffing,
    /// Wrong CRC.
    Crc,
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::TooLong => "longer than any frame",
            Self::TooShort => "shorter than any frame",
            Self::Stuffing => "not stuffed right",
            Self::Crc => "wrong CRC",
        })
    }
}

impl core::error::Error for FrameError {}

/// Encodes a frame with its ending 0 into `output`; returns its length, or `None` if the body is longer than
/// [`MAX_BODY`] or `output` is too short ([`MAX_WIRE`] always suffices).
pub fn encode_frame(kind: u8, body: &[u8], output: &mut [u8]) -> Option<usize> {
    if body.len() > MAX_BODY {
        return None;
    }
    let mut plain = [0; 1 + MAX_BODY + 2];
    plain[0] = kind;
    plain[1..=body.len()].copy_from_slice(body);
    let crc = crc16(CRC_START, &plain[..=body.len()]);
    plain[1 + body.len()..3 + body.len()].copy_from_slice(&crc.to_le_bytes());
    let stuffed = cobs::encode(&plain[..3 + body.len()], output)?;
    *output.get_mut(stuffed)? = 0;
    Some(stuffed + 1)
}

/// Streaming decoder of frames. Buffers one frame, never allocates, never panics.
///
/// After any damage it resynchronizes at the next 0, so that at most the damaged frames are lost: a changed or
/// missing 0 joins two frames, which both fail; an additional 0 splits one, which fails.
/// flipped or missing 0 joins two frames, which both fail; a false 0 splits one, which fails.
#[derive(Debug, Clone)]
pub struct FrameDecoder {
    buffer: [u8; MAX_STUFFED],
    length: usize,
    overlong: bool,
}

impl Default for FrameDecoder {
    fn default() -> Self {
        Self::new()
    }
}

impl FrameDecoder {
    /// A decoder with an empty buffer.
    pub const fn new() -> Self {
        Self {
            buffer: [0; MAX_STUFFED],
            length: 0,
            overlong: false,
        }
    }

    /// Processes one byte. The ending 0 returns the frame, or the error; repeated zeros return nothing.
    pub fn push(&mut self, byte: u8) -> Option<Result<RawFrame<'_>, FrameError>> {
        if byte != 0 {
            match self.buffer.get_mut(self.length) {
                Some(slot) => {
                    *slot = byte;
                    self.length += 1;
                }
                None => self.overlong = true,
            }
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if core::mem::take(&mut self.overlong) {
            return Some(Err(FrameError::TooLong));
        }
        if length == 0 {
            return None;
        }
        Some(check(&mut self.buffer[..length]))
    }

    /// Whether a frame is incomplete.
    pub fn is_inside_frame(&self) -> bool {
        self.length > 0
    }

    /// Discards the buffer, as after opening a port in the middle of a frame.
    pub fn reset(&mut self) {
        self.length = 0;
        self.overlong = false;
    }
}

/// Decodes COBS and checks the CRC.
fn check(stuffed: &mut [u8]) -> Result<RawFrame<'_>, FrameError> {
    let length = cobs::decode_in_place(stuffed).ok_or(FrameError::Stuffing)?;
    let plain = &stuffed[..length];
    let Some((content, crc)) = plain.split_last_chunk::<2>() else {
        return Err(FrameError::TooShort);
    };
    let Some((&kind, body)) = content.split_first() else {
        return Err(FrameError::TooShort);
    };
    if crc16(CRC_START, content) == u16::from_le_bytes(*crc) {
        Ok(RawFrame { kind, body })
    } else {
        Err(FrameError::Crc)
    }
}
