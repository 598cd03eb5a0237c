//! Source of a log: text, or the table of a file of another format.

use std::io::{self, Cursor, Read};

use super::unmapped::{GivenFlags, HEAD_BYTES, Reading, Ready, understand, understand_table};
use super::{Form, FormatError, MOST_FILE_BYTES, RECOGNITION_BYTES, Table};

/// Why a log cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// An error of its bytes.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// An error of its format.
    #[error(transparent)]
    Form(#[from] FormatError),
    /// The file is too large for memory.
    #[error("it is {form} of more than {MOST_FILE_BYTES} bytes\nhint: cut it into parts")]
    TooLarge {
        /// Name of the format.
        form: &'static str,
    },
}

/// An open log.
pub enum Source<'a> {
    /// Text in columns, plain or gzipped.
    Text(Box<dyn Read + 'a>),
    /// A table of another format.
    Table(Table),
}

impl<'a> Source<'a> {
    /// Recognizes the format by the first bytes, or by the file's name. Binary files are read completely.
    ///
    /// # Errors
    /// It cannot be read, or its format is not supported.
    pub fn new(mut bytes: Box<dyn Read + 'a>, name: &str) -> Result<Self, SourceError> {
        let mut beginning = beginning(&mut bytes, RECOGNITION_BYTES as u64)?;
        if ends_lines_by_cr(&beginning) {
            let all = Cursor::new(beginning).chain(bytes);
            bytes = Box::new(Newlines(all));
            beginning = self::beginning(&mut bytes, RECOGNITION_BYTES as u64)?;
        }
        let form = Form::of(&beginning).or_else(|| Form::of_name(name));
        let mut all = Cursor::new(beginning).chain(bytes);
        let Some(form) = form else {
            return Ok(Self::Text(Box::new(all)));
        };
        if let Form::NotRead(..) = form {
            return Ok(Self::Table(form.read(&[])?));
        }
        let whole = self::beginning(&mut all, MOST_FILE_BYTES + 1)?;
        if whole.len() as u64 > MOST_FILE_BYTES {
            return Err(SourceError::TooLarge { form: form.name() });
        }
        Ok(Self::Table(form.read(&whole)?))
    }

    /// A mapping adapted to this log.
    #[must_use]
    pub fn fitted(&self, ready: Ready) -> Ready {
        match self {
            Self::Text(_) => ready,
            Self::Table(_) => Ready {
                map: ready.map.for_table(),
                toml: ready.toml,
            },
        }
    }

    /// Makes a mapping from the log and the given facts; `command` as for [`understand`].
    ///
    /// # Errors
    /// It cannot be read.
    pub fn understand(
        &mut self,
        name: &str,
        given: &GivenFlags,
        command: &str,
    ) -> io::Result<Reading> {
        match self {
            Self::Table(table) => Ok(understand_table(table, name, given, command)),
            Self::Text(text) => {
                let head = beginning(text, HEAD_BYTES)?;
                let is_whole = (head.len() as u64) < HEAD_BYTES;
                let found = understand(&head, is_whole, name, given, command);
                let rest = std::mem::replace(text, Box::new(io::empty()));
                *text = Box::new(Cursor::new(head).chain(rest));
                Ok(found)
            }
        }
    }

    /// The log as text in columns.
    pub fn read(&mut self) -> Box<dyn Read + '_> {
        match self {
            Self::Text(text) => Box::new(text),
            Self::Table(table) => Box::new(table.text()),
        }
    }
}

/// Whether a text ends its lines with a carriage return alone, as old programs for the Mac and terminals do.
fn ends_lines_by_cr(beginning: &[u8]) -> bool {
    let is_text = |byte: &u8| !byte.is_ascii_control() || matches!(byte, b'\r' | b'\t');
    beginning.contains(&b'\r') && beginning.iter().all(is_text)
}

/// Line feeds in the place of carriage returns.
struct Newlines<R>(R);

impl<R: Read> Read for Newlines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.0.read(buffer)?;
        for byte in &mut buffer[..count] {
            if *byte == b'\r' {
                *byte = b'\n';
            }
        }
        Ok(count)
    }
}

/// The first bytes, fewer only at the end.
fn beginning(source: &mut impl Read, count: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(count).read_to_end(&mut bytes)?;
    Ok(bytes)
}
