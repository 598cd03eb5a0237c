//! Messages in CDR, the serialization of ROS 2 (OMG DDS-RTPS): plain CDR and XCDR2, both byte orders.

use super::super::table::of_f32;
use super::bytes::Bytes;
use super::messages::{Leaf, MOST_ELEMENTS, Sink};
use super::ros_types::{Field, Kind, Many, Types};

/// Deepest nesting of messages.
const MOST_DEPTH: usize = 16;
/// Most fields of a message that take no bytes.
const LEAST_ROOM: usize = 1000;

/// Reader of a message.
struct Reader<'a> {
    rest: Bytes<'a>,
    /// Total length, the reference of alignment.
    length: usize,
    is_big_endian: bool,
    most_alignment: usize,
    /// Fields that may still be read: nested types can name more than any message contains.
    room: usize,
}

/// Passes every number of a message to `sink`, with its path from `path` on. `None` if the bytes do not match the
/// type.
pub(super) fn read(
    types: &Types,
    name: &str,
    bytes: &[u8],
    path: &mut String,
    sink: &mut Sink,
) -> Option<()> {
    let mut rest = Bytes(bytes);
    let [_, representation, _, _] = rest.array()?;
    let (is_big_endian, most_alignment) = match representation {
        0 => (true, 8),
        1 => (false, 8),
        6 => (true, 4),
        7 => (false, 4),
        _ => return None,
    };
    let mut reader = Reader {
        rest,
        length: rest.0.len(),
        is_big_endian,
        most_alignment,
        room: LEAST_ROOM + bytes.len(),
    };
    reader.fields(types, types.fields(name)?, path, sink, 0)
}

impl Reader<'_> {
    /// The next number of this size, aligned.
    fn number(&mut self, size: usize) -> Option<u64> {
        let at = self.length - self.rest.0.len();
        let alignment = size.min(self.most_alignment);
        self.rest.take(at.wrapping_neg() & (alignment - 1))?;
        let bytes = self.rest.take(size)?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(match self.is_big_endian {
            true => bytes.iter().fold(0, add),
            false => bytes.iter().rev().fold(0, add),
        })
    }

    fn text(&mut self) -> Option<&str> {
        let length = self.number(4)? as usize;
        let bytes = self.rest.take(length)?;
        std::str::from_utf8(bytes.strip_suffix(b"\0").unwrap_or(bytes)).ok()
    }

    fn fields(
        &mut self,
        types: &Types,
        fields: &[Field],
        path: &mut String,
        sink: &mut Sink,
        depth: usize,
    ) -> Option<()> {
        if depth > MOST_DEPTH {
            return None;
        }
        // A type without fields is a byte on the wire.
        if fields.is_empty() {
            self.rest.take(1)?;
        }
        for field in fields {
            self.room = self.room.checked_sub(1)?;
            let whole = path.len();
            path.push('.');
            path.push_str(&field.name);
            let count = match field.many {
                Many::One => None,
                Many::Fixed(count) => Some(count),
                Many::Counted => Some(self.number(4)? as usize),
            };
            match count {
                None => self.value(types, &field.kind, path, Some(sink), depth)?,
                // Every element takes at least a byte.
                Some(count) if count > self.rest.0.len() => return None,
                Some(count) => {
                    let name = path.len();
                    for at in 0..count {
                        let sink = (at < MOST_ELEMENTS).then_some(&mut *sink);
                        if sink.is_some() {
                            path.push_str(&format!("[{at}]"));
                        }
                        self.value(types, &field.kind, path, sink, depth)?;
                        path.truncate(name);
                    }
                }
            }
            path.truncate(whole);
        }
        Some(())
    }

    fn value(
        &mut self,
        types: &Types,
        kind: &Kind,
        path: &mut String,
        sink: Option<&mut Sink>,
        depth: usize,
    ) -> Option<()> {
        let number = match kind {
            Kind::Bool => f64::from(self.number(1)? != 0),
            Kind::Unsigned(size) => self.number(usize::from(*size))? as f64,
            Kind::Signed(size) => {
                let size = usize::from(*size);
                let unused = 64 - 8 * size as u32;
                ((self.number(size)? << unused) as i64 >> unused) as f64
            }
            Kind::Float(4) => of_f32(f32::from_bits(self.number(4)? as u32)),
            Kind::Float(_) => f64::from_bits(self.number(8)?),
            Kind::Text => {
                let text = self.text()?;
                if let Some(sink) = sink {
                    sink(path, Leaf::Text(text));
                }
                return Some(());
            }
            Kind::WideText => return None,
            Kind::Nested(name) if name == "builtin_interfaces/Time" => {
                let seconds = self.number(4)? as u32 as i32;
                let ns = self.number(4)?;
                if let Some(sink) = sink {
                    sink(
                        path,
                        Leaf::Time(i64::from(seconds) * 1_000_000_000 + ns as i64),
                    );
                }
                return Some(());
            }
            Kind::Nested(name) => {
                let fields = types.fields(name)?;
                let mut unseen = |_: &str, _: Leaf| {};
                let sink: &mut Sink = match sink {
                    Some(sink) => sink,
                    None => &mut unseen,
                };
                return self.fields(types, fields, path, sink, depth + 1);
            }
        };
        if let Some(sink) = sink {
            sink(path, Leaf::Number(number));
        }
        Some(())
    }
}
