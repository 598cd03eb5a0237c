//! MATLAB's MAT files of version 7.3, which are HDF5: every dataset of numbers, by its path.
//!
//! A struct is a group. Contents of cells and objects are in `#refs#`; `#subsystem#/MCOS` lists the cells of objects.

use std::collections::HashMap;

use ::hdf5_reader::group::Group;
use ::hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};

use super::super::table::{Table, of_f32};
use super::mcos::{Objects, reference};
use super::workspace::{self, Value};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Hdf5;
/// Deepest nesting of groups.
const MOST_DEPTH: usize = 8;
/// Most groups and datasets of the workspace that are read.
const MOST_MEMBERS: usize = 4096;
/// Most of them in objects: a thousand signals of 60 properties.
const MOST_INSIDE: usize = 1 << 16;
/// Largest block of compressed data, in bytes.
const MOST_CHUNK_BYTES: usize = 1 << 27;
/// Most elements of an array of structs.
const MOST_STRUCTS: usize = 64;
/// Bytes of a reference: the address of its target.
const REFERENCE_BYTES: usize = 8;

/// The group of Simulink's logs to a file: samples in an unsupported format.
const STREAMS: &str = "#sigstream#";

/// Targets of references, by address.
struct Referred {
    groups: HashMap<u64, Group>,
    datasets: HashMap<u64, Dataset>,
}

/// Sizes, the first index the fastest, and numbers.
type Array = (Vec<usize>, Vec<f64>);

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let broken = |error: ::hdf5_reader::error::Error| FORM.broken(error);
    let options = OpenOptions::default()
        .with_max_read_bytes(MOST_VALUES * size_of::<f64>())
        .with_max_chunk_bytes(MOST_CHUNK_BYTES);
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(broken)?;
    let root = file.root_group().map_err(broken)?;
    let referred = referred(&root);
    let mut reader = Reader {
        referred: &referred,
        members: MOST_MEMBERS,
        values: MOST_VALUES,
        is_inside: false,
    };
    let members = reader.members(&root, 0)?.into_iter();
    let values =
        members.flat_map(|(name, values)| values.into_iter().map(move |x| (name.clone(), x)));
    let mut values: Vec<(String, Value)> = values.collect();
    if root.group(STREAMS).is_ok() {
        let class = "Simulink signal stream".to_owned();
        values.push((STREAMS.to_owned(), Value::Objects(class, Vec::new())));
    }
    reader.is_inside = true;
    reader.members = MOST_INSIDE;
    let objects = reader.objects(&root);
    workspace::table(FORM, values, objects)
}

/// All possible targets of references; empty if there are none or they cannot be read.
fn referred(root: &Group) -> Referred {
    let members = root.group("#refs#").and_then(|group| group.members());
    let (groups, datasets) = members.unwrap_or_default();
    let groups = groups.into_iter().map(|group| (group.address(), group));
    let datasets = datasets
        .into_iter()
        .map(|dataset| (dataset.address(), dataset));
    Referred {
        groups: groups.collect(),
        datasets: datasets.collect(),
    }
}

struct Reader<'a> {
    referred: &'a Referred,
    /// Groups and datasets that may still be read.
    members: usize,
    /// Numbers that may still be read.
    values: usize,
    /// Inside objects: cells are needed, and unreadable parts are left out.
    is_inside: bool,
}

impl Reader<'_> {
    /// The objects of the file; `None` if there are none or they cannot be read.
    fn objects(&mut self, root: &Group) -> Option<Objects> {
        let list = root.group("#subsystem#").ok()?.dataset("MCOS").ok()?;
        let cells = self.referred_to(&list, 0, MOST_INSIDE).ok()?;
        Objects::of(cells)
    }

    /// The members of a group with their values: one, or one for every element of an array of structs.
    fn members(
        &mut self,
        group: &Group,
        depth: usize,
    ) -> Result<Vec<(String, Vec<Value>)>, FormatError> {
        let (groups, datasets) = group.members().map_err(|error| FORM.broken(error))?;
        self.look(groups.len() + datasets.len(), depth)?;
        let mut values = Vec::new();
        for dataset in &datasets {
            values.push((dataset.name().to_owned(), self.dataset(dataset, depth)?));
        }
        // `#refs#` and `#subsystem#` contain the parts of cells and objects.
        for group in groups.iter().filter(|group| !group.name().starts_with('#')) {
            values.push((group.name().to_owned(), vec![self.group(group, depth + 1)?]));
        }
        Ok(values)
    }

    fn look(&mut self, count: usize, depth: usize) -> Result<(), FormatError> {
        let left = self
            .members
            .checked_sub(count)
            .filter(|_| depth <= MOST_DEPTH);
        self.members =
            left.ok_or_else(|| FORM.broken("it has more groups and datasets than a log has"))?;
        Ok(())
    }

    /// A struct; a sparse matrix is a group too.
    fn group(&mut self, group: &Group, depth: usize) -> Result<Value, FormatError> {
        match group.attribute("MATLAB_sparse") {
            Ok(_) => Ok(Value::Other),
            Err(_) => Ok(Value::Structs(self.members(group, depth)?)),
        }
    }

    fn dataset(&mut self, dataset: &Dataset, depth: usize) -> Result<Vec<Value>, FormatError> {
        let word = |attribute: &str| {
            let found = dataset.attribute(attribute).ok()?;
            found.read_string().ok()
        };
        let class = word("MATLAB_class").unwrap_or_default();
        // The numbers of an empty array are its sizes.
        if dataset.attribute("MATLAB_empty").is_ok() {
            return Ok(vec![Value::Other]);
        }
        if matches!(dataset.dtype(), Datatype::Reference { .. }) {
            return match class.as_str() {
                "" => self.referred_to(dataset, depth, MOST_STRUCTS),
                "cell" if self.is_inside => {
                    let cells = self.referred_to(dataset, depth, MOST_INSIDE)?;
                    Ok(vec![Value::Cells(cells)])
                }
                _ => Ok(vec![Value::Other]),
            };
        }
        let is_object = dataset.attribute("MATLAB_object_decode").is_ok();
        let value = match self.numbers(dataset)? {
            Some((_, numbers)) if is_object => {
                Value::Objects(class, reference(&numbers).unwrap_or_default())
            }
            None if is_object => Value::Objects(class, Vec::new()),
            Some((_, letters)) if class == "char" => {
                let letters: Vec<u16> = letters.iter().map(|letter| *letter as u16).collect();
                Value::Text(String::from_utf16_lossy(&letters))
            }
            Some((sizes, numbers)) => Value::Numbers(sizes, numbers),
            None => Value::Other,
        };
        Ok(vec![value])
    }

    /// Targets of a dataset of references, up to a limit.
    fn referred_to(
        &mut self,
        dataset: &Dataset,
        depth: usize,
        most: usize,
    ) -> Result<Vec<Value>, FormatError> {
        let bytes = dataset
            .read_raw_bytes()
            .map_err(|error| FORM.broken(error))?;
        let addresses = bytes.as_chunks::<REFERENCE_BYTES>().0.iter().take(most);
        self.look(addresses.len(), depth)?;
        let referred = self.referred;
        let mut values = Vec::new();
        for address in addresses {
            let address = u64::from_le_bytes(*address);
            let group = referred.groups.get(&address);
            let value = match (group, referred.datasets.get(&address)) {
                (Some(group), _) => self.group(group, depth + 1),
                (None, Some(dataset)) => self.dataset(dataset, depth + 1).map(one),
                (None, None) => Ok(Value::Other),
            };
            values.push(match self.is_inside {
                true => value.unwrap_or(Value::Other),
                false => value?,
            });
        }
        Ok(values)
    }

    /// Sizes and numbers of a numeric dataset; the real part of complex ones.
    fn numbers(&mut self, dataset: &Dataset) -> Result<Option<Array>, FormatError> {
        let (kind, width) = match dataset.dtype() {
            Datatype::Compound { size, fields } => match &fields[..] {
                [real, _] if real.byte_offset == 0 && is_f64(&real.datatype) => {
                    (&real.datatype, *size as usize)
                }
                _ => return Ok(None),
            },
            kind => (kind, 0),
        };
        let is_number = matches!(
            kind,
            Datatype::FloatingPoint { .. } | Datatype::FixedPoint { .. }
        );
        let shape = dataset.shape();
        if !is_number || shape.is_empty() || (shape.len() > 2 && !self.is_inside) {
            return Ok(None);
        }
        // MATLAB writes sizes in reverse order, and matrices in column-major order.
        let mut sizes: Vec<usize> = shape.iter().rev().map(|size| *size as usize).collect();
        if let [_] = sizes[..] {
            sizes.push(1);
        }
        let count = sizes
            .iter()
            .try_fold(1, |count: usize, size| count.checked_mul(*size));
        self.values = count
            .and_then(|count| self.values.checked_sub(count))
            .ok_or_else(|| FORM.too_much("values"))?;
        let bytes = dataset
            .read_native_bytes()
            .map_err(|error| FORM.broken(error))?;
        let numbers = match width {
            0 => numbers(kind, &bytes),
            width => {
                let parts = bytes.chunks_exact(width);
                let real = parts.flat_map(|both| both.iter().take(size_of::<f64>()));
                numbers(kind, &real.copied().collect::<Vec<u8>>())
            }
        };
        Ok(numbers.map(|numbers| (sizes, numbers)))
    }
}

fn is_f64(kind: &Datatype) -> bool {
    matches!(kind, Datatype::FloatingPoint { size: 8, .. })
}

/// The first of the values of a dataset.
fn one(values: Vec<Value>) -> Value {
    values.into_iter().next().unwrap_or(Value::Other)
}

/// Numbers of any of the types of HDF5, in this machine's byte order.
fn numbers(kind: &Datatype, bytes: &[u8]) -> Option<Vec<f64>> {
    macro_rules! all {
        ($type:ty, $convert:expr) => {{
            let chunks = bytes.chunks_exact(size_of::<$type>());
            let number =
                |chunk: &[u8]| Some($convert(<$type>::from_ne_bytes(chunk.try_into().ok()?)));
            chunks.map(number).collect()
        }};
    }
    match *kind {
        Datatype::FloatingPoint { size: 4, .. } => all!(f32, of_f32),
        Datatype::FloatingPoint { size: 8, .. } => all!(f64, |x| x),
        Datatype::FixedPoint { size, signed, .. } => match (size, signed) {
            (1, true) => all!(i8, f64::from),
            (1, false) => all!(u8, f64::from),
            (2, true) => all!(i16, f64::from),
            (2, false) => all!(u16, f64::from),
            (4, true) => all!(i32, f64::from),
            (4, false) => all!(u32, f64::from),
            (8, true) => all!(i64, |x| x as f64),
            (8, false) => all!(u64, |x| x as f64),
            _ => None,
        },
        _ => None,
    }
}
