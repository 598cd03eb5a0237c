//! The raw log: every byte of a serial line with its arrival time, as readable text.
//!
//! ```text
//! # format = "motorlab-rawlog/1"
//! # port = "/dev/ttyACM0"
//!        0 < "motorlab\r\n"
//!     1532 > 0b 4d 4c 01 00
//!     3127 < 0c 02 01 ff 40 00
//! ```
//!
//! Leading lines that start with `#` are, without `# `, one TOML document. Every other line is an event: microseconds
//! since the log began, `<` for bytes from the board or `>` for bytes to it, and the bytes: in hexadecimal, or in
//! quotes with `\r`, `
//! `, `\t`, `\"`, `\\` and `\xhh` for text. `!` in place of the arrow is a hang-up. An incomplete last line is
//! reported and ignored.

use std::io::{self, BufRead, Read, Write};

use crate::plain::one_line_table;

/// Value of the `format` key.
pub const FORMAT: &str = "motorlab-rawlog/1";

/// Longest line accepted: a read of the serial port is at most 4096 bytes.
const LONGEST_LINE: usize = 1 << 16;

/// Longest header accepted, in bytes.
const LONGEST_HEADER: usize = 1 << 20;

/// Latest time accepted, in microseconds: 285 years, so that times can be added and subtracted.
const LATEST_US: u64 = 1 << 53;

/// Event on the line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// Bytes from the board.
    FromBoard(Vec<u8>),
    /// Bytes to the board.
    ToBoard(Vec<u8>),
    /// The device was unplugged.
    HangUp,
}

/// Writes a raw log.
#[derive(Debug)]
pub struct Writer<W: Write> {
    output: W,
    line: String,
}

impl<W: Write> Writer<W> {
    /// Begins a log with `header` (TOML) and the key `format`.
    pub fn new(mut output: W, header: &toml::Table) -> io::Result<Self> {
        writeln!(output, "# format = \"{FORMAT}\"")?;
        let mut header = one_line_table(header);
        header.remove("format");
        let text = toml::to_string(&header).map_err(io::Error::other)?;
        for line in text.lines() {
            writeln!(output, "# {line}")?;
        }
        Ok(Self {
            output,
            line: String::new(),
        })
    }

    /// Appends bytes that arrived from the board.
    pub fn from_board(&mut self, at_us: u64, bytes: &[u8]) -> io::Result<()> {
        self.write(at_us, '<', bytes)
    }

    /// Appends bytes that were sent to the board.
    pub fn to_board(&mut self, at_us: u64, bytes: &[u8]) -> io::Result<()> {
        self.write(at_us, '>', bytes)
    }

    /// Appends a hang-up.
    pub fn hang_up(&mut self, at_us: u64) -> io::Result<()> {
        writeln!(self.output, "{at_us:>10} !")
    }

    /// Flushes the log to the operating system.
    pub fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }

    fn write(&mut self, at_us: u64, arrow: char, bytes: &[u8]) -> io::Result<()> {
        use std::fmt::Write as _;
        if bytes.is_empty() {
            return Ok(());
        }
        self.line.clear();
        let mut format = || -> std::fmt::Result {
            write!(self.line, "{at_us:>10} {arrow}")?;
            if bytes.iter().all(|&byte| is_text(byte)) {
                self.line.push_str(" \"");
                for &byte in bytes {
                    push_escaped(&mut self.line, byte);
                }
                self.line.push('"');
            } else {
                for byte in bytes {
                    write!(self.line, " {byte:02x}")?;
                }
            }
            Ok(())
        };
        format().map_err(io::Error::other)?;
        self.line.push('\n');
        self.output.write_all(self.line.as_bytes())
    }
}

fn is_text(byte: u8) -> bool {
    matches!(byte, b' '..=b'~' | b'\r' | b'\n' | b'\t')
}

fn push_escaped(line: &mut String, byte: u8) {
    match byte {
        b'\r' => line.push_str("\\r"),
        b'\n' => line.push_str("\\n"),
        b'\t' => line.push_str("\\t"),
        b'"' => line.push_str("\\\""),
        b'\\' => line.push_str("\\\\"),
        other => line.push(char::from(other)),
    }
}

/// Why a raw log cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file failed.
    #[error("line {line} of the raw log cannot be read: {source}")]
    Io {
        /// Line, from 1.
        line: u64,
        /// Cause.
        source: io::Error,
    },
    /// Not a raw log.
    #[error(
        "this is no raw log: its first line should be `# format = \"{FORMAT}\"`, and is '{found}'\nhint: `motorlab capture PORT --log FILE` writes a raw log; a log of another program is read by motorlab import"
    )]
    NotARawLog {
        /// Beginning of the first line.
        found: String,
    },
    /// The header is not TOML.
    #[error("the raw log's header is not TOML: {}\nhint: correct the lines that start with #, each of which is `# KEY = VALUE`", .0.message())]
    Header(#[from] toml::de::Error),
    /// A line is neither bytes nor a hang-up.
    #[error(
        "line {line} of the raw log: {problem}\nhint: a line is `MICROSECONDS < BYTES`, with `>` for bytes to the board; correct or remove this one"
    )]
    Line {
        /// Line, from 1.
        line: u64,
        /// Error.
        problem: &'static str,
    },
}

impl ReadError {
    /// The line of the error, from 1.
    pub fn line(&self) -> Option<u64> {
        match self {
            Self::Io { line, .. } | Self::Line { line, .. } => Some(*line),
            Self::NotARawLog { .. } | Self::Header(_) => None,
        }
    }
}

/// Reads a raw log line by line in constant memory.
#[derive(Debug)]
pub struct Reader<R: BufRead> {
    input: R,
    header: toml::Table,
    line: Vec<u8>,
    line_number: u64,
    /// The first event line was read with the header.
    pending: bool,
    torn: bool,
}

impl<R: BufRead> Reader<R> {
    /// Reads the header.
    pub fn new(input: R) -> Result<Self, ReadError> {
        let mut reader = Self {
            input,
            header: toml::Table::new(),
            line: Vec::new(),
            line_number: 0,
            pending: false,
            torn: false,
        };
        let mut header = String::new();
        while reader.read_line()? {
            let Some(rest) = reader.line.strip_prefix(b"#") else {
                reader.pending = true;
                break;
            };
            header.push_str(String::from_utf8_lossy(rest).trim_start_matches(' '));
            header.push('\n');
            if header.len() > LONGEST_HEADER {
                return Err(ReadError::Line {
                    line: reader.line_number,
                    problem: "the header is longer than 1,048,576 bytes",
                });
            }
        }
        let table = header.parse::<toml::Table>();
        if let Ok(table) = &table
            && table.get("format").and_then(toml::Value::as_str) != Some(FORMAT)
        {
            let first = header.lines().next().unwrap_or("").to_owned();
            let found = if first.is_empty() {
                String::from_utf8_lossy(&reader.line)
                    .trim_end()
                    .chars()
                    .take(60)
                    .collect()
            } else {
                first
            };
            return Err(ReadError::NotARawLog { found });
        }
        reader.header = table?;
        Ok(reader)
    }

    /// The header.
    pub fn header(&self) -> &toml::Table {
        &self.header
    }

    /// Whether the last line was incomplete, as when the writer was killed.
    pub fn torn(&self) -> bool {
        self.torn
    }

    /// The next event with its microseconds, or `None` at the end.
    pub fn next_event(&mut self) -> Result<Option<(u64, Event)>, ReadError> {
        loop {
            if !std::mem::take(&mut self.pending) && !self.read_line()? {
                return Ok(None);
            }
            if self.line.last() != Some(&b'\n') {
                self.torn = true;
                return Ok(None);
            }
            let text = self.line.trim_ascii();
            if text.is_empty() || text.starts_with(b"#") {
                continue;
            }
            return parse_line(text)
                .map(Some)
                .map_err(|problem| ReadError::Line {
                    line: self.line_number,
                    problem,
                });
        }
    }

    fn read_line(&mut self) -> Result<bool, ReadError> {
        self.line.clear();
        self.line_number += 1;
        let line = self.line_number;
        let read = Read::take(&mut self.input, LONGEST_LINE as u64)
            .read_until(b'\n', &mut self.line)
            .map_err(|source| ReadError::Io { line, source })?;
        if read == LONGEST_LINE && self.line.last() != Some(&b'\n') {
            return Err(ReadError::Line {
                line,
                problem: "it is longer than 65,536 bytes",
            });
        }
        Ok(read > 0)
    }
}

fn parse_line(text: &[u8]) -> Result<(u64, Event), &'static str> {
    let text = std::str::from_utf8(text).map_err(|_| "it is not UTF-8")?;
    let (time, rest) = text.split_once(' ').ok_or("it has no arrow")?;
    let at_us: u64 = time
        .parse()
        .ok()
        .filter(|&at_us| at_us <= LATEST_US)
        .ok_or("its time is no number of microseconds")?;
    let rest = rest.trim_start();
    let arrow = rest.chars().next().ok_or("it has no arrow")?;
    let bytes = rest[arrow.len_utf8()..].trim();
    let event = match arrow {
        '<' => Event::FromBoard(parse_bytes(bytes)?),
        '>' => Event::ToBoard(parse_bytes(bytes)?),
        '!' => Event::HangUp,
        _ => return Err("its arrow is none of <, > and !"),
    };
    Ok((at_us, event))
}

fn parse_bytes(text: &str) -> Result<Vec<u8>, &'static str> {
    match text.strip_prefix('"') {
        Some(quoted) => parse_quoted(quoted),
        None => text
            .split_ascii_whitespace()
            .map(|pair| match pair.len() {
                2 => u8::from_str_radix(pair, 16).map_err(|_| "a byte is not hexadecimal"),
                _ => Err("a byte is not two hexadecimal digits"),
            })
            .collect(),
    }
}

fn parse_quoted(text: &str) -> Result<Vec<u8>, &'static str> {
    let mut bytes = Vec::new();
    let mut input = text.bytes();
    loop {
        let byte = input.next().ok_or("its closing quote is missing")?;
        match byte {
            b'"' => break,
            b'\\' => bytes.push(match input.next() {
                Some(b'r') => b'\r',
                Some(b'n') => b'\n',
                Some(b't') => b'\t',
                Some(b'x') => {
                    let mut digit = || {
                        let digit = char::from(input.next()?).to_digit(16)?;
                        u8::try_from(digit).ok()
                    };
                    match (digit(), digit()) {
                        (Some(high), Some(low)) => high << 4 | low,
                        _ => return Err("\\x wants two hexadecimal digits"),
                    }
                }
                Some(same @ (b'"' | b'\\')) => same,
                _ => return Err("it has an unknown escape"),
            }),
            other => bytes.push(other),
        }
    }
    match input.next() {
        None => Ok(bytes),
        Some(_) => Err("something follows its closing quote"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read_all(log: &[u8]) -> Result<(Vec<(u64, Event)>, bool), ReadError> {
        let mut reader = Reader::new(log)?;
        let mut events = Vec::new();
        while let Some(event) = reader.next_event()? {
            events.push(event);
        }
        Ok((events, reader.torn()))
    }

    fn a_log(events: &[(u64, Event)]) -> Vec<u8> {
        let mut header = toml::Table::new();
        header.insert("port".to_owned(), "/dev/ttyACM0".into());
        let mut writer = Writer::new(Vec::new(), &header).expect("memory");
        for (at_us, event) in events {
            match event {
                Event::FromBoard(bytes) => writer.from_board(*at_us, bytes),
                Event::ToBoard(bytes) => writer.to_board(*at_us, bytes),
                Event::HangUp => writer.hang_up(*at_us),
            }
            .expect("memory");
        }
        writer.output
    }

    #[test]
    fn text_is_logged_as_text_and_bytes_as_hexadecimal() {
        let log = a_log(&[
            (0, Event::FromBoard(b"ready \"1\"\r\n".to_vec())),
            (1532, Event::ToBoard(vec![0, 0x4d, 0xff])),
            (99, Event::HangUp),
        ]);
        let text = String::from_utf8(log).expect("a text format");
        assert_eq!(
            text,
            "# format = \"motorlab-rawlog/1\"\n# port = \"/dev/ttyACM0\"\n         0 < \"ready \\\"1\\\"\\r\\n\"\n      1532 > 00 4d ff\n        99 !\n"
        );
    }

    #[test]
    fn a_torn_line_is_left_out_and_reported() {
        let mut log = a_log(&[
            (1, Event::FromBoard(vec![1, 2, 3])),
            (2, Event::FromBoard(vec![4, 5, 6])),
        ]);
        log.truncate(log.len() - 3);
        let (events, torn) = read_all(&log).expect("a torn log is readable");
        assert_eq!(events, [(1, Event::FromBoard(vec![1, 2, 3]))]);
        assert!(torn);
    }

    #[test]
    fn errors_name_their_line() {
        let message = |line: &str| {
            let log = format!("# format = \"{FORMAT}\"\n{line}\n");
            read_all(log.as_bytes())
                .expect_err("a bad line")
                .to_string()
        };
        assert!(message("12 < 0g").starts_with("line 2 of the raw log: a byte is not hex"));
        assert!(message("x < 00").contains("no number of microseconds"));
        assert!(message("18446744073709551615 < 00").contains("no number of microseconds"));
        assert!(message("5 = 00").contains("arrow"));
        assert!(message("5 < \"abc").contains("closing quote"));
        assert!(message("5 < \"\\x1é\"").contains("two hexadecimal digits"));
        assert!(matches!(
            read_all(b"t_s,counts\n0,1\n"),
            Err(ReadError::NotARawLog { .. })
        ));
    }

    fn any_event() -> impl Strategy<Value = Event> {
        let bytes = || {
            prop_oneof![
                prop::collection::vec(any::<u8>(), 1..40),
                "[ -~\r\n\t]{1,40}".prop_map(String::into_bytes),
            ]
        };
        prop_oneof![
            bytes().prop_map(Event::FromBoard),
            bytes().prop_map(Event::ToBoard),
            Just(Event::HangUp),
        ]
    }

    proptest! {
        #[test]
        fn a_written_log_is_read_back_unchanged(events in prop::collection::vec((0..=LATEST_US, any_event()), 0..20)) {
            prop_assert_eq!(read_all(&a_log(&events)).expect("own log"), (events, false));
        }

        #[test]
        fn arbitrary_bytes_do_not_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = read_all(&bytes);
            let mut log = format!("# format = \"{FORMAT}\"\n").into_bytes();
            log.extend(bytes);
            let _ = read_all(&log);
        }
    }
}
