//! A log line by line: where its rows begin, and the cells of each.

use super::ImportProblem;
use super::cells::{Cells, Separator, decode, number_after};
use super::labels::labels;
use super::layout::Layout;
use super::lines::{Line, Lines};
use super::map::Map;
use super::stamp::{before_line, stamp};

/// Lines before that of the names which are looked at.
const BANNER_LINES: u64 = 400;

/// A log under way.
pub(super) struct Log<'a, R> {
    pub lines: Lines<R>,
    pub map: &'a Map,
    pub cells: Cells,
    separator: Separator,
    /// The line of names, which may come again between blocks of rows.
    names: Vec<String>,
    /// A comment or the names again: from here the clock may begin anew.
    pub is_new_block: bool,
    /// The command that the last comment line gives.
    pub commented: Option<f64>,
}

/// Result of a line of the log.
pub(super) enum Next {
    /// Cells to be converted; they are in [`Log::cells`].
    Row,
    /// A row that is too long, and its beginning.
    TooLong(Vec<u8>),
    End,
}

impl<'a, R: std::io::BufRead> Log<'a, R> {
    pub fn new(lines: Lines<R>, map: &'a Map) -> Self {
        Self {
            lines,
            map,
            cells: Cells::default(),
            separator: map.shape.separator.unwrap_or(Separator::Blanks),
            names: Vec::new(),
            is_new_block: false,
            commented: None,
        }
    }

    /// Reads up to the first row: its layout, and the row itself.
    pub fn layout(&mut self) -> Result<Option<(Layout, Next)>, ImportProblem> {
        for _ in 0..self.map.shape.skip_lines {
            match self.lines.next()? {
                None => return Ok(None),
                Some(Line::Whole(line)) => {
                    self.commented = commented(self.map, line).or(self.commented);
                }
                Some(Line::TooLong(_)) => {}
            }
        }
        let mut next = self.next_guessing(self.map.shape.separator.is_none())?;
        if let Next::TooLong(_) = next {
            return Err(ImportProblem::NoText(
                "its first line is longer than 65536 bytes\nhint: save it as CSV, one row per sample",
            ));
        }
        if let Next::End = next {
            return Ok(None);
        }
        if self.separator == Separator::Labels {
            return self.labelled(next);
        }
        let has_names = self.has_names();
        if has_names {
            while self.cells.len() > 1 && self.cells.get(self.cells.len() - 1).is_empty() {
                self.cells.trim_to(self.cells.len() - 1);
            }
        }
        let mut found = Layout::new(self.map, self.lines.number(), &self.cells, has_names);
        // A banner stands before the names.
        while let (Err(ImportProblem::NoSuchColumn { .. }), Next::Row) = (&found, &next)
            && self.lines.number() < self.map.shape.skip_lines + BANNER_LINES
        {
            next = self.next_guessing(self.map.shape.separator.is_none())?;
            let here = Layout::new(self.map, self.lines.number(), &self.cells, has_names);
            found = match here {
                Err(ImportProblem::NoSuchColumn { .. }) => found,
                here => here,
            };
        }
        let layout = found?;
        if has_names {
            self.names = (0..self.cells.len())
                .map(|at| self.cells.text(at).into_owned())
                .collect();
            for _ in 0..=self.map.shape.unit_lines {
                next = self.next()?;
            }
        }
        Ok(Some((layout, next)))
    }

    /// The same of lines that name their cells: the first that does names the columns, and is a row.
    fn labelled(&mut self, mut next: Next) -> Result<Option<(Layout, Next)>, ImportProblem> {
        let mut first_problem = None;
        let (labels, layout) = loop {
            match next {
                Next::End => return first_problem.map_or(Ok(None), Err),
                Next::Row => {
                    if let Some(labels) = labels(self.lines.last()) {
                        let line = self.lines.number();
                        match Layout::new(self.map, line, &Cells::of(&labels), true) {
                            Ok(layout) => break (labels, layout),
                            Err(problem) if line > BANNER_LINES => return Err(problem),
                            Err(problem) => first_problem = first_problem.or(Some(problem)),
                        }
                    }
                }
                Next::TooLong(_) => {}
            }
            next = self.next()?;
        };
        self.cells.expect(labels);
        self.cells.split(self.lines.last(), self.separator);
        Ok(Some((layout, next)))
    }

    /// Whether the first line has names: where nothing is said and no name is asked for, one of numbers has none.
    fn has_names(&self) -> bool {
        let is_number = |at: usize| {
            let cell = self.cells.get(at);
            stamp(cell).is_some() || self.map.shape.number(cell, "").is_ok()
        };
        let has_numbers = || (0..self.cells.len()).all(is_number);
        let guess = || self.map.asks_for_names() || !has_numbers();
        self.map.shape.names.unwrap_or_else(guess)
    }

    /// Whether the present row is the line of names once more; a terminal's stamp before it does not count.
    pub fn is_names_again(&mut self) -> bool {
        if self.names.is_empty() {
            return false;
        }
        self.cells.trim_to(self.names.len());
        let is_same = |(at, name): (usize, &String)| {
            let cell = self.cells.get(at);
            cell == name.as_bytes() || (at == 0 && stamp(cell).is_some())
        };
        self.cells.len() == self.names.len() && self.names.iter().enumerate().all(is_same)
    }

    pub fn next(&mut self) -> Result<Next, ImportProblem> {
        self.next_guessing(false)
    }

    /// The next line that is neither empty nor a comment, taken apart.
    fn next_guessing(&mut self, guess: bool) -> Result<Next, ImportProblem> {
        let shape = &self.map.shape;
        loop {
            match self.lines.next()? {
                None => return Ok(Next::End),
                Some(Line::TooLong(beginning)) => return Ok(Next::TooLong(beginning.to_vec())),
                Some(Line::Whole(line)) => {
                    if line.trim_ascii_start().is_empty() {
                        continue;
                    }
                    if is_comment(self.map, line) {
                        self.is_new_block = true;
                        self.commented = commented(self.map, line).or(self.commented);
                        continue;
                    }
                    if guess {
                        self.separator = Separator::guess(line, shape.decimal_comma);
                    }
                    self.cells.split(line, self.separator);
                    return Ok(Next::Row);
                }
            }
        }
    }
}

/// Whether a line is a comment; a terminal's stamp before it does not count.
fn is_comment(map: &Map, line: &[u8]) -> bool {
    let content = before_line(line).map_or(line, |(_, rest)| rest);
    let mark = map.shape.comment.as_bytes();
    !mark.is_empty() && content.trim_ascii_start().starts_with(mark)
}

/// The command that a comment line gives.
fn commented(map: &Map, line: &[u8]) -> Option<f64> {
    let word = map.command_word().filter(|_| is_comment(map, line))?;
    number_after(&decode(line), word)
}
