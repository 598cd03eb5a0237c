//! Teleplot's lines: `>name:value`, `>name:milliseconds:value`, of its UDP `name:milliseconds:value|g`, with `§unit` behind and several samples between semicolons. MegunoLink's
//! are of the same kind: `{TIMEPLOT|DATA|name|T|value}`.

use super::super::table::{Cell, Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Teleplot;
/// Samples of a board come this far apart in ms: Teleplot's times are in ms, and others' in what makes such steps.
const STEPS_MS: (f64, f64) = (0.2, 900.0);
/// Most signals: what a cell's number of a column holds.
const MOST_SIGNALS: usize = 1000;

/// Whether the first lines are those.
pub(super) fn is_teleplot(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let is_one = |line: Option<&str>| line.is_some_and(|line| signal(line).is_some());
    is_one(lines.next()) && is_one(lines.next())
}

/// Name, unit and samples: time in ms, if stated, and the number.
type Signal<'a> = (&'a str, Option<&'a str>, Vec<(Option<f64>, f64)>);

fn signal(line: &str) -> Option<Signal<'_>> {
    if let Some(rest) = line.strip_prefix("{TIMEPLOT") {
        return megunolink(rest);
    }
    // By UDP the mark is behind.
    let plain = || Some(line).filter(|line| line.ends_with("|g"));
    let line = line.strip_prefix('>').or_else(plain)?;
    let (name, rest) = line.split_once(':')?;
    let rest = rest.split('|').next()?;
    let (samples, unit) = match rest.split_once('§') {
        Some((samples, unit)) => (samples, Some(unit.trim())),
        None => (rest, None),
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let sample = |text: &str| match text.split_once(':') {
        Some((ms, value)) => Some((Some(number(ms)?), number(value)?)),
        None => Some((None, number(text)?)),
    };
    let samples: Option<Vec<_>> = samples.split(';').map(sample).collect();
    samples
        .filter(|_| !name.is_empty())
        .map(|samples| (name.trim(), unit, samples))
}

/// MegunoLink's `{TIMEPLOT|DATA|name:style|T|value}`: `T` is the time of arrival, which is not in the log.
fn megunolink(rest: &str) -> Option<Signal<'_>> {
    let mut parts = rest.strip_suffix('}')?.split('|');
    // The channel, if any.
    parts.next()?;
    let (kind, name, time, value) = (parts.next()?, parts.next()?, parts.next()?, parts.next()?);
    let is_data = matches!(kind.trim(), "DATA" | "D" | "data") && parts.next().is_none();
    let name = name.split(':').next()?.trim();
    let value = value.trim().parse::<f64>().ok().filter(|x| x.is_finite())?;
    (is_data && time.trim() == "T" && !name.is_empty()).then(|| (name, None, vec![(None, value)]))
}

/// Whether the stated times rise as times in ms do; if not, the unit follows from their steps, as for any clock without a unit.
fn is_in_ms(samples: &[(Option<f64>, u16, f64)]) -> bool {
    let times = samples.iter().filter_map(|(ms, _, _)| *ms);
    let mut steps: Vec<f64> = (times.clone().zip(times.skip(1)))
        .map(|(before, after)| after - before)
        .filter(|step| *step > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    let middle = steps.get(steps.len() / 2);
    middle.is_none_or(|step| (STEPS_MS.0..=STEPS_MS.1).contains(step))
}

/// Reads all lines. Without times a row ends where a name is repeated.
pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let mut columns = vec![TableColumn {
        name: "time_ms".to_owned(),
        unit: Some("ms".to_owned()),
    }];
    let mut samples: Vec<(Option<f64>, u16, f64)> = Vec::new();
    for (name, unit, values) in text.lines().filter_map(|line| signal(line.trim())) {
        let known = columns
            .iter()
            .skip(1)
            .position(|column| column.name == name);
        let at = known.map_or(columns.len(), |at| at + 1);
        if known.is_none() {
            columns.push(TableColumn {
                name: name.to_owned(),
                unit: unit.map(str::to_owned),
            });
        }
        samples.extend(values.into_iter().map(|(ms, value)| (ms, at as u16, value)));
        if samples.len() > MOST_VALUES || columns.len() > MOST_SIGNALS {
            return Err(FORM.too_much("values"));
        }
    }
    let has_times = samples.iter().all(|(ms, _, _)| ms.is_some());
    let mut cells: Vec<Cell> = Vec::with_capacity(samples.len());
    let mut rows = 0;
    if has_times {
        samples.sort_by(|a, b| a.0.unwrap_or_default().total_cmp(&b.0.unwrap_or_default()));
        if !is_in_ms(&samples) {
            columns[0].name = "time".to_owned();
            columns[0].unit = None;
        }
        let mut before = None;
        for (ms, at, value) in samples {
            if ms != before {
                rows += 1;
                cells.push((rows - 1, 0, ms.unwrap_or_default()));
                before = ms;
            }
            cells.push((rows - 1, at, value));
        }
        return Ok(Table::sparse(columns, rows as usize, cells));
    }
    columns.remove(0);
    let mut is_filled = vec![true; columns.len()];
    for (_, at, value) in samples {
        let at = at - 1;
        if rows == 0 || is_filled[usize::from(at)] {
            rows += 1;
            is_filled.fill(false);
        }
        is_filled[usize::from(at)] = true;
        cells.push((rows - 1, at, value));
    }
    Ok(Table::sparse(columns, rows as usize, cells))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    fn text(lines: &str) -> String {
        assert!(is_teleplot(lines.as_bytes()), "{lines}");
        let table = read(lines.as_bytes()).expect("a table");
        let mut text = String::new();
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn signals_are_rows() {
        let lines = ">pos:0\n>pwm:5§%\n>pos:1\nboot\n>pwm:6§%\n";
        assert_eq!(text(lines), "\"pos\",\"pwm\"\n0,5\n1,6\n");
        let lines = ">pos:10:0;20:1|np\n>pwm:10:5\n";
        assert_eq!(text(lines), "\"time_ms\",\"pos\",\"pwm\"\n10,0,5\n20,1,\n");
        let seconds = ">pos:5.00:0\n>pos:5.01:1\n>pos:5.02:2\n";
        assert_eq!(text(seconds), "\"time\",\"pos\"\n5,0\n5.01,1\n5.02,2\n");
        let of_udp = "pos:10:0|g\npwm:10:5|g\npos:20:1|g\n";
        assert_eq!(text(of_udp), "\"time_ms\",\"pos\",\"pwm\"\n10,0,5\n20,1,\n");
        assert!(!is_teleplot(b"> pos\n") && !is_teleplot(b"pos:1\npos:2\n"));
        let lines = "{TIMEPLOT|DATA|pos|T|0}\n{TIMEPLOT:Motor|D|pwm:b|T|-5.5}\nboot\n{TIMEPLOT|DATA|pos|T|1}\n{TIMEPLOT|DATA|pwm|T|6}\n";
        assert_eq!(text(lines), "\"pos\",\"pwm\"\n0,-5.5\n1,6\n");
    }
}
