//! Signals with separate times: one row for every time with a value.

use std::collections::HashMap;

use super::super::table::{Cell, Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

/// Most signals of a log; more than any robot's.
const MOST_SIGNALS: usize = 20_000;

#[derive(Debug)]
pub(super) struct Signals {
    form: Form,
    columns: Vec<TableColumn>,
    by_name: HashMap<String, u16>,
    /// Time in ns, signal, value; in order of arrival.
    values: Vec<(i64, u16, f64)>,
    pub notes: Vec<String>,
}

impl Signals {
    pub fn new(form: Form) -> Self {
        let time = TableColumn {
            name: "time".to_owned(),
            unit: Some("s".to_owned()),
        };
        Self {
            form,
            columns: vec![time],
            by_name: HashMap::new(),
            values: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// The signal of this name.
    pub fn signal(&mut self, name: &str, unit: Option<&str>) -> Result<u16, FormatError> {
        if let Some(at) = self.by_name.get(name) {
            return Ok(*at);
        }
        let at = self.columns.len();
        if at >= MOST_SIGNALS {
            return Err(self
                .form
                .broken(format!("more than {MOST_SIGNALS} signals")));
        }
        let at = at as u16;
        self.columns.push(TableColumn {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
        });
        self.by_name.insert(name.to_owned(), at);
        Ok(at)
    }

    /// One value.
    pub fn push(&mut self, time_ns: i64, signal: u16, value: f64) -> Result<(), FormatError> {
        if !value.is_finite() {
            return Ok(());
        }
        if self.values.len() >= MOST_VALUES {
            return Err(self.form.too_much("values"));
        }
        self.values.push((time_ns, signal, value));
        Ok(())
    }

    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The table: time in s relative to the first value. Of two values of a signal at one time the later is used.
    pub fn table(mut self) -> Table {
        self.values.sort_by_key(|(time_ns, _, _)| *time_ns);
        let first_ns = self.values.first().map_or(0, |(time_ns, _, _)| *time_ns);
        let mut cells: Vec<Cell> = Vec::with_capacity(self.values.len() + self.values.len() / 2);
        let mut row = 0_u32;
        let mut before: Option<i64> = None;
        for (time_ns, signal, value) in &self.values {
            if before.is_none_or(|before| before != *time_ns) {
                row += u32::from(before.is_some());
                before = Some(*time_ns);
                cells.push((row, 0, time_ns.wrapping_sub(first_ns) as f64 / 1e9));
            }
            cells.push((row, *signal, *value));
        }
        let rows = before.map_or(0, |_| row as usize + 1);
        let mut table = Table::sparse(self.columns, rows, cells);
        table.notes.extend(self.notes);
        table
    }
}
