//! Long tables: one row per value, with a column of signal names. InfluxDB's CSV (`_time,_field,_value`), Grafana's,
//! Home Assistant's and Foxglove's, and pandas' melted tables.

use super::super::cells::{Cells, Separator, number};
use super::super::stamp::stamp;
use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Long;
/// Names of the column of signal names.
const SIGNALS: [&str; 14] = [
    "_field",
    "field",
    "signal",
    "signal_name",
    "variable",
    "channel",
    "metric",
    "series",
    "entity_id",
    "topic",
    "sensor",
    "tag",
    "name",
    "parameter",
];
/// Names of the column of values.
const VALUES: [&str; 6] = ["_value", "value", "values", "state", "val", "reading"];
/// Names of the column of times, the best first.
const TIMES: [&str; 12] = [
    "_time",
    "elapsed",
    "receive time",
    "receive_time",
    "time",
    "timestamp",
    "t",
    "time_s",
    "time_ms",
    "time_us",
    "last_changed",
    "datetime",
];
/// Fewest signals.
const LEAST_SIGNALS: usize = 2;
/// Most signals: a column of words has more.
const MOST_SIGNALS: usize = 200;
/// Most lines above the names.
const BANNER_LINES: usize = 40;

/// Indices of the three columns.
struct Layout {
    separator: Separator,
    time: usize,
    signal: usize,
    value: usize,
    time_name: String,
    columns: usize,
}

fn layout(line: &str) -> Option<Layout> {
    [b'\t', b';', b','].into_iter().find_map(|byte| {
        let separator = Separator::Byte(byte);
        let mut cells = Cells::default();
        cells.split(line.as_bytes(), separator);
        let names: Vec<String> = (0..cells.len())
            .map(|at| cells.text(at).to_lowercase())
            .collect();
        let find = |list: &[&str]| {
            list.iter()
                .find_map(|known| names.iter().position(|name| name == known))
        };
        let (time, signal, value) = (find(&TIMES)?, find(&SIGNALS)?, find(&VALUES)?);
        Some(Layout {
            separator,
            time,
            signal,
            value,
            time_name: cells.text(time).into_owned(),
            columns: cells.len(),
        })
    })
}

/// Time, signal and number of each value.
fn values<'a>(text: &'a str, layout: &'a Layout) -> impl Iterator<Item = (f64, String, f64)> + 'a {
    let mut cells = Cells::default();
    let is_comma = layout.separator != Separator::Byte(b',');
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(move |line| {
            cells.split(line.as_bytes(), layout.separator);
            let read = |at: usize| {
                let cell = cells.get(at);
                number(cell, is_comma, "")
                    .ok()
                    .or_else(|| stamp(cell).map(|stamp| stamp.s))
            };
            let signal = cells.text(layout.signal).into_owned();
            let is_word = !signal.is_empty() && number(signal.as_bytes(), is_comma, "").is_err();
            let is_row = cells.len() == layout.columns && is_word;
            is_row.then_some(())?;
            Some((read(layout.time)?, signal, read(layout.value)?))
        })
}

fn found(text: &str) -> Option<Layout> {
    text.lines()
        .take(BANNER_LINES)
        .filter(|line| !line.starts_with('#'))
        .find_map(layout)
}

/// Whether a text has this format.
pub(super) fn is_long(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    found(&text).is_some_and(|layout| values(&text, &layout).nth(LEAST_SIGNALS).is_some())
}

/// Reads it into one column per signal.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let layout = found(&text).ok_or_else(|| FORM.nothing(""))?;
    let named = |name: &str| TableColumn {
        name: name.to_owned(),
        unit: None,
    };
    let mut columns = vec![named(&layout.time_name)];
    let mut samples: Vec<(f64, u16, f64)> = Vec::new();
    for (time, signal, value) in values(&text, &layout) {
        let known = columns
            .iter()
            .skip(1)
            .position(|column| column.name == signal);
        let at = known.map_or(columns.len(), |at| at + 1);
        if known.is_none() {
            columns.push(named(&signal));
        }
        samples.push((time, at as u16, value));
        if samples.len() > MOST_VALUES || columns.len() > MOST_SIGNALS {
            return Err(FORM.too_much("values"));
        }
    }
    let is_stamps = text.lines().filter_map(|line| {
        let mut cells = Cells::default();
        cells.split(line.as_bytes(), layout.separator);
        stamp(cells.get(layout.time))
    });
    if is_stamps.take(LEAST_SIGNALS).count() == LEAST_SIGNALS {
        columns[0].unit = Some("s".to_owned());
    }
    Ok(Table::by_time(columns, samples))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn text(log: &str) -> String {
        assert!(is_long(log.as_bytes()), "{log}");
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn every_signal_is_a_column() {
        let log = "time_s,signal,value\n0,counts,0\n0,voltage,6\n0.01,counts,3\n0.01,voltage,6\n";
        assert_eq!(
            text(log),
            "\"time_s\",\"counts\",\"voltage\"\n0,0,6\n0.01,3,6\n"
        );
        let influx = "#group,false\n#datatype,string\n,result,table,_time,_value,_field\n,,0,1970-01-01T00:00:00.5Z,3,pos\n\
                      ,,0,1970-01-01T00:00:01Z,4,pos\n\n,result,table,_time,_value,_field\n,,1,1970-01-01T00:00:00.5Z,6,voltage\n";
        assert_eq!(
            text(influx),
            "\"_time\",\"pos\",\"voltage\"\n0.5,3,6\n1,4,\n"
        );
    }

    #[test]
    fn tables_with_a_column_of_words_are_not_recognized() {
        for none in [
            "time,name,value\n0,1,2\n1,2,3\n2,3,4\n3,4,5\n",
            "time,mode,counts\n0,a,2\n1,b,3\n2,a,4\n3,b,5\n",
            "",
        ] {
            assert!(!is_long(none.as_bytes()), "{none}");
        }
    }
}
