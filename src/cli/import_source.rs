//! Where a log comes from: text as it is read, or a table that a file of another form holds.

use std::io::{Cursor, Read};

use super::Failure;
use crate::import::{
    Form, HEAD_BYTES, MOST_FILE_BYTES, Reading, Ready, Said, TOLD_BY_BYTES, Table, understand,
    understand_table,
};

/// A log that is open.
pub(super) enum Source {
    /// Text in columns, plain or gzipped.
    Text(Box<dyn Read>),
    /// Remark about another form.
    Table(Table),
}

impl Source {
    /// Tells the form by the first bytes. Binary files are read whole.
    pub fn new(mut bytes: Box<dyn Read>, name: &str) -> Result<Self, Failure> {
        let beginning = beginning(&mut bytes, name, TOLD_BY_BYTES as u64)?;
        let form = Form::of(&beginning).or_else(|| Form::of_name(name));
        let mut all = Cursor::new(beginning).chain(bytes);
        let Some(form) = form else {
            return Ok(Self::Text(Box::new(all)));
        };
        if let Form::NotRead(..) = form {
            let failed = |error| Failure::input(format!("{name}: {error}"));
            return form.read(&[]).map(Self::Table).map_err(failed);
        }
        let whole = self::beginning(&mut all, name, MOST_FILE_BYTES + 1)?;
        if whole.len() as u64 > MOST_FILE_BYTES {
            return Err(Failure::input(format!(
                "{name}: it is {} of more than {MOST_FILE_BYTES} bytes: cut it into parts",
                form.name()
            )));
        }
        let failed = |error| Failure::input(format!("{name}: {error}"));
        form.read(&whole).map(Self::Table).map_err(failed)
    }

    /// A mapping file as it is used for this log.
    pub fn fitted(&self, ready: Ready) -> Ready {
        match self {
            Self::Text(_) => ready,
            Self::Table(_) => Ready {
                map: ready.map.for_table(),
                toml: ready.toml,
            },
        }
    }

    /// Makes a mapping from the log and the given facts.
    pub fn understand(
        &mut self,
        name: &str,
        said: &Said,
        command: &str,
    ) -> Result<Reading, Failure> {
        match self {
            Self::Table(table) => Ok(understand_table(table, name, said, command)),
            Self::Text(text) => {
                let head = beginning(text, name, HEAD_BYTES)?;
                let is_whole = (head.len() as u64) < HEAD_BYTES;
                let found = understand(&head, is_whole, name, said, command);
                let rest = std::mem::replace(text, Box::new(std::io::empty()));
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

/// The first bytes, fewer only if there are no more.
fn beginning(source: &mut impl Read, name: &str, count: u64) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = source.take(count).read_to_end(&mut bytes);
    read.map_err(|error| Failure::input(format!("{name}: {error}")))?;
    Ok(bytes)
}
