//! One signal per line: a transposed table, and lists of MATLAB and Python: `rpm,0,3.1,6.4`, `rpm = [0.0, 3.1, 6.4]`.
//! The unit is in the name, or a cell after it: `Speed,rad/s,0,3.1,6.4`.
//! A matrix on one line, `[0 5; 10 6]`, has semicolons between its rows. MATLAB prints consecutive vectors, each
//! below `rpm =`.

use super::super::cells::number;
use super::super::table::{Table, TableColumn};
use super::super::unmapped::is_known;
use super::printed::{block, factor};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Lists;
/// Fewest numbers of a named signal: tables in columns have fewer.
const LEAST_SAMPLES: usize = 20;
/// Fewest numbers of an unnamed signal: few logs have so many columns, and those have names.
const LEAST_UNNAMED: usize = 100;

/// Whether the first line is a name with its numbers, or a matrix.
pub(super) fn is_lists(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let text = text.trim_start();
    if is_matrix(text) || is_printed(text) || is_unnamed(text) {
        return true;
    }
    // Truncated content, or the end of a list, is not parsed.
    let Some((name, rest)) = named(text) else {
        return false;
    };
    let is_apart = |c: char| matches!(c, '\n' | '=' | ']');
    let (_, rest) = with_unit(rest);
    let first = rest.split(is_apart).next().unwrap_or_default();
    let has_decimal_comma = has_decimal_comma(first);
    let cells: Vec<&str> = cells(first, has_decimal_comma).collect();
    let whole = &cells[..cells.len().saturating_sub(1)];
    let is_number = |cell: &&str| number(cell.as_bytes(), has_decimal_comma, "").is_ok();
    !name.is_empty() && whole.len() >= LEAST_SAMPLES && whole.iter().all(is_number)
}

/// A vector as MATLAB prints it: its name, and a number per line, or blocks of a single row.
fn is_printed(text: &str) -> bool {
    let mut lines = (text.lines().map(str::trim)).filter(|line| !line.is_empty());
    let is_named = lines.next().is_some_and(|line| name_alone(line).is_some());
    let rows: Vec<&str> = lines
        .filter(|line| factor(line).is_none())
        .take(LEAST_SAMPLES)
        .collect();
    let is_one = |line: &&str| line.parse::<f64>().is_ok();
    let is_row = |pair: &[&str]| block(pair[0]).is_some() && block(pair[1]).is_none();
    let is_vector = match rows.first() {
        Some(first) if block(first).is_some() => rows.chunks_exact(2).take(2).all(is_row),
        _ => rows.len() == LEAST_SAMPLES && rows.iter().all(is_one),
    };
    is_named && is_vector && rows.len() > 2
}

/// A first line of many numbers only.
fn is_unnamed(text: &str) -> bool {
    let first = text.lines().next().unwrap_or_default();
    let has_decimal_comma = has_decimal_comma(first);
    let all: Vec<&str> = cells(first, has_decimal_comma).collect();
    let whole = &all[..all.len().saturating_sub(1)];
    let is_number = |cell: &&str| number(cell.as_bytes(), has_decimal_comma, "").is_ok();
    whole.len() >= LEAST_UNNAMED && whole.iter().all(is_number)
}

/// `rpm =`
fn name_alone(line: &str) -> Option<&str> {
    let name = line.strip_suffix('=')?.trim();
    name.starts_with(char::is_alphabetic).then_some(name)
}

/// Whether commas are decimal: other separators are between the numbers.
fn has_decimal_comma(cells: &str) -> bool {
    cells.matches([';', '\t']).count() >= LEAST_SAMPLES
}

/// `[0 5; 10 6; 20 7]`
fn is_matrix(text: &str) -> bool {
    let line = text.lines().next().unwrap_or_default();
    let rows = line.split(';').map(|row| cells(row, false).count());
    let counts: Vec<usize> = rows.collect();
    line.starts_with('[')
        && counts.len() > LEAST_SAMPLES
        && counts[0] > 1
        && counts[1..counts.len() - 1]
            .iter()
            .all(|count| *count == counts[0])
}

fn cells(text: &str, has_decimal_comma: bool) -> impl Iterator<Item = &str> {
    let is_between = move |c: char| {
        c.is_whitespace()
            || matches!(c, ';' | '[' | ']' | '(' | ')' | '"' | '}')
            || (c == ',' && !has_decimal_comma)
    };
    text.split(is_between).filter(|cell| !cell.is_empty())
}

/// A leading name, quoted or not, and the text after it.
fn named(text: &str) -> Option<(&str, &str)> {
    let (name, rest) = match text.strip_prefix('"') {
        Some(quoted) => quoted.split_once('"')?,
        None => {
            // A bracket after a name contains its unit, or the numbers.
            let is_list = |at: usize| {
                let inside = text[at + 1..].trim_start();
                let is_range = |(inside, _): (&str, &str)| !inside.contains([',', ';', ' ', '\t']);
                inside.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '.' | '['))
                    && !inside.split_once(']').is_some_and(is_range)
            };
            let is_end = |(at, c): &(usize, char)| {
                matches!(c, ',' | ';' | '\t' | '=' | ':') || (*c == '[' && is_list(*at))
            };
            let (end, _) = text.char_indices().find(is_end)?;
            text.split_at(end)
        }
    };
    let rest = rest.trim_start_matches(|c: char| {
        c.is_whitespace() || matches!(c, ',' | ';' | '=' | ':' | '[')
    });
    let name = name.trim();
    let is_name = name.starts_with(char::is_alphabetic) && !name.contains('\n');
    is_name.then_some((name, rest))
}

/// A unit in the first cell, and the text after it.
fn with_unit(text: &str) -> (Option<String>, &str) {
    let found = text.split_once([',', ';', '\t']);
    let unit = |cell: &str| cell.trim_matches(['"', ' ', '[', ']', '(', ')']).to_owned();
    match found.map(|(cell, rest)| (unit(cell), rest)) {
        Some((unit, rest)) if is_known(&unit) => (Some(unit), rest),
        _ => (None, text),
    }
}

/// Reads every signal; those of another length than the first are left out and reported.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    if is_matrix(text.trim_start()) {
        return matrix(&text);
    }
    let mut signals: Vec<(TableColumn, Vec<f64>)> = Vec::new();
    let column = |name: String, unit| TableColumn { name, unit };
    let mut values = 0;
    let (mut times, is_unnamed) = (1.0, is_unnamed(text.trim_start()));
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        if let Some(found) = factor(line) {
            times = found;
            continue;
        }
        if block(line).is_some() {
            continue;
        }
        if name_alone(line).is_some() {
            times = 1.0;
        }
        let rest = match named(line) {
            Some((name, rest)) => {
                let (unit, rest) = with_unit(rest);
                signals.push((column(name.to_owned(), unit), Vec::new()));
                rest
            }
            None if is_unnamed => {
                let name = (signals.len() + 1).to_string();
                signals.push((column(name, None), Vec::new()));
                line
            }
            // A list continues in the next line.
            None => line,
        };
        let Some((_, numbers)) = signals.last_mut() else {
            continue;
        };
        let has_decimal_comma = has_decimal_comma(rest);
        for cell in cells(rest, has_decimal_comma) {
            let value = number(cell.as_bytes(), has_decimal_comma, "").unwrap_or(f64::NAN);
            numbers.push(times * value);
            values += 1;
        }
        if values > MOST_VALUES {
            return Err(FORM.too_much("values"));
        }
    }
    let rows = signals.first().map_or(0, |(_, numbers)| numbers.len());
    let others: Vec<String> = (signals.iter())
        .filter(|(_, numbers)| numbers.len() != rows)
        .map(|(column, numbers)| format!("`{}` ({} values)", column.name, numbers.len()))
        .collect();
    signals.retain(|(_, numbers)| numbers.len() == rows);
    let mut table = Table::whole(signals);
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
        .map(|row| cells(row, false).collect::<Vec<_>>());
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
    fn a_signal_per_line_is_a_column() {
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
            format!(
                "t_s;{}\nu;{}\n",
                list(";", 0.5).replace('.', ","),
                list(";", 2.0)
            ),
            format!(
                "t_s =\n\n{}\nu =\n\n  2.0e+00 *\n\n{}\n",
                list("\n", 0.5),
                list("\n", 1.0)
            ),
            format!(
                "t_s =\n  Columns 1 through 20\n{}\n  Columns 21 through 30\n{}\nu =\n{}\n",
                &list(" ", 0.5)[..list(" ", 0.5).find(" 10 ").expect("10")],
                &list(" ", 0.5)[list(" ", 0.5).find(" 10 ").expect("10")..],
                list(" ", 2.0),
            ),
        ] {
            let found = lines(&text);
            assert_eq!(found[0], "\"t_s\",\"u\"", "{text}");
            assert_eq!((found.len(), found[30].as_str()), (31, "14.5,58"), "{text}");
        }
        let units = format!("t [s],{t}\nU [V],{u}\n");
        assert_eq!(lines(&units)[0], "\"t [s]\",\"U [V]\"");
        let apart = format!(
            "t;s;{};\nU;V;{}\n",
            t.replace(',', ";"),
            u.replace(',', ";")
        );
        let table = read(apart.as_bytes()).expect("a table");
        assert!(is_lists(apart.as_bytes()), "{apart}");
        let units: Vec<_> = table
            .columns
            .iter()
            .map(|column| column.unit.as_deref())
            .collect();
        assert_eq!(
            (units, lines(&apart)[30].as_str()),
            (vec![Some("s"), Some("V")], "14.5,58")
        );
        let ranges = lines(&format!(
            "PWM [0-255]: {}\nt [ms]: {}\n",
            list(" ", 2.0),
            list(" ", 0.5)
        ));
        assert_eq!(
            (ranges[0].as_str(), ranges.len()),
            ("\"PWM [0-255]\",\"t [ms]\"", 31)
        );
        let rows: Vec<String> = (0..30).map(|k| format!("{} {}", 10 * k, k)).collect();
        let found = lines(&format!("[{}]", rows.join(";")));
        assert_eq!((found.len(), found[30].as_str()), (31, "290,29"));
        let numbers = |scale: f64| -> String {
            (0..120)
                .map(|k| format!("{}, ", f64::from(k) * scale))
                .collect()
        };
        let found = lines(&format!("[{}]\n[{}]\n", numbers(0.5), numbers(2.0)));
        assert_eq!((found.len(), found[120].as_str()), (121, "59.5,238"));
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
