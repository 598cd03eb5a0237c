//! The import of a log: lines to rows to runs.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::cells::Cells;
use super::convert::{Converter, Sample};
use super::error::RowProblem;
use super::lines::lines;
use super::log::{Log, Next};
use super::map::Map;
use super::rejected::{Rejected, for_file_name};
use super::segment::Segment;
use super::{BadRow, ImportError, ImportProblem};
use crate::platform::files::remove_file;

pub use super::segment::ImportedRun;

/// Rejected rows at the beginning after which the mapping is taken to be wrong.
const HOPELESS_ROWS: u64 = 1000;
/// Most runs of one log.
const MOST_RUNS: usize = 10_000;
/// Most runs that restarts of the clock make by default: a board is reset by hand a few times in a log, and a wrong
/// clock column falls in every second row.
const DEFAULT_MOST_RUNS: usize = 12;

/// Result of an import.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct Imported {
    /// The runs, in the log's order.
    pub runs: Vec<ImportedRun>,
    /// Rows of the log: all lines after the names that are neither empty nor comments.
    pub rows: u64,
    /// Rejected rows.
    pub bad_rows: u64,
    /// Rows that only set held values (`empty = "hold"`).
    pub rows_without_position: u64,
    /// The first rejected rows.
    pub first_bad: Vec<BadRow>,
    /// The file with all of them.
    pub rejected: Option<PathBuf>,
    /// Rows whose command was clamped to full drive.
    pub beyond_full_drive: u64,
    /// The largest of them, relative to full drive.
    pub most_full_drives: Option<f64>,
    /// The last line has no line end, so that its last number may be incomplete.
    pub unended: bool,
}

/// Reads a log and writes its run, or runs, to `output` or the next free name.
///
/// `name` is the log's name in messages and in the runs' headers. An import that is killed leaves a file of complete
/// rows that is not marked complete.
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

/// The current run, and the results so far.
struct Progress<'a> {
    imported: Imported,
    segment: Segment<'a>,
    rejected: &'a mut Rejected,
    bad_in_run: u64,
    used: u64,
    /// Most runs made by restarts of the clock.
    most_runs: usize,
}

impl<'a> Progress<'a> {
    /// Ends the run after a restart of the clock; with too many restarts all runs are removed.
    fn clock_restarted(&mut self, next: Segment<'a>, line: u64) -> Result<(), ImportProblem> {
        let runs = self.imported.runs.len() + 2;
        if runs <= self.most_runs {
            return self.next_run(next, line);
        }
        self.segment.discard();
        for run in &self.imported.runs {
            // They are this import's files, and the following error is reported.
            let _ = remove_file(&run.path);
        }
        Err(ImportProblem::ClockFalls { line, runs })
    }

    /// Ends the run and begins the next.
    fn next_run(&mut self, next: Segment<'a>, line: u64) -> Result<(), ImportProblem> {
        one_more_run(&self.imported, line)?;
        let ended = std::mem::replace(&mut self.segment, next);
        self.imported.runs.extend(ended.finish(self.bad_in_run)?);
        self.bad_in_run = 0;
        Ok(())
    }

    /// Adds a converted row, or rejects it.
    fn settle(
        &mut self,
        line: u64,
        converted: Result<Option<Sample>, RowProblem>,
        content: &[u8],
    ) -> Result<(), ImportProblem> {
        let imported = &mut self.imported;
        imported.rows += 1;
        match converted {
            Ok(Some(sample)) => {
                self.used += 1;
                if let Some(share) = sample.beyond_full {
                    imported.beyond_full_drive += 1;
                    let most = imported.most_full_drives.unwrap_or(1.0);
                    imported.most_full_drives = Some(most.max(share));
                }
                self.segment.push(line, sample)?;
            }
            // A value of a signal with another rate, which is held.
            Ok(None) => imported.rows_without_position += 1,
            Err(problem) => {
                self.bad_in_run += 1;
                self.rejected.push(line, &problem, content)?;
                if self.used == 0
                    && self.rejected.count >= HOPELESS_ROWS
                    && let Some(first) = self.rejected.first.first()
                {
                    return Err(ImportProblem::AllBad {
                        rows: self.rejected.count,
                        first: Box::new(first.clone()),
                    });
                }
            }
        }
        Ok(())
    }
}

/// A row whose time falls back by more than half of the run. If the next row continues from it, the board restarted;
/// else it is rejected.
struct Fallen {
    line: u64,
    cells: Cells,
    commented: Option<f64>,
    content: Vec<u8>,
    before: f64,
    after: f64,
}

impl Fallen {
    fn problem(&self) -> RowProblem {
        RowProblem::TimeNotRising {
            before: self.before,
            after: self.after,
        }
    }
}

impl<R: std::io::BufRead> Log<'_, R> {
    fn runs(
        &mut self,
        name: &str,
        output: &Path,
        rejected: &mut Rejected,
    ) -> Result<Imported, ImportProblem> {
        let Some((layout, mut next)) = self.layout()? else {
            return Err(ImportProblem::NoRows {
                rows: 0,
                first: None,
            });
        };
        let map = self.map;
        let mut progress = Progress {
            imported: Imported::default(),
            segment: Segment::new(map, name, output),
            rejected,
            bad_in_run: 0,
            used: 0,
            most_runs: map.most_runs.unwrap_or(DEFAULT_MOST_RUNS),
        };
        let numbered = |progress: &Progress| {
            let path = split_name(output, &(progress.imported.runs.len() + 2).to_string());
            Segment::new(map, name, &path)
        };
        let mut split_value = None;
        let mut converter = Converter::new(map, &layout);
        let mut fallen: Option<Fallen> = None;
        self.is_new_block = false;
        loop {
            let line = self.lines.number();
            let mut converted = match &next {
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
                        let path = split_name(output, &value);
                        progress.next_run(Segment::new(map, name, &path), line)?;
                        converter = Converter::new(map, &layout);
                        split_value = Some(value);
                    }
                    converter.convert(&self.cells, self.commented)
                }
            };
            if let Some(first) = fallen.take() {
                match converted {
                    // The board restarted: a new run.
                    Err(RowProblem::TimeNotRising { after, .. }) if after > first.after => {
                        progress.clock_restarted(numbered(&progress), first.line)?;
                        converter = Converter::new(map, &layout);
                        let begun = converter.convert(&first.cells, first.commented);
                        progress.settle(first.line, begun, &first.content)?;
                        converted = converter.convert(&self.cells, self.commented);
                    }
                    _ => progress.settle(first.line, Err(first.problem()), &first.content)?,
                }
            }
            match converted {
                // The clock of a new block restarted: a new run.
                Err(RowProblem::TimeNotRising { .. })
                    if self.is_new_block && layout.split_by.is_none() =>
                {
                    progress.clock_restarted(numbered(&progress), line)?;
                    converter = Converter::new(map, &layout);
                    converted = converter.convert(&self.cells, self.commented);
                }
                Err(RowProblem::TimeNotRising { before, after })
                    if after < before / 2.0 && layout.split_by.is_none() =>
                {
                    fallen = Some(Fallen {
                        line,
                        cells: self.cells.clone(),
                        commented: self.commented,
                        content: self.lines.last().to_vec(),
                        before,
                        after,
                    });
                    next = self.next()?;
                    continue;
                }
                _ => {}
            }
            self.is_new_block &= !matches!(converted, Ok(Some(_)));
            let content = match &next {
                Next::TooLong(beginning) => beginning.as_slice(),
                _ => self.lines.last(),
            };
            progress.settle(line, converted, content)?;
            next = self.next()?;
        }
        if let Some(first) = fallen {
            progress.settle(first.line, Err(first.problem()), &first.content)?;
        }
        let Progress {
            mut imported,
            segment,
            rejected,
            bad_in_run,
            used,
            ..
        } = progress;
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
