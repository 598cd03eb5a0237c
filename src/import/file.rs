//! A whole log: lines to rows to runs.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::cells::{Cells, Separator, decode, number, number_after};
use super::convert::Converter;
use super::error::RowProblem;
use super::labels::labels;
use super::layout::Layout;
use super::lines::{Line, Lines, lines};
use super::map::Map;
use super::rejected::{Rejected, for_file_name};
use super::segment::Segment;
use super::stamp::{before_line, stamp};
use super::{BadRow, ImportError, ImportProblem};

pub use super::segment::ImportedRun;

/// So many bad rows before the first good one mean that the mapping is wrong.
const HOPELESS_ROWS: u64 = 1000;
/// Most runs of one log.
const MOST_RUNS: usize = 10_000;

/// What became of a log.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Imported {
    /// The runs, in the log's order.
    pub runs: Vec<ImportedRun>,
    /// Rows of the log: all lines after the names that are neither empty nor comments.
    pub rows: u64,
    /// Those that could not be used.
    pub bad_rows: u64,
    /// Those that only set a value that is held (`empty = "hold"`).
    pub rows_without_position: u64,
    /// The first of them.
    pub first_bad: Vec<BadRow>,
    /// The file with all of them.
    pub rejected: Option<PathBuf>,
    /// Rows whose command was more than full drive, and was held to it.
    pub beyond_full_drive: u64,
    /// The largest of them, in full drives.
    pub most_full_drives: Option<f64>,
    /// The last line has no line end, so its last number may have been cut off.
    pub unended: bool,
}

/// Reads a log and writes its run, or runs, to `output` or the next free name.
///
/// `name` stands for the log in messages and in the runs' headers. An import that is killed leaves a
/// file of whole rows that is not marked complete.
///
/// # Errors
/// The log cannot be read, does not fit the mapping, or the run cannot be written.
pub fn import(
    source: impl Read,
    name: &str,
    map: &Map,
    output: &Path,
) -> Result<Imported, ImportError> {
    let mut rejected = Rejected::beside(output);
    let result = lines(source).and_then(|lines| {
        let mut log = Log::new(lines, map);
        log.runs(name, output, &mut rejected)
    });
    let finished = match result {
        Ok(imported) => rejected.finish().map(|path| Imported {
            rejected: path,
            ..imported
        }),
        Err(problem) => {
            rejected.forget();
            Err(problem)
        }
    };
    finished.map_err(|problem| ImportError {
        file: name.to_owned(),
        problem,
    })
}

/// A log under way.
struct Log<'a, R> {
    lines: Lines<R>,
    map: &'a Map,
    cells: Cells,
    separator: Separator,
    /// The line of names, which may come again between blocks of rows.
    names: Vec<String>,
    /// A comment or the names again: from here the clock may begin anew.
    is_new_block: bool,
    /// The command that the last comment line gives.
    commented: Option<f64>,
}

/// What a line of the log gave.
enum Next {
    /// Cells to be converted; they are in [`Log::cells`].
    Row,
    /// A row that is too long, and its beginning.
    TooLong(Vec<u8>),
    End,
}

impl<'a, R: std::io::BufRead> Log<'a, R> {
    fn new(lines: Lines<R>, map: &'a Map) -> Self {
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

    fn runs(
        &mut self,
        name: &str,
        output: &Path,
        rejected: &mut Rejected,
    ) -> Result<Imported, ImportProblem> {
        let mut imported = Imported {
            runs: Vec::new(),
            rows: 0,
            bad_rows: 0,
            rows_without_position: 0,
            first_bad: Vec::new(),
            rejected: None,
            beyond_full_drive: 0,
            most_full_drives: None,
            unended: false,
        };
        let Some((layout, mut next)) = self.layout()? else {
            return Err(ImportProblem::NoRows {
                rows: 0,
                first: None,
            });
        };
        let mut split_value = None;
        let mut converter = Converter::new(self.map, &layout);
        let mut segment = Segment::new(self.map, name, output);
        let mut bad_in_run = 0;
        let mut used = 0_u64;
        self.is_new_block = false;
        loop {
            let line = self.lines.number();
            let converted = match &next {
                Next::End => break,
                Next::Row if self.is_names_again() => {
                    self.is_new_block = true;
                    next = self.next()?;
                    continue;
                }
                Next::TooLong(_) => {
                    converter.skip();
                    Err(RowProblem::TooLong)
                }
                Next::Row => {
                    self.cells.trim_to(layout.columns);
                    if let Some(place) = &layout.split_by
                        && self.cells.len() == layout.columns
                        && split_value.as_deref() != Some(&*self.cells.text(place.at))
                    {
                        let value = self.cells.text(place.at).into_owned();
                        one_more_run(&imported, line)?;
                        let path = split_name(output, &value);
                        let ended =
                            std::mem::replace(&mut segment, Segment::new(self.map, name, &path));
                        imported.runs.extend(ended.finish(bad_in_run)?);
                        converter = Converter::new(self.map, &layout);
                        bad_in_run = 0;
                        split_value = Some(value);
                    }
                    converter.convert(&self.cells, self.commented)
                }
            };
            let converted = match converted {
                // The clock of a new block began again: a run of its own.
                Err(RowProblem::TimeNotRising { .. })
                    if self.is_new_block && layout.split_by.is_none() =>
                {
                    one_more_run(&imported, line)?;
                    let path = split_name(output, &(imported.runs.len() + 2).to_string());
                    let ended =
                        std::mem::replace(&mut segment, Segment::new(self.map, name, &path));
                    imported.runs.extend(ended.finish(bad_in_run)?);
                    converter = Converter::new(self.map, &layout);
                    bad_in_run = 0;
                    converter.convert(&self.cells, self.commented)
                }
                converted => converted,
            };
            imported.rows += 1;
            match converted {
                Ok(Some(sample)) => {
                    used += 1;
                    self.is_new_block = false;
                    if let Some(share) = sample.beyond_full {
                        imported.beyond_full_drive += 1;
                        let most = imported.most_full_drives.unwrap_or(1.0);
                        imported.most_full_drives = Some(most.max(share));
                    }
                    segment.push(line, sample)?;
                }
                // A value of another rate, which is held.
                Ok(None) => imported.rows_without_position += 1,
                Err(problem) => {
                    bad_in_run += 1;
                    let content = match &next {
                        Next::TooLong(beginning) => beginning.as_slice(),
                        _ => self.lines.last(),
                    };
                    rejected.push(line, &problem, content)?;
                    if used == 0
                        && rejected.count >= HOPELESS_ROWS
                        && let Some(first) = rejected.first.first()
                    {
                        return Err(ImportProblem::AllBad {
                            rows: rejected.count,
                            first: Box::new(first.clone()),
                        });
                    }
                }
            }
            next = self.next()?;
        }
        imported.unended = !self.lines.ended() && used > 0;
        imported.runs.extend(segment.finish(bad_in_run)?);
        imported.bad_rows = rejected.count;
        imported.first_bad = rejected.first.clone();
        if imported.runs.is_empty() {
            return Err(ImportProblem::NoRows {
                rows: imported.rows,
                first: rejected.first.first().cloned().map(Box::new),
            });
        }
        Ok(imported)
    }

    /// Reads up to the first row: its layout, and the row itself.
    fn layout(&mut self) -> Result<Option<(Layout, Next)>, ImportProblem> {
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
                "its first line is longer than 65536 bytes",
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
        let layout = Layout::new(self.map, self.lines.number(), &self.cells, has_names)?;
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
        let labels = loop {
            match next {
                Next::End => return Ok(None),
                Next::Row => {
                    if let Some(labels) = labels(self.lines.last()) {
                        break labels;
                    }
                }
                Next::TooLong(_) => {}
            }
            next = self.next()?;
        };
        let layout = Layout::new(self.map, self.lines.number(), &Cells::of(&labels), true)?;
        self.cells.expect(labels);
        self.cells.split(self.lines.last(), self.separator);
        Ok(Some((layout, next)))
    }

    /// Whether the first line has names: where nothing is said and no name is asked for, one of numbers has none.
    fn has_names(&self) -> bool {
        let is_number = |at: usize| {
            let cell = self.cells.get(at);
            let decimal_comma = self.map.shape.decimal_comma;
            stamp(cell).is_some() || number(cell, decimal_comma, "").is_ok()
        };
        let has_numbers = || (0..self.cells.len()).all(is_number);
        let guess = || self.map.asks_for_names() || !has_numbers();
        self.map.shape.names.unwrap_or_else(guess)
    }

    /// Whether the present row is the line of names once more; a terminal's stamp before it does not count.
    fn is_names_again(&mut self) -> bool {
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

    fn next(&mut self) -> Result<Next, ImportProblem> {
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

/// Refuses more runs than any log has.
fn one_more_run(imported: &Imported, line: u64) -> Result<(), ImportProblem> {
    let runs = imported.runs.len() + 1;
    if runs > MOST_RUNS {
        return Err(ImportProblem::TooManyRuns { line, runs });
    }
    Ok(())
}

/// `spinup-3.csv` for the value 3 of the split column and `spinup.csv`.
fn split_name(output: &Path, value: &str) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_os_string();
    name.push("-");
    name.push(for_file_name(value));
    if let Some(extension) = output.extension() {
        name.push(".");
        name.push(extension);
    }
    output.with_file_name(name)
}
