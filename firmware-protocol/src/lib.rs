//! The wire protocol between a motorlab board and its host. `PROTOCOL.md` beside this crate specifies it.
//!
//! ```text
//! bytes --FrameDecoder--> RawFrame --parse--> BoardMessage / HostMessage --unwrap--> a running sample
//!         COBS, CRC-16    CRC right           every field in its range      64-bit numbers
//! ```
//!
//! A [`RawFrame`] and a validated message are different types: unchecked data stop at [`BoardMessage::parse`]. No
//! function panics, whatever the bytes; none allocates; the crate is `no_std` for firmware and host alike.
//!
//! ```
//! use firmware_protocol::{BoardFields, BoardMessage, FrameDecoder, HostMessage, MAX_WIRE};
//!
//! let mut wire = [0; MAX_WIRE];
//! let length = HostMessage::Start { samples: 1000 }.encode(&mut wire).unwrap();
//!
//! let mut decoder = FrameDecoder::new();
//! let mut started = false;
//! for &byte in &wire[..length] {
//!     if let Some(Ok(frame)) = decoder.push(byte) {
//!         started = HostMessage::parse(frame) == Ok(HostMessage::Start { samples: 1000 });
//!     }
//! }
//! assert!(started);
//! ```
#![no_std]
#![forbid(unsafe_code)]

pub mod board_message;
pub mod cobs;
pub mod crc;
mod fields;
mod frame;
pub mod host_message;
pub mod sketch;
mod text;
mod unwrap;

pub use board_message::{
    BoardFields, BoardMessage, EndReason, Hello, Refusal, Sample, SampleFlags,
};
pub use frame::{FrameDecoder, FrameError, MAX_BODY, MAX_WIRE, RawFrame, encode_frame};
pub use host_message::{CHUNK_SEGMENTS, Chunk, HostMessage, ProfileSegment, profile_crc};
pub use text::ShortText;
pub use unwrap::{CountsUnwrapper, MicrosUnwrapper, Sequence, SequenceUnwrapper};

/// First bytes of every HELLO, in every version.
pub const MAGIC: [u8; 4] = *b"MLAB";
/// The protocol version of this crate.
pub const PROTOCOL_VERSION: u8 = 1;
/// Bits per second on the serial line.
pub const BAUD: u32 = 115_200;
/// Time in ms after which a recording board without a frame of its host stops the motor.
pub const LINK_TIMEOUT_MS: u32 = 500;
/// Longest interval of ALIVE messages during a recording, in ms.
pub const ALIVE_INTERVAL_MS: u32 = 150;

/// Why a frame with a right CRC is no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageError {
    /// A type unknown to this version.
    Unknown {
        /// The type.
        kind: u8,
    },
    /// A wrong length for the type.
    Length {
        /// The type.
        kind: u8,
    },
    /// An invalid value.
    Value {
        /// The type.
        kind: u8,
    },
    /// A HELLO of another protocol.
    Magic,
    /// A HELLO of another version of this protocol.
    Version {
        /// The version.
        found: u8,
    },
}

impl core::fmt::Display for MessageError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Unknown { kind } => write!(f, "unknown message type 0x{kind:02x}"),
            Self::Length { kind } => write!(f, "message 0x{kind:02x} has the wrong length"),
            Self::Value { kind } => write!(f, "message 0x{kind:02x} holds an impossible value"),
            Self::Magic => f.write_str("a HELLO that is not motorlab's"),
            Self::Version { found } => write!(
                f,
                "the board speaks protocol version {found}, this program version {PROTOCOL_VERSION}"
            ),
        }
    }
}

impl core::error::Error for MessageError {}
