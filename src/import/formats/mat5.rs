//! MATLAB's MAT files of versions 5 to 7: tagged elements, compressed by zlib or plain.
//!
//! Format: "MAT-File Format", MathWorks, version 5. Objects are in a variable without a name, which is a MAT file
//! itself. An object of the workspace is an index of one of them.

use std::cell::Cell;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::table::{Table, of_f32};
use super::bytes::Bytes;
use super::mcos::{Objects, reference};
use super::workspace::{self, Value};
use super::{Form, FormatError, MOST_FILE_BYTES, MOST_VALUES};

const FORM: Form = Form::Mat5;
/// Deepest nesting of structs.
const MOST_DEPTH: usize = 16;
/// Numbers whose memory equals the overhead of a value.
const NUMBERS_OF_A_VALUE: usize = 8;
/// Class of byte arrays, such as the variable of objects.
const MX_UINT8: u32 = 9;
/// Class of objects, undocumented by MathWorks: a kind, a class and a reference.
const MX_OPAQUE: u32 = 17;

const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;

/// Reader of a file.
struct Reader {
    is_big_endian: bool,
    /// Bytes that may still be decompressed.
    room: u64,
    /// Numbers that may still be read: one byte each in the file, eight in memory.
    values: Cell<usize>,
    /// Inside objects: cells and arrays of more than two dimensions are needed, and too large ones are left out.
    is_inside: bool,
}

/// Type and content of an element.
type Element<'a> = (u32, Bytes<'a>);

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let mut reader = Reader {
        is_big_endian: bytes.get(126) == Some(&b'M'),
        room: MOST_FILE_BYTES,
        values: Cell::new(MOST_VALUES),
        is_inside: false,
    };
    let (mut variables, mut objects) = (Vec::new(), None);
    let mut rest = Bytes(bytes.get(128..).unwrap_or_default());
    let cut_off = || FORM.broken("it ends within a variable");
    while !rest.is_empty() {
        let (kind, mut content) = reader.element(&mut rest).ok_or_else(cut_off)?;
        if kind == MI_COMPRESSED {
            let plain = reader.inflated(content.0)?;
            let (kind, mut content) = reader.element(&mut Bytes(&plain)).ok_or_else(cut_off)?;
            if kind == MI_MATRIX {
                objects = reader.objects(content).or(objects);
                reader.variable(&mut content, &mut variables)?;
            }
        } else if kind == MI_MATRIX {
            objects = reader.objects(content).or(objects);
            reader.variable(&mut content, &mut variables)?;
        }
    }
    workspace::table(FORM, variables, objects)
}

impl Reader {
    fn u32(&self, bytes: &mut Bytes) -> Option<u32> {
        let array = bytes.array()?;
        Some(match self.is_big_endian {
            true => u32::from_be_bytes(array),
            false => u32::from_le_bytes(array),
        })
    }

    /// The next element. One of at most four bytes has its length in its tag.
    fn element<'a>(&self, bytes: &mut Bytes<'a>) -> Option<Element<'a>> {
        let tag = self.u32(bytes)?;
        if tag >> 16 != 0 {
            let content = bytes.take(4)?;
            return Some((tag & 0xffff, Bytes(content.get(..(tag >> 16) as usize)?)));
        }
        let length = self.u32(bytes)? as usize;
        let content = bytes.take(length)?;
        if tag != MI_COMPRESSED {
            // The last one may lack the padding to eight bytes.
            let filling = length.wrapping_neg() & 7;
            bytes.take(filling.min(bytes.0.len()))?;
        }
        Some((tag, Bytes(content)))
    }

    fn inflated(&mut self, compressed: &[u8]) -> Result<Vec<u8>, FormatError> {
        let mut plain = Vec::new();
        let mut source = ZlibDecoder::new(compressed).take(self.room + 1);
        source
            .read_to_end(&mut plain)
            .map_err(|error| FORM.broken(error))?;
        let length = plain.len() as u64;
        if length > self.room {
            return Err(FORM.too_much("bytes behind its compression"));
        }
        self.room -= length;
        Ok(plain)
    }

    fn variable(
        &self,
        bytes: &mut Bytes,
        variables: &mut Vec<(String, Value)>,
    ) -> Result<(), FormatError> {
        // Variables without a name belong to the objects.
        if self.unnamed(*bytes).is_some() {
            return Ok(());
        }
        let variable = self.matrix(bytes, 0).ok_or_else(|| {
            FORM.broken("a variable contradicts its own lengths, or is larger than a log")
        })?;
        variables.push(variable);
        Ok(())
    }

    /// The bytes of a variable without a name.
    fn unnamed<'a>(&self, mut bytes: Bytes<'a>) -> Option<Bytes<'a>> {
        let (_, mut flags) = self.element(&mut bytes)?;
        let is_bytes = self.u32(&mut flags)? & 0xff == MX_UINT8;
        let _sizes = self.element(&mut bytes)?;
        let (_, name) = self.element(&mut bytes)?;
        let (_, content) = self.element(&mut bytes)?;
        (is_bytes && name.is_empty()).then_some(content)
    }

    /// The objects in a variable without a name; `None` if there are none or they cannot be read.
    fn objects(&self, variable: Bytes) -> Option<Objects> {
        let mut file = self.unnamed(variable)?;
        // Version, byte order, and padding.
        let head: [u8; 8] = file.array()?;
        let inside = Self {
            is_big_endian: head[2] == b'M',
            room: 0,
            values: self.values.clone(),
            is_inside: true,
        };
        let (_, mut content) = inside.element(&mut file)?;
        let (_, value) = inside.matrix(&mut content, 0)?;
        self.values.set(inside.values.get());
        match value {
            Value::Structs(fields) => {
                let found = fields.into_iter().find(|(name, _)| name == "MCOS")?;
                match found.1.into_iter().next()? {
                    Value::Cells(cells) => Objects::of(cells),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    fn matrix(&self, bytes: &mut Bytes, depth: usize) -> Option<(String, Value)> {
        if depth > MOST_DEPTH {
            return None;
        }
        let left = self.values.get().checked_sub(NUMBERS_OF_A_VALUE)?;
        self.values.set(left);
        if bytes.is_empty() {
            return Some((String::new(), Value::Other));
        }
        let (_, mut flags) = self.element(bytes)?;
        let flags = self.u32(&mut flags)?;
        let class = flags & 0xff;
        if class == MX_OPAQUE {
            return self.opaque(bytes, depth);
        }
        let (_, mut sizes) = self.element(bytes)?;
        let mut dimensions = Vec::new();
        while let Some(size) = self.u32(&mut sizes) {
            dimensions.push(size as usize);
        }
        let name = text(self.element(bytes)?.1);
        let count = dimensions
            .iter()
            .try_fold(1, |product: usize, size| product.checked_mul(*size))?;
        let value = match class {
            1 if self.is_inside => Value::Cells(self.cells(bytes, count, depth)?),
            2 => self.structs(bytes, count, depth)?,
            3 => {
                let class = text(self.element(bytes)?.1);
                Value::Objects(class, Vec::new())
            }
            4 => {
                let (kind, content) = self.element(bytes)?;
                let letters = self.numbers(kind, content)?;
                let text = letters.iter().filter_map(|x| char::from_u32(*x as u32));
                Value::Text(text.collect())
            }
            6..=15 if dimensions.len() == 2 || self.is_inside => {
                let (kind, content) = self.element(bytes)?;
                let numbers = self.numbers(kind, content);
                match numbers.filter(|numbers| numbers.len() == count) {
                    Some(numbers) => Value::Numbers(dimensions, numbers),
                    None if self.is_inside => Value::Other,
                    None => return None,
                }
            }
            _ => Value::Other,
        };
        Some((name, value))
    }

    /// Name and value of an object: its class and the index of its object.
    fn opaque(&self, bytes: &mut Bytes, depth: usize) -> Option<(String, Value)> {
        let name = text(self.element(bytes)?.1);
        let _kind = self.element(bytes)?;
        let class = text(self.element(bytes)?.1);
        let (_, mut content) = self.element(bytes)?;
        let value = match self.matrix(&mut content, depth + 1)?.1 {
            Value::Cells(cells) => Value::Cells(cells),
            Value::Numbers(_, numbers) => {
                Value::Objects(class, reference(&numbers).unwrap_or_default())
            }
            _ => Value::Objects(class, Vec::new()),
        };
        Some((name, value))
    }

    fn cells(&self, bytes: &mut Bytes, count: usize, depth: usize) -> Option<Vec<Value>> {
        let mut cells = Vec::new();
        for _ in 0..count {
            let (_, mut content) = self.element(bytes)?;
            cells.push(self.matrix(&mut content, depth + 1)?.1);
        }
        Some(cells)
    }

    fn structs(&self, bytes: &mut Bytes, count: usize, depth: usize) -> Option<Value> {
        let (_, mut length) = self.element(bytes)?;
        let length = self.u32(&mut length)? as usize;
        let (_, names) = self.element(bytes)?;
        if length == 0 {
            return Some(Value::Other);
        }
        let names: Vec<String> = names
            .0
            .chunks_exact(length)
            .map(|name| text(Bytes(name)))
            .collect();
        let mut fields: Vec<(String, Vec<Value>)> =
            names.into_iter().map(|name| (name, Vec::new())).collect();
        if fields.is_empty() {
            return Some(Value::Other);
        }
        for _ in 0..count {
            for (_, values) in &mut fields {
                let (kind, mut content) = self.element(bytes)?;
                if kind != MI_MATRIX {
                    return None;
                }
                values.push(self.matrix(&mut content, depth + 1)?.1);
            }
        }
        Some(Value::Structs(fields))
    }

    /// Numbers of any numeric storage type.
    fn numbers(&self, kind: u32, bytes: Bytes) -> Option<Vec<f64>> {
        macro_rules! all {
            ($type:ty, $convert:expr) => {{
                let size = size_of::<$type>();
                let left = self.values.get().checked_sub(bytes.0.len() / size)?;
                self.values.set(left);
                let number = |chunk: &[u8]| -> Option<f64> {
                    let array = chunk.try_into().ok()?;
                    let number = match self.is_big_endian {
                        true => <$type>::from_be_bytes(array),
                        false => <$type>::from_le_bytes(array),
                    };
                    Some($convert(number))
                };
                bytes.0.chunks_exact(size).map(number).collect()
            }};
        }
        match kind {
            1 => all!(i8, f64::from),
            2 | 16 => all!(u8, f64::from),
            3 => all!(i16, f64::from),
            4 | 17 => all!(u16, f64::from),
            5 => all!(i32, f64::from),
            6 | 18 => all!(u32, f64::from),
            7 => all!(f32, of_f32),
            9 => all!(f64, |x| x),
            12 => all!(i64, |x| x as f64),
            13 => all!(u64, |x| x as f64),
            _ => None,
        }
    }
}

fn text(bytes: Bytes) -> String {
    let end = bytes.0.iter().position(|byte| *byte == 0);
    String::from_utf8_lossy(&bytes.0[..end.unwrap_or(bytes.0.len())]).into_owned()
}
