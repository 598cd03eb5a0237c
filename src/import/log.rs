//! A log line by line: the start of its rows, and the cells of each.

use super::ImportProblem;
use super::cells::{Cells, Separator, decode, number_after};
use super::labels::labels;
use super::layout::Layout;
use super::lines::{Line, Lines};
use super::map::Map;
use super::stamp::{before_line, stamp};

/// Lines among which the line of names is searched.
const BANNER_LINES: u64 = 400;

/// Reader of a log.
pub(super) struct Log<'a, R> {
    pub lines: Lines<R>,
    pub map: &'a Map,
    pub cells: Cells,
    separator: Separator,
    /// The line of names, which may be repeated between blocks of rows.
    names: Vec<String>,
    /// After a comment or repeated names the clock may restart.
    pub is_new_block: bool,
    /// The command in the last comment line.
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

    /// Reads up to the first row: its layout, and the row.
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
        // A banner precedes the names.
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

    /// The same for lines with labels: the first one names the columns, and is a row.
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

    /// Whether the first line has names: unless stated otherwise or names are used, a numeric line has none.
    fn has_names(&self) -> bool {
        let is_number = |at: usize| {
            let cell = self.cells.get(at);
            stamp(cell).is_some() || self.map.shape.number(cell, "").is_ok()
        };
        let has_numbers = || (0..self.cells.len()).all(is_number);
        let guess = || self.map.asks_for_names() || !has_numbers();
        self.map.shape.names.unwrap_or_else(guess)
    }

    /// Whether the present row repeats the line of names, ignoring a terminal's stamp.
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

    /// The next line that is neither empty nor a comment, split into cells.
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

/// Whether a line is a comment, ignoring a terminal's stamp.
fn is_comment(map: &Map, line: &[u8]) -> bool {
    let content = before_line(line).map_or(line, |(_, rest)| rest);
    let mark = map.shape.comment.as_bytes();
    !mark.is_empty() && content.trim_ascii_start().starts_with(mark)
}

fn commented(map: &Map, line: &[u8]) -> Option<f64> {
    let word = map.command_word().filter(|_| is_comment(map, line))?;
    number_after(&decode(line), word)
}
