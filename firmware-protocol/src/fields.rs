//! Reading and writing of little-endian numbers in a message's body, without panics.

use crate::frame::MAX_BODY;

/// Reads numbers from the front of a body; `None` if it ends too early.
pub(crate) struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*head)
    }

    pub fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take()
    }

    pub fn u8(&mut self) -> Option<u8> {
        self.take().map(|[byte]| byte)
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub fn i16(&mut self) -> Option<i16> {
        self.take().map(i16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub fn i32(&mut self) -> Option<i32> {
        self.take().map(i32::from_le_bytes)
    }

    pub fn rest(self) -> &'a [u8] {
        self.0
    }
}

/// A body under construction. Bytes beyond [`MAX_BODY`] are dropped: no message is that long.
pub(crate) struct Body {
    bytes: [u8; MAX_BODY],
    length: usize,
}

impl Body {
    pub fn new() -> Self {
        Self {
            bytes: [0; MAX_BODY],
            length: 0,
        }
    }

    pub fn put(mut self, bytes: &[u8]) -> Self {
        for &byte in bytes {
            if let Some(slot) = self.bytes.get_mut(self.length) {
                *slot = byte;
                self.length += 1;
            }
        }
        self
    }

    pub fn as_slice(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}
