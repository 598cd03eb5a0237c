//! Tables with unquoted decimal commas between comma-separated cells, as programs write them in some locales:
//! `0,010,6,00,83,3` below `t,U,n`.
//!
//! Where every cell has a fraction, a row has twice as many parts as there are names. Where some columns are whole
//! numbers, a row has fewer: the parts belong to columns in the only way in which each fraction is of as many digits
//! in every row, and no whole number begins with a zero. If there are several ways, the table is refused.

use super::super::cells::{Cells, Separator, number};
use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES, RECOGNITION_BYTES};

const FORM: Form = Form::Decimals;
/// Most lines above the rows.
const BANNER_LINES: usize = 40;
/// Consecutive equal rows that make a table.
const ALIKE: usize = 3;

/// Names, and the number of lines up to them.
struct Header {
    lines: usize,
    names: Vec<String>,
    /// Which columns have a fraction; `None` if the rows fit in several ways.
    fractions: Option<Vec<bool>>,
}

fn parts(line: &str) -> Vec<String> {
    let mut cells = Cells::default();
    cells.split(line.as_bytes(), Separator::Byte(b','));
    (0..cells.len())
        .map(|at| cells.text(at).into_owned())
        .collect()
}

fn is_digits(part: &str) -> bool {
    !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit())
}

/// Digits with a zero before others: of a fraction, and of no whole number.
fn is_padded(part: &str) -> bool {
    part.len() > 1 && part.starts_with('0') && is_digits(part)
}

fn is_whole(part: &str) -> bool {
    !is_padded(part) && number(part.as_bytes(), true, "").is_ok()
}

/// The numbers of a row.
fn row(line: &str, fractions: &[bool]) -> Option<Vec<f64>> {
    let parts = parts(line);
    let mut rest = parts.iter();
    let cell = |has_fraction: &bool| {
        let whole = rest.next()?;
        let text = match has_fraction {
            true => format!("{whole},{}", rest.next().filter(|part| is_digits(part))?),
            false => whole.clone(),
        };
        number(text.as_bytes(), true, "").ok()
    };
    let numbers: Vec<f64> = fractions.iter().map(cell).collect::<Option<_>>()?;
    rest.next().is_none().then_some(numbers)
}

/// Whether each of so many columns has a fraction, and whether the parts of all rows are these columns in that way only. A
/// fraction has the same digits in every row, and no whole number begins with a zero.
fn fractions(rows: &[Vec<String>], columns: usize) -> Option<(Vec<bool>, bool)> {
    let count = rows[0].len();
    let all = |at: usize, is: &dyn Fn(&str) -> bool| rows.iter().all(|row| is(&row[at]));
    let whole: Vec<bool> = (0..count).map(|at| all(at, &is_whole)).collect();
    let is_pair = |at: usize| {
        let digits = |part: &str| is_digits(part) && part.len() == rows[0][at + 1].len();
        at + 1 < count && whole[at] && all(at + 1, &digits)
    };
    let pair: Vec<bool> = (0..count).map(is_pair).collect();
    // The number of ways (2 for more) in which the last columns are the parts from each one on.
    let mut ways: Vec<Vec<u8>> = vec![vec![0; count + 2]];
    ways[0][count] = 1;
    for _ in 0..columns {
        let after = &ways[ways.len() - 1];
        let from = |at: usize| match at < count {
            true => {
                let alone = u8::from(whole[at]) * after[at + 1];
                (alone + u8::from(pair[at]) * after[at + 2]).min(2)
            }
            false => 0,
        };
        ways.push((0..count + 2).map(from).collect());
    }
    let mut at = 0;
    let is_only = match ways[columns][0] {
        0 => return None,
        number => number == 1,
    };
    let has_fraction = ways[..columns].iter().rev().map(|after| {
        let has = !(whole[at] && after[at + 1] > 0);
        at += 1 + usize::from(has);
        has
    });
    Some((has_fraction.collect(), is_only))
}

fn header(beginning: &[u8]) -> Option<Header> {
    let text = String::from_utf8_lossy(&beginning[..beginning.len().min(RECOGNITION_BYTES)]);
    // The last line may be incomplete.
    let text = text.rsplit_once('\n').map_or("", |(lines, _)| lines);
    let lines: Vec<&str> = (text.lines())
        .filter(|line| !line.trim().is_empty())
        .collect();
    (0..lines.len().min(BANNER_LINES)).find_map(|at| {
        let names = parts(lines[at]);
        let is_name = |name: &String| name.starts_with(|c: char| c.is_alphabetic() || c == '_');
        if names.len() < 2 || !names.iter().all(is_name) {
            return None;
        }
        let below = lines.get(at + 1..at + 1 + ALIKE)?;
        let mut rows: Vec<Vec<String>> = below.iter().map(|line| parts(line)).collect();
        let count = rows[0].len();
        if !(names.len() + 1..=2 * names.len()).contains(&count) {
            return None;
        }
        if count < 2 * names.len() {
            // Which columns are whole numbers shows in many rows.
            rows.extend(lines[at + 1 + ALIKE..].iter().map(|line| parts(line)));
        }
        let is_padded = |row: &Vec<String>| row.iter().any(|part| is_padded(part));
        let is_alike = rows.iter().all(|row| row.len() == count);
        if !is_alike || (count < 2 * names.len() && !rows.iter().any(is_padded)) {
            return None;
        }
        let (fractions, is_only) = fractions(&rows, names.len())?;
        Some(Header {
            lines: at + 1,
            names,
            fractions: is_only.then_some(fractions),
        })
    })
}

/// Whether a text has this format.
pub(super) fn is_decimals(beginning: &[u8]) -> bool {
    header(beginning).is_some()
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let header = header(bytes).ok_or_else(|| FORM.nothing(""))?;
    let Some(fractions) = header.fractions else {
        return Err(FormatError::NotRead {
            what: "a table with commas between its cells and within its numbers, whose parts belong together in several ways",
            remedy: "export it with semicolons between the cells, or with decimal points",
        });
    };
    let count = header.names.len();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); count];
    let mut others = 0_usize;
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    for line in lines.skip(header.lines) {
        match row(line, &fractions) {
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
    let whole: Vec<String> = (header.names.iter().zip(&fractions))
        .filter(|(_, has_fraction)| !**has_fraction)
        .map(|(name, _)| format!("`{name}`"))
        .collect();
    let named = |name| TableColumn { name, unit: None };
    let names = header.names.into_iter().map(named);
    let mut table = Table::whole(names.zip(columns).collect());
    table.notes.push(format!(
        "commas are between its cells and within its numbers: two parts are one number{}{}",
        match whole.is_empty() {
            true => String::new(),
            false => format!("; {} in whole numbers", whole.join(", ")),
        },
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
    fn whole_numbers_beside_fractions_are_read_where_only_one_way_fits() {
        let log = "t,U,n\n0,000,-6,50,0\n0,010,6,50,98\n0,020,7,25,-102\n0,030,7,05,1024\n";
        let table = read(log.as_bytes()).expect("a table");
        let mut text = String::new();
        table.text().read_to_string(&mut text).expect("memory");
        assert_eq!(
            text,
            "\"t\",\"U\",\"n\"\n0,-6.5,0\n0.01,6.5,98\n0.02,7.25,-102\n0.03,7.05,1024\n"
        );
        assert!(
            table.notes[0].contains("`n` in whole numbers"),
            "{}",
            table.notes[0]
        );
        // Either the command or the counts may have the decimals.
        let log = "t,U,n\n0,00,6,5,1\n0,01,6,5,1\n0,02,7,5,2\n0,03,7,5,2\n";
        let error = read(log.as_bytes()).expect_err("two ways").to_string();
        assert!(
            error.contains("several ways") && error.contains("semicolons"),
            "{error}"
        );
    }

    #[test]
    fn plain_tables_are_not_recognized() {
        for log in [
            // The first column has the numbers of the rows.
            "t_ms,u,n\n1,0,200,0\n2,10,200,3\n3,20,200,7\n4,30,200,9\n",
            "t,u,n\n0,0,5,0\n0,1,5,3\n0,2,5,7\n0,3,5,9\n",
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
