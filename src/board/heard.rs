//! Bytes that are no frames, kept for messages.

use std::fmt;

const KEPT: usize = 240;

/// The first bytes of a line, and their number.
#[derive(Debug, Clone, Default)]
pub struct Heard {
    first: Vec<u8>,
    total: u64,
}

impl Heard {
    /// Takes one byte.
    pub fn push(&mut self, byte: u8) {
        self.total += 1;
        if self.first.len() < KEPT {
            self.first.push(byte);
        }
    }

    /// How many bytes there were.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Whether the bytes contain a HELLO of motorlab's protocol.
    pub fn is_of_protocol(&self) -> bool {
        let magic = firmware_protocol::MAGIC;
        self.first.windows(magic.len()).any(|bytes| bytes == magic)
    }

    /// Whether most of them are text: a plain sketch, or the wrong program on the board.
    pub fn is_text(&self) -> bool {
        let text = self.first.iter().filter(|byte| is_text(**byte)).count();
        !self.first.is_empty() && 10 * text >= 9 * self.first.len()
    }
}

fn is_text(byte: u8) -> bool {
    matches!(byte, b' '..=b'~' | b'\r' | b'\n' | b'\t')
}

/// Text in quotes with escaped control characters, anything else in hexadecimal.
impl fmt::Display for Heard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_text() {
            write!(f, "\"{}\"", self.first.escape_ascii())?;
        } else {
            for (index, byte) in self.first.iter().take(48).enumerate() {
                let space = if index == 0 { "" } else { " " };
                write!(f, "{space}{byte:02x}")?;
            }
        }
        let shown = if self.is_text() { KEPT } else { 48 };
        if self.total > shown as u64 {
            write!(f, " ... ({} bytes in all)", self.total)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(bytes: &[u8]) -> Heard {
        let mut heard = Heard::default();
        bytes.iter().for_each(|&byte| heard.push(byte));
        heard
    }

    #[test]
    fn text_is_printed_as_text_and_other_bytes_as_hexadecimal() {
        assert_eq!(heard(b"ok\r\n1,2").to_string(), "\"ok\\r\\n1,2\"");
        assert_eq!(heard(&[0, 0xff, 3]).to_string(), "00 ff 03");
        let long = heard(&[b'x'; 1000]).to_string();
        assert!(long.ends_with("x\" ... (1000 bytes in all)"));
        assert_eq!(
            heard(b"\x1b[2J text that would clear the screen")
                .to_string()
                .find('\x1b'),
            None
        );
    }
}
