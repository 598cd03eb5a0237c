//! Frames: `COBS(type, body, CRC-16) 0`, and the decoder that finds them in a stream of bytes.
//!
//! A [`RawFrame`] has a right CRC, but nothing in it has been looked at; the messages of
//! [`crate::board_message`] and [`crate::host_message`] are what has been validated.

use crate::cobs;
use crate::crc::{CRC_START, crc16};

/// Longest body of a frame.
pub const MAX_BODY: usize = 52;
/// Longest frame on the wire: type, body, CRC, the COBS code byte and the ending 0.
pub const MAX_WIRE: usize = 1 + MAX_BODY + 2 + 1 + 1;
/// Longest run of stuffed bytes between two zeros.
const MAX_STUFFED: usize = MAX_WIRE - 1;

/// A frame whose CRC is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawFrame<'a> {
    /// Kind of message of the body.
    pub kind: u8,
    /// The message's bytes.
    pub body: &'a [u8],
}

/// Why the bytes between two zeros are not a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than any frame.
    TooLong,
    /// Shorter than type and CRC.
    TooShort,
    /// Not stuffed right.
    Stuffing,
    /// The CRC does not fit.
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

/// Writes a frame with its ending 0 into `output`; its length, or `None` where the body is longer
/// than [`MAX_BODY`] or `output` is too short ([`MAX_WIRE`] always suffices).
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

/// Finds frames in a stream of bytes. Holds one frame, never allocates, never panics.
///
/// After any damage it is in step again at the next 0, so that at most the frames hit are lost: a
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
    /// A decoder that holds nothing yet.
    pub const fn new() -> Self {
        Self {
            buffer: [0; MAX_STUFFED],
            length: 0,
            overlong: false,
        }
    }

    /// Takes one byte. With the 0 that ends it comes the frame, or why there is none; zeros in a row
    /// are nothing.
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

    /// Whether bytes wait for their ending 0.
    pub fn is_inside_frame(&self) -> bool {
        self.length > 0
    }

    /// Forgets what waits, as after opening a port in the middle of a frame.
    pub fn reset(&mut self) {
        self.length = 0;
        self.overlong = false;
    }
}

/// Takes off the stuffing and looks at the CRC.
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
