//! Reader of run files, `motorlab-run/1`: TOML in leading `#` lines, then CSV.
//!
//! A truncated file is read up to its last complete row, with a note; any other inconsistency is an error with line
//! and column.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use crate::motor::plausible;

use super::driven::known_differences;
use super::line_limit::{LineLimit, without_byte_order_mark};
use super::read_error::{ReadError, ReadNote, ReadProblem};
use super::rows::{Table, fill};
use super::{RUN_FORMAT, Run};

/// Longest header in bytes.
const MAX_HEADER_BYTES: usize = 1 << 20;

/// Reads a run file, with notes about ignored parts.
///
/// # Errors
/// The file cannot be read, or is not a run file; the message has the place and the remedy.
pub fn read_run(path: &Path) -> Result<(Run, Vec<ReadNote>), ReadError> {
    let file = path.display().to_string();
    let opened = File::open(path).and_then(|opened| {
        if opened.metadata()?.is_dir() {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "it is a directory",
            ));
        }
        Ok(opened)
    });
    let result = match opened {
        Ok(opened) => read_run_from(opened, &file),
        Err(error) => Err(ReadError {
            file,
            problem: ReadProblem::Io(error),
        }),
    };
    result.map(|(mut run, notes)| {
        run.path = Some(path.to_owned());
        (run, notes)
    })
}

/// Reads a run from any source; `name` is its name in messages.
///
/// # Errors
/// As [`read_run`].
pub fn read_run_from(source: impl Read, name: &str) -> Result<(Run, Vec<ReadNote>), ReadError> {
    read(source).map_err(|problem| ReadError {
        file: name.to_owned(),
        problem,
    })
}

fn read(source: impl Read) -> Result<(Run, Vec<ReadNote>), ReadProblem> {
    let last_byte = Cell::new(b'\n');
    let source = without_byte_order_mark(source).map_err(ReadProblem::Io)?;
    let mut source = BufReader::new(LineLimit::new(source, &last_byte));
    let (header, header_lines) = read_header(&mut source)?;
    let mut run = run_from_header(header)?;
    let mut notes = Vec::new();
    let table = Table::new(&mut source, header_lines)?;
    let last_row = fill(&mut run, table, &mut notes)?;
    if let Some(row) = last_row
        && last_byte.get() != b'\n'
        && !run.complete
    {
        // Without its line end the last cell may be incomplete.
        run.truncate(run.len() - 1);
        notes.push(ReadNote::TornTail { row });
    }
    finish(&mut run, &mut notes)?;
    Ok((run, notes))
}

/// Reads the leading `#` lines as one TOML document; returns their number as well.
fn read_header(source: &mut impl BufRead) -> Result<(toml::Table, usize), ReadProblem> {
    let mut text = String::new();
    let mut lines = 0;
    while source.fill_buf().map_err(ReadProblem::Io)?.first() == Some(&b'#') {
        let mut line = Vec::new();
        source
            .read_until(b'\n', &mut line)
            .map_err(ReadProblem::Io)?;
        lines += 1;
        let line = String::from_utf8(line).map_err(|_| ReadProblem::HeaderToml {
            line: lines,
            message: "it is not UTF-8".to_owned(),
        })?;
        let content = &line[1..];
        text.push_str(content.strip_prefix(' ').unwrap_or(content).trim_end());
        text.push('\n');
        if text.len() > MAX_HEADER_BYTES {
            return Err(ReadProblem::HeaderToml {
                line: lines,
                message: format!("it is longer than {MAX_HEADER_BYTES} bytes"),
            });
        }
    }
    let header = text.parse::<toml::Table>().map_err(|error| {
        let before = error.span().map_or(0, |span| span.start.min(text.len()));
        ReadProblem::HeaderToml {
            line: 1 + text.as_bytes()[..before]
                .iter()
                .filter(|&&b| b == b'\n')
                .count(),
            message: error.message().to_owned(),
        }
    })?;
    Ok((header, lines))
}

fn run_from_header(header: toml::Table) -> Result<Run, ReadProblem> {
    if let Some(format) = header.get("format") {
        let format = format
            .as_str()
            .map_or_else(|| format.to_string(), str::to_owned);
        if format != RUN_FORMAT {
            return Err(ReadProblem::Format(shortened(&format, 40)));
        }
    }
    let known = known_differences(&header).map_err(ReadProblem::Differs)?;
    let counts_per_rev = positive(&header, "counts_per_rev", plausible::COUNTS_PER_REV)?.ok_or(
        ReadProblem::MissingKey {
            key: "counts_per_rev",
            example: "720",
        },
    )?;
    Ok(Run {
        sample_time_s: positive(&header, "sample_time_s", plausible::SAMPLE_TIME_S)?
            .unwrap_or(f64::NAN),
        counts_per_rev,
        supply_v: positive(&header, "supply_v", plausible::SUPPLY_V)?,
        complete: header.get("complete").and_then(toml::Value::as_bool) == Some(true),
        header,
        known,
        ..Run::default()
    })
}

/// A numeric header key in this range, if present.
fn positive(
    header: &toml::Table,
    key: &'static str,
    range: plausible::Range,
) -> Result<Option<f64>, ReadProblem> {
    let Some(value) = header.get(key) else {
        return Ok(None);
    };
    let number = match value {
        toml::Value::Float(number) => *number,
        toml::Value::Integer(number) => *number as f64,
        _ => f64::NAN,
    };
    if range.holds(number) {
        Ok(Some(number))
    } else {
        Err(ReadProblem::BadKey {
            key,
            found: shortened(&value.to_string(), 40),
            expected: range.to_string(),
        })
    }
}

/// Checks that need all rows.
fn finish(run: &mut Run, notes: &mut Vec<ReadNote>) -> Result<(), ReadProblem> {
    let Some(&first_s) = run.t_s.first() else {
        return Err(ReadProblem::Empty);
    };
    if first_s != 0.0 {
        run.t_s.iter_mut().for_each(|t| *t -= first_s);
        notes.push(ReadNote::OriginShifted { first_s });
    }
    if run.sample_time_s.is_nan() {
        let mut steps: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps.get(steps.len() / 2).copied();
        run.sample_time_s = median.ok_or(ReadProblem::MissingKey {
            key: "sample_time_s",
            example: "0.003",
        })?;
        notes.push(ReadNote::SampleTimeGuessed {
            sample_time_s: run.sample_time_s,
        });
    }
    if run.is_host_timed() {
        notes.push(ReadNote::HostTimed);
    }
    if !run.complete {
        notes.push(ReadNote::NotComplete);
    }
    Ok(())
}

/// A text clipped for a message.
pub(super) fn shortened(text: &str, most_chars: usize) -> String {
    let mut short: String = text.chars().take(most_chars).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
