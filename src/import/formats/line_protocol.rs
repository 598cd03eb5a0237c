//! InfluxDB's line protocol: `motor,id=left pos=3i,pwm=255 1690000000000000000`.
//!
//! Each field is a column; for lines of several series, prefixed by the series.

use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::LineProtocol;
/// Most fields of all series: the range of a cell's column number.
const MOST_FIELDS: usize = 1000;

/// Measurement with its tags, fields, time.
struct Line<'a> {
    series: &'a str,
    fields: Vec<(&'a str, Option<f64>)>,
    time: f64,
}

/// Splits at a byte outside quotes and not escaped by a backslash.
fn cut(text: &str, mark: u8) -> Vec<&str> {
    let (mut parts, mut from, mut is_quoted, mut is_escaped) = (Vec::new(), 0, false, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' => is_escaped = true,
            b'"' => is_quoted = !is_quoted,
            byte if byte == mark && !is_quoted => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[from..]);
    parts
}

fn line(text: &str) -> Option<Line<'_>> {
    let parts = cut(text.trim_end(), b' ');
    let [series, fields, time] = parts.as_slice() else {
        return None;
    };
    let (measurement, tags) = series.split_once(',').unwrap_or((series, ""));
    let is_series = !measurement.is_empty()
        && !measurement.contains('=')
        && (tags.is_empty() || cut(tags, b',').iter().all(|tag| tag.contains('=')));
    let is_time = time.len() >= 10 && time.bytes().all(|byte| byte.is_ascii_digit());
    let fields: Option<Vec<_>> = cut(fields, b',')
        .into_iter()
        .map(|field| {
            let (name, value) = field.split_once('=')?;
            (!name.is_empty() && !value.is_empty()).then(|| (name, number(value)))
        })
        .collect();
    (is_series && is_time).then_some(())?;
    Some(Line {
        series,
        fields: fields?,
        time: time.parse().ok()?,
    })
}

/// A number, an integer with the suffix `i` or `u`, or a truth value; `None` for text.
fn number(value: &str) -> Option<f64> {
    match value {
        "t" | "T" | "true" | "True" | "TRUE" => return Some(1.0),
        "f" | "F" | "false" | "False" | "FALSE" => return Some(0.0),
        _ => {}
    }
    let digits = value.strip_suffix(['i', 'u']).unwrap_or(value);
    digits
        .parse::<f64>()
        .ok()
        .filter(|number| number.is_finite())
}

fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .filter(|line| !line.trim().is_empty() && !line.starts_with('#'))
}

/// Whether the first lines have this format.
pub(super) fn is_line_protocol(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let mut lines = lines(&text);
    let is_one = |text: Option<&str>| text.is_some_and(|text| line(text).is_some());
    is_one(lines.next()) && is_one(lines.next())
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    // The precision is not in the file: the unit of the clock follows from its steps.
    let mut columns = vec![("", "time")];
    let mut samples: Vec<(f64, u16, f64)> = Vec::new();
    for line in lines(&text).filter_map(line) {
        for (name, value) in line.fields {
            let Some(value) = value else { continue };
            let known = (columns.iter().skip(1)).position(|column| *column == (line.series, name));
            let at = known.map_or(columns.len(), |at| at + 1);
            if known.is_none() {
                columns.push((line.series, name));
            }
            samples.push((line.time, at as u16, value));
        }
        if samples.len() > MOST_VALUES || columns.len() > MOST_FIELDS {
            return Err(FORM.too_much("values"));
        }
    }
    let first = columns.get(1).map_or("", |column| column.0);
    let is_one_series = columns.iter().skip(1).all(|column| column.0 == first);
    let named = |&(series, name): &(&str, &str)| {
        let name = name.replace('\\', "");
        TableColumn {
            name: match is_one_series || series.is_empty() {
                true => name,
                false => format!("{} {name}", series.replace('\\', "")),
            },
            unit: None,
        }
    };
    let columns = columns.iter().map(named).collect();
    Ok(Table::by_time(columns, samples))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn text(log: &str) -> String {
        assert!(is_line_protocol(log.as_bytes()), "{log}");
        let mut text = String::new();
        let table = read(log.as_bytes()).expect("a table");
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn fields_are_columns_and_series_are_separate() {
        let log = "motor,id=left pos=3i,pwm=255,mode=\"a b\" 1690000000000000000\nmotor,id=left pos=4i,on=t 1690000000010000000\n";
        assert_eq!(
            text(log),
            "\"time\",\"pos\",\"pwm\",\"on\"\n1.69e18,3,255,\n1.69000000001e18,4,,1\n"
        );
        let two = log.replace("left pos=4i,on=t", "right\\ one pos=4i,on=t");
        assert!(
            text(&two).starts_with("\"time\",\"motor,id=left pos\","),
            "{}",
            text(&two)
        );
    }

    #[test]
    fn labels_of_other_logs_are_not_recognized() {
        for none in [
            "Motor pos=1 pwm=2\nMotor pos=2 pwm=3\n",
            "pos=1,pwm=2 t=3 1690000000\npos=1,pwm=2 t=3 1690000000\n",
            "motor pos=1,pwm=2 5\nmotor pos=1,pwm=2 6\n",
            "",
        ] {
            assert!(!is_line_protocol(none.as_bytes()), "{none}");
        }
    }
}
