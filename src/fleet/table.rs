//! Tables in columns, and as CSV.

use crate::plain::one_line;

/// The cells of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Texts.
    Text(Vec<Option<String>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Integers.
    Whole(Vec<Option<i64>>),
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name, with the unit where there is one.
    pub name: &'static str,
    /// The cells.
    pub values: Values,
}

/// Columns of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: usize,
}

pub(super) struct Columns<'a, T> {
    rows: &'a [T],
    columns: Vec<Column>,
}

impl<'a, T> Columns<'a, T> {
    pub(super) fn of(rows: &'a [T]) -> Self {
        Self {
            rows,
            columns: Vec::new(),
        }
    }

    pub(super) fn text(mut self, name: &'static str, of: impl Fn(&T) -> Option<String>) -> Self {
        let values = Values::Text(self.rows.iter().map(of).collect());
        self.columns.push(Column { name, values });
        self
    }

    pub(super) fn number(mut self, name: &'static str, of: impl Fn(&T) -> Option<f64>) -> Self {
        let finite = |row| of(row).filter(|value: &f64| value.is_finite());
        let values = Values::Number(self.rows.iter().map(finite).collect());
        self.columns.push(Column { name, values });
        self
    }

    pub(super) fn whole(mut self, name: &'static str, of: impl Fn(&T) -> Option<i64>) -> Self {
        let values = Values::Whole(self.rows.iter().map(of).collect());
        self.columns.push(Column { name, values });
        self
    }

    pub(super) fn table(self) -> Table {
        Table {
            rows: self.rows.len(),
            columns: self.columns,
        }
    }
}

impl Table {
    /// As CSV (RFC 4180 with Unix line ends): names first; a missing value is an empty cell.
    ///
    /// # Errors
    /// An error of the writer; none in memory.
    pub fn to_csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.columns.iter().map(|column| column.name))?;
        for row in 0..self.rows {
            writer.write_record((self.columns.iter()).map(|column| column.values.csv_cell(row)))?;
        }
        writer
            .into_inner()
            .map_err(|error| error.into_error().into())
    }
}

/// Characters with which a spreadsheet formula begins.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// Text that neither a spreadsheet evaluates nor a terminal interprets: a quotation mark precedes what would be a
/// formula, control and invisible characters are replaced.
fn harmless(text: &str) -> String {
    let mark = if text.starts_with(FORMULA) { "'" } else { "" };
    format!("{mark}{}", one_line(text))
}

impl Values {
    fn csv_cell(&self, row: usize) -> String {
        match self {
            Self::Text(cells) => cells[row].as_deref().map(harmless).unwrap_or_default(),
            Self::Number(_) | Self::Whole(_) => self.cell(row),
        }
    }

    /// A cell as text; empty for a missing value.
    pub fn cell(&self, row: usize) -> String {
        match self {
            Self::Text(cells) => cells[row].clone(),
            // The shortest text that parses to the same number.
            Self::Number(cells) => cells[row].map(|value| value.to_string()),
            Self::Whole(cells) => cells[row].map(|value| value.to_string()),
        }
        .unwrap_or_default()
    }
}
