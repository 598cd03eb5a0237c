//! The CSV part of a run file: column names, then rows, each complete or rejected.

use std::collections::HashSet;
use std::io::{self, Read};

use super::line_limit::without_byte_order_mark;
use super::read_error::{ReadNote, ReadProblem};
use super::reader::shortened;
use super::{CommandKind, Run};
use crate::motor::plausible;

/// Most rows of a run: four hours at 333 Hz, 400 MB in memory.
pub(crate) const MAX_ROWS: usize = 5_000_000;

/// The known columns.
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

pub(super) struct Table<R> {
    rows: csv::Reader<io::Chain<io::Cursor<Vec<u8>>, R>>,
    names: Vec<String>,
    header_lines: usize,
}

impl<R: Read> Table<R> {
    /// Reads the column names.
    pub fn new(source: R, header_lines: usize) -> Result<Self, ReadProblem> {
        // The CSV part may come from another file, with its byte order mark.
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

/// One cell and its place, for messages.
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

    /// A time in s.
    fn time(&self) -> Result<f64, ReadProblem> {
        self.number_in(plausible::TIME_S)
    }

    /// A command, or a measured value of the drive.
    fn drive(&self) -> Result<f64, ReadProblem> {
        self.number_in(plausible::COMMAND)
    }

    /// A number that a motor, an encoder or a clock can give.
    fn number_in(&self, range: plausible::Range) -> Result<f64, ReadProblem> {
        let number = self.number()?;
        self.held(number, range).map(|()| number)
    }

    fn held(&self, number: f64, range: plausible::Range) -> Result<(), ReadProblem> {
        if range.holds(number) {
            return Ok(());
        }
        Err(ReadProblem::Implausible {
            row: self.row,
            column: self.column,
            found: plausible::Shown(number).to_string(),
            range: range.to_string(),
        })
    }

    fn whole<T: std::str::FromStr>(&self) -> Result<T, ReadProblem> {
        // Spreadsheets write integers as 12.0.
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

/// Reads all rows into the run's columns. Returns the line of the last complete row.
pub(super) fn fill<R: Read>(
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
        // An invalid row is incomplete if it is the last one, and an error if another follows.
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

/// Index of each column in a row.
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
    /// Adds a complete row, or leaves the run unchanged.
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
        // A missing measured value is an empty cell.
        type Read = fn(&TextCell<'_>) -> Result<f64, ReadProblem>;
        let measured = |cell: Option<TextCell<'_>>, read: Read| match cell {
            Some(cell) if cell.text.is_empty() => Ok(Some(f64::NAN)),
            Some(cell) => read(&cell).map(Some),
            None => Ok(None),
        };
        let time = cell(self.time, "t_s").time()?;
        let command = cell(self.command, run.command_kind.column()).drive()?;
        let counted = cell(self.counts, "counts");
        let counts: i64 = counted.whole()?;
        counted.held(counts as f64, plausible::COUNTS)?;
        let seq = optional(self.seq, "seq")
            .map(|cell| cell.whole())
            .transpose()?;
        let host = measured(optional(self.host, "host_t_s"), |cell| cell.time())?;
        let velocity = match optional(self.velocity, "velocity_rad_s") {
            Some(cell) if cell.text.is_empty() => Some(None),
            Some(cell) => Some(Some(cell.number()?)),
            None => None,
        };
        let flags = optional(self.flags, "flags")
            .map(|cell| {
                let flags = cell.text.parse();
                flags.map_err(|_| {
                    cell.bad("a list of overrun, dropped, encoder_error, saturated, time_leap, counts_leap joined by +")
                })
            })
            .transpose()?;
        let supply = measured(optional(self.supply, "supply_v"), |cell| cell.drive())?;
        let current = measured(optional(self.current, "current_a"), |cell| cell.drive())?;
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
            && time - before > plausible::GAP_S.hi
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
