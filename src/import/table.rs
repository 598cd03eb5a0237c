//! Contents of a file of another format: columns of numbers, and the equivalent text in columns.
//!
//! Every reader in `formats` makes a [`Table`], which is then processed as any other log.

use std::io::{self, Read, Write};

use super::cells::{Cells, Separator};

/// Most columns of a table; constant ones are left out first.
const MOST_COLUMNS: usize = 400;
/// Most characters of a column's name, so that the line of names fits the longest line.
const MOST_NAME: usize = 120;

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct TableColumn {
    /// Name in the file.
    pub name: String,
    /// Unit in the file.
    pub unit: Option<String>,
}

/// One value of a signal: its row, its column and the number.
pub(super) type Cell = (u32, u16, f64);

/// The numbers of a table.
#[derive(Debug, Clone, PartialEq)]
enum Numbers {
    /// By columns; NaN is an empty cell.
    Whole(Vec<Vec<f64>>),
    /// Cells in the order of their rows: with signals of different rates most are empty.
    Sparse { rows: usize, cells: Vec<Cell> },
}

/// Columns of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Of every column.
    pub columns: Vec<TableColumn>,
    /// Notes for the user.
    pub notes: Vec<String>,
    numbers: Numbers,
    /// Name of a column of words and its word in each row: every new one begins a run.
    runs: Option<(String, Vec<String>)>,
}

impl Table {
    /// From columns of equal length.
    pub(super) fn whole(columns: Vec<(TableColumn, Vec<f64>)>) -> Self {
        let (columns, numbers): (Vec<TableColumn>, Vec<Vec<f64>>) = columns.into_iter().unzip();
        let mut table = Self {
            columns,
            notes: Vec::new(),
            numbers: Numbers::Whole(numbers),
            runs: None,
        };
        table.narrow();
        table
    }

    /// From values in the order of their rows.
    pub(super) fn sparse(columns: Vec<TableColumn>, rows: usize, cells: Vec<Cell>) -> Self {
        let mut table = Self {
            columns,
            notes: Vec::new(),
            numbers: Numbers::Sparse { rows, cells },
            runs: None,
        };
        table.narrow();
        table
    }

    /// From samples of signals at separate times: time, column, value. Column 0 is the time; samples of one time
    /// share a row.
    pub(super) fn by_time(columns: Vec<TableColumn>, mut samples: Vec<(f64, u16, f64)>) -> Self {
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut cells: Vec<Cell> = Vec::with_capacity(2 * samples.len());
        let (mut rows, mut before) = (0_u32, f64::NAN);
        for (time, at, value) in samples {
            if time != before {
                rows += 1;
                cells.push((rows - 1, 0, time));
                before = time;
            }
            cells.push((rows - 1, at, value));
        }
        Self::sparse(columns, rows as usize, cells)
    }

    /// Divided into runs by each row's word.
    pub(super) fn in_runs(mut self, name: &str, words: Vec<String>) -> Self {
        self.runs = Some((name.to_owned(), words));
        self
    }

    /// The column whose words divide the runs.
    pub(super) fn split_by(&self) -> Option<&str> {
        self.runs.as_ref().map(|(name, _)| name.as_str())
    }

    pub(super) fn rows(&self) -> usize {
        match &self.numbers {
            Numbers::Whole(columns) => columns.iter().map(Vec::len).max().unwrap_or(0),
            Numbers::Sparse { rows, .. } => *rows,
        }
    }

    /// Removes columns beyond the limit: constant ones, then the last.
    fn narrow(&mut self) {
        for column in &mut self.columns {
            column.name = named(&column.name);
        }
        let count = self.columns.len();
        if count <= MOST_COLUMNS {
            return;
        }
        let changes = self.changes();
        let mut kept: Vec<usize> = (0..count).filter(|&at| changes[at]).collect();
        kept.truncate(MOST_COLUMNS);
        self.notes.push(format!(
            "it has {count} columns of numbers; the {} first that change are read",
            kept.len()
        ));
        let mut place = vec![None; count];
        for (new, &old) in kept.iter().enumerate() {
            place[old] = Some(new as u16);
        }
        self.columns = kept.iter().map(|&at| self.columns[at].clone()).collect();
        match &mut self.numbers {
            Numbers::Whole(columns) => {
                *columns = kept
                    .iter()
                    .map(|&at| std::mem::take(&mut columns[at]))
                    .collect();
            }
            Numbers::Sparse { cells, .. } => {
                cells.retain_mut(|cell| match place[usize::from(cell.1)] {
                    Some(at) => {
                        cell.1 = at;
                        true
                    }
                    None => false,
                })
            }
        }
    }

    /// Columns with two different numbers. The first column of signals is their time, which always varies.
    fn changes(&self) -> Vec<bool> {
        let mut first: Vec<Option<f64>> = vec![None; self.columns.len()];
        let mut changes = vec![false; self.columns.len()];
        let mut see = |at: usize, number: f64| {
            changes[at] |= *first[at].get_or_insert(number) != number;
        };
        match &self.numbers {
            Numbers::Whole(columns) => {
                for (at, column) in columns.iter().enumerate() {
                    column
                        .iter()
                        .filter(|x| x.is_finite())
                        .for_each(|x| see(at, *x));
                }
            }
            Numbers::Sparse { cells, .. } => {
                cells
                    .iter()
                    .for_each(|(_, at, number)| see(usize::from(*at), *number));
            }
        }
        changes
    }

    /// The table as text: a line of names, then the rows, separated by commas.
    pub fn text(&self) -> TableText<'_> {
        TableText {
            table: self,
            line: Vec::new(),
            read: 0,
            row: None,
            cell: 0,
            numbers: vec![f64::NAN; self.columns.len()],
        }
    }

    /// Passes the first rows to `at_row`.
    pub(super) fn look(&self, rows: usize, mut at_row: impl FnMut(&Cells)) {
        let mut text = self.text();
        let mut cells = Cells::default();
        text.write_line();
        for _ in 0..rows {
            if !text.write_line() {
                break;
            }
            let line = text.line.trim_ascii_end();
            cells.split(line, Separator::Byte(b','));
            at_row(&cells);
        }
    }
}

/// A name on one line, of limited length.
fn named(name: &str) -> String {
    let name: String = name
        .trim()
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(MOST_NAME)
        .collect();
    match name.trim() {
        "" => "unnamed".to_owned(),
        name => name.to_owned(),
    }
}

/// A table read as text, line by line.
#[derive(Debug)]
pub struct TableText<'a> {
    table: &'a Table,
    line: Vec<u8>,
    read: usize,
    /// The next row; `None` before the names.
    row: Option<usize>,
    /// The next cell of a sparse table.
    cell: usize,
    numbers: Vec<f64>,
}

impl TableText<'_> {
    /// Writes the next line into `line`; returns whether there was one.
    fn write_line(&mut self) -> bool {
        self.line.clear();
        self.read = 0;
        match self.row {
            None => self.write_names(),
            Some(row) if row < self.table.rows() => self.write_row(row),
            Some(_) => return false,
        }
        self.row = Some(self.row.map_or(0, |row| row + 1));
        true
    }

    fn write_names(&mut self) {
        let names = self.table.columns.iter().map(|column| column.name.as_str());
        for (at, name) in names.chain(self.table.split_by()).enumerate() {
            let comma = if at > 0 { "," } else { "" };
            let quoted = name.replace('"', "\"\"");
            // Writing to memory does not fail.
            let _ = write!(self.line, "{comma}\"{quoted}\"");
        }
        self.line.push(b'\n');
    }

    fn write_row(&mut self, row: usize) {
        self.numbers.fill(f64::NAN);
        match &self.table.numbers {
            Numbers::Whole(columns) => {
                for (number, column) in self.numbers.iter_mut().zip(columns) {
                    *number = column.get(row).copied().unwrap_or(f64::NAN);
                }
            }
            Numbers::Sparse { cells, .. } => {
                while let Some((at, column, number)) = cells.get(self.cell)
                    && *at as usize == row
                {
                    self.numbers[usize::from(*column)] = *number;
                    self.cell += 1;
                }
            }
        }
        for (at, number) in self.numbers.iter().enumerate() {
            if at > 0 {
                self.line.push(b',');
            }
            write_number(&mut self.line, *number);
        }
        if let Some((_, words)) = &self.table.runs {
            self.line.push(b',');
            let word = words.get(row).map_or("", String::as_str);
            self.line.extend_from_slice(word.as_bytes());
        }
        self.line.push(b'\n');
    }
}

/// The shortest text that parses to the same number; empty for NaN.
fn write_number(line: &mut Vec<u8>, number: f64) {
    let magnitude = number.abs();
    let _ = match number {
        number if !number.is_finite() => Ok(()),
        number if number != 0.0 && !(1e-5..1e16).contains(&magnitude) => write!(line, "{number:e}"),
        number => write!(line, "{number}"),
    };
}

impl Read for TableText<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.read == self.line.len() && !self.write_line() {
            return Ok(0);
        }
        let rest = &self.line[self.read..];
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.read += count;
        Ok(count)
    }
}

/// A 32-bit float as the number of its shortest digits: 0.1, not 0.10000000149.
pub(super) fn of_f32(number: f32) -> f64 {
    let exact = f64::from(number);
    if exact.fract() == 0.0 || !exact.is_finite() {
        return exact;
    }
    number.to_string().parse().unwrap_or(exact)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(name: &str) -> TableColumn {
        TableColumn {
            name: name.to_owned(),
            unit: None,
        }
    }

    fn text(table: &Table) -> String {
        let mut text = String::new();
        table.text().read_to_string(&mut text).expect("memory");
        text
    }

    #[test]
    fn whole_and_sparse_tables_read_as_text() {
        let table = Table::whole(vec![
            (column("t"), vec![0.0, 0.003, 1e20]),
            (column("a \"b\",\nc"), vec![-1.5, f64::NAN, 7.0]),
        ]);
        assert_eq!(
            text(&table),
            "\"t\",\"a \"\"b\"\", c\"\n0,-1.5\n0.003,\n1e20,7\n"
        );
        let cells = vec![(0, 0, 0.5), (0, 1, 3.0), (1, 0, 0.75)];
        let table = Table::sparse(vec![column("t"), column("n")], 2, cells)
            .in_runs("test", vec!["a".to_owned(), "b".to_owned()]);
        assert_eq!(text(&table), "\"t\",\"n\",\"test\"\n0.5,3,a\n0.75,,b\n");
    }

    #[test]
    fn a_table_that_is_too_wide_keeps_what_changes() {
        let columns = (0..1000_u16)
            .map(|k| (column(&format!("c{k}")), vec![0.0, f64::from(k % 2)]))
            .collect();
        let table = Table::whole(columns);
        assert_eq!(table.columns.len(), MOST_COLUMNS);
        assert_eq!(table.columns[1].name, "c3");
        assert!(text(&table).starts_with("\"c1\",\"c3\","));
        assert_eq!(table.notes.len(), 1);
    }

    #[test]
    fn a_float_of_32_bits_keeps_its_own_digits() {
        assert_eq!(of_f32(0.1), 0.1);
        assert_eq!(of_f32(-16_777_216.0), -16_777_216.0);
        assert_eq!(of_f32(1.0e-9), 1.0e-9);
    }
}
