//! Variables of a workspace: those of one length are the columns of a table.

use std::collections::BTreeMap;

use super::super::table::{Table, TableColumn};
use super::{Form, FormatError, MOST_VALUES};

/// Columns of a matrix that become columns of the table.
const MOST_OF_A_MATRIX: usize = 64;
/// Names of variables left out that a message lists.
const MOST_LISTED: usize = 8;
/// `tout`, which Simulink writes beside its signals, is their time in s.
const SIMULINK_TIME: &str = "tout";

/// Vectors with their names, as they are found.
#[derive(Debug)]
pub(super) struct Variables {
    form: Form,
    vectors: Vec<(String, Vec<f64>)>,
    /// Variables of kinds that are not read, with what they are.
    pub not_read: Vec<String>,
}

impl Variables {
    pub fn new(form: Form) -> Self {
        Self {
            form,
            vectors: Vec::new(),
            not_read: Vec::new(),
        }
    }

    /// A matrix, its numbers column by column. A vector is a column, lying or standing; of a matrix the longer side is time.
    pub fn push(&mut self, name: &str, rows: usize, columns: usize, numbers: Vec<f64>) {
        let length = rows.max(columns);
        let count = rows.min(columns);
        if length < 2 || numbers.len() != length.saturating_mul(count) {
            return;
        }
        if count == 1 {
            self.vectors.push((name.to_owned(), numbers));
            return;
        }
        if count > MOST_OF_A_MATRIX {
            self.not_read
                .push(format!("{name} (a matrix of {rows} by {columns})"));
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
            self.vectors.push((part, column));
        }
    }

    /// The vectors of the length that most of them have.
    pub fn table(self) -> Result<Table, FormatError> {
        let mut lengths: BTreeMap<usize, usize> = BTreeMap::new();
        for (_, numbers) in &self.vectors {
            *lengths.entry(numbers.len()).or_default() += 1;
        }
        let not_read = listed(&self.not_read);
        let best = lengths
            .iter()
            .max_by_key(|(length, count)| (**count, **length));
        let Some((&length, &count)) = best.filter(|(_, count)| **count >= 2) else {
            let there = match (self.vectors.is_empty(), self.not_read.is_empty()) {
                (false, _) => "no two of its variables have one length".to_owned(),
                (true, true) => "it has no vectors".to_owned(),
                (true, false) => format!("of its variables are not read: {not_read}"),
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
        let named = kept.into_iter().map(|(name, numbers)| {
            let unit = (name == SIMULINK_TIME).then(|| "s".to_owned());
            (TableColumn { name, unit }, numbers)
        });
        let mut table = Table::whole(named.collect());
        if !rest.is_empty() {
            let names: Vec<String> = rest
                .iter()
                .map(|(name, numbers)| format!("{name} ({} values)", numbers.len()))
                .collect();
            table.notes.push(format!(
                "the {count} variables of {length} values are read; of another length: {}",
                listed(&names)
            ));
        }
        if !not_read.is_empty() {
            table.notes.push(format!("not read: {not_read}"));
        }
        Ok(table)
    }
}

fn listed(names: &[String]) -> String {
    let mut list = names[..names.len().min(MOST_LISTED)].join(", ");
    if names.len() > MOST_LISTED {
        list.push_str(&format!(" and {} more", names.len() - MOST_LISTED));
    }
    list
}

/// How an object of MATLAB, whose form is not documented, becomes variables that are read.
pub(super) fn object(name: &str, class: &str) -> String {
    format!(
        "{name} (an object of class {class}, whose form MathWorks does not document; in MATLAB, of a timeseries: \
         t = {name}.Time; x = {name}.Data; of a Simulink Dataset or SimulationOutput the same of each of its signals; save log.mat t x)"
    )
}
