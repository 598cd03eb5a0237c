//! The hash chain of verdicts, `DIR/verdicts.log`: one JSON line per verdict, append-only.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use super::BlindError;
use super::files::{sha256, write_whole};

/// One link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The case judged.
    pub case: String,
    /// SHA-256 of the verdict's file.
    pub sha256: String,
    /// Time of the verdict.
    #[serde(with = "time::serde::rfc3339")]
    pub decided_at: OffsetDateTime,
    /// Hash of this link and all before it.
    pub head: String,
}

/// The chain in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    path: PathBuf,
    /// The links, oldest first.
    pub entries: Vec<Entry>,
}

impl Ledger {
    /// Reads and verifies the chain of a set; an incomplete last line is ignored, and removed by the next
    /// [`Ledger::append`].
    ///
    /// # Errors
    /// The chain is broken: a link was changed, removed or inserted.
    pub fn read(directory: &Path) -> Result<Self, BlindError> {
        let path = directory.join("verdicts.log");
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(BlindError::file(&path)(error)),
        };
        let mut ledger = Self {
            path,
            entries: Vec::new(),
        };
        for (k, line) in text.split_inclusive('\n').enumerate() {
            let Some(line) = line.strip_suffix('\n') else {
                break;
            };
            let entry: Entry = serde_json::from_str(line).map_err(|error| {
                BlindError::content(&ledger.path, format!("line {}: {error}", k + 1))
            })?;
            let expected = link(ledger.head(), &entry.case, &entry.sha256, entry.decided_at);
            if entry.head != expected {
                return Err(BlindError::altered(format!(
                    "the chain of verdicts breaks at line {} ({}): a verdict or its time was changed",
                    k + 1,
                    entry.case
                )));
            }
            ledger.entries.push(entry);
        }
        Ok(ledger)
    }

    /// Hash over all verdicts so far; `start` for an empty chain.
    pub fn head(&self) -> &str {
        self.entries.last().map_or("start", |entry| &entry.head)
    }

    /// The entry of a case.
    pub fn of(&self, case: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.case == case)
    }

    /// Appends a link and syncs it to disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(
        &mut self,
        case: &str,
        sha256: String,
        decided_at: OffsetDateTime,
    ) -> Result<(), BlindError> {
        let head = link(self.head(), case, &sha256, decided_at);
        let entry = Entry {
            case: case.to_owned(),
            sha256,
            decided_at,
            head,
        };
        self.cut_torn_line()?;
        let line = serde_json::to_string(&entry)
            .map_err(|error| BlindError::content(&self.path, error))?;
        OpenOptions::new()
            .create(true)
            .append(true)
            .open(&self.path)
            .and_then(|mut file| {
                file.write_all(format!("{line}\n").as_bytes())?;
                file.sync_all()
            })
            .map_err(BlindError::file(&self.path))?;
        self.entries.push(entry);
        Ok(())
    }

    fn cut_torn_line(&self) -> Result<(), BlindError> {
        let Ok(bytes) = fs::read(&self.path) else {
            return Ok(());
        };
        if bytes.is_empty() || bytes.ends_with(b"\n") {
            return Ok(());
        }
        let whole = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
        write_whole(&self.path, &bytes[..whole])
    }
}

fn link(previous: &str, case: &str, verdict_sha256: &str, decided_at: OffsetDateTime) -> String {
    // A time of this century formats; any other still gives a distinct hash.
    let time = decided_at
        .format(&Rfc3339)
        .unwrap_or_else(|_| decided_at.unix_timestamp_nanos().to_string());
    sha256(format!("{previous}\n{case}\n{verdict_sha256}\n{time}").as_bytes())
}
