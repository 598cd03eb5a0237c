//! WPILib's data log (WPILOG 1.0): a header, then records of an entry's number, a time in us and a value; entry 0
//! defines the others.
//!
//! Format: "WPILib Data Log File Format Specification, Version 1.0", wpiutil/doc/datalog.adoc of wpilibsuite/allwpilib.

use std::collections::HashMap;

use super::super::table::{Table, of_f32};
use super::bytes::Bytes;
use super::signals::Signals;
use super::{Form, FormatError};

const FORM: Form = Form::WpiLog;
/// Most elements of an array that become separate signals.
const MOST_ELEMENTS: usize = 64;

/// Format of an entry's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Double,
    Float,
    Whole,
    Switch,
}

impl Kind {
    /// From the name of the type, and whether it is an array.
    fn of(name: &str) -> Option<(Self, bool)> {
        let (name, is_array) = match name.strip_suffix("[]") {
            Some(name) => (name, true),
            None => (name, false),
        };
        let kind = match name {
            "double" => Self::Double,
            "float" => Self::Float,
            "int64" => Self::Whole,
            "boolean" => Self::Switch,
            _ => return None,
        };
        Some((kind, is_array))
    }

    fn value(self, bytes: &mut Bytes) -> Option<f64> {
        Some(match self {
            Self::Double => f64::from_le_bytes(bytes.array()?),
            Self::Float => of_f32(f32::from_le_bytes(bytes.array()?)),
            Self::Whole => i64::from_le_bytes(bytes.array()?) as f64,
            Self::Switch => f64::from(bytes.u8()? != 0),
        })
    }
}

/// An entry that has been started.
struct Entry {
    name: String,
    unit: Option<String>,
    kind: Kind,
    is_array: bool,
    /// Its signals so far.
    signals: Vec<u16>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let mut rest = Bytes(bytes);
    header(&mut rest).ok_or_else(|| FORM.broken("its header is cut off"))?;
    let mut entries: HashMap<u64, Entry> = HashMap::new();
    let mut signals = Signals::new(FORM);
    while !rest.is_empty() {
        let Some((entry, time_us, mut payload)) = record(&mut rest) else {
            signals
                .notes
                .push("it ends within a record, and is read up to there".to_owned());
            break;
        };
        if entry == 0 {
            control(&mut payload, &mut entries);
        } else if let Some(entry) = entries.get_mut(&entry) {
            // 64 bits of us are 64 bits of ns for 292 years.
            let time_ns = i64::try_from(time_us)
                .ok()
                .and_then(|us| us.checked_mul(1000));
            if let Some(time_ns) = time_ns {
                values(entry, time_ns, payload, &mut signals)?;
            }
        }
    }
    if signals.is_empty() {
        return Err(FORM.nothing("none of its entries holds double, float, int64 or boolean"));
    }
    Ok(signals.table())
}

fn header(rest: &mut Bytes) -> Option<()> {
    rest.take(8)?;
    let extra = rest.u32_le()?;
    rest.take(extra as usize).map(|_| ())
}

/// Entry, time and payload of the next record.
fn record<'a>(rest: &mut Bytes<'a>) -> Option<(u64, u64, Bytes<'a>)> {
    let lengths = rest.u8()?;
    let entry = rest.uint_le(usize::from(lengths & 3) + 1)?;
    let size = rest.uint_le(usize::from(lengths >> 2 & 3) + 1)?;
    let time_us = rest.uint_le(usize::from(lengths >> 4 & 7) + 1)?;
    let payload = rest.take(usize::try_from(size).ok()?)?;
    Some((entry, time_us, Bytes(payload)))
}

/// Contents of entry 0: an entry starts (0) or ends (1). Later metadata (2) change no value.
fn control(payload: &mut Bytes, entries: &mut HashMap<u64, Entry>) -> Option<()> {
    match payload.u8()? {
        0 => {
            let entry = u64::from(payload.u32_le()?);
            let name = payload.text()?;
            let kind = Kind::of(&payload.text()?);
            let metadata = payload.text()?;
            entries.remove(&entry);
            let (kind, is_array) = kind?;
            let unit = serde_json::from_str::<serde_json::Value>(&metadata)
                .ok()
                .and_then(|value| Some(value.get("unit")?.as_str()?.to_owned()));
            entries.insert(
                entry,
                Entry {
                    name,
                    unit,
                    kind,
                    is_array,
                    signals: Vec::new(),
                },
            );
        }
        1 => {
            entries.remove(&u64::from(payload.u32_le()?));
        }
        _ => {}
    }
    Some(())
}

fn values(
    entry: &mut Entry,
    time_ns: i64,
    mut payload: Bytes,
    signals: &mut Signals,
) -> Result<(), FormatError> {
    let count = if entry.is_array { MOST_ELEMENTS } else { 1 };
    for at in 0..count {
        let Some(value) = entry.kind.value(&mut payload) else {
            break;
        };
        if at == entry.signals.len() {
            let name = match entry.is_array {
                true => format!("{}[{at}]", entry.name),
                false => entry.name.clone(),
            };
            entry
                .signals
                .push(signals.signal(&name, entry.unit.as_deref())?);
        }
        signals.push(time_ns, entry.signals[at], value)?;
    }
    Ok(())
}
