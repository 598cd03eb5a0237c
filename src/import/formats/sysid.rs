//! The JSON of WPILib's SysId up to 2023: four tests, each a list of rows.
//!
//! A row of a mechanism is time in s, voltage, position in rotations and velocity in rotations per second; of a drivetrain time,
//! the two voltages, the two positions, the two velocities, the heading and its rate.

use serde_json::Value;

use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::SysId;
/// Largest file in bytes: an hour of tests at 200 Hz. A document takes some sixteen times as much memory.
const MOST_BYTES: usize = 1 << 25;
/// Names of the tests in SysId and its predecessors.
const TESTS: [&str; 8] = [
    "slow-forward",
    "slow-backward",
    "fast-forward",
    "fast-backward",
    "quasistatic-forward",
    "quasistatic-reverse",
    "dynamic-forward",
    "dynamic-reverse",
];
const MECHANISM: [(&str, &str); 4] = [
    ("time", "s"),
    ("voltage", "V"),
    ("position", "rev"),
    ("velocity", "rev/s"),
];
const DRIVETRAIN: [(&str, &str); 9] = [
    ("time", "s"),
    ("left_voltage", "V"),
    ("right_voltage", "V"),
    ("left_position", "rev"),
    ("right_position", "rev"),
    ("left_velocity", "rev/s"),
    ("right_velocity", "rev/s"),
    ("heading", ""),
    ("heading_rate", ""),
];

/// Whether a file has this format.
pub(super) fn is_sysid(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let has = |key: &str| text.contains(&format!("\"{key}\""));
    text.trim_start().starts_with('{') && (has("sysid") || TESTS.into_iter().any(has))
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    if bytes.len() > MOST_BYTES {
        return Err(FORM.broken(format!("it is longer than {MOST_BYTES} bytes")));
    }
    let document: Value = serde_json::from_slice(bytes).map_err(|error| FORM.broken(error))?;
    let mut names: Option<&[(&str, &str)]> = None;
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut tests = Vec::new();
    for test in TESTS {
        let Some(rows) = document.get(test) else {
            continue;
        };
        let rows = rows
            .as_array()
            .ok_or_else(|| FORM.broken(format!("`{test}` is no list of rows")))?;
        for (at, row) in rows.iter().enumerate() {
            let numbers: Option<Vec<f64>> = row
                .as_array()
                .and_then(|row| row.iter().map(Value::as_f64).collect());
            let wrong = || {
                FORM.broken(format!(
                    "row {} of `{test}` is no list of 4 or 9 numbers",
                    at + 1
                ))
            };
            let numbers = numbers.ok_or_else(wrong)?;
            let expected = match (names, numbers.len()) {
                (Some(names), _) => names,
                (None, 4) => &MECHANISM,
                (None, 9) => &DRIVETRAIN,
                (None, _) => return Err(wrong()),
            };
            if numbers.len() != expected.len() {
                return Err(wrong());
            }
            names = Some(expected);
            columns.resize(expected.len(), Vec::new());
            for (column, number) in columns.iter_mut().zip(numbers) {
                column.push(number);
            }
            tests.push(test.to_owned());
            if tests.len() * expected.len() > MOST_VALUES {
                return Err(FORM.too_much("values"));
            }
        }
    }
    let names = names.ok_or_else(|| FORM.nothing("its tests are empty"))?;
    let named = names.iter().zip(columns).map(|((name, unit), numbers)| {
        let unit = (!unit.is_empty()).then(|| (*unit).to_owned());
        let name = (*name).to_owned();
        (TableColumn { name, unit }, numbers)
    });
    Ok(Table::whole(named.collect()).in_runs("test", tests))
}
