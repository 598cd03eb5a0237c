//! Reads run files, `motorlab-run/1`: TOML in leading `#` lines, then CSV.
//!
//! A file that was cut off is read up to its last whole row and says so; anything else that does not
//! fit is an error with the line and the column. Lines are bounded, so that a file that is no run file
//! (`/dev/zero`, a gigabyte without a line end) fails early instead of filling the memory.

use std::cell::Cell;
use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::read_error::{ReadError, ReadNote, ReadProblem};
use super::{CommandKind, RUN_FORMAT, Run};

/// U+FEFF in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
/// Longest line of a run file in bytes.
const MAX_LINE_BYTES: usize = 1 << 16;
/// Most rows of a run: four hours at 333 Hz, 400 MB in memory.
const MAX_ROWS: usize = 5_000_000;
/// Longest time between two rows in s. Whoever simulates a run simulates its gaps too.
pub(super) const LONGEST_GAP_S: f64 = 3600.0;
/// Longest header in bytes.
const MAX_HEADER_BYTES: usize = 1 << 20;

/// Reads a run file, with notes on what was left out.
///
/// # Errors
/// The file cannot be read, or it is not a run file; the message says where and what to do.
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

/// Reads a run from any bytes; `name` stands for the file in messages.
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
        // Without its line end nobody knows whether the last cell is whole.
        run.truncate(run.len() - 1);
        notes.push(ReadNote::TornTail { row });
    }
    finish(&mut run, &mut notes)?;
    Ok((run, notes))
}

/// Takes the leading `#` lines as one TOML document; also their number.
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

/// The source without byte order marks, as some spreadsheets put them in front of UTF-8. A pipe may give
/// its bytes one by one.
fn without_byte_order_mark<R: Read>(
    mut source: R,
) -> io::Result<io::Chain<io::Cursor<Vec<u8>>, R>> {
    let mut begin = Vec::with_capacity(BYTE_ORDER_MARK.len());
    loop {
        source
            .by_ref()
            .take(BYTE_ORDER_MARK.len() as u64)
            .read_to_end(&mut begin)?;
        if begin != BYTE_ORDER_MARK {
            return Ok(io::Cursor::new(begin).chain(source));
        }
        begin.clear();
    }
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
    let counts_per_rev = positive(&header, "counts_per_rev")?.ok_or(ReadProblem::MissingKey {
        key: "counts_per_rev",
        example: "720",
    })?;
    Ok(Run {
        sample_time_s: positive(&header, "sample_time_s")?.unwrap_or(f64::NAN),
        counts_per_rev,
        supply_v: positive(&header, "supply_v")?,
        complete: header.get("complete").and_then(toml::Value::as_bool) == Some(true),
        header,
        ..Run::default()
    })
}

/// A header key that must be a positive number, if it is there.
fn positive(header: &toml::Table, key: &'static str) -> Result<Option<f64>, ReadProblem> {
    let Some(value) = header.get(key) else {
        return Ok(None);
    };
    let number = match value {
        toml::Value::Float(number) => *number,
        toml::Value::Integer(number) => *number as f64,
        _ => f64::NAN,
    };
    if number.is_finite() && number > 0.0 {
        Ok(Some(number))
    } else {
        Err(ReadProblem::BadKey {
            key,
            found: shortened(&value.to_string(), 40),
            expected: "a number above 0",
        })
    }
}

/// The columns that a run may have, by name.
const KNOWN: [&str; 11] = [
    "t_s",
    "command_v",
    "command_a",
    "command_nm",
    "counts",
    "seq",
    "host_t_s",
    "velocity_rad_s",
    "flags",
    "supply_v",
    "current_a",
];

/// The CSV part of a file.
struct Table<R> {
    rows: csv::Reader<io::Chain<io::Cursor<Vec<u8>>, R>>,
    names: Vec<String>,
    header_lines: usize,
}

impl<R: Read> Table<R> {
    fn new(source: R, header_lines: usize) -> Result<Self, ReadProblem> {
        // The names may be from another file, with its mark.
        let source = without_byte_order_mark(source).map_err(ReadProblem::Io)?;
        let mut rows = csv::ReaderBuilder::new()
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(source);
        let line = header_lines as u64 + 1;
        let names: Vec<String> = match rows.headers() {
            Ok(names) => names.iter().map(str::to_owned).collect(),
            Err(error) => return Err(csv_problem(error, header_lines)),
        };
        if names.iter().all(String::is_empty) {
            return Err(ReadProblem::NoColumns);
        }
        let mut seen = HashSet::new();
        if let Some(twice) = names.iter().find(|name| !seen.insert(name.as_str())) {
            let column = shortened(twice, 40);
            return Err(ReadProblem::ColumnTwice { line, column });
        }
        Ok(Self {
            rows,
            names,
            header_lines,
        })
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|found| found == name)
    }

    fn needed(&self, name: &'static str) -> Result<usize, ReadProblem> {
        self.place(name).ok_or_else(|| ReadProblem::MissingColumn {
            line: self.header_lines as u64 + 1,
            column: name,
            found: shortened(&self.names.join(", "), 400),
        })
    }
}

fn csv_problem(error: csv::Error, header_lines: usize) -> ReadProblem {
    let row = error.position().map_or(0, csv::Position::line) + header_lines as u64;
    match error.into_kind() {
        csv::ErrorKind::Io(error) => ReadProblem::Io(error),
        _ => ReadProblem::BadCell {
            row,
            column: "(any)",
            found: "bytes".to_owned(),
            expected: "UTF-8 text",
        },
    }
}

/// What a message shows of a text that may be long.
fn shortened(text: &str, most_chars: usize) -> String {
    let mut short: String = text.chars().take(most_chars).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

/// One cell and where it stands, for messages.
struct TextCell<'a> {
    text: &'a str,
    column: &'static str,
    row: u64,
}

impl TextCell<'_> {
    fn bad(&self, expected: &'static str) -> ReadProblem {
        ReadProblem::BadCell {
            row: self.row,
            column: self.column,
            found: shortened(self.text, 40),
            expected,
        }
    }

    fn number(&self) -> Result<f64, ReadProblem> {
        let number = self.text.parse::<f64>().ok().filter(|n| n.is_finite());
        number.ok_or_else(|| self.bad("a finite number"))
    }

    fn whole<T: std::str::FromStr>(&self) -> Result<T, ReadProblem> {
        // Spreadsheets write whole numbers as 12.0.
        let digits = self
            .text
            .split_once('.')
            .map_or(self.text, |(digits, rest)| {
                if rest.bytes().all(|b| b == b'0') {
                    digits
                } else {
                    self.text
                }
            });
        digits
            .parse()
            .map_err(|_| self.bad("a whole number of at most 64 bits"))
    }
}

/// Reads all rows into the run's columns. The last row's line, where that row was whole.
fn fill<R: Read>(
    run: &mut Run,
    mut table: Table<R>,
    notes: &mut Vec<ReadNote>,
) -> Result<Option<u64>, ReadProblem> {
    let kinds = [
        CommandKind::Voltage,
        CommandKind::Current,
        CommandKind::Torque,
    ];
    let present = kinds
        .into_iter()
        .find(|kind| table.place(kind.column()).is_some());
    run.command_kind = present.unwrap_or_default();
    let places = Places {
        time: table.needed("t_s")?,
        command: table.needed(run.command_kind.column())?,
        counts: table.needed("counts")?,
        seq: table.place("seq"),
        host: table.place("host_t_s"),
        velocity: table.place("velocity_rad_s"),
        flags: table.place("flags"),
        supply: table.place("supply_v"),
        current: table.place("current_a"),
    };
    let left_out = table
        .names
        .iter()
        .filter(|name| !KNOWN.contains(&name.as_str()) && !name.is_empty());
    let names: Vec<String> = left_out.cloned().collect();
    if !names.is_empty() {
        notes.push(ReadNote::ColumnsLeftOut { names });
    }
    run.seq = places.seq.map(|_| Vec::new());
    run.host_t_s = places.host.map(|_| Vec::new());
    run.velocity_rad_s = places.velocity.map(|_| Vec::new());
    run.flags = places.flags.map(|_| Vec::new());
    run.measured_supply_v = places.supply.map(|_| Vec::new());
    run.measured_current_a = places.current.map(|_| Vec::new());

    let mut record = csv::StringRecord::new();
    let mut waiting: Option<ReadProblem> = None;
    let mut last_row = None;
    loop {
        match table.rows.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => match csv_problem(error, table.header_lines) {
                problem @ ReadProblem::Io(_) => return Err(problem),
                problem => {
                    waiting = Some(waiting.unwrap_or(problem));
                    continue;
                }
            },
        }
        // A row that does not fit is torn off if it is the last one, and an error if another follows.
        if let Some(problem) = waiting {
            return Err(problem);
        }
        let line = record.position().map_or(0, csv::Position::line) + table.header_lines as u64;
        if run.len() == MAX_ROWS {
            return Err(ReadProblem::TooLong { rows: MAX_ROWS });
        }
        match places.push(run, &record, table.names.len(), line) {
            Ok(()) => last_row = Some(line),
            Err(problem) => waiting = Some(problem),
        }
    }
    if let Some(problem) = waiting {
        let (ReadProblem::BadCell { row, .. } | ReadProblem::CellCount { row, .. }) = problem
        else {
            return Err(problem);
        };
        if run.complete {
            return Err(problem);
        }
        notes.push(ReadNote::TornTail { row });
        return Ok(None);
    }
    Ok(last_row)
}

/// Where each column stands in a row.
struct Places {
    time: usize,
    command: usize,
    counts: usize,
    seq: Option<usize>,
    host: Option<usize>,
    velocity: Option<usize>,
    flags: Option<usize>,
    supply: Option<usize>,
    current: Option<usize>,
}

impl Places {
    /// Reads a whole row, or leaves the run as it was.
    fn push(
        &self,
        run: &mut Run,
        record: &csv::StringRecord,
        expected: usize,
        row: u64,
    ) -> Result<(), ReadProblem> {
        if record.len() != expected {
            let found = record.len();
            return Err(ReadProblem::CellCount {
                row,
                found,
                expected,
            });
        }
        let cell = |at: usize, column: &'static str| TextCell {
            text: record.get(at).unwrap_or_default(),
            column,
            row,
        };
        let optional = |at: Option<usize>, column| at.map(|at| cell(at, column));
        // A measured value that a sample lacks is an empty cell.
        let measured = |cell: Option<TextCell>| match cell {
            Some(cell) if cell.text.is_empty() => Ok(Some(f64::NAN)),
            Some(cell) => cell.number().map(Some),
            None => Ok(None),
        };
        let time = cell(self.time, "t_s").number()?;
        let command = cell(self.command, run.command_kind.column()).number()?;
        let counts = cell(self.counts, "counts").whole()?;
        let seq = optional(self.seq, "seq")
            .map(|cell| cell.whole())
            .transpose()?;
        let host = measured(optional(self.host, "host_t_s"))?;
        let velocity = match optional(self.velocity, "velocity_rad_s") {
            Some(cell) if cell.text.is_empty() => Some(None),
            Some(cell) => Some(Some(cell.number()?)),
            None => None,
        };
        let flags = optional(self.flags, "flags")
            .map(|cell| {
                let flags = cell.text.parse();
                flags.map_err(|_| {
                    cell.bad("a list of overrun, dropped, encoder_error, saturated joined by +")
                })
            })
            .transpose()?;
        let supply = measured(optional(self.supply, "supply_v"))?;
        let current = measured(optional(self.current, "current_a"))?;
        if let Some(&before) = run.t_s.last()
            && time <= before
        {
            return Err(ReadProblem::TimeNotRising {
                row,
                before,
                after: time,
            });
        }
        if let Some(&before) = run.t_s.last()
            && time - before > LONGEST_GAP_S
        {
            return Err(ReadProblem::TimeJumps {
                row,
                before,
                after: time,
            });
        }
        run.t_s.push(time);
        run.command.push(command);
        run.counts.push(counts);
        push_to(&mut run.seq, seq);
        push_to(&mut run.host_t_s, host);
        push_to(&mut run.velocity_rad_s, velocity);
        push_to(&mut run.flags, flags);
        push_to(&mut run.measured_supply_v, supply);
        push_to(&mut run.measured_current_a, current);
        Ok(())
    }
}

fn push_to<T>(column: &mut Option<Vec<T>>, value: Option<T>) {
    if let Some((column, value)) = column.as_mut().zip(value) {
        column.push(value);
    }
}

/// What can be said only when all rows are there.
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

/// Fails on a line longer than [`MAX_LINE_BYTES`], before anything gathers it in memory. Line ends within
/// quotes end no line.
struct LineLimit<'a, R> {
    source: R,
    line: u64,
    length: usize,
    quoted: bool,
    comment: bool,
    last_byte: &'a Cell<u8>,
}

impl<'a, R: Read> LineLimit<'a, R> {
    fn new(source: R, last_byte: &'a Cell<u8>) -> Self {
        Self {
            source,
            line: 1,
            length: 0,
            quoted: false,
            comment: false,
            last_byte,
        }
    }
}

impl<R: Read> Read for LineLimit<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.source.read(buffer)?;
        if let Some(&last) = buffer[..count].last() {
            self.last_byte.set(last);
        }
        for &byte in &buffer[..count] {
            self.length += 1;
            // Header lines may hold single quotation marks.
            self.comment |= self.length == 1 && byte == b'#';
            self.quoted ^= byte == b'"' && !self.comment;
            if byte == b'\n' && !self.quoted {
                self.line += 1;
                self.length = 0;
                self.comment = false;
            } else if self.length > MAX_LINE_BYTES {
                let line = self.line;
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    format!(
                        "line {line} is longer than {MAX_LINE_BYTES} bytes: this is no run file"
                    ),
                ));
            }
        }
        Ok(count)
    }
}
