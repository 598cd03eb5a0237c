//! Columns from memory into a run: they go the way of an imported log, so that names, units, integration and messages are its own.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Cursor;

use motorlab::hint::Hinted;
use motorlab::import::{
    GivenFlags, HEAD_BYTES, Imported, Unclear, Understood, import, is_spelling_of, understand,
};
use motorlab::recording::{Run, read_run};
use pyo3::prelude::*;

use crate::failure::{refused, refused_of};

/// Name of the frame in messages.
const NAME: &str = "frame";

/// The numbers of a column. Missing values are NaN.
#[derive(Debug, Clone)]
pub(crate) enum Numbers {
    Floats(Vec<f64>),
    Wholes(Vec<i64>),
}

/// A column of a frame.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) numbers: Numbers,
    /// The unit, where the column's type has one: of time stamps and durations.
    pub(crate) unit: Option<&'static str>,
}

impl Column {
    /// Takes the first time stamp off: nanoseconds since 1970 are more than a float holds.
    fn begin_at_first_stamp(&mut self) {
        if self.unit.is_none() {
            return;
        }
        match &mut self.numbers {
            Numbers::Wholes(stamps) => {
                let first = stamps.first().copied().unwrap_or(0);
                (stamps.iter_mut()).for_each(|stamp| *stamp = stamp.saturating_sub(first));
            }
            Numbers::Floats(stamps) => {
                let first = stamps.iter().copied().find(|stamp| !stamp.is_nan());
                let first = first.unwrap_or(0.0);
                stamps.iter_mut().for_each(|stamp| *stamp -= first);
            }
        }
    }
}

impl Numbers {
    fn len(&self) -> usize {
        match self {
            Self::Floats(numbers) => numbers.len(),
            Self::Wholes(numbers) => numbers.len(),
        }
    }

    fn write(&self, row: usize, text: &mut String) {
        // Writing to a string does not fail.
        let _ = match self {
            Self::Wholes(numbers) => write!(text, "{}", numbers[row]),
            Self::Floats(numbers) => match numbers[row] {
                number if number.is_nan() => Ok(()),
                number if number == 0.0 || (1e-5..1e16).contains(&number.abs()) => {
                    write!(text, "{number}")
                }
                number => write!(text, "{number:e}"),
            },
        };
    }
}

/// Facts about a frame: the flags of `motorlab import` as keywords, with `units` by column.
#[derive(Debug, Default, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Keywords {
    time: Option<String>,
    command: Option<String>,
    command_limit: Option<f64>,
    direction: Option<String>,
    position: Option<String>,
    speed: Option<String>,
    integrate: Option<String>,
    current: Option<String>,
    supply_v: Option<String>,
    counts_per_rev: Option<f64>,
    m_per_rev: Option<f64>,
    pwm_full: Option<f64>,
    wrap: Option<f64>,
    increments: bool,
    reverse: bool,
    unsigned: Option<bool>,
    every: Option<u64>,
    units: BTreeMap<String, String>,
}

/// A run made of columns, and what was understood and left out.
pub(crate) fn run_of(
    py: Python<'_>,
    mut columns: Vec<Column>,
    keywords: Keywords,
) -> PyResult<(Run, Vec<String>)> {
    columns.iter_mut().for_each(Column::begin_at_first_stamp);
    let lengths: Vec<usize> = columns.iter().map(|column| column.numbers.len()).collect();
    if let Some(other) = lengths.iter().position(|length| *length != lengths[0]) {
        return Err(refused(
            py,
            Hinted::new(
                format!(
                    "{NAME}: column `{}` has {} rows, column `{}` has {}",
                    columns[0].name, lengths[0], columns[other].name, lengths[other]
                ),
                "all columns of a frame have one length: leave out or fill what is missing",
            ),
        ));
    }
    let made = py.detach(|| made(&columns, &keywords));
    made.map_err(|error| refused_of(py, error))
}

type Problem = Box<dyn std::error::Error + Send + Sync>;

fn made(columns: &[Column], keywords: &Keywords) -> Result<(Run, Vec<String>), Problem> {
    let (given, units) = keywords.given(columns)?;
    let text = text_of(columns, &units);
    let head = &text.as_bytes()[..text.len().min(HEAD_BYTES as usize)];
    let is_whole = head.len() == text.len();
    let reading = understand(head, is_whole, NAME, &given, NAME);
    keywords.check_units(columns, &reading.understood)?;
    let ready = reading.map.map_err(|unclear| match unclear {
        Unclear::Missing { missing, flags, .. } => {
            let asked = missing.iter().map(|one| {
                let (flag, value) = one.flag.split_once(' ').unwrap_or((&one.flag, ""));
                format!("  {}  {}\n", keyword(flag, value), one.why)
            });
            let keywords: Vec<String> = (flags.iter())
                .map(|(flag, value)| keyword(flag, value))
                .collect();
            format!(
                "{NAME} lacks:\n{}hint: complete call:\n  Run.from_frame(frame, {})",
                asked.collect::<String>(),
                keywords.join(", ")
            )
        }
        unclear => format!("{NAME}: {unclear}"),
    })?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("frame.run.csv");
    let imported = import(Cursor::new(text), NAME, &ready.map, &path)?;
    if imported.runs.len() > 1 {
        return Err(Hinted::new(
            format!(
                "{NAME}: its time restarts within, so that it holds {} runs",
                imported.runs.len()
            ),
            "make a run of each part",
        )
        .into());
    }
    if let (Some(why), true) = (left_out(&imported), 2 * imported.bad_rows > imported.rows) {
        let hint =
            "correct the rows, or name the columns and units yourself: time=, position=, command=";
        return Err(Hinted::new(format!("{NAME}: {why}"), hint).into());
    }
    let (mut run, _) = read_run(&imported.runs[0].path)?;
    run.path = None;
    let understood = reading.understood.iter();
    let mut notes: Vec<String> = understood
        .map(|one| format!("{}: {}", one.what, one.words))
        .collect();
    notes.extend(reading.notes);
    notes.extend(left_out(&imported));
    Ok((run, notes))
}

fn left_out(imported: &Imported) -> Option<String> {
    let first = imported.first_bad.first()?;
    // Row 0 of a frame is line 2 of its text.
    let row = first.line.saturating_sub(2);
    Some(format!(
        "{} of {} rows cannot be used and were left out; the first is row {row}: {}",
        imported.bad_rows, imported.rows, first.why
    ))
}

impl Keywords {
    /// Every unit is of a column that is there, and is the one that the column was understood in.
    fn check_units(&self, columns: &[Column], understood: &[Understood]) -> Result<(), Problem> {
        for (column, unit) in &self.units {
            if !columns.iter().any(|one| one.name == *column) {
                let all: Vec<&str> = columns.iter().map(|one| one.name.as_str()).collect();
                return Err(Hinted::new(
                    format!("{NAME}: units has `{column}`, and there is no such column"),
                    format!("the columns are {}", all.join(", ")),
                )
                .into());
            }
            let name = format!("{} [{unit}]", named(column));
            let used = (understood.iter())
                .find(|one| one.column.as_ref() == Some(&name))
                .and_then(|one| Some((one.what, one.unit.as_ref()?)));
            if let Some((what, used)) = used
                && !is_spelling_of(unit, used)
            {
                return Err(Hinted::new(
                    format!(
                        "{NAME}: units has `{unit}` for `{column}`, which is no unit of a {what}"
                    ),
                    format!(
                        "by its name it is in {used}; correct units, or leave the column out of it"
                    ),
                )
                .into());
            }
        }
        Ok(())
    }

    /// As flags, with each unit at its column; also the units of columns that no flag names.
    fn given(&self, columns: &[Column]) -> Result<(GivenFlags, BTreeMap<String, String>), Problem> {
        let mut units = self.units.clone();
        for column in columns {
            if let Some(unit) = column.unit {
                let of = units.entry(column.name.clone());
                of.or_insert_with(|| unit.to_owned());
            }
        }
        let all = units.clone();
        let mut with_unit = |column: &Option<String>| {
            let column = column.as_ref()?;
            let is_there = |name: &str| columns.iter().any(|one| one.name == name);
            // A unit may stand behind the name.
            let (name, unit) = match column.rsplit_once(':') {
                Some((name, unit)) if !is_there(column) && is_there(name) => (name, Some(unit)),
                _ => (column.as_str(), None),
            };
            units.remove(name);
            let unit = unit.or(all.get(name).map(String::as_str));
            let name = match is_there(name) {
                true => named(name),
                false => name.to_owned(),
            };
            Some(match unit {
                Some(unit) => format!("{name}:{unit}"),
                None => name,
            })
        };
        let given = GivenFlags {
            time: with_unit(&self.time),
            command: with_unit(&self.command),
            command_limit: self.command_limit,
            direction: self.direction.clone(),
            position: with_unit(&self.position),
            speed: with_unit(&self.speed),
            integrate: self.integrate.as_deref().map(str::parse).transpose()?,
            current: with_unit(&self.current),
            supply: with_unit(&self.supply_v),
            counts_per_rev: self.counts_per_rev,
            m_per_rev: self.m_per_rev,
            pwm_full: self.pwm_full,
            wrap: self.wrap,
            increments: self.increments,
            reverse: self.reverse,
            unsigned: self.unsigned,
            every: self.every,
            runs: None,
        };
        Ok((given, units))
    }
}

/// The name of a column in the text: a log's columns go by numbers too, so that a number for a name needs a word.
fn named(name: &str) -> String {
    match name.parse::<f64>() {
        Ok(_) => format!("column {name}"),
        Err(_) => name.to_owned(),
    }
}

/// The frame as the text of a log, its units in brackets behind the names.
fn text_of(columns: &[Column], units: &BTreeMap<String, String>) -> String {
    let rows = columns.first().map_or(0, |column| column.numbers.len());
    let mut text = String::with_capacity(24 * columns.len() * (rows + 1));
    let names = columns.iter().map(|column| {
        let name = match units.get(&column.name) {
            Some(unit) => format!("{} [{unit}]", named(&column.name)),
            None => named(&column.name),
        };
        format!(
            "\"{}\"",
            name.replace('"', "\"\"").replace(['\n', '\r'], " ")
        )
    });
    text.push_str(&names.collect::<Vec<_>>().join("\t"));
    text.push('\n');
    for row in 0..rows {
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                text.push('\t');
            }
            column.numbers.write(row, &mut text);
        }
        text.push('\n');
    }
    text
}

/// A flag of the command line as a keyword of `from_frame`.
fn keyword(flag: &str, value: &str) -> String {
    let name = match flag.trim_start_matches('-') {
        "supply" => "supply_v".to_owned(),
        "unsigned=false" => return "unsigned=False".to_owned(),
        name => name.replace('-', "_"),
    };
    let is_number = value.parse::<f64>().is_ok();
    let is_to_be_filled_in = !value.is_empty() && value.chars().all(|c| c.is_ascii_uppercase());
    match value {
        "" => format!("{name}=True"),
        value if is_number || is_to_be_filled_in => format!("{name}={value}"),
        value => format!("{name}={value:?}"),
    }
}
