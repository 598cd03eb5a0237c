//! Tables with unquoted decimal commas between comma-separated cells, as programs write them in some locales:
//! `0,010,6,00,83,3` below `t,U,n`. Every cell has a fraction, so that a row has twice as many parts as there are
//! names.

use super::super::cells::{Cells, Separator, number};
use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Decimals;
/// Most lines above the rows.
const BANNER_LINES: usize = 40;
/// Consecutive equal rows that make a table.
const ALIKE: usize = 3;

/// Names, and the number of lines up to them.
struct Header {
    lines: usize,
    names: Vec<String>,
}

fn parts(line: &str) -> Vec<String> {
    let mut cells = Cells::default();
    cells.split(line.as_bytes(), Separator::Byte(b','));
    (0..cells.len())
        .map(|at| cells.text(at).into_owned())
        .collect()
}

/// The numbers of a row with this many columns.
fn row(line: &str, count: usize) -> Option<Vec<f64>> {
    let parts = parts(line);
    let joined = |pair: &[String]| {
        let is_fraction = !pair[1].is_empty() && pair[1].bytes().all(|byte| byte.is_ascii_digit());
        let joined = is_fraction.then(|| format!("{},{}", pair[0], pair[1]))?;
        number(joined.as_bytes(), true, "").ok()
    };
    (parts.len() == 2 * count).then(|| parts.chunks(2).map(joined).collect())?
}

fn header(text: &str) -> Option<Header> {
    let lines: Vec<&str> = text.lines().take(BANNER_LINES + ALIKE).collect();
    (0..lines.len().min(BANNER_LINES)).find_map(|at| {
        let names = parts(lines[at]);
        let is_name = |name: &String| name.starts_with(|c: char| c.is_alphabetic() || c == '_');
        let below = lines.get(at + 1..at + 1 + ALIKE)?;
        // A program writes a column with the same digits in every row, and at least one column is a fraction.
        let digits = |line: &&str| -> Vec<usize> {
            parts(line)
                .iter()
                .skip(1)
                .step_by(2)
                .map(String::len)
                .collect()
        };
        let is_table = names.len() > 1
            && names.iter().all(is_name)
            && below.iter().all(|line| row(line, names.len()).is_some())
            && below
                .windows(2)
                .all(|two| digits(&two[0]) == digits(&two[1]));
        is_table.then(|| Header {
            lines: at + 1,
            names,
        })
    })
}

/// Whether a text has this format.
pub(super) fn is_decimals(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    header(text.rsplit_once('\n').map_or("", |(lines, _)| lines)).is_some()
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let header = header(&text).ok_or_else(|| FORM.nothing(""))?;
    let count = header.names.len();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); count];
    let mut others = 0_usize;
    for line in text
        .lines()
        .skip(header.lines)
        .filter(|line| !line.trim().is_empty())
    {
        match row(line, count) {
            Some(numbers) => {
                for (column, number) in columns.iter_mut().zip(numbers) {
                    column.push(number);
                }
            }
            None => others += 1,
        }
        if columns[0].len() * count > MOST_VALUES {
            return Err(FORM.too_much("values"));
        }
    }
    let named = |name| TableColumn { name, unit: None };
    let names = header.names.into_iter().map(named);
    let mut table = Table::whole(names.zip(columns).collect());
    table.notes.push(format!(
        "commas are between its cells and within its numbers: two parts are one number{}",
        match others {
            0 => String::new(),
            others => format!("; {others} lines with other parts are left out"),
        }
    ));
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    #[test]
    fn two_parts_are_one_number() {
        let log = "Time (s),U (V)\n0,000,6,00\n0,010,-0,50\n0,020,7,25\n0,030\n0,040,7,25\n";
        assert!(is_decimals(log.as_bytes()));
        let table = read(log.as_bytes()).expect("a table");
        let mut text = String::new();
        table.text().read_to_string(&mut text).expect("memory");
        assert_eq!(
            text,
            "\"Time (s)\",\"U (V)\"\n0,6\n0.01,-0.5\n0.02,7.25\n0.04,7.25\n"
        );
        assert!(table.notes[0].contains("1 lines"), "{}", table.notes[0]);
    }

    #[test]
    fn plain_tables_are_not_recognized() {
        for log in [
            "t,u\n0,1\n1,2\n2,3\n3,4\n",
            "t,u\n0,1,2,3\n0,1,2,30\n0,1,2,3\n0,1,2,3\n",
            "t,u\n0,1,2,-3\n0,1,2,-3\n0,1,2,-3\n0,1,2,-3\n",
            "0,000,6,00\n0,010,6,00\n0,020,7,25\n0,030,7,25\n",
            "",
        ] {
            assert!(!is_decimals(log.as_bytes()), "{log}");
        }
    }
}
