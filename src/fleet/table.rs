//! A table in columns, and as CSV.

use crate::plain::one_line;

/// The cells of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Words.
    Text(Vec<Option<String>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Whole numbers.
    Whole(Vec<Option<i64>>),
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name, with the unit where there is one.
    pub name: &'static str,
    /// The cells.
    pub values: Values,
}

/// Columns of one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: usize,
}

/// Columns of a table under way, of rows of one kind.
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
    /// As CSV (RFC 4180, line ends as on Unix): names first; an empty cell is one that is not there.
    ///
    /// # Errors
    /// The writer's, which memory has none of.
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

/// A text of a recording that neither a spreadsheet evaluates nor a terminal obeys: a quotation mark goes before what would be a formula, and
/// what steers or cannot be seen is replaced.
fn harmless(text: &str) -> String {
    let mark = if text.starts_with(FORMULA) { "'" } else { "" };
    format!("{mark}{}", one_line(text))
}

impl Values {
    /// A cell of a CSV file.
    fn csv_cell(&self, row: usize) -> String {
        match self {
            Self::Text(cells) => cells[row].as_deref().map(harmless).unwrap_or_default(),
            Self::Number(_) | Self::Whole(_) => self.cell(row),
        }
    }

    /// A cell as text; empty where it is not there.
    pub fn cell(&self, row: usize) -> String {
        match self {
            Self::Text(cells) => cells[row].clone(),
            // The shortest text that is read as the same number.
            Self::Number(cells) => cells[row].map(|value| value.to_string()),
            Self::Whole(cells) => cells[row].map(|value| value.to_string()),
        }
        .unwrap_or_default()
    }
}
