//! Tables as text: columns of the needed width, numbers right-aligned.

use std::fmt;

use super::html::is_number;
use crate::plain::markdown_text;

/// Column names and rows of cells.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new<T: Into<String>>(names: impl IntoIterator<Item = T>) -> Self {
        Self {
            names: names.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// Names of the columns.
    pub fn names(&self) -> Vec<&str> {
        self.names.iter().map(String::as_str).collect()
    }

    /// The rows.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// The table in Markdown, with escaped cells.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| markdown_text(cell)).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rule = format!("|{}\n", " --- |".repeat(self.names.len()));
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        line(&self.names) + &rule + &rows
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cell = |row: &[String], k: usize| row.get(k).cloned().unwrap_or_default();
        let columns: Vec<(usize, bool)> = (0..self.names.len())
            .map(|k| {
                let cells = self.rows.iter().map(|row| cell(row, k));
                let widest = cells.clone().map(|c| c.chars().count()).max().unwrap_or(0);
                let numbers = cells.clone().all(|c| c == "·" || is_short_number(&c));
                (widest.max(self.names[k].chars().count()), numbers)
            })
            .collect();
        for row in std::iter::once(&self.names).chain(&self.rows) {
            let mut line = String::from(" ");
            for (k, &(width, right)) in columns.iter().enumerate() {
                let text = cell(row, k);
                line += &if right {
                    format!(" {text:>width$}")
                } else {
                    format!(" {text:<width$}")
                };
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// A number, possibly with a unit, but not a sentence that begins with one.
fn is_short_number(cell: &str) -> bool {
    is_number(cell) && cell.chars().count() <= 8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_right_and_words_left() {
        let mut table = Table::new(["effect", "cases"]);
        table.row(["stribeck", "7"]);
        table.row(["drag", "12"]);
        let text = table.to_string();
        assert_eq!(
            text,
            "  effect   cases\n  stribeck     7\n  drag        12\n"
        );
        assert!(
            table
                .markdown()
                .starts_with("| effect | cases |\n| --- | --- |\n| stribeck | 7 |")
        );
    }
}
