//! Atomic writes of files, hashes, and times.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use time::OffsetDateTime;

use super::BlindError;

pub(super) fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

pub(super) fn sha256_of(path: &Path) -> Result<String, BlindError> {
    Ok(sha256(&fs::read(path).map_err(BlindError::file(path))?))
}

/// Writes a temporary file in the same folder and renames it.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), BlindError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(BlindError::file(folder))?;
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    File::create(&part)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&part, path))
        .map_err(BlindError::file(path))
}

/// Writes a document as indented JSON.
pub(super) fn write_document(path: &Path, document: &impl Serialize) -> Result<(), BlindError> {
    let mut text =
        serde_json::to_string_pretty(document).map_err(|error| BlindError::content(path, error))?;
    text.push('\n');
    write_whole(path, text.as_bytes())
}

pub(super) fn read_document<T: DeserializeOwned>(path: &Path) -> Result<T, BlindError> {
    let bytes = fs::read(path).map_err(BlindError::file(path))?;
    serde_json::from_slice(&bytes).map_err(|error| BlindError::content(path, error))
}

pub(super) fn now() -> OffsetDateTime {
    OffsetDateTime::now_utc()
}
