//! Filters before the reader of run files: byte order marks and unbounded lines.
//!
//! Lines are bounded, so that other files (`/dev/zero`, a gigabyte without a line end) fail early instead of filling
//! the memory.

use std::cell::Cell;
use std::io::{self, Read};

/// U+FEFF in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
/// Longest line of a run file in bytes.
const MAX_LINE_BYTES: usize = 1 << 16;

/// Removes byte order marks, as some spreadsheets write them before UTF-8. A pipe may deliver single bytes.
pub(super) fn without_byte_order_mark<R: Read>(
    mut source: R,
) -> io::Result<io::Chain<io::Cursor<Vec<u8>>, R>> {
    let mut begin = Vec::with_capacity(BYTE_ORDER_MARK.len());
    loop {
        source
            .by_ref()
            .take(BYTE_ORDER_MARK.len() as u64)
            .read_to_end(&mut begin)?;
        if begin != BYTE_ORDER_MARK {
            return Ok(io::Cursor::new(begin).chain(source));
        }
        begin.clear();
    }
}

/// Fails on a line longer than [`MAX_LINE_BYTES`] before it is buffered. Line ends within quotes end no line.
pub(super) struct LineLimit<'a, R> {
    source: R,
    line: u64,
    length: usize,
    quoted: bool,
    comment: bool,
    last_byte: &'a Cell<u8>,
}

impl<'a, R: Read> LineLimit<'a, R> {
    /// Stores the last byte of each read in `last_byte`.
    pub fn new(source: R, last_byte: &'a Cell<u8>) -> Self {
        Self {
            source,
            line: 1,
            length: 0,
            quoted: false,
            comment: false,
            last_byte,
        }
    }
}

impl<R: Read> Read for LineLimit<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.source.read(buffer)?;
        if let Some(&last) = buffer[..count].last() {
            self.last_byte.set(last);
        }
        for &byte in &buffer[..count] {
            self.length += 1;
            // Header lines may contain single quotation marks.
            self.comment |= self.length == 1 && byte == b'#';
            self.quoted ^= byte == b'"' && !self.comment;
            if byte == b'\n' && !self.quoted {
                self.line += 1;
                self.length = 0;
                self.comment = false;
            } else if self.length > MAX_LINE_BYTES {
                let line = self.line;
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    format!(
                        "line {line} is longer than {MAX_LINE_BYTES} bytes: this is no run file"
                    ),
                ));
            }
        }
        Ok(count)
    }
}
