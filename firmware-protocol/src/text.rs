//! Short text without allocation.

use crate::frame::MAX_BODY;

/// Up to [`MAX_BODY`] bytes of text; invalid UTF-8 is cut off.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ShortText {
    bytes: [u8; MAX_BODY],
    length: u8,
}

impl ShortText {
    /// The longest prefix of `bytes` that is UTF-8 and fits.
    pub fn new(bytes: &[u8]) -> Self {
        let bytes = &bytes[..bytes.len().min(MAX_BODY)];
        let good = match core::str::from_utf8(bytes) {
            Ok(text) => text.len(),
            Err(error) => error.valid_up_to(),
        };
        let mut text = Self {
            bytes: [0; MAX_BODY],
            length: good as u8,
        };
        text.bytes[..good].copy_from_slice(&bytes[..good]);
        text
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(self.as_bytes()).unwrap_or_default()
    }

    /// The text's bytes.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }
}

impl core::fmt::Debug for ShortText {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}
