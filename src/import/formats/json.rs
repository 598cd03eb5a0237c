//! JSON, and what Python prints of lists and dictionaries: an object a line, a list of objects or of rows, an object of columns, or
//! what pandas writes of a frame.
//!
//! Objects within objects become columns `a.b`, lists within them `a[0]`. A table further inside a document is not searched for: the
//! message names the command that makes a log of it.

use serde_json::Value;

use super::super::stamp::{before_line, stamp};
use super::super::table::{Table, TableColumn};
use super::pandas::{of_columns, of_pandas};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Json;
/// Objects within objects are followed so deep.
const MOST_DEPTH: usize = 8;
/// Most bytes of a name; a table keeps fewer. A longer key would be in the name of every value beneath it, and take memory
/// as the square of the file's size.
pub(super) const MOST_NAME: usize = 256;

/// Of what a terminal put before a line: the time in s.
const RECEIVED: &str = "received_s";

/// Whether a file begins as JSON, or as a list of rows that Python printed on one line.
pub(super) fn is_json(beginning: &[u8]) -> bool {
    let text = beginning.trim_ascii_start();
    let first_line = text.split(|byte| *byte == b'\n').next();
    if let Some((_, rest)) = first_line.and_then(before_line) {
        return rest.starts_with(b"{\"");
    }
    let mut marks = text.iter().filter(|byte| !byte.is_ascii_whitespace());
    let first = (marks.next(), marks.next());
    let row = || {
        text.split(|byte| matches!(byte, b']' | b')'))
            .next()
            .unwrap_or_default()
    };
    match first {
        (Some(b'{'), Some(b'"' | b'\'')) | (Some(b'['), Some(b'{')) => true,
        // A list of rows: NumPy prints its own without commas, and a row a line is text in columns.
        (Some(b'['), Some(b'[' | b'(')) => {
            let first_line = text.split(|byte| *byte == b'\n').next().unwrap_or_default();
            let rows = first_line
                .iter()
                .filter(|byte| matches!(byte, b']' | b')'))
                .count();
            row().contains(&b',') && rows > 1
        }
        _ => false,
    }
}

/// Columns that are being read: name and numbers, NaN in rows without one. Those of a name beyond the limit are passed over.
#[derive(Default)]
pub(super) struct Columns {
    rows: usize,
    columns: Vec<(String, Vec<f64>)>,
    values: usize,
}

impl Columns {
    pub fn put(&mut self, name: &str, number: f64) {
        if name.len() > MOST_NAME {
            return;
        }
        let column = match self.columns.iter().position(|(known, _)| known == name) {
            Some(at) => &mut self.columns[at].1,
            None => {
                self.columns.push((name.to_owned(), Vec::new()));
                let last = self.columns.len() - 1;
                &mut self.columns[last].1
            }
        };
        column.resize(self.rows, f64::NAN);
        column.push(number);
        self.values += 1;
    }

    /// Everything of a row that is a number; whether there was any.
    pub fn put_value(&mut self, name: &str, value: &Value, depth: usize) -> bool {
        if name.len() > MOST_NAME {
            return false;
        }
        let before = self.values;
        let below = |key: &str| match name.is_empty() {
            true => key.to_owned(),
            false => format!("{name}.{key}"),
        };
        match value {
            Value::Object(map) if depth < MOST_DEPTH => {
                for (key, value) in map {
                    self.put_value(&below(key), value, depth + 1);
                }
            }
            Value::Array(values) if depth < MOST_DEPTH => {
                for (at, value) in values.iter().enumerate() {
                    let name = match name.is_empty() {
                        true => (at + 1).to_string(),
                        false => format!("{name}[{at}]"),
                    };
                    self.put_value(&name, value, depth + 1);
                }
            }
            _ => {
                if let Some(number) = number(value) {
                    self.put(name, number);
                }
            }
        }
        self.values > before
    }

    /// Ends a row, unless there would be more values than a table has, empty ones included.
    pub fn end_row(&mut self, form: Form) -> Result<(), FormatError> {
        self.rows += 1;
        match self.rows.saturating_mul(self.columns.len()) > MOST_VALUES {
            true => Err(form.too_much("values")),
            false => Ok(()),
        }
    }

    pub fn row(&mut self, value: &Value) -> Result<(), FormatError> {
        self.put_value("", value, 0);
        self.end_row(FORM)
    }

    pub fn table(mut self) -> Table {
        for (_, column) in &mut self.columns {
            column.resize(self.rows, f64::NAN);
        }
        let column = |(name, numbers)| (TableColumn { name, unit: None }, numbers);
        Table::whole(self.columns.into_iter().map(column).collect())
    }
}

/// A number, a truth value, or a time stamp in seconds.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => number.as_f64(),
        Value::Bool(is) => Some(f64::from(u8::from(*is))),
        Value::String(text) => {
            let stamped = || stamp(text.as_bytes()).map(|stamp| stamp.s);
            (text.trim().parse().ok())
                .filter(|x: &f64| x.is_finite())
                .or_else(stamped)
        }
        _ => None,
    }
}

/// Names before a number in brackets, as Python prints it.
const TYPES: [&str; 4] = ["np.", "numpy.", "Decimal", "array"];
/// Characters of such a name.
const LONGEST_TYPE: usize = 40;

/// `np.float64(0.5)` is 0.5, and `array([1, 2])` is a list.
fn without_types(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    // Of each bracket that is open, whether it follows the name of a type.
    let mut open: Vec<bool> = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let name = TYPES
            .iter()
            .find(|name| rest.starts_with(**name))
            .and_then(|_| {
                let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_');
                let mut letters = rest.char_indices().take(LONGEST_TYPE);
                letters
                    .find(|(_, c)| !is_name(*c))
                    .filter(|(_, c)| *c == '(')
            });
        if let Some((end, _)) = name {
            open.push(true);
            rest = &rest[end + 1..];
            continue;
        }
        let is_of_type = match first {
            '(' => {
                open.push(false);
                false
            }
            ')' => open.pop().unwrap_or(false),
            _ => false,
        };
        if !is_of_type {
            plain.push(first);
        }
        rest = &rest[first.len_utf8()..];
        // NumPy prints 5.0 as `5.`.
        let is_number = plain
            .as_bytes()
            .iter()
            .rev()
            .nth(1)
            .is_some_and(u8::is_ascii_digit);
        if first == '.' && is_number && !rest.starts_with(|c: char| c.is_alphanumeric()) {
            plain.push('0');
        }
    }
    plain
}

/// JSON, or else what Python prints: single quotes, tuples, `None`.
fn parse(text: &str) -> Option<Value> {
    serde_json::from_str(text).ok().or_else(|| {
        let text = without_types(text);
        let json = (text.replace('\'', "\"").replace('(', "[").replace(')', "]"))
            .replace("None", "null")
            .replace("NaN", "null")
            .replace("nan", "null")
            .replace("True", "true")
            .replace("False", "false");
        serde_json::from_str(&json).ok()
    })
}

/// Reads a document, or an object a line.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = std::str::from_utf8(bytes).map_err(|error| FORM.broken(error))?;
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let is_of_lines = lines.next().is_some_and(|line| {
        matches!(parse(as_sent(line).1), Some(Value::Object(_))) && lines.next().is_some()
    });
    if is_of_lines {
        return of_lines(text);
    }
    match parse(text).ok_or_else(|| FORM.broken(why_broken(text)))? {
        Value::Array(rows) if rows.iter().all(|row| row.is_object() || row.is_array()) => {
            let mut columns = Columns::default();
            rows.iter().try_for_each(|row| columns.row(row))?;
            Ok(columns.table())
        }
        Value::Object(map) => of_pandas(&map)?.or_else(|| of_columns(&map)).ok_or(NESTED),
        _ => Err(NESTED),
    }
}

fn why_broken(text: &str) -> String {
    match serde_json::from_str::<Value>(text) {
        Err(error) => error.to_string(),
        Ok(_) => String::new(),
    }
}

const NESTED: FormatError = FormatError::NotRead {
    what: "nested JSON",
    remedy: "name the list of rows in it as KEY: python3 -c \"import json, pandas; \
             pandas.json_normalize(json.load(open('FILE'))['KEY']).to_csv('log.csv', index=False)\"",
};

/// A line as the board sent it, and the time in s that a terminal put before it.
fn as_sent(line: &str) -> (Option<f64>, &str) {
    let found = before_line(line.as_bytes()).and_then(|(stamped, rest)| {
        let sent = line.get(line.len() - rest.len()..)?;
        Some((stamp(stamped)?.s, sent))
    });
    found.map_or((None, line), |(s, sent)| (Some(s), sent))
}

/// An object a line; other lines are messages, and the last may be cut off.
fn of_lines(text: &str) -> Result<Table, FormatError> {
    let mut columns = Columns::default();
    let mut others = 0_usize;
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (received_s, sent) = as_sent(line);
        match parse(sent) {
            Some(value @ Value::Object(_)) => {
                if let Some(received_s) = received_s {
                    columns.put(RECEIVED, received_s);
                }
                columns.row(&value)?;
            }
            _ => others += 1,
        }
    }
    let mut table = columns.table();
    if others > 0 {
        table.notes.push(format!(
            "{others} lines are no JSON objects, and are left out"
        ));
    }
    Ok(table)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::io::Read as _;

    /// The table of a text of JSON, as text.
    pub(in crate::import::formats) fn text(json: &str) -> String {
        assert!(is_json(json.as_bytes()), "{json}");
        let table = read(json.as_bytes()).unwrap_or_else(|error| panic!("{json}: {error}"));
        let mut text = String::new();
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn tables_of_every_kind_are_read() {
        let rows = "\"t\",\"u\"\n0,5\n10,6\n20,7\n";
        for json in [
            "{\"t\": 0, \"u\": 5}\n{\"t\": 10, \"u\": 6}\n{\"t\": 20, \"u\": 7}\n",
            "{'t': 0, 'u': 5}\n{'t': 10, 'u': 6}\n{'t': 20, 'u': 7}\n",
            "{'t': 0, 'u': np.float64(5.0)}\n{'t': 10, 'u': np.int64(6)}\n{'t': 20, 'u': Decimal('7')}\n",
            "{'t': array([0, 10, 20]), 'u': np.array([5., 6., 7.0])}",
            "[{\"t\": 0, \"u\": 5}, {\"t\": 10, \"u\": 6},\n {\"t\": 20, \"u\": \"7\"}]",
            "{\"t\": [0, 10, 20], \"u\": [5, 6, 7]}",
            "{\"t\": {\"0\": 0, \"1\": 10, \"2\": 20}, \"u\": {\"0\": 5, \"1\": 6, \"2\": 7}}",
        ] {
            assert_eq!(text(json), rows, "{json}");
        }
        for json in ["[[0, 5], [10, 6], [20, 7]]", "[(0, 5), (10, 6), (20, 7)]"] {
            assert_eq!(text(json), "\"1\",\"2\"\n0,5\n10,6\n20,7\n", "{json}");
        }
        let stamped = "12:00:00.5 -> {\"u\": 5}\n12:00:00.6 -> boot\n12:00:00.7 -> {\"u\": 6}\n";
        assert_eq!(
            text(stamped),
            "\"received_s\",\"u\"\n43200.5,5\n43200.7,6\n"
        );
        let nested = "{\"t\": 0, \"m\": {\"u\": [1, 2]}}\n{\"t\": 1}\nboot\n";
        assert_eq!(text(nested), "\"m.u[0]\",\"m.u[1]\",\"t\"\n1,2,0\n,,1\n");
    }

    #[test]
    fn what_is_beneath_a_longer_name_than_the_most_is_passed_over() {
        let json = |key: usize| {
            let key = "k".repeat(key);
            format!("{{\"{key}\": [1, {{\"a\": 2}}], \"t\": 0}}\n{{\"t\": 1}}\n")
        };
        assert!(text(&json(MOST_NAME - 3)).ends_with("\n1,0\n,1\n"));
        assert_eq!(text(&json(MOST_NAME + 1)), "\"t\"\n0\n1\n");
    }

    #[test]
    fn a_document_that_holds_a_table_somewhere_is_told_how_to_be_converted() {
        let nested = b"{\"meta\": {\"rig\": 1}, \"data\": [{\"t\": 0}, {\"t\": 1}]}";
        let error = read(nested).expect_err("nested").to_string();
        assert!(error.contains("json_normalize"), "{error}");
        let broken = read(b"{\"t\": [0, 1").expect_err("broken").to_string();
        assert!(broken.contains("EOF"), "{broken}");
        assert!(!is_json(b"[0, 1, 2]\n[3, 4, 5]\n") && !is_json(b"[[0. 1.]\n [2. 3.]]"));
    }
}
