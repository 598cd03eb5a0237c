//! MCAP, as ROS 2 and Foxglove record it: messages in CDR and in JSON, in chunks compressed by zstd, LZ4 or plain.
//!
//! Format: <https://mcap.dev/spec>. Parsed here because the reader of the crate `mcap` 0.26 allocates damaged
//! lengths, and panics on other errors.

use std::collections::HashMap;
use std::io::Read;

use flate2::Crc;

use super::super::table::Table;
use super::bytes::Bytes;
use super::messages::Messages;
use super::{Form, FormatError, MOST_FILE_BYTES};

const FORM: Form = Form::Mcap;
const MAGIC_BYTES: usize = 8;
/// Largest decompressed chunk in bytes: recorders write some megabytes.
const MOST_CHUNK_BYTES: u64 = 1 << 28;
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const DATA_END: u8 = 15;

/// Type, encoding and definition.
type Schema = (String, String, String);

/// Reader of a file.
struct Reader {
    schemas: HashMap<u16, Schema>,
    messages: Messages,
    /// Bytes that may still be decompressed.
    room: u64,
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let mut reader = Reader {
        schemas: HashMap::new(),
        messages: Messages::new(FORM),
        room: MOST_FILE_BYTES,
    };
    let read = reader.records(bytes.get(MAGIC_BYTES..).unwrap_or_default(), true);
    match read {
        Ok(()) => {}
        // Records before a truncated end are complete.
        Err(FormatError::Broken { why, .. }) if !reader.messages.signals.is_empty() => {
            let note = format!("it is read up to where it breaks off: {why}");
            reader.messages.signals.notes.push(note);
        }
        Err(error) => return Err(error),
    }
    reader.messages.table()
}

impl Reader {
    /// Reads records up to the end of the data.
    fn records(&mut self, bytes: &[u8], is_file: bool) -> Result<(), FormatError> {
        let mut rest = Bytes(bytes);
        while !rest.is_empty() {
            let (opcode, data) =
                next(&mut rest).ok_or_else(|| FORM.broken("it ends within a record"))?;
            match opcode {
                CHUNK if is_file => self.chunk(data)?,
                // The rest repeats earlier records.
                DATA_END if is_file => return Ok(()),
                _ => self
                    .record(opcode, data)
                    .ok_or_else(|| FORM.broken("a record is shorter than it says"))??,
            }
        }
        match is_file {
            true => Err(FORM.broken("it has no end")),
            false => Ok(()),
        }
    }

    fn chunk(&mut self, data: &[u8]) -> Result<(), FormatError> {
        let (size, crc, compression, records) =
            chunk(data).ok_or_else(|| FORM.broken("a chunk is shorter than it says"))?;
        if size > self.room.min(MOST_CHUNK_BYTES) {
            return Err(FORM.too_much("bytes behind its compression"));
        }
        self.room -= size;
        let inflated = |source: &mut dyn Read| {
            let mut plain = Vec::new();
            source
                .take(size)
                .read_to_end(&mut plain)
                .map(|_| plain)
                .map_err(|error| FORM.broken(error))
        };
        let plain = match compression.as_str() {
            "" => records.to_vec(),
            "zstd" => {
                let source = zstd::stream::read::Decoder::with_buffer(records);
                inflated(&mut source.map_err(|error| FORM.broken(error))?)?
            }
            "lz4" => inflated(&mut lz4_flex::frame::FrameDecoder::new(records))?,
            other => return Err(FORM.broken(format!("its chunks are compressed with `{other}`"))),
        };
        let mut sum = Crc::new();
        sum.update(&plain);
        if crc != 0 && crc != sum.sum() {
            return Err(FORM.broken("a chunk does not have the checksum that it says"));
        }
        self.records(&plain, false)
    }

    /// Reads one record; `None` if it is shorter than its lengths state.
    fn record(&mut self, opcode: u8, data: &[u8]) -> Option<Result<(), FormatError>> {
        let mut rest = Bytes(data);
        match opcode {
            SCHEMA => {
                let id = rest.u16_le()?;
                let schema = (rest.text()?, rest.text()?, rest.text()?);
                self.schemas.insert(id, schema);
            }
            CHANNEL => {
                let id = u64::from(rest.u16_le()?);
                let schema = self.schemas.get(&rest.u16_le()?);
                let (topic, encoding) = (rest.text()?, rest.text()?);
                if self.messages.has_topic(id) {
                    return Some(Ok(()));
                }
                let kind = schema.map_or("", |(name, _, _)| name);
                // For encodings other than ros2msg, such as IDL, the common types are known.
                let definition = schema
                    .filter(|(_, encoding, _)| encoding == "ros2msg")
                    .map(|(_, _, definition)| definition.as_str());
                self.messages.topic(id, &topic, &encoding, kind, definition);
            }
            MESSAGE => {
                let channel = rest.u16_le()?;
                let _sequence = rest.u32_le()?;
                let recorded_ns = rest.uint_le(8)?;
                let _published_ns = rest.uint_le(8)?;
                let time_ns = i64::try_from(recorded_ns).unwrap_or(i64::MAX);
                return Some(self.messages.message(u64::from(channel), time_ns, rest.0));
            }
            _ => {}
        }
        Some(Ok(()))
    }
}

fn next<'a>(rest: &mut Bytes<'a>) -> Option<(u8, &'a [u8])> {
    let opcode = rest.u8()?;
    let length = usize::try_from(rest.uint_le(8)?).ok()?;
    Some((opcode, rest.take(length)?))
}

/// Size and checksum of a chunk's records, their compression, and the records.
fn chunk(data: &[u8]) -> Option<(u64, u32, String, &[u8])> {
    let mut rest = Bytes(data);
    // Times of the first and the last message.
    rest.take(16)?;
    let size = rest.uint_le(8)?;
    let crc = rest.u32_le()?;
    let compression = rest.text()?;
    let length = usize::try_from(rest.uint_le(8)?).ok()?;
    Some((size, crc, compression, rest.take(length)?))
}
