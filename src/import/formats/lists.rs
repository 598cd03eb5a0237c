//! A signal a line: a table that is turned on its side, and the lists that MATLAB and Python print:
//! `rpm,0,3.1,6.4`, `rpm = [0.0, 3.1, 6.4]`. A matrix on one line, `[0 5; 10 6]`, has its rows between semicolons.

use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Lists;
/// Numbers behind a name that are a signal: tables of columns have fewer.
const LEAST_SAMPLES: usize = 20;

/// Whether the first line is a name and its numbers, or a matrix.
pub(super) fn is_lists(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let text = text.trim_start();
    if is_matrix(text) {
        return true;
    }
    // Content cut off by the beginning is not read, nor the end of a list.
    let Some((name, rest)) = named(text) else {
        return false;
    };
    let is_apart = |c: char| matches!(c, '\n' | '=' | ']');
    let first = rest.split(is_apart).next().unwrap_or_default();
    let cells: Vec<&str> = cells(first).collect();
    let whole = &cells[..cells.len().saturating_sub(1)];
    !name.is_empty()
        && whole.len() >= LEAST_SAMPLES
        && whole.iter().all(|cell| cell.parse::<f64>().is_ok())
}

/// `[0 5; 10 6; 20 7]`
fn is_matrix(text: &str) -> bool {
    let line = text.lines().next().unwrap_or_default();
    let rows = line.split(';').map(|row| cells(row).count());
    let counts: Vec<usize> = rows.collect();
    line.starts_with('[')
        && counts.len() > LEAST_SAMPLES
        && counts[0] > 1
        && counts[1..counts.len() - 1]
            .iter()
            .all(|count| *count == counts[0])
}

fn cells(text: &str) -> impl Iterator<Item = &str> {
    let is_between = |c: char| c.is_whitespace() || matches!(c, ',' | ';' | '[' | ']' | '(' | ')');
    text.split(is_between).filter(|cell| !cell.is_empty())
}

/// A name at the beginning, in quotes or not, and what follows it.
fn named(text: &str) -> Option<(&str, &str)> {
    let (name, rest) = match text.strip_prefix('"') {
        Some(quoted) => quoted.split_once('"')?,
        None => {
            let is_end = |c: char| matches!(c, ',' | ';' | '\t' | '=' | ':' | '[');
            let comma = text.find(is_end)?;
            text.split_at(comma)
        }
    };
    let rest = rest.trim_start_matches(|c: char| {
        c.is_whitespace() || matches!(c, ',' | ';' | '=' | ':' | '[')
    });
    let name = name.trim();
    let is_name = name.starts_with(char::is_alphabetic) && !name.contains('\n');
    is_name.then_some((name, rest))
}

/// Reads every signal; those of another length than the first are left out and named.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    if is_matrix(text.trim_start()) {
        return matrix(&text);
    }
    let mut signals: Vec<(String, Vec<f64>)> = Vec::new();
    let mut values = 0;
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let rest = match named(line) {
            Some((name, rest)) => {
                signals.push((name.to_owned(), Vec::new()));
                rest
            }
            // A list goes on in the next line.
            None => line,
        };
        let Some((_, numbers)) = signals.last_mut() else {
            continue;
        };
        for cell in cells(rest) {
            numbers.push(cell.parse().unwrap_or(f64::NAN));
            values += 1;
        }
        if values > MOST_VALUES {
            return Err(FORM.too_much("values"));
        }
    }
    let rows = signals.first().map_or(0, |(_, numbers)| numbers.len());
    let others: Vec<String> = (signals.iter())
        .filter(|(_, numbers)| numbers.len() != rows)
        .map(|(name, numbers)| format!("`{name}` ({} values)", numbers.len()))
        .collect();
    signals.retain(|(_, numbers)| numbers.len() == rows);
    let column = |(name, numbers)| (TableColumn { name, unit: None }, numbers);
    let mut table = Table::whole(signals.into_iter().map(column).collect());
    if !others.is_empty() {
        table.notes.push(format!(
            "left out, as they are not {rows} long: {}",
            others.join(", ")
        ));
    }
    Ok(table)
}

fn matrix(text: &str) -> Result<Table, FormatError> {
    let mut columns: Vec<(TableColumn, Vec<f64>)> = Vec::new();
    let rows = text
        .split([';', '\n'])
        .map(|row| cells(row).collect::<Vec<_>>());
    for row in rows.filter(|row| !row.is_empty()) {
        if columns.is_empty() {
            let unnamed = |at: usize| TableColumn {
                name: at.to_string(),
                unit: None,
            };
            columns = (1..=row.len())
                .map(|at| (unnamed(at), Vec::new()))
                .collect();
        }
        if row.len() != columns.len() {
            return Err(FORM.broken(format!("a row of {} numbers", row.len())));
        }
        for ((_, numbers), cell) in columns.iter_mut().zip(row) {
            numbers.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Ok(Table::whole(columns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn lines(text: &str) -> Vec<String> {
        assert!(is_lists(text.as_bytes()), "{text}");
        let mut found = String::new();
        let table = read(text.as_bytes()).expect("a table");
        table.text().read_to_string(&mut found).expect("memory");
        found.lines().map(str::to_owned).collect()
    }

    #[test]
    fn signals_a_line_are_columns() {
        let list = |between: &str, scale: f64| {
            let numbers: Vec<String> = (0..30)
                .map(|k| (f64::from(k) * scale).to_string())
                .collect();
            numbers.join(between)
        };
        let (t, u) = (list(",", 0.5), list(",", 2.0));
        let wrapped = u.replacen(",20,", ",\n 20,", 1);
        for text in [
            format!("t_s,{t}\nu,{u}\n"),
            format!("t_s\t{}\nu\t{}\n", list("\t", 0.5), list("\t", 2.0)),
            format!("t_s = [{t}]\nu = [{wrapped}]\n"),
            format!("t_s = [{}];\nu = [{}];\n", list(" ", 0.5), list(" ", 2.0)),
            format!("\"t_s\": [{t}]\n\"u\": [{u}]\n"),
        ] {
            let found = lines(&text);
            assert_eq!(found[0], "\"t_s\",\"u\"", "{text}");
            assert_eq!((found.len(), found[30].as_str()), (31, "14.5,58"), "{text}");
        }
        let rows: Vec<String> = (0..30).map(|k| format!("{} {}", 10 * k, k)).collect();
        let found = lines(&format!("[{}]", rows.join(";")));
        assert_eq!((found.len(), found[30].as_str()), (31, "290,29"));
        for table in [
            "t,u\n0,1\n2,3\n",
            "a 1 2 3\n",
            "Dear reader, this is a letter\n",
            "",
        ] {
            assert!(!is_lists(table.as_bytes()), "{table}");
        }
    }
}
