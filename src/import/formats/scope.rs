//! Oscilloscope files without times, with the start and the increment above the rows. Rigol's
//! `X,CH1,CH2,Start,Increment` with `Sequence,Volt,Volt,-6.0e-3,1.0e-5` below it, and `CH1V,CH2V,t0 = -5.0e-2,tInc =
//! 1.0e-6`.

use super::super::cells::{Cells, Separator, number, texts};
use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Scope;
/// Most lines above the rows.
const BANNER_LINES: usize = 20;
/// Names of start and increment in one line.
const NAMES: [(&str, &str); 3] = [("start", "increment"), ("t0", "tinc"), ("x0", "dx")];

#[derive(Debug)]
struct Header {
    separator: Separator,
    /// Number of lines above the rows.
    lines: usize,
    start_s: f64,
    increment_s: f64,
    /// The column of the sample number.
    index: Option<usize>,
    /// A column of times.
    has_time: bool,
    signals: Vec<(usize, TableColumn)>,
}

fn header(text: &str) -> Option<Header> {
    let lines: Vec<&str> = text.lines().take(BANNER_LINES + 1).collect();
    [b'\t', b';', b','].into_iter().find_map(|byte| {
        let separator = Separator::Byte(byte);
        let read = |cell: &str| number(cell.as_bytes(), byte != b',', "").ok();
        (0..lines.len().min(BANNER_LINES)).find_map(|at| {
            let names = texts(lines[at], separator);
            let below = lines.get(at + 1).map(|line| texts(line, separator));
            below_names(&names, below.as_deref().unwrap_or_default(), read)
                .or_else(|| in_names(&names, read))
                .map(|(header, own_lines)| Header {
                    separator,
                    lines: at + own_lines,
                    ..header
                })
        })
    })
}

/// Names with the numbers below them, in the line of the units.
fn below_names(
    names: &[String],
    below: &[String],
    read: impl Fn(&str) -> Option<f64>,
) -> Option<(Header, usize)> {
    let named = |name: &str| {
        names
            .iter()
            .position(|cell| cell.eq_ignore_ascii_case(name))
    };
    let (start, increment) =
        (NAMES.iter()).find_map(|(start, step)| Some((named(start)?, named(step)?)))?;
    let (start_s, increment_s) = (read(below.get(start)?)?, read(below.get(increment)?)?);
    let is_unit = |at: &usize| below.get(*at).is_some_and(|cell| !cell.is_empty());
    let others: Vec<usize> = (0..names.len())
        .filter(|at| ![start, increment].contains(at) && is_unit(at))
        .collect();
    // Names above a numeric row are a plain table.
    if others.is_empty() || others.iter().any(|at| read(&below[*at]).is_some()) {
        return None;
    }
    let is_index = |at: &usize| below[*at].eq_ignore_ascii_case("sequence") || names[*at] == "X";
    let index = others.iter().copied().find(is_index);
    let signal = |&at: &usize| {
        let (name, unit) = (names[at].clone(), Some(below[at].clone()));
        (at, TableColumn { name, unit })
    };
    let header = Header {
        separator: Separator::Blanks,
        lines: 0,
        start_s,
        increment_s,
        index,
        has_time: false,
        signals: (others.iter().filter(|at| Some(**at) != index))
            .map(signal)
            .collect(),
    };
    header.checked().map(|header| (header, 2))
}

/// Names with the numbers beside them, `tInc = 1.0e-6`.
fn in_names(names: &[String], read: impl Fn(&str) -> Option<f64>) -> Option<(Header, usize)> {
    let keyed = |key: &str| {
        names.iter().enumerate().find_map(|(at, cell)| {
            let (name, value) = cell.split_once('=')?;
            (name.trim().eq_ignore_ascii_case(key)).then_some((at, read(value.trim())?))
        })
    };
    let ((start, start_s), (increment, increment_s)) =
        (NAMES.iter()).find_map(|(start, step)| Some((keyed(start)?, keyed(step)?)))?;
    let is_time = |name: &str| name.to_lowercase().starts_with("time");
    let signals: Vec<(usize, TableColumn)> = (names.iter().enumerate())
        .filter(|(at, name)| ![start, increment].contains(at) && !name.is_empty())
        .map(|(at, name)| {
            // `CH1V` is channel 1 in volts.
            let channel = name
                .strip_suffix('V')
                .filter(|channel| channel.ends_with(|c: char| c.is_ascii_digit()));
            let (name, unit) = match channel {
                Some(channel) => (channel.to_owned(), Some("V".to_owned())),
                None => (name.clone(), None),
            };
            (at, TableColumn { name, unit })
        })
        .collect();
    let header = Header {
        separator: Separator::Blanks,
        lines: 0,
        start_s,
        increment_s,
        index: None,
        has_time: signals.iter().any(|(_, column)| is_time(&column.name)),
        signals,
    };
    header.checked().map(|header| (header, 1))
}

impl Header {
    fn checked(self) -> Option<Self> {
        let is_clock = self.start_s.is_finite() && self.increment_s.is_finite();
        (is_clock && self.increment_s > 0.0 && !self.signals.is_empty()).then_some(self)
    }
}

/// Whether a text has this format.
pub(super) fn is_scope(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    header(text.rsplit_once('\n').map_or("", |(lines, _)| lines)).is_some()
}

/// Reads it. The time of a sample is its number times the increment after the start.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let header = header(&text).ok_or_else(|| FORM.nothing(""))?;
    let decimal_comma = header.separator != Separator::Byte(b',');
    let mut times: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); header.signals.len()];
    let mut cells = Cells::default();
    for line in text.lines().skip(header.lines) {
        cells.split(line.as_bytes(), header.separator);
        let read = |at: usize| match at < cells.len() {
            true => number(cells.get(at), decimal_comma, "").unwrap_or(f64::NAN),
            false => f64::NAN,
        };
        let numbers: Vec<f64> = header.signals.iter().map(|(at, _)| read(*at)).collect();
        if !numbers.iter().any(|number| number.is_finite()) {
            continue;
        }
        let counted = times.len() as f64;
        let sample = header.index.map(read).filter(|index| index.is_finite());
        times.push(header.start_s + sample.unwrap_or(counted) * header.increment_s);
        for (column, number) in columns.iter_mut().zip(numbers) {
            column.push(number);
        }
        if times.len() * (1 + columns.len()) > MOST_VALUES {
            return Err(FORM.too_much("values"));
        }
    }
    let time = TableColumn {
        name: "time".to_owned(),
        unit: Some("s".to_owned()),
    };
    let signals = (header.signals.into_iter())
        .map(|(_, column)| column)
        .zip(columns);
    Ok(Table::whole(match header.has_time {
        true => signals.collect(),
        false => std::iter::once((time, times)).chain(signals).collect(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn text(log: &str) -> (Table, String) {
        assert!(is_scope(log.as_bytes()), "{log}");
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        (table, text)
    }

    #[test]
    fn times_are_counted_from_the_start_by_the_increment() {
        let rigol = "X,CH1,CH2,Start,Increment\nSequence,Volt,Volt,-2.0e-01,1.0e-01\n0,6.0,1.5,\n1,7.0,2.5,\n3,8.0,3.5,\n";
        let (table, found) = text(rigol);
        assert_eq!(
            found,
            "\"time\",\"CH1\",\"CH2\"\n-0.2,6,1.5\n-0.1,7,2.5\n0.10000000000000003,8,3.5\n"
        );
        assert_eq!(table.columns[1].unit.as_deref(), Some("Volt"));
        let (_, semicolons) = text(&rigol.replace(',', ";").replace('.', ","));
        assert_eq!(semicolons, found);
        let newer = "CH1V,CH2V,t0 = -2.0e-01,tInc = 1.0e-01\n6.0,1.5,,\n7.0,2.5,,\n";
        let (table, found) = text(newer);
        assert_eq!(found, "\"time\",\"CH1\",\"CH2\"\n-0.2,6,1.5\n-0.1,7,2.5\n");
        assert_eq!(table.columns[2].unit.as_deref(), Some("V"));
        let timed = "Time(s),CH1V,t0 = 0,tInc = 0.1,\n0.0,6.0,,\n0.1,7.0,,\n";
        assert_eq!(text(timed).1, "\"Time(s)\",\"CH1\"\n0,6\n0.1,7\n");
    }

    #[test]
    fn plain_tables_are_not_recognized() {
        for log in [
            "Start,Increment,n\n0,1,2\n0,1,3\n",
            "t0,tinc,n\ns,s,-\n0,1,2\n",
            "X,CH1,Start,Increment\nSequence,Volt,0,0\n0,1\n",
            "t,n\n0,1\n",
            "",
        ] {
            assert!(!is_scope(log.as_bytes()), "{log}");
        }
    }
}
