//! Tables whose cells are more than a number: lists, `[0.1]` and `"(0.1, 0.2)"`, of ROS messages in pandas and bagpy;
//! numbers with units, `5.00 V`; hexadecimal, `0x1F`.
//!
//! A list becomes columns `name[0]`; the unit of the first row is the column's. A cell with another unit is no
//! number.

use super::super::cells::{Cells, Separator, decode, number};
use super::super::stamp::stamp;
use super::super::table::Table;
use super::super::unmapped::is_known;
use super::json::Columns;
use super::{Form, FormatError};

const FORM: Form = Form::Wordy;
/// Most lines above the names.
const BANNER_LINES: usize = 40;
/// Consecutive equal rows that make a table.
const ALIKE: usize = 3;
/// Most numbers of a list: a wrench, a quaternion, the joints of a robot.
const MOST_OF_A_LIST: usize = 64;

#[derive(Debug, Clone, PartialEq)]
enum Held {
    Nothing,
    Number(f64),
    List(Vec<f64>),
    /// A number with its unit.
    Unit(f64, String),
    Hex(f64),
    Words,
}

impl Held {
    fn of(cell: &[u8], is_comma: bool) -> Self {
        let cell = cell.trim_ascii();
        if cell.is_empty() {
            return Self::Nothing;
        }
        if let Ok(number) = number(cell, is_comma, "") {
            return Self::Number(number);
        }
        if let Some(stamp) = stamp(cell) {
            return Self::Number(stamp.s);
        }
        let text = decode(cell);
        if let Some(hex) = hex(&text) {
            return Self::Hex(hex);
        }
        if let Some(list) = list(&text) {
            return Self::List(list);
        }
        let digits = text
            .rfind(|c: char| c.is_ascii_digit())
            .map(|at| text.split_at(at + 1));
        match digits {
            Some((digits, unit)) if is_known(unit.trim()) => {
                match number(digits.trim().as_bytes(), is_comma, "") {
                    Ok(number) => Self::Unit(number, unit.trim().to_owned()),
                    Err(_) => Self::Words,
                }
            }
            _ => Self::Words,
        }
    }

    /// Whether both are of one kind; an empty cell is of any.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Nothing, _) | (_, Self::Nothing) => true,
            (Self::List(a), Self::List(b)) => a.len() == b.len(),
            (Self::Unit(_, a), Self::Unit(_, b)) => a == b,
            (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
        }
    }

    fn is_more_than_a_number(&self) -> bool {
        matches!(self, Self::List(_) | Self::Unit(..) | Self::Hex(_))
    }
}

/// `0x1F`, in two's complement of 32 bits.
fn hex(text: &str) -> Option<f64> {
    let digits = text.strip_prefix("0x").or(text.strip_prefix("0X"))?;
    let number = u64::from_str_radix(digits, 16).ok()?;
    Some(match (digits.len(), number) {
        (8, number) => f64::from(number as u32 as i32),
        (_, number) => number as f64,
    })
}

/// `[0.1, 0.2]`, `(0.1,)`, `array('d', [0.1])`.
fn list(text: &str) -> Option<Vec<f64>> {
    let is_list = text.starts_with(['[', '(']) || text.starts_with("array(");
    let text = text
        .strip_prefix("array(")
        .map_or(text, |rest| match rest.find('[') {
            Some(at) => &rest[at..],
            None => rest,
        });
    let inside = text.trim_matches(|c| matches!(c, '[' | ']' | '(' | ')' | ' '));
    let parts = inside
        .split([',', ' ', ';'])
        .map(str::trim)
        .filter(|part| !part.is_empty());
    let numbers: Option<Vec<f64>> = parts
        .map(|part| part.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    numbers.filter(|numbers| is_list && !numbers.is_empty() && numbers.len() <= MOST_OF_A_LIST)
}

/// Names, and the format of the rows below.
struct Layout {
    separator: Separator,
    /// Number of lines up to the names.
    lines: usize,
    names: Vec<String>,
    kinds: Vec<Held>,
}

fn row(line: &str, separator: Separator) -> Vec<Held> {
    let mut cells = Cells::default();
    cells.split(line.as_bytes(), separator);
    let is_comma = separator != Separator::Byte(b',');
    (0..cells.len())
        .map(|at| Held::of(cells.get(at), is_comma))
        .collect()
}

fn layout(text: &str) -> Option<Layout> {
    let lines: Vec<&str> = text.lines().take(BANNER_LINES + ALIKE).collect();
    [b'\t', b';', b','].into_iter().find_map(|byte| {
        let separator = Separator::Byte(byte);
        (0..lines.len().min(BANNER_LINES)).find_map(|at| {
            let mut cells = Cells::default();
            cells.split(lines[at].as_bytes(), separator);
            let names: Vec<String> = (0..cells.len())
                .map(|at| cells.text(at).into_owned())
                .collect();
            let is_name = |name: &String| {
                name.starts_with(|c: char| c.is_alphabetic() || matches!(c, '_' | '/' | '.' | '%'))
            };
            if names.len() < 2 || !names.iter().all(is_name) {
                return None;
            }
            let rows: Vec<Vec<Held>> = (lines.get(at + 1..at + 1 + ALIKE)?)
                .iter()
                .map(|line| row(line, separator))
                .collect();
            let kinds = rows[0].clone();
            let is_alike = |row: &Vec<Held>| {
                row.len() == names.len() && row.iter().zip(&kinds).all(|(a, b)| a.is_like(b))
            };
            let is_table =
                rows.iter().all(is_alike) && kinds.iter().any(Held::is_more_than_a_number);
            is_table.then_some(Layout {
                separator,
                lines: at + 1,
                names,
                kinds,
            })
        })
    })
}

/// Whether a text has this format. A column of changing words, such as directions, is supported by the reader of
/// plain text only.
pub(super) fn is_wordy(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let text = text.rsplit_once('\n').map_or("", |(lines, _)| lines);
    let Some(layout) = layout(text) else {
        return false;
    };
    let words = |line: &str| -> Vec<String> {
        let mut cells = Cells::default();
        cells.split(line.as_bytes(), layout.separator);
        (layout.kinds.iter().enumerate())
            .filter(|(_, kind)| **kind == Held::Words)
            .map(|(at, _)| cells.text(at).into_owned())
            .collect()
    };
    let mut rows = text.lines().skip(layout.lines).map(words);
    let first = rows.next();
    rows.all(|row| Some(row) == first)
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let layout = layout(&text).ok_or_else(|| FORM.nothing(""))?;
    let mut columns = Columns::default();
    for line in text
        .lines()
        .skip(layout.lines)
        .filter(|line| !line.trim().is_empty())
    {
        let cells = row(line, layout.separator);
        for ((cell, kind), name) in cells.iter().zip(&layout.kinds).zip(&layout.names) {
            match (cell, kind) {
                (Held::Number(number) | Held::Hex(number), _) => columns.put(name, *number),
                (Held::Unit(number, unit), Held::Unit(_, of)) if unit == of => {
                    columns.put(name, *number);
                }
                (Held::List(numbers), _) => {
                    for (at, number) in numbers.iter().enumerate() {
                        columns.put(&format!("{name}[{at}]"), *number);
                    }
                }
                _ => {}
            }
        }
        columns.end_row(FORM)?;
    }
    let mut table = columns.table();
    for column in &mut table.columns {
        let kind = layout
            .names
            .iter()
            .position(|name| *name == column.name)
            .map(|at| &layout.kinds[at]);
        if let Some(Held::Unit(_, unit)) = kind {
            column.unit = Some(unit.clone());
        }
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn text(log: &str) -> String {
        assert!(is_wordy(log.as_bytes()), "{log}");
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn lists_units_and_hexadecimal_are_numbers() {
        let ros = "Time,name,position,velocity\n0.5,['wheel'],[0.25],[1]\n0.6,['wheel'],[0.5],[1]\n0.7,['wheel'],[0.75],[1]\n0.8,['wheel'],[0.75],[1]\n";
        assert_eq!(
            text(ros),
            "\"Time\",\"position[0]\",\"velocity[0]\"\n0.5,0.25,1\n0.6,0.5,1\n0.7,0.75,1\n0.8,0.75,1\n"
        );
        let two = "t,position\n0,\"(1, 2)\"\n1,\"(3, 4)\"\n2,\"(5, 6)\"\n3,\"(5, 6)\"\n";
        assert_eq!(
            text(two),
            "\"t\",\"position[0]\",\"position[1]\"\n0,1,2\n1,3,4\n2,5,6\n3,5,6\n"
        );
        let units = "Time;Voltage;counts\n0,00 s;6,5 V;0xFFFFFFFE\n0,01 s;6,5 V;0x00000001\n0,02 s;6,5 V;0x2\n0,03 s;6,5 V;0x3\n";
        assert_eq!(
            text(units),
            "\"Time\",\"Voltage\",\"counts\"\n0,6.5,-2\n0.01,6.5,1\n0.02,6.5,2\n0.03,6.5,3\n"
        );
        let table = read(units.as_bytes()).expect("a table");
        assert_eq!(table.columns[1].unit.as_deref(), Some("V"));
    }

    #[test]
    fn plain_tables_and_changing_words_are_not_recognized() {
        for none in [
            "t,n\n0,1\n1,2\n2,3\n3,4\n",
            "t,dir,u\n0,CW,5 V\n1,CW,5 V\n2,CCW,5 V\n3,CW,5 V\n",
            "[0, 1]\n[1, 2]\n[2, 3]\n[3, 4]\n",
            "t,date\n0,12:00:00\n1,12:00:01\n2,12:00:02\n3,12:00:03\n",
            "",
        ] {
            assert!(!is_wordy(none.as_bytes()), "{none}");
        }
    }
}
