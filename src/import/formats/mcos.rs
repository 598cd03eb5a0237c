//! Objects of MATLAB's class system (MCOS) in MAT files: the cells of its `FileWrapper__`.
//!
//! Undocumented by MathWorks. Source: "Subsystem Data Format" of the Python package `mat-io`, checked against files
//! of MATLAB R2019a to R2025b. The first cell maps the properties of each object to cells; the last has the defaults.

use super::bytes::Bytes;
use super::workspace::Value;

/// First value of a reference to objects.
const REFERENCE: f64 = 0xDD00_0000_u32 as f64;
/// Known versions of the format.
const VERSIONS: std::ops::RangeInclusive<u32> = 2..=4;
/// Cells before the first property.
const BEFORE_PROPERTIES: usize = 2;
/// Bytes before the names: version, number of names, eight offsets of 32 bits.
const BEFORE_NAMES: usize = 40;
/// Kind of a property whose value is in a cell.
const IN_A_CELL: u32 = 1;

/// Name, kind and value of a property, as indices.
type Property = [u32; 3];

/// The objects of a file.
pub(super) struct Objects {
    cells: Vec<Value>,
    /// Names of properties, classes and packages; numbered from 1.
    names: Vec<String>,
    /// Package and name of every class; the first is unused.
    classes: Vec<[u32; 4]>,
    /// For every object: class, two unknown fields, properties with custom saving, properties, dependencies.
    objects: Vec<[u32; 6]>,
    by_own_saving: Vec<Vec<Property>>,
    properties: Vec<Vec<Property>>,
}

impl Objects {
    /// The objects described by the cells; `None` if they are inconsistent or of an unknown version.
    pub fn of(cells: Vec<Value>) -> Option<Self> {
        let Some(Value::Numbers(_, numbers)) = cells.first() else {
            return None;
        };
        let bytes: Vec<u8> = numbers.iter().map(|byte| *byte as u8).collect();
        let is_big_endian = !VERSIONS.contains(&Bytes(&bytes).u32_le()?);
        let words = |from: usize, to: usize| -> Option<Vec<u32>> {
            let word = |chunk: &[u8]| -> Option<u32> {
                let array = chunk.try_into().ok()?;
                Some(match is_big_endian {
                    true => u32::from_be_bytes(array),
                    false => u32::from_le_bytes(array),
                })
            };
            bytes.get(from..to)?.chunks_exact(4).map(word).collect()
        };
        let head = words(0, BEFORE_NAMES)?;
        if !VERSIONS.contains(&head[0]) {
            return None;
        }
        let offset = |region: usize| head[2 + region] as usize;
        let region = |at: usize| words(offset(at), offset(at + 1));
        let names = bytes.get(BEFORE_NAMES..offset(0))?;
        let names = names
            .split(|byte| *byte == 0)
            .map(|name| String::from_utf8_lossy(name).into_owned());
        Some(Self {
            names: names.collect(),
            classes: region(0)?.as_chunks().0.to_vec(),
            by_own_saving: blocks(&region(1)?)?,
            objects: region(2)?.as_chunks().0.to_vec(),
            properties: blocks(&region(3)?)?,
            cells,
        })
    }

    fn name(&self, number: u32) -> Option<&str> {
        let at = (number as usize).checked_sub(1)?;
        self.names.get(at).map(String::as_str)
    }

    fn object(&self, id: u32) -> Option<&[u32; 6]> {
        self.objects.get(id as usize).filter(|_| id > 0)
    }

    /// Name of an object's class with its package.
    pub fn class(&self, id: u32) -> Option<String> {
        let [class, ..] = self.object(id)?;
        let [package, name, ..] = self.classes.get(*class as usize)?;
        let name = self.name(*name)?;
        Some(match self.name(*package) {
            Some(package) => format!("{package}.{name}"),
            None => name.to_owned(),
        })
    }

    /// A property of an object: its value, or its class's default.
    pub fn property(&self, id: u32, name: &str) -> Option<&Value> {
        let [class, _, _, by_own_saving, properties, _] = *self.object(id)?;
        let block = match by_own_saving {
            0 => self.properties.get(properties as usize),
            at => self.by_own_saving.get(at as usize),
        };
        let own = block?
            .iter()
            .find(|[number, ..]| self.name(*number) == Some(name));
        if let Some([_, kind, cell]) = own {
            let cell = self.cells.get(BEFORE_PROPERTIES + *cell as usize);
            return cell.filter(|_| *kind == IN_A_CELL);
        }
        match self.cells.last()? {
            Value::Cells(defaults) => defaults.get(class as usize)?.field(name),
            _ => None,
        }
    }

    /// The same for the single object that a value refers to.
    pub fn property_of(&self, object: Option<&Value>, name: &str) -> Option<&Value> {
        self.property(object?.object()?, name)
    }
}

/// The properties of every object: their number, then name, kind and value of each, padded to eight bytes.
fn blocks(mut words: &[u32]) -> Option<Vec<Vec<Property>>> {
    let mut blocks = Vec::new();
    while let Some((&count, rest)) = words.split_first() {
        let length = (count as usize).checked_mul(3)?;
        let (block, rest) = rest.split_at_checked(length)?;
        blocks.push(block.as_chunks().0.to_vec());
        words = &rest[usize::from(length % 2 == 0).min(rest.len())..];
    }
    Some(blocks)
}

/// The objects that numbers refer to: the mark, number of sizes, the sizes, an identifier each, the class.
pub(super) fn reference(numbers: &[f64]) -> Option<Vec<u32>> {
    let (&mark, rest) = numbers.split_first()?;
    if mark != REFERENCE {
        return None;
    }
    let (&dimensions, rest) = rest.split_first()?;
    let (sizes, rest) = rest.split_at_checked(dimensions as usize)?;
    let count: f64 = sizes.iter().product();
    let ids = rest.get(..count as usize)?;
    Some(ids.iter().map(|id| *id as u32).collect())
}

/// Cells of objects made for tests.
#[cfg(test)]
pub(super) mod made {
    use super::super::workspace::Value;

    /// Package, class and properties.
    pub type Object<'a> = (&'a str, &'a str, Vec<(&'a str, Value)>);

    /// A reference to an object.
    pub fn reference_to(id: u32) -> Value {
        let numbers = [0xDD00_0000, 2, 1, 1, id, id].map(f64::from);
        Value::Numbers(vec![6, 1], numbers.to_vec())
    }

    /// The cells of these objects, numbered from 1. Each has its own class.
    pub fn cells(objects: Vec<Object>) -> Vec<Value> {
        let mut names: Vec<String> = Vec::new();
        let mut number = |name: &str| -> u32 {
            if name.is_empty() {
                return 0;
            }
            names.push(name.to_owned());
            names.len() as u32
        };
        let (mut classes, mut ids) = (vec![0; 4], vec![0; 6]);
        let (mut properties, mut values) = (vec![0, 0], Vec::new());
        for (at, (package, class, own)) in (1..).zip(objects) {
            classes.extend([number(package), number(class), 0, 0]);
            ids.extend([at, 0, 0, 0, at, 0]);
            properties.push(own.len() as u32);
            for (name, value) in own {
                properties.extend([number(name), 1, values.len() as u32]);
                values.push(value);
            }
            properties.resize(properties.len().next_multiple_of(2), 0);
        }
        let names = names.join("\0") + "\0";
        let regions = [classes, vec![0, 0], ids, properties];
        let mut offsets = vec![(super::BEFORE_NAMES + names.len()) as u32];
        for region in &regions {
            offsets.push(offsets[offsets.len() - 1] + 4 * region.len() as u32);
        }
        offsets.resize(8, offsets[4]);
        let words = |words: &[u32]| -> Vec<u8> {
            words.iter().flat_map(|word| word.to_le_bytes()).collect()
        };
        let mut bytes = words(&[4, 0]);
        bytes.extend(words(&offsets));
        bytes.extend(names.into_bytes());
        bytes.extend(words(&regions.concat()));
        let numbers: Vec<f64> = bytes.into_iter().map(f64::from).collect();
        let mut cells = vec![
            Value::Numbers(vec![numbers.len(), 1], numbers),
            Value::Other,
        ];
        cells.extend(values);
        cells.push(Value::Cells(Vec::new()));
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Vec<Value> {
        let shape = || Value::Text("round".to_owned());
        made::cells(vec![
            (
                "lab",
                "Wheel",
                vec![("shape", shape()), ("motor", made::reference_to(2))],
            ),
            ("", "Motor", vec![("shape", shape())]),
        ])
    }

    #[test]
    fn an_object_has_its_class_its_properties_and_its_defaults() {
        let mut cells = two();
        let default = Value::Structs(vec![("turns".to_owned(), vec![Value::Other])]);
        cells.pop();
        cells.push(Value::Cells(vec![Value::Other, default]));
        let objects = Objects::of(cells).expect("objects");
        assert_eq!(objects.class(1).as_deref(), Some("lab.Wheel"));
        assert_eq!(objects.class(2).as_deref(), Some("Motor"));
        let motor = objects.property(1, "motor");
        let shape = objects.property_of(motor, "shape");
        assert_eq!(shape.and_then(Value::text), Some("round"));
        assert!(matches!(objects.property(1, "turns"), Some(Value::Other)));
        assert!(objects.property(2, "turns").is_none());
        assert!(objects.property(3, "shape").is_none());
        assert!(objects.class(0).is_none());
    }

    #[test]
    fn contradictory_cells_cause_no_panic() {
        for at in 0..200 {
            for byte in [0, 1, 5, 127, 255] {
                let mut cells = two();
                if let Value::Numbers(_, numbers) = &mut cells[0] {
                    match byte {
                        1 => numbers.truncate(at),
                        byte => numbers
                            .iter_mut()
                            .skip(at)
                            .take(4)
                            .for_each(|x| *x = f64::from(byte)),
                    }
                }
                if let Some(objects) = Objects::of(cells) {
                    for id in [0, 1, 2, 3, u32::MAX] {
                        let _ = (objects.class(id), objects.property(id, "shape").is_some());
                    }
                }
            }
        }
    }

    #[test]
    fn a_reference_names_each_object_of_an_array() {
        let numbers = [0xDD00_0000_u32, 2, 1, 3, 7, 8, 9, 1].map(f64::from);
        assert_eq!(reference(&numbers), Some(vec![7, 8, 9]));
        assert_eq!(reference(&numbers[..6]), None);
        assert_eq!(reference(&[1.0, 2.0]), None);
    }
}
