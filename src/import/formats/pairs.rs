//! Tables with a pair of columns for every signal, X and Y, under one name: the exports of drives' scopes and of
//! TwinCAT Scope.
//!
//! The name of a pair is above its X, or its columns are named `A_X` and `A_Y`. TwinCAT has a line `Name,A,Name,B`
//! instead, and similar lines of `Unit` and `SampleTime[ms]`.

use super::super::cells::{Cells, Separator, number, texts};
use super::super::table::{Cell, Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Pairs;
/// Most lines above the rows.
const BANNER_LINES: usize = 60;
/// Consecutive equal rows that make a table.
const ALIKE: usize = 3;
/// Unit of X relative to milliseconds: 100 ns, as in Windows file times.
const FILE_TIME_MS: f64 = 1e-4;

struct Header {
    separator: Separator,
    /// Number of lines above the rows.
    lines: usize,
    names: Vec<String>,
    units: Vec<Option<String>>,
    /// Name of the X columns.
    x: String,
    sample_time_ms: Option<f64>,
}

fn header(text: &str) -> Option<Header> {
    [b'\t', b';', b','].into_iter().find_map(|byte| {
        let separator = Separator::Byte(byte);
        let lines: Vec<Vec<String>> = text
            .lines()
            .take(BANNER_LINES)
            .map(|line| texts(line, separator))
            .collect();
        let is_number = |cell: &String| number(cell.as_bytes(), byte != b',', "").is_ok();
        let is_row = |row: &Vec<String>, count: usize| {
            row.len() >= count && row[..count].iter().all(is_number)
        };
        // The first numeric rows, in pairs.
        let first = lines.windows(ALIKE).position(|rows| {
            let filled = rows[0].iter().filter(|cell| !cell.is_empty()).count();
            filled >= 4 && filled % 2 == 0 && rows.iter().all(|row| is_row(row, filled))
        })?;
        let count = lines[first].iter().filter(|cell| !cell.is_empty()).count();
        let filled =
            |row: &&Vec<String>| row.len() >= count - 1 && row.iter().any(|cell| !cell.is_empty());
        let above: Vec<&Vec<String>> = lines[..first].iter().filter(filled).collect();
        let even = |row: &Vec<String>, key: &str| {
            row.iter()
                .step_by(2)
                .all(|cell| cell.is_empty() || cell.to_lowercase().starts_with(key))
                && row[0].to_lowercase().starts_with(key)
        };
        let keyed = |key: &str| above.iter().rev().find(|row| even(row, key));
        let odd = |row: &Vec<String>| -> Vec<String> {
            (0..count / 2)
                .map(|pair| row.get(2 * pair + 1).cloned().unwrap_or_default())
                .collect()
        };
        let pairs = |row: &Vec<String>| {
            row[0] != row[1]
                && !row[0].is_empty()
                && !row[1].is_empty()
                && row
                    .iter()
                    .take(count)
                    .enumerate()
                    .all(|(at, cell)| *cell == row[at % 2])
        };
        let is_over = |row: &&&Vec<String>| {
            (0..count / 2).all(|pair| {
                row.get(2 * pair)
                    .is_some_and(|name| !name.is_empty() && !is_number(name))
                    && row.get(2 * pair + 1).is_none_or(String::is_empty)
            })
        };
        let marks = above.iter().rev().find(|row| pairs(row));
        let over = above.iter().rev().find(is_over);
        // Coordinates of points are named so too, and fall as well as rise.
        let rises = |at: usize| {
            let read = |row: &Vec<String>| number(row.get(at)?.as_bytes(), byte != b',', "").ok();
            let xs: Vec<f64> = lines[first..].iter().filter_map(read).collect();
            xs.windows(2).all(|two| two[0] < two[1])
        };
        let ended = || {
            let names = above.last().and_then(|row| ended(row))?;
            let is_whole = names.len() == count / 2 && (0..count).step_by(2).all(rises);
            is_whole.then_some(names)
        };
        let (names, x) = match (keyed("name"), over) {
            (Some(names), _) => (odd(names), "time".to_owned()),
            (None, Some(over)) => {
                let names = (0..count / 2).map(|pair| over[2 * pair].clone()).collect();
                (names, marks.map_or("X".to_owned(), |row| row[0].clone()))
            }
            (None, None) => (ended()?, "X".to_owned()),
        };
        let units = match keyed("unit") {
            Some(units) => odd(units)
                .into_iter()
                .map(|unit| Some(unit).filter(|unit| !unit.is_empty()))
                .collect(),
            None => vec![None; count / 2],
        };
        let sample_time_ms = keyed("sampletime[ms]").and_then(|row| row.get(1)?.parse().ok());
        Some(Header {
            separator,
            lines: first,
            names,
            units,
            x,
            sample_time_ms,
        })
    })
}

/// The names of pairs `A_X,A_Y,B_X,B_Y`.
fn ended(row: &[String]) -> Option<Vec<String>> {
    let end = |name: &str, of: char| {
        let stem = name.strip_suffix([of, of.to_ascii_uppercase()])?;
        let is_apart = stem.ends_with(['_', ' ', '.', '-', ':']);
        let stem = stem.trim_end_matches(['_', ' ', '.', '-', ':']);
        (is_apart && !stem.is_empty()).then(|| stem.to_owned())
    };
    let name = |pair: &[String]| {
        let (x, y) = (end(&pair[0], 'x')?, end(&pair[1], 'y')?);
        (x == y).then_some(x)
    };
    row.chunks_exact(2).map(name).collect()
}

/// Whether a text has this format.
pub(super) fn is_pairs(beginning: &[u8]) -> bool {
    // The last line may be incomplete.
    let text = String::from_utf8_lossy(beginning);
    header(text.rsplit_once('\n').map_or("", |(lines, _)| lines)).is_some()
}

/// Reads it: one X if all are the same, else the signals by their times.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let header = header(&text).ok_or_else(|| FORM.nothing(""))?;
    let count = header.names.len();
    let decimal_comma = header.separator != Separator::Byte(b',');
    let mut series: Vec<Signal> = vec![Vec::new(); count];
    let mut cells = Cells::default();
    let mut values = 0;
    for line in text.lines().skip(header.lines) {
        cells.split(line.as_bytes(), header.separator);
        for (pair, series) in series.iter_mut().enumerate() {
            let read = |at: usize| number(cells.get(at), decimal_comma, "");
            if let (Ok(x), Ok(y)) = (read(2 * pair), read(2 * pair + 1)) {
                series.push((x, y));
                values += 1;
            }
        }
        if values > MOST_VALUES {
            return Err(FORM.too_much("values"));
        }
    }
    let (factor, time) = time_column(&header, &series[0]);
    for (x, _) in series.iter_mut().flatten() {
        *x *= factor;
    }
    let named = |at: usize| TableColumn {
        name: header.names[at].clone(),
        unit: header.units[at].clone(),
    };
    Ok(table(time, (0..count).map(named).collect(), &[series]))
}

pub(super) type Signal = Vec<(f64, f64)>;

/// The table of signals, each segment a run: one X if all signals have the same, else a row for each X of any signal.
pub(super) fn table(time: TableColumn, names: Vec<TableColumn>, segments: &[Vec<Signal>]) -> Table {
    let is_one_x = |signals: &Vec<Signal>| {
        let xs = |signal: &Signal| signal.iter().map(|(x, _)| *x).collect::<Vec<f64>>();
        signals.windows(2).all(|two| xs(&two[0]) == xs(&two[1]))
    };
    let columns: Vec<TableColumn> = std::iter::once(time).chain(names).collect();
    let mut words: Vec<String> = Vec::new();
    let table = if segments.iter().all(is_one_x) {
        let mut numbers: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
        for (number, signals) in segments.iter().enumerate() {
            for (at, signal) in signals.iter().enumerate() {
                numbers[at + 1].extend(signal.iter().map(|(_, y)| *y));
                if at == 0 {
                    numbers[0].extend(signal.iter().map(|(x, _)| *x));
                }
            }
            words.resize(numbers[0].len(), (number + 1).to_string());
        }
        Table::whole(columns.into_iter().zip(numbers).collect())
    } else {
        let mut cells: Vec<Cell> = Vec::new();
        let mut rows = 0_u32;
        for (number, signals) in segments.iter().enumerate() {
            let mut samples: Vec<(f64, u16, f64)> = Vec::new();
            for (at, signal) in signals.iter().enumerate() {
                samples.extend(signal.iter().map(|(x, y)| (*x, at as u16 + 1, *y)));
            }
            samples.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut before = f64::NAN;
            for (x, at, y) in samples {
                if x != before {
                    rows += 1;
                    cells.push((rows - 1, 0, x));
                    before = x;
                }
                cells.push((rows - 1, at, y));
            }
            words.resize(rows as usize, (number + 1).to_string());
        }
        Table::sparse(columns, rows as usize, cells)
    };
    match segments.len() {
        1 => table,
        _ => table.in_runs("segment", words),
    }
}

/// The factor of the X column, its name and its unit. With a sample time in ms, X is in ms, the sample number, or in
/// 100 ns.
fn time_column(header: &Header, first: &[(f64, f64)]) -> (f64, TableColumn) {
    let column = |name: &str, unit: Option<&str>| TableColumn {
        name: name.to_owned(),
        unit: unit.map(str::to_owned),
    };
    let Some(sample_time_ms) = header.sample_time_ms else {
        return (1.0, column(&header.x, None));
    };
    let mut steps: Vec<f64> = first.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
    let is = |factor: f64| (step * factor / sample_time_ms - 1.0).abs() < 0.1;
    let factor = [1.0, sample_time_ms, FILE_TIME_MS]
        .into_iter()
        .find(|factor| is(*factor));
    match factor {
        Some(factor) => (factor, column("time", Some("ms"))),
        None => (1.0, column(&header.x, None)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn text(log: &str) -> String {
        assert!(is_pairs(log.as_bytes()), "{log}");
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn a_name_over_a_pair_is_the_name_of_its_y() {
        let log =
            "Pos [counts],,Voltage [V],\nX,Y,X,Y\n 0,5, 0,1\n 1,6, 1,1\n 2,7, 2,1\n 3,8, 3,1\n";
        assert_eq!(
            text(log),
            "\"X\",\"Pos [counts]\",\"Voltage [V]\"\n0,5,1\n1,6,1\n2,7,1\n3,8,1\n"
        );
        let other = log.replace(" 2,7, 2,1", " 2,7, 2.5,1");
        assert!(text(&other).contains("2,7,\n2.5,,1\n"), "{}", text(&other));
    }

    #[test]
    fn names_that_end_in_x_and_y_are_pairs() {
        let log = "Pos [counts]_X,Pos [counts]_Y,u_X,u_Y\n0,5,0,1\n1,6,1,1\n2,7,2,1\n3,8,3,1\n";
        let read = "\"X\",\"Pos [counts]\",\"u\"\n0,5,1\n1,6,1\n2,7,1\n3,8,1\n";
        assert_eq!(text(log), read);
        assert_eq!(text(&log.replace("_X", " x").replace("_Y", " y")), read);
        for other in [log.replace("u_X", "v_X"), log.replace("2,7,2,1", "2,7,0,1")] {
            assert!(!is_pairs(other.as_bytes()), "{other}");
        }
    }

    #[test]
    fn sample_times_and_units_of_twincat_are_read() {
        let log = "Name,Scope,,,\nFile,a.svdx,,,\n\nName;Pos;Name;U\nSampleTime[ms];2;SampleTime[ms];2\nUnit;deg;Unit;V\n\n\
                   0;0,5;0;1\n1;0,6;1;1\n2;0,7;2;1\n3;0,8;3;1\n";
        assert_eq!(
            text(log),
            "\"time\",\"Pos\",\"U\"\n0,0.5,1\n2,0.6,1\n4,0.7,1\n6,0.8,1\n"
        );
    }

    #[test]
    fn plain_tables_are_not_recognized() {
        for log in [
            "a,b,c,d\n0,1,2,3\n0,1,2,3\n0,1,2,3\n0,1,2,3\n",
            "X,Y,X,Y\n0,1,2,3\n0,1,2,3\n0,1,2,3\n0,1,2,3\n",
            "t,n\n0,1\n1,2\n2,3\n3,4\n",
        ] {
            assert!(!is_pairs(log.as_bytes()), "{log}");
        }
    }
}
