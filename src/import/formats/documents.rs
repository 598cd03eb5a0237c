//! Consecutive documents: the YAML of `ros2 topic echo` and `rostopic echo`, and rows of `key: value` lines separated
//! by a blank line or `---`.
//!
//! Nested keys become columns `a.b`, lists `a[0]`, as in JSON. Words are left out.

use serde_json::Value;

use super::super::table::Table;
use super::json::{Columns, MOST_NAME};
use super::{Form, FormatError};

const FORM: Form = Form::Documents;
/// Fewest documents of this format.
const LEAST_DOCUMENTS: usize = 2;
/// Least share of lines of this format: the others are messages.
const OF_THE_FORM: f64 = 0.9;
/// Deepest nesting of lists and maps within one line.
const MOST_DEPTH: usize = 8;
/// The lists of a joint state of ROS 2, the first two in rad and rad/s.
const JOINT_STATE: [(&str, Option<&str>); 3] = [
    ("position[", Some("rad")),
    ("velocity[", Some("rad/s")),
    ("effort[", None),
];

enum Line<'a> {
    Between,
    /// Indentation, key, and the text after it.
    Key(usize, &'a str, &'a str),
    /// Indentation, and the text after the dash.
    Item(usize, &'a str),
    Other,
}

impl<'a> Line<'a> {
    fn of(line: &'a str) -> Self {
        let line = line.trim_end();
        let text = line.trim_start();
        let indent = line.len() - text.len();
        if text.is_empty() || matches!(text, "---" | "...") {
            return Self::Between;
        }
        if let Some(item) = text.strip_prefix("- ") {
            return Self::Item(indent, item.trim_start());
        }
        match text.split_once(':') {
            Some((key, value))
                if is_key(key) && (value.is_empty() || value.starts_with([' ', '\t'])) =>
            {
                Self::Key(indent, key, value.trim())
            }
            _ => Self::Other,
        }
    }
}

fn is_key(key: &str) -> bool {
    let is_of_words = |c: char| {
        c.is_alphanumeric()
            || matches!(
                c,
                '_' | ' ' | '.' | '/' | '-' | '(' | ')' | '[' | ']' | '%' | '°'
            )
    };
    key.starts_with(|c: char| c.is_alphabetic() || c == '_') && key.chars().all(is_of_words)
}

/// Whether a text has this format with numbers.
pub(super) fn is_documents(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    // The last line may be incomplete.
    let text = text.rsplit_once('\n').map_or("", |(lines, _)| lines);
    let (mut lines, mut fitting) = (0.0, 0.0);
    let (mut documents, mut in_this, mut numbers) = (0, 0, 0);
    for line in text.lines() {
        let of = Line::of(line);
        if matches!(of, Line::Between) {
            // One line per row is text in columns.
            if in_this > 1 && numbers > 0 {
                documents += 1;
            }
            (in_this, numbers) = (0, 0);
            continue;
        }
        lines += 1.0;
        match of {
            Line::Key(_, _, value) | Line::Item(_, value) => {
                fitting += 1.0;
                in_this += 1;
                numbers += usize::from(holds_number(&flow(value)));
            }
            _ => {}
        }
    }
    documents += usize::from(in_this > 1 && numbers > 0);
    documents >= LEAST_DOCUMENTS && fitting >= OF_THE_FORM * lines
}

fn holds_number(value: &Value) -> bool {
    match value {
        Value::Number(_) => true,
        Value::Array(values) => values.iter().any(holds_number),
        Value::Object(map) => map.values().any(holds_number),
        _ => false,
    }
}

/// A key or an item with nested lines.
struct Under {
    indent: usize,
    name: String,
    is_item: bool,
    items: usize,
}

impl Under {
    /// A name beyond the limit is cut, still beyond it: what is beneath is passed over.
    fn of(indent: usize, name: &str, is_item: bool) -> Self {
        Self {
            indent,
            name: name.chars().take(MOST_NAME + 1).collect(),
            is_item,
            items: 0,
        }
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let mut columns = Columns::default();
    let mut under: Vec<Under> = Vec::new();
    let mut is_open = false;
    for line in text.lines() {
        let (indent, key, value) = match Line::of(line) {
            Line::Other => continue,
            Line::Between => {
                if is_open {
                    columns.end_row(FORM)?;
                }
                is_open = false;
                under.clear();
                continue;
            }
            Line::Item(indent, rest) => {
                while under
                    .last()
                    .is_some_and(|top| top.indent > indent || (top.indent == indent && top.is_item))
                {
                    under.pop();
                }
                let Some(list) = under.last_mut() else {
                    continue;
                };
                let name = format!("{}[{}]", list.name, list.items);
                list.items += 1;
                match Line::of(rest) {
                    Line::Key(_, key, value) => {
                        under.push(Under::of(indent, &name, true));
                        (indent + 2, key, value)
                    }
                    _ => {
                        is_open |= columns.put_value(&name, &flow(rest), 0);
                        continue;
                    }
                }
            }
            Line::Key(indent, key, value) => (indent, key, value),
        };
        while under.last().is_some_and(|top| top.indent >= indent) {
            under.pop();
        }
        let name = match under.last() {
            Some(top) => format!("{}.{key}", top.name),
            None => key.to_owned(),
        };
        match value {
            "" => under.push(Under::of(indent, &name, false)),
            value => is_open |= columns.put_value(&name, &flow(value), 0),
        }
    }
    if is_open {
        columns.end_row(FORM)?;
    }
    let mut table = columns.table();
    let has = |list: &str| {
        table
            .columns
            .iter()
            .any(|column| column.name.starts_with(list))
    };
    if JOINT_STATE.iter().all(|(list, _)| has(list)) {
        for column in &mut table.columns {
            let of = JOINT_STATE
                .iter()
                .find(|(list, _)| column.name.starts_with(list));
            column.unit = of.and_then(|(_, unit)| *unit).map(str::to_owned);
        }
    }
    Ok(table)
}

/// A value on one line: a number, a truth value, a time stamp as text, `[1, 2]`, `{x: 1}`; the text itself for words.
fn flow(text: &str) -> Value {
    let mut rest = text;
    match flow_value(&mut rest, 0) {
        Some(value) if rest.trim().is_empty() || rest.trim_start().starts_with('#') => value,
        // `12:34:56.5` and the like.
        _ => Value::String(text.trim().to_owned()),
    }
}

/// The value at the beginning, which is removed; `None` where a bracket is not closed by its own.
fn flow_value(rest: &mut &str, depth: usize) -> Option<Value> {
    *rest = rest.trim_start();
    let ends = |rest: &mut &str, end: char| match rest.trim_start().strip_prefix(end) {
        Some(after) => {
            *rest = after;
            true
        }
        None => rest.trim_start().is_empty(),
    };
    // The next value would begin at the bracket of another list, and be empty for ever.
    let goes_on = |rest: &mut &str, end: char| {
        *rest = rest.trim_start();
        match rest.strip_prefix(',') {
            Some(after) => {
                *rest = after;
                true
            }
            None => rest.starts_with(end) || !rest.starts_with([']', '}']),
        }
    };
    if depth > MOST_DEPTH {
        *rest = "";
        return Some(Value::Null);
    }
    if let Some(after) = rest.strip_prefix('[') {
        *rest = after;
        let mut values = Vec::new();
        while !ends(rest, ']') {
            values.push(flow_value(rest, depth + 1)?);
            if !goes_on(rest, ']') {
                return None;
            }
        }
        return Some(Value::Array(values));
    }
    if let Some(after) = rest.strip_prefix('{') {
        *rest = after;
        let mut map = serde_json::Map::new();
        while !ends(rest, '}') {
            let Some((key, after)) = rest.split_once(':') else {
                *rest = "";
                break;
            };
            let key = key.trim().trim_matches(['"', '\'']).to_owned();
            *rest = after;
            map.insert(key, flow_value(rest, depth + 1)?);
            if !goes_on(rest, '}') {
                return None;
            }
        }
        return Some(Value::Object(map));
    }
    let end = match depth {
        0 => rest.len(),
        _ => rest.find([',', ']', '}']).unwrap_or(rest.len()),
    };
    let (word, after) = rest.split_at(end);
    *rest = after;
    Some(scalar(word.split(" #").next().unwrap_or(word).trim()))
}

fn scalar(word: &str) -> Value {
    let word = word.trim_matches(['"', '\'']);
    match word {
        "true" | "True" => Value::Bool(true),
        "false" | "False" => Value::Bool(false),
        word => match word
            .parse::<f64>()
            .ok()
            .and_then(serde_json::Number::from_f64)
        {
            Some(number) => Value::Number(number),
            // `3.1 V`: a number and its unit.
            None => Value::String(word.to_owned()),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn text(log: &str) -> String {
        assert!(is_documents(log.as_bytes()), "{log}");
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn documents_of_topic_echo_are_rows() {
        let block = |s: u32, ns: u32, x: f64| {
            format!(
                "header:\n  stamp:\n    sec: {s}\n    nanosec: {ns}\n  frame_id: ''\nname:\n- wheel\nposition:\n- {x}\nvelocity:\n- 0.0\neffort:\n- 6.0\n---\n"
            )
        };
        let names = "\"header.stamp.sec\",\"header.stamp.nanosec\",\"position[0]\",\"velocity[0]\",\"effort[0]\"\n";
        let log = block(7, 0, 0.5) + &block(7, 10_000_000, 0.75);
        assert_eq!(
            text(&log),
            format!("{names}7,0,0.5,0,6\n7,10000000,0.75,0,6\n")
        );
        let flowing = log
            .replace("position:\n- ", "position: [")
            .replace("\nvelocity:\n- ", "]\nvelocity: [")
            .replace("\neffort:\n- ", "]\neffort: [")
            .replace("6.0\n", "6.0]\n");
        assert_eq!(text(&flowing), text(&log));
        let units: Vec<_> = read(log.as_bytes())
            .expect("a table")
            .columns
            .into_iter()
            .map(|column| column.unit)
            .collect();
        assert_eq!(
            units[2..],
            [Some("rad".to_owned()), Some("rad/s".to_owned()), None]
        );
    }

    #[test]
    fn maps_within_lists_and_on_one_line_are_read() {
        let log = "t: 1\nmotors:\n- id: 3\n  pos: 5\n- id: 4\n  pos: 6\nextra: {u: 2, list: [1, 2]}\n---\nt: 2\nmotors:\n- id: 3\n  pos: 7\n---\n";
        assert_eq!(
            text(log),
            "\"t\",\"motors[0].id\",\"motors[0].pos\",\"motors[1].id\",\"motors[1].pos\",\"extra.list[0]\",\"extra.list[1]\",\"extra.u\"\n\
             1,3,5,4,6,1,2,2\n2,3,7,,,,,\n"
        );
    }

    #[test]
    fn a_bracket_that_another_closes_is_text() {
        for broken in ["[2, 3_}", "{x: 1, y: [2, 3_}", "[{x: 1]", "{x: 1]", "[2}"] {
            let log = format!("t: 1\npos: {broken}\n---\nt: 2\npos: 5\n---\n");
            assert_eq!(text(&log), "\"t\",\"pos\"\n1,\n2,5\n", "{broken}");
        }
        // A list that continues in the next line.
        let log = "t: 1\npos: [5, 6,\n---\nt: 2\npos: [7, 8\n---\n";
        assert_eq!(text(log), "\"t\",\"pos[0]\",\"pos[1]\"\n1,5,6\n2,7,8\n");
    }

    #[test]
    fn what_is_beneath_a_longer_name_than_the_most_is_passed_over() {
        let key = "k".repeat(MOST_NAME);
        let log = format!("t: 1\n{key}:\n  a:\n  - 5\n  - b: 6\nu: 2\n---\nt: 2\nu: 3\n---\n");
        assert_eq!(text(&log), "\"t\",\"u\"\n1,2\n2,3\n");
    }

    #[test]
    fn only_rows_of_several_lines_are_documents() {
        let rows = "Position: 10\nSpeed: 5\n\nPosition: 11\nSpeed: 6\n\n";
        assert_eq!(text(rows), "\"Position\",\"Speed\"\n10,5\n11,6\n");
        for none in [
            "pos: 1 pwm: 2\n\npos: 2 pwm: 3\n\n",
            "a: b\nc: d\n---\na: b\nc: d\n---\n",
            "t,n\n---\n1,2\n2,3\n---\n",
            "Motor: 1\nSupply: 12\n\nDate: 3\nName: 4\n\nt,n\n0,1\n1,2\n2,3\n3,4\n",
            "",
        ] {
            assert!(!is_documents(none.as_bytes()), "{none}");
        }
    }
}
