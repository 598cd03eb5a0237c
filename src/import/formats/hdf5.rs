//! MATLAB's MAT file of version 7.3, which is HDF5: every dataset of numbers, by its path.
//!
//! Objects (timeseries, Dataset) have an undocumented form; they are named, with what to do. A struct is a group.

use ::hdf5_reader::group::Group;
use ::hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};

use super::super::table::{Table, of_f32};
use super::variables::{Variables, object};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Hdf5;
/// Groups within groups.
const MOST_DEPTH: usize = 8;
/// Groups and datasets that are looked at.
const MOST_OBJECTS: usize = 4096;
/// Largest piece of compressed data, in bytes.
const MOST_CHUNK_BYTES: usize = 1 << 27;

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let broken = |error: ::hdf5_reader::error::Error| FORM.broken(error);
    let options = OpenOptions::default()
        .with_max_read_bytes(MOST_VALUES * size_of::<f64>())
        .with_max_chunk_bytes(MOST_CHUNK_BYTES);
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(broken)?;
    let root = file.root_group().map_err(broken)?;
    let mut found = Found {
        variables: Variables::new(FORM),
        objects: 0,
        values: 0,
    };
    found.group(&root, "", 0)?;
    found.variables.table()
}

struct Found {
    variables: Variables,
    objects: usize,
    values: usize,
}

impl Found {
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), FormatError> {
        let (groups, datasets) = group.members().map_err(|error| FORM.broken(error))?;
        self.objects += groups.len() + datasets.len();
        if depth > MOST_DEPTH || self.objects > MOST_OBJECTS {
            return Err(FORM.broken("it has more groups and datasets than a log has"));
        }
        let inside = |name: &str| match path {
            "" => name.to_owned(),
            path => format!("{path}.{name}"),
        };
        for dataset in &datasets {
            self.dataset(dataset, &inside(dataset.name()))?;
        }
        // `#refs#` and `#subsystem#` hold what cells and objects are made of.
        for group in groups.iter().filter(|group| !group.name().starts_with('#')) {
            self.group(group, &inside(group.name()), depth + 1)?;
        }
        Ok(())
    }

    fn dataset(&mut self, dataset: &Dataset, name: &str) -> Result<(), FormatError> {
        let word = |attribute: &str| {
            let found = dataset.attribute(attribute).ok()?;
            found.read_string().ok()
        };
        if dataset.attribute("MATLAB_object_decode").is_ok() {
            let class = word("MATLAB_class").unwrap_or_default();
            self.variables.not_read.push(object(name, &class));
            return Ok(());
        }
        let is_number = matches!(
            dataset.dtype(),
            Datatype::FloatingPoint { .. } | Datatype::FixedPoint { .. }
        );
        if !is_number || word("MATLAB_class").as_deref() == Some("char") {
            return Ok(());
        }
        // MATLAB writes a matrix with its sizes the other way round, column by column.
        let (rows, columns) = match *dataset.shape() {
            [length] => (length, 1),
            [columns, rows] => (rows, columns),
            _ => return Ok(()),
        };
        let (rows, columns) = (rows as usize, columns as usize);
        self.values = rows
            .checked_mul(columns)
            .and_then(|count| count.checked_add(self.values))
            .filter(|count| *count <= MOST_VALUES)
            .ok_or_else(|| FORM.too_much("values"))?;
        let bytes = dataset
            .read_native_bytes()
            .map_err(|error| FORM.broken(error))?;
        if let Some(numbers) = numbers(dataset.dtype(), &bytes) {
            self.variables.push(name, rows, columns, numbers);
        }
        Ok(())
    }
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
