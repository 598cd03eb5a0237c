//! Matrices as printed by MATLAB and Octave, with a common factor and in blocks of columns:
//!
//! ```text
//! data =
//!    1.0e+03 *
//!   Columns 1 through 2
//!          0    0.0050
//! ```

use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Printed;

/// Whether it begins with a name, followed by a factor or a block of columns. Without these it is text in columns.
pub(super) fn is_printed(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let is_name = |line: &str| line.ends_with('=') && line.starts_with(char::is_alphabetic);
    lines.next().is_some_and(is_name)
        && lines
            .take(3)
            .any(|line| factor(line).is_some() || block(line).is_some())
}

/// `1.0e+03 *`
pub(super) fn factor(line: &str) -> Option<f64> {
    line.strip_suffix('*')?.trim().parse().ok()
}

/// The first column of `Columns 1 through 8`, `Columns 9 and 10:`, `Column 17`.
pub(super) fn block(line: &str) -> Option<usize> {
    let rest = line
        .strip_prefix("Columns ")
        .or(line.strip_prefix("Column "))?;
    rest.split(|c: char| !c.is_ascii_digit())
        .find(|word| !word.is_empty())?
        .parse()
        .ok()
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let (mut times, mut first, mut values) = (1.0, 1, 0);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(found) = factor(line) {
            times = found;
            continue;
        }
        if let Some(found) = block(line) {
            first = found;
            continue;
        }
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let Ok(numbers) = numbers else { continue };
        for (at, number) in numbers.iter().enumerate() {
            let column = (first + at).saturating_sub(1);
            if column > columns.len() {
                return Err(FORM.broken(format!("column {} has none before it", column + 1)));
            }
            if column == columns.len() {
                columns.push(Vec::new());
            }
            columns[column].push(number * times);
        }
        values += numbers.len();
        if values > MOST_VALUES {
            return Err(FORM.too_much("values"));
        }
    }
    let rows = columns.first().map_or(0, Vec::len);
    if columns.iter().any(|column| column.len() != rows) {
        return Err(FORM.broken("its blocks of columns differ in length"));
    }
    let named = |(at, numbers)| {
        let name = format!("{}", at + 1_usize);
        (TableColumn { name, unit: None }, numbers)
    };
    let mut table = Table::whole(columns.into_iter().enumerate().map(named).collect());
    if times != 1.0 {
        table.notes.push(format!("all numbers are times {times}, as is printed above them; with four digits after the point"));
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    #[test]
    fn factors_and_blocks_are_read() {
        let log = "data =\n\n   1.0e+03 *\n\n  Columns 1 through 2\n\n    0    0.0050\n    0.0100    0.0060\n\n  Column 3\n\n    0.2550\n    0\n";
        assert!(is_printed(log.as_bytes()));
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        assert_eq!(text, "\"1\",\"2\",\"3\"\n0,5,255\n10,6,0\n");
        for other in [
            "data =\n\n  0 0.5\n 0.1 0.6\n 0.2 0.7\n 0.3 0.8\n",
            "t,u\n0,1\n",
            "",
        ] {
            assert!(!is_printed(other.as_bytes()), "{other}");
        }
    }
}
