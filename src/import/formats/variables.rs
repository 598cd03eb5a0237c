//! Variables of a workspace: those of equal length are the columns of a table; series have a separate time.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::super::table::{Table, TableColumn};
use super::signals::Signals;
use super::{Form, FormatError, MOST_VALUES};

/// Most columns of a matrix that become columns of the table.
pub(super) const MOST_OF_A_MATRIX: usize = 64;
/// Most characters of a name; a table keeps fewer.
const MOST_NAME: usize = 256;
/// Most names of omitted variables in a message.
const MOST_LISTED: usize = 8;
/// `tout`, Simulink's time in s.
const SIMULINK_TIME: &str = "tout";
/// Remedy for an unsupported object.
const REMEDY: &str = "in MATLAB save the vectors of each: t = x.Time; y = x.Data; save log.mat t y";

/// A column and its numbers.
type Column = (TableColumn, Vec<f64>);

/// Named vectors.
#[derive(Debug)]
pub(super) struct Variables {
    form: Form,
    vectors: Vec<Column>,
    /// Times in s, each with its columns.
    series: Vec<(Vec<f64>, Vec<Column>)>,
    /// Index of the series by its times, bitwise.
    by_time: HashMap<Vec<u64>, usize>,
    /// Names of the columns of series.
    names: HashSet<String>,
    /// Unsupported variables with their kind: the first ones, and their number.
    not_read: (Vec<String>, usize),
    /// Whether objects are among them.
    has_objects: bool,
}

impl Variables {
    pub fn new(form: Form) -> Self {
        Self {
            form,
            vectors: Vec::new(),
            series: Vec::new(),
            by_time: HashMap::new(),
            names: HashSet::new(),
            not_read: (Vec::new(), 0),
            has_objects: false,
        }
    }

    /// Whether a column of a series has this name.
    pub fn has(&self, name: &str) -> bool {
        self.names.contains(name)
    }

    /// A matrix in column-major order. A row or column vector is one column; the longer side of a matrix is time.
    pub fn push(&mut self, name: &str, rows: usize, columns: usize, numbers: &[f64]) {
        let length = rows.max(columns);
        let count = rows.min(columns);
        if length < 2 || numbers.len() != length.saturating_mul(count) {
            return;
        }
        if count == 1 {
            let unit = (name.rsplit('.').next() == Some(SIMULINK_TIME)).then_some("s");
            self.vector(name, unit, numbers.to_vec());
            return;
        }
        if count > MOST_OF_A_MATRIX {
            self.leave(name, &format!("a matrix of {rows} by {columns}"));
            return;
        }
        for at in 0..count {
            let (part, column) = match rows >= columns {
                true => (
                    format!("{name}(:,{})", at + 1),
                    numbers[at * rows..(at + 1) * rows].to_vec(),
                ),
                false => (
                    format!("{name}({},:)", at + 1),
                    numbers.iter().skip(at).step_by(rows).copied().collect(),
                ),
            };
            self.vector(&part, None, column);
        }
    }

    /// Times in s.
    pub fn push_time(&mut self, name: &str, time_s: Vec<f64>) {
        if time_s.len() > 1 {
            self.vector(name, Some("s"), time_s);
        }
    }

    fn vector(&mut self, name: &str, unit: Option<&str>, numbers: Vec<f64>) {
        let (name, unit) = (short(name), unit.map(str::to_owned));
        self.vectors.push((TableColumn { name, unit }, numbers));
    }

    /// Columns with their time in s.
    pub fn push_series(&mut self, time_s: &[f64], mut columns: Vec<Column>) {
        for (column, _) in &mut columns {
            column.name = short(&column.name);
            if self.names.contains(&column.name) {
                column.name = format!("{} ({})", column.name, self.names.len() + 1);
            }
            self.names.insert(column.name.clone());
        }
        let at = *self
            .by_time
            .entry(bits(time_s))
            .or_insert(self.series.len());
        match self.series.get_mut(at) {
            Some((_, others)) => others.append(&mut columns),
            None => self.series.push((time_s.to_vec(), columns)),
        }
    }

    /// An unsupported object: its class, and the reason.
    pub fn object_not_read(&mut self, name: &str, class: &str) {
        self.has_objects = true;
        self.leave(name, &format!("an object of class {class}"));
    }

    fn leave(&mut self, name: &str, what: &str) {
        let (listed, count) = &mut self.not_read;
        *count += 1;
        if *count <= MOST_LISTED {
            listed.push(format!("{} ({})", short(name), short(what)));
        }
    }

    /// Text about unsupported objects with the remedy; empty without any.
    fn not_read_words(&self) -> String {
        let (listed, count) = &self.not_read;
        let mut text = all_of(listed, *count);
        if self.has_objects {
            text.push_str("; ");
            text.push_str(REMEDY);
        }
        text
    }

    /// The series by their time; without any, the vectors of the most frequent length.
    pub fn table(mut self) -> Result<Table, FormatError> {
        let not_read = self.not_read_words();
        // A vector equal to the time of a series is redundant.
        let times = &self.by_time;
        self.vectors
            .retain(|(_, numbers)| times.is_empty() || !times.contains_key(&bits(numbers)));
        let mut table = match self.series.len() {
            0 => self.of_vectors(&not_read)?,
            1 => self.of_one_time(),
            _ => self.of_many_times()?,
        };
        if !not_read.is_empty() {
            table.notes.push(format!("not read: {not_read}"));
        }
        Ok(table)
    }

    fn of_vectors(self, not_read: &str) -> Result<Table, FormatError> {
        let mut lengths: BTreeMap<usize, usize> = BTreeMap::new();
        for (_, numbers) in &self.vectors {
            *lengths.entry(numbers.len()).or_default() += 1;
        }
        let best = lengths
            .iter()
            .max_by_key(|(length, count)| (**count, **length));
        let Some((&length, &count)) = best.filter(|(_, count)| **count >= 2) else {
            let there = match (self.vectors.is_empty(), not_read.is_empty()) {
                (false, true) => "no two of its variables have one length".to_owned(),
                (true, true) => "it has no vectors".to_owned(),
                (_, false) => format!("of its variables are not read: {not_read}"),
            };
            return Err(self.form.nothing(&there));
        };
        if length.saturating_mul(count) > MOST_VALUES {
            return Err(self.form.too_much("values"));
        }
        let (kept, rest): (Vec<_>, Vec<_>) = self
            .vectors
            .into_iter()
            .partition(|(_, numbers)| numbers.len() == length);
        let mut table = Table::whole(kept);
        if !rest.is_empty() {
            table.notes.push(format!(
                "the {count} variables of {length} values are read; of another length: {}",
                listed(&rest)
            ));
        }
        Ok(table)
    }

    /// The series of one time, and the vectors of its length.
    fn of_one_time(&mut self) -> Table {
        let (time_s, columns) = self.series.remove(0);
        let (mut kept, rest): (Vec<_>, Vec<_>) = std::mem::take(&mut self.vectors)
            .into_iter()
            .partition(|(_, numbers)| numbers.len() == time_s.len());
        let mut all = vec![(seconds(), time_s)];
        all.extend(columns);
        all.append(&mut kept);
        let mut table = Table::whole(all);
        if !rest.is_empty() {
            let rest = listed(&rest);
            table
                .notes
                .push(format!("of another length than the series: {rest}"));
        }
        table
    }

    /// One row for every time with a value of a series.
    fn of_many_times(&mut self) -> Result<Table, FormatError> {
        let mut signals = Signals::new(self.form);
        for (time_s, columns) in std::mem::take(&mut self.series) {
            for (column, numbers) in columns {
                let signal = signals.signal(&column.name, column.unit.as_deref())?;
                for (time_s, number) in time_s.iter().zip(numbers) {
                    signals.push((time_s * 1e9).round() as i64, signal, number)?;
                }
            }
        }
        let times = self.by_time.len();
        signals.notes.push(format!(
            "its series have {times} different times: a row for every time at which one has a value"
        ));
        if !self.vectors.is_empty() {
            let rest = listed(&self.vectors);
            signals.notes.push(format!("without a time: {rest}"));
        }
        Ok(signals.table())
    }
}

/// The column of time.
fn seconds() -> TableColumn {
    TableColumn {
        name: "time".to_owned(),
        unit: Some("s".to_owned()),
    }
}

/// Numbers by their bits, for comparison.
fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

fn short(name: &str) -> String {
    name.chars().take(MOST_NAME).collect()
}

/// The first columns with their lengths, and the number of others.
fn listed(columns: &[Column]) -> String {
    let first = columns.iter().take(MOST_LISTED);
    let names: Vec<String> = first
        .map(|(column, numbers)| format!("{} ({} values)", column.name, numbers.len()))
        .collect();
    all_of(&names, columns.len())
}

fn all_of(names: &[String], count: usize) -> String {
    let mut list = names.join(", ");
    if count > names.len() {
        list.push_str(&format!(" and {} more", count - names.len()));
    }
    list
}
