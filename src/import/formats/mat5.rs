//! MATLAB's MAT file of versions 5 to 7: tagged elements, each behind zlib or plain.
//!
//! Format: "MAT-File Format", MathWorks, version 5. Vectors, matrices and structs of them are read, Simulink's structure with time
//! by the labels of its signals. Objects (timeseries, Dataset) have an undocumented form; they are named, with what to do.

use std::cell::Cell;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::table::{Table, of_f32};
use super::bytes::Bytes;
use super::variables::{Variables, object};
use super::{Form, FormatError, MOST_FILE_BYTES, MOST_VALUES};

const FORM: Form = Form::Mat5;
/// Structs within structs.
const MOST_DEPTH: usize = 16;
/// Elements of an array of structs whose fields become columns.
const MOST_STRUCTS: usize = 64;

const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;

/// A value of the workspace.
enum Node {
    /// Numbers of so many rows, column by column.
    Numbers(usize, Vec<f64>),
    Text(String),
    /// Fields with their value in every element.
    Structs(Vec<(String, Vec<Node>)>),
    /// Class of an object.
    Object(String),
    Other,
}

/// A file under way.
struct Reader {
    is_big_endian: bool,
    /// Bytes that may still come of compressed data.
    room: u64,
    /// Numbers that may still come: of one byte each they take eight in memory.
    values: Cell<usize>,
}

/// Type and content of an element.
type Element<'a> = (u32, Bytes<'a>);

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let mut reader = Reader {
        is_big_endian: bytes.get(126) == Some(&b'M'),
        room: MOST_FILE_BYTES,
        values: Cell::new(MOST_VALUES),
    };
    let mut variables = Variables::new(FORM);
    let mut rest = Bytes(bytes.get(128..).unwrap_or_default());
    let cut_off = || FORM.broken("it ends within a variable");
    while !rest.is_empty() {
        let (kind, mut content) = reader.element(&mut rest).ok_or_else(cut_off)?;
        if kind == MI_COMPRESSED {
            let plain = reader.inflated(content.0)?;
            let (kind, mut content) = reader.element(&mut Bytes(&plain)).ok_or_else(cut_off)?;
            if kind == MI_MATRIX {
                reader.variable(&mut content, &mut variables)?;
            }
        } else if kind == MI_MATRIX {
            reader.variable(&mut content, &mut variables)?;
        }
    }
    variables.table()
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
            // The last one may lack what fills it up to eight bytes.
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

    fn variable(&self, bytes: &mut Bytes, variables: &mut Variables) -> Result<(), FormatError> {
        let (name, node) = self.matrix(bytes, 0).ok_or_else(|| {
            FORM.broken("a variable contradicts its own lengths, or is larger than a log")
        })?;
        // What stands without a name belongs to the objects.
        if !name.is_empty() {
            flatten(&name, node, variables);
        }
        Ok(())
    }

    /// Name and value of an array.
    fn matrix(&self, bytes: &mut Bytes, depth: usize) -> Option<(String, Node)> {
        if depth > MOST_DEPTH {
            return None;
        }
        if bytes.is_empty() {
            return Some((String::new(), Node::Other));
        }
        let (_, mut flags) = self.element(bytes)?;
        let flags = self.u32(&mut flags)?;
        let class = flags & 0xff;
        if class == 17 {
            let name = text(self.element(bytes)?.1);
            let _kind = self.element(bytes)?;
            let class = text(self.element(bytes)?.1);
            return Some((name, Node::Object(class)));
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
        let node = match class {
            2 => self.structs(bytes, count, depth)?,
            3 => {
                let class = text(self.element(bytes)?.1);
                Node::Object(class)
            }
            4 => {
                let (kind, content) = self.element(bytes)?;
                let letters = self.numbers(kind, content)?;
                let text = letters.iter().filter_map(|x| char::from_u32(*x as u32));
                Node::Text(text.collect())
            }
            6..=15 if dimensions.len() == 2 => {
                let (kind, content) = self.element(bytes)?;
                let numbers = self.numbers(kind, content)?;
                if numbers.len() != count {
                    return None;
                }
                Node::Numbers(dimensions[0], numbers)
            }
            _ => Node::Other,
        };
        Some((name, node))
    }

    fn structs(&self, bytes: &mut Bytes, count: usize, depth: usize) -> Option<Node> {
        let (_, mut length) = self.element(bytes)?;
        let length = self.u32(&mut length)? as usize;
        let (_, names) = self.element(bytes)?;
        if length == 0 {
            return Some(Node::Other);
        }
        let names: Vec<String> = names
            .0
            .chunks_exact(length)
            .map(|name| text(Bytes(name)))
            .collect();
        let mut fields: Vec<(String, Vec<Node>)> =
            names.into_iter().map(|name| (name, Vec::new())).collect();
        if fields.is_empty() {
            return Some(Node::Other);
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
        Some(Node::Structs(fields))
    }

    /// Numbers of any of the types that numbers are stored as.
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

/// The vectors in a value, under the names by which MATLAB calls them.
fn flatten(name: &str, node: Node, variables: &mut Variables) {
    match node {
        Node::Numbers(rows, numbers) => {
            let columns = numbers.len() / rows.max(1);
            variables.push(name, rows, columns, numbers);
        }
        Node::Structs(fields) => {
            let is_simulink = ["time", "signals"]
                .iter()
                .all(|wanted| fields.iter().any(|(field, _)| field == wanted));
            for (field, values) in fields {
                let count = values.len();
                for (at, value) in values.into_iter().enumerate().take(MOST_STRUCTS) {
                    let element = match count {
                        1 => format!("{name}.{field}"),
                        _ => format!("{name}({}).{field}", at + 1),
                    };
                    match value {
                        Node::Structs(parts) if is_simulink && field == "signals" => {
                            signals(&element, parts, variables);
                        }
                        value => flatten(&element, value, variables),
                    }
                }
            }
        }
        Node::Object(class) => variables.not_read.push(object(name, &class)),
        Node::Text(_) | Node::Other => {}
    }
}

/// Simulink's structure with time: `values` of every signal under its label.
fn signals(name: &str, fields: Vec<(String, Vec<Node>)>, variables: &mut Variables) {
    let (mut values, mut labels) = (Vec::new(), Vec::new());
    for (field, nodes) in fields {
        match field.as_str() {
            "values" => values = nodes,
            "label" => labels = nodes,
            _ => {}
        }
    }
    let count = values.len();
    for (at, value) in values.into_iter().enumerate() {
        let name = match (labels.get(at), count) {
            (Some(Node::Text(label)), _) if !label.trim().is_empty() => label.clone(),
            (_, 1) => name.to_owned(),
            _ => format!("{name}({})", at + 1),
        };
        flatten(&name, value, variables);
    }
}
