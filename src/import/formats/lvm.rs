//! LabVIEW's measurement files (LVM): a header of keys, `***End_of_Header***`, a line of names from `X_Value` on,
//! rows. With `X_Columns No` the times are `X0 + k Delta_X`; with `Multi` each signal has an `X_Value`.

use super::super::cells::{Cells, Separator, number};
use super::super::table::{Table, TableColumn};
use super::pairs::{Signal, table};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Lvm;
/// First bytes of an LVM file.
pub(super) const MAGIC: &[u8] = b"LabVIEW Measurement";

/// A part of the file: its columns, and the times unless they are in one.
#[derive(Default)]
struct Segment {
    /// `X_Columns`: `No`, `One` or `Multi`.
    x: String,
    x0: f64,
    delta_x: f64,
    units: Vec<String>,
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

/// Reads all segments; each of several is a run.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let value = |key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key))?;
        line.chars().nth(1)
    };
    let separator = Separator::Byte(match value("Separator") {
        Some('C') => b',',
        _ => b'\t',
    });
    let decimal_comma = value("Decimal_Separator") == Some(',');
    let mut cells = Cells::default();
    let mut segments = vec![Segment::default()];
    let mut values = 0;
    for line in text.lines() {
        cells.split(line.as_bytes(), separator);
        let numbers = |at: usize| number(cells.get(at), decimal_comma, "").unwrap_or(f64::NAN);
        let Some(segment) = segments.last_mut() else {
            break;
        };
        match &*cells.text(0) {
            "Channels" if !segment.names.is_empty() => segments.push(Segment::default()),
            "X_Columns" => segment.x = cells.text(1).into_owned(),
            "X0" => segment.x0 = numbers(1),
            "Delta_X" => segment.delta_x = numbers(1),
            "Y_Unit_Label" => {
                segment.units = (1..cells.len())
                    .map(|at| cells.text(at).into_owned())
                    .collect();
            }
            "X_Value" => {
                let names = (0..cells.len()).map(|at| cells.text(at).into_owned());
                segment.names = names.filter(|name| name != "Comment").collect();
            }
            key if segment.names.is_empty() || key.starts_with("***") => {}
            _ => {
                let row: Vec<f64> = (0..segment.names.len()).map(numbers).collect();
                if row.iter().any(|number| number.is_finite()) {
                    values += row.len();
                    segment.rows.push(row);
                }
            }
        }
        if values > MOST_VALUES {
            return Err(FORM.too_much("values"));
        }
    }
    segments.retain(|segment| !segment.rows.is_empty());
    // `X_Columns` is stated once, above all segments.
    let x = segments
        .first()
        .map(|segment| segment.x.clone())
        .unwrap_or_default();
    if segments.is_empty() {
        return Err(FORM.nothing(""));
    }
    Ok(match x.as_str() {
        "Multi" => table(time(), names_of(&segments[0], 2), &signals(&segments)),
        _ => of_one_x(&segments, x == "No"),
    })
}

fn time() -> TableColumn {
    TableColumn {
        name: "time".to_owned(),
        unit: Some("s".to_owned()),
    }
}

/// Names and units of the signals, which are every `step`th column from the second on. Units are in the signals'
/// columns, or consecutive.
fn names_of(segment: &Segment, step: usize) -> Vec<TableColumn> {
    let signals: Vec<usize> = (1..segment.names.len()).step_by(step).collect();
    let is_dense = segment.units.iter().filter(|unit| !unit.is_empty()).count() == signals.len()
        && segment
            .units
            .iter()
            .take(signals.len())
            .all(|unit| !unit.is_empty());
    let unit = |(k, at): (usize, usize)| {
        let unit = segment.units.get(if is_dense { k } else { at - 1 });
        unit.cloned().filter(|unit| !unit.is_empty())
    };
    let named = |(k, &at): (usize, &usize)| TableColumn {
        name: segment.names[at].clone(),
        unit: unit((k, at)),
    };
    signals.iter().enumerate().map(named).collect()
}

/// The signals of each segment with their X.
fn signals(segments: &[Segment]) -> Vec<Vec<Signal>> {
    let count = segments.first().map_or(0, |first| first.names.len() / 2);
    let signal = |segment: &Segment, at: usize| -> Signal {
        let sample = |row: &Vec<f64>| Some((*row.get(2 * at)?, *row.get(2 * at + 1)?));
        let is_whole = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        segment
            .rows
            .iter()
            .filter_map(sample)
            .filter(is_whole)
            .collect()
    };
    let of_segment = |segment: &Segment| (0..count).map(|at| signal(segment, at)).collect();
    segments.iter().map(of_segment).collect()
}

/// Segments with one X for all signals, or none, where the rows are a sample time apart (`is_counted`).
fn of_one_x(segments: &[Segment], is_counted: bool) -> Table {
    let names = std::iter::once(time()).chain(names_of(&segments[0], 1));
    let mut columns: Vec<(TableColumn, Vec<f64>)> = names.map(|name| (name, Vec::new())).collect();
    let mut runs = Vec::new();
    for (number, segment) in segments.iter().enumerate() {
        for (row, cells) in segment.rows.iter().enumerate() {
            for (at, (_, column)) in columns.iter_mut().enumerate() {
                column.push(match at {
                    0 if is_counted => segment.x0 + row as f64 * segment.delta_x,
                    _ => cells.get(at).copied().unwrap_or(f64::NAN),
                });
            }
            runs.push((number + 1).to_string());
        }
    }
    let table = Table::whole(columns);
    match segments.len() {
        1 => table,
        _ => table.in_runs("segment", runs),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    const HEADER: &str = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tXS\n\
                          ***End_of_Header***\t\n\t\n";
    const SEGMENT: &str = "Channels\t2\t\nSamples\t3\t3\t\nY_Unit_Label\tV\trpm\t\nX0\t1,0E+0\t1,0E+0\t\n\
                           Delta_X\t0,010000\t0,010000\t\n***End_of_Header***\t\t\t\nX_Value\tU\tn\tComment\n";

    fn text(x: &str, segments: &[&str]) -> String {
        let mut log = HEADER.replace("XS", x);
        for rows in segments {
            log += &format!("{SEGMENT}{rows}\n");
        }
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn rows_and_their_times_are_read() {
        let found = text("One", &["0,5\t6,0\t0\n0,6\t6,0\t8\n"]);
        assert_eq!(found, "\"time\",\"U\",\"n\"\n0.5,6,0\n0.6,6,8\n");
        let found = text("No", &["\t6,0\t0\n\t6,0\t8\n", "\t1,0\t2\n"]);
        assert_eq!(
            found,
            "\"time\",\"U\",\"n\",\"segment\"\n1,6,0,1\n1.01,6,8,1\n1,1,2,2\n"
        );
    }

    /// As LabVIEW writes it: units above the signals, not above their X; the second signal at half the rate in a
    /// shorter column.
    #[test]
    fn each_signal_has_its_own_x() {
        let segment = "Channels\t2\t\t\t\nY_Unit_Label\tV\t\trpm\t\nX0\t0\t\t0\t\n***End_of_Header***\t\t\t\t\n\
                       X_Value\tU\tX_Value\tn\tComment\n";
        let multi = |rows: &str| HEADER.replace("XS", "Multi") + segment + rows;
        let read = |log: &str| {
            let mut text = String::new();
            let table = read(log.as_bytes()).expect("a table");
            let units: Vec<_> = table.columns.iter().map(|one| one.unit.clone()).collect();
            let of_signals = ["s", "V", "rpm"].map(|unit| Some(unit.to_owned()));
            assert_eq!(units, of_signals);
            table.text().read_to_string(&mut text).expect("memory");
            text
        };
        let log = multi("0,0\t6,0\t0,0\t1,5\n0,1\t7,0\t0,2\t2,5\n0,2\t8,0\t\t\n");
        let two_rates = "\"time\",\"U\",\"n\"\n0,6,1.5\n0.1,7,\n0.2,8,2.5\n";
        assert_eq!(read(&log), two_rates);
        assert_eq!(read(&log.replace("V\t\trpm", "V\trpm\t")), two_rates);
        let log = multi("0,0\t6,0\t0,0\t1,5\n") + segment + "0,0\t7,0\t0,0\t2,5\n";
        let two_runs = "\"time\",\"U\",\"n\",\"segment\"\n0,6,1.5,1\n0,7,2.5,2\n";
        assert_eq!(read(&log), two_runs);
    }
}
