//! The lines of a log, plain or gzipped, in bounded memory.

use std::io::{self, BufRead, BufReader, Cursor, Read};

use flate2::bufread::MultiGzDecoder;

use super::ImportProblem;
use super::bare::bare;

/// Longest line kept, in bytes; a longer one is a rejected row.
pub const MAX_LINE_BYTES: usize = 1 << 16;
/// Longest line skipped, in bytes; a longer one ends the import.
pub const MOST_LINE_BYTES: u64 = 1 << 26;

/// Magic bytes of gzip.
const GZIP: [u8; 2] = [0x1f, 0x8b];
const UTF8_MARK: [u8; 3] = [0xef, 0xbb, 0xbf];
const UTF16: &str =
    "it is UTF-16, as some Windows programs write it\nhint: save it as UTF-8 or plain CSV";

pub(super) struct Lines<R> {
    source: R,
    line: Vec<u8>,
    number: u64,
    ended: bool,
}

/// Kind of a line.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Line<'a> {
    /// Its bytes, without the line end.
    Whole(&'a [u8]),
    /// The beginning of a line that is too long.
    TooLong(&'a [u8]),
}

/// The lines of `source`, decompressed if it is gzipped.
///
/// # Errors
/// It cannot be read, or is not text.
pub(super) fn lines<'a>(
    source: impl Read + 'a,
) -> Result<Lines<Box<dyn BufRead + 'a>>, ImportProblem> {
    let (beginning, source) = peek(source)?;
    if !beginning.starts_with(&GZIP) {
        return Lines::new(beginning, Box::new(source));
    }
    let compressed = BufReader::new(Cursor::new(beginning).chain(source));
    let (beginning, source) = peek(MultiGzDecoder::new(compressed))?;
    Lines::new(beginning, Box::new(source))
}

/// The first bytes (fewer only at the end), and the rest.
fn peek<R: Read>(mut source: R) -> Result<(Vec<u8>, BufReader<R>), ImportProblem> {
    let mut beginning = Vec::new();
    let read = (&mut source).take(4).read_to_end(&mut beginning);
    read.map_err(|source| ImportProblem::Read { line: 0, source })?;
    Ok((beginning, BufReader::with_capacity(1 << 16, source)))
}

impl<'a> Lines<Box<dyn BufRead + 'a>> {
    fn new(beginning: Vec<u8>, source: Box<dyn BufRead + 'a>) -> Result<Self, ImportProblem> {
        if beginning.starts_with(&[0xff, 0xfe]) || beginning.starts_with(&[0xfe, 0xff]) {
            return Err(ImportProblem::NoText(UTF16));
        }
        let zeros = beginning.iter().filter(|&&byte| byte == 0).count();
        if zeros == 2 && beginning.len() == 4 && beginning[0] != beginning[1] {
            return Err(ImportProblem::NoText(UTF16));
        }
        if zeros > 0 {
            return Err(ImportProblem::NoText(
                "it begins with zero bytes\nhint: export it from the program that wrote it as CSV",
            ));
        }
        if beginning.starts_with(b"PK\x03\x04") {
            return Err(ImportProblem::NoText(
                "it is a ZIP archive (perhaps .xlsx or .npz)\nhint: save the table as CSV",
            ));
        }
        let rest = beginning.strip_prefix(&UTF8_MARK).unwrap_or(&beginning);
        Ok(Self {
            source: Box::new(Cursor::new(rest.to_vec()).chain(source)),
            line: Vec::new(),
            number: 0,
            ended: true,
        })
    }
}

impl<R: BufRead> Lines<R> {
    /// Number of the last line, from 1.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Whether the last line had a line end.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// The last line, or its beginning.
    pub fn last(&self) -> &[u8] {
        &self.line
    }

    /// The next line, or `None` at the end.
    pub fn next(&mut self) -> Result<Option<Line<'_>>, ImportProblem> {
        self.line.clear();
        let (mut length, mut ended) = (0_u64, false);
        while !ended {
            let available = match self.source.fill_buf() {
                Ok(available) => available,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(source) => {
                    return Err(ImportProblem::Read {
                        line: self.number,
                        source,
                    });
                }
            };
            if available.is_empty() {
                break;
            }
            let end = memchr::memchr(b'\n', available);
            let part = &available[..end.unwrap_or(available.len())];
            let room = MAX_LINE_BYTES.saturating_sub(self.line.len());
            self.line.extend_from_slice(&part[..part.len().min(room)]);
            length += part.len() as u64;
            let used = part.len() + usize::from(end.is_some());
            self.source.consume(used);
            ended = end.is_some();
            if length > MOST_LINE_BYTES {
                return Err(ImportProblem::EndlessLine {
                    line: self.number + 1,
                });
            }
        }
        if length == 0 && !ended {
            return Ok(None);
        }
        self.ended = ended;
        self.number += 1;
        if length > self.line.len() as u64 {
            return Ok(Some(Line::TooLong(&self.line)));
        }
        if self.line.last() == Some(&b'\r') {
            self.line.pop();
        }
        let left = bare(&self.line);
        if left.len() != self.line.len() {
            self.line = left.into_owned();
        }
        Ok(Some(Line::Whole(&self.line)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn all(bytes: &[u8]) -> Vec<String> {
        let mut lines = lines(bytes).expect("text");
        let mut found = Vec::new();
        while let Some(line) = lines.next().expect("readable") {
            found.push(match line {
                Line::Whole(line) => String::from_utf8_lossy(line).into_owned(),
                Line::TooLong(_) => "too long".to_owned(),
            });
        }
        found
    }

    #[test]
    fn line_ends_marks_and_compression_make_no_difference() {
        let expected = ["t,x", "", "1,2"];
        assert_eq!(all(b"t,x\n\n1,2\n"), expected);
        assert_eq!(all(b"t,x\r\n\r\n1,2"), expected);
        assert_eq!(all(b"\xef\xbb\xbft,x\n\n1,2\n"), expected);
        let mut gzipped = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzipped.write_all(b"t,x\n\n1,2\n").expect("memory");
        assert_eq!(all(&gzipped.finish().expect("memory")), expected);
        assert_eq!(all(b""), Vec::<String>::new());
        assert_eq!(all(b"t"), ["t"]);
    }

    #[test]
    fn a_line_of_ten_megabytes_is_skipped() {
        let mut bytes = b"a\n".to_vec();
        bytes.resize(10_000_000, b'7');
        bytes.extend_from_slice(b"\nb\n");
        assert_eq!(all(&bytes), ["a", "too long", "b"]);
    }

    #[test]
    fn files_that_are_no_text_are_errors() {
        for (bytes, says) in [
            (&b"\xff\xfet\0"[..], "UTF-16"),
            (b"t\0,\0x\0", "UTF-16"),
            (b"\0\0\0\0", "zero bytes"),
            (b"PK\x03\x04", "ZIP"),
        ] {
            let error = lines(bytes).err().expect("refused").to_string();
            assert!(error.contains(says), "{error}");
        }
    }

    #[test]
    fn an_endless_line_is_an_error() {
        let mut lines = lines(io::repeat(b'1')).expect("text so far");
        let error = lines.next().expect_err("endless");
        assert!(matches!(error, ImportProblem::EndlessLine { line: 1 }));
    }
}
