//! A log of another program in place of a run file: it is imported on the way, if it is unambiguous.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use thiserror::Error;

use super::import::{open, run_name};
use super::import_flags::Flags;
use super::import_words::{print_rows, print_understood};
use super::progress::FileProgress;
use super::{Failure, Output};
use crate::hint::{In, parted};
use crate::import::{Form, GivenFlags, Kind, Source, Unclear, import, understand};
use crate::plain::{quoted, shown};
use crate::recording::{ReadError, ReadNote, ReadProblem, Run, read_run, read_run_from};

/// Bytes of the file that are examined.
const EXAMINED_BYTES: u64 = 1 << 18;

/// A log that has to be imported first.
#[derive(Debug, Error)]
#[error(
    "{}; this is a log of another program\nhint: import it first{blanks}, then take {run}:\n  {line}",
    parted(&error.to_string()).0
)]
struct ForeignLog {
    #[source]
    error: ReadError,
    blanks: &'static str,
    line: String,
    run: String,
}

/// Neither a run file nor a log that can be imported.
#[derive(Debug, Error)]
#[error("{}: it is no run file of motorlab: {what}", shown(path))]
struct NoRun {
    path: PathBuf,
    what: String,
}

/// Runs, with the notes of their reading.
pub(super) type RunsRead = Vec<(Run, Vec<ReadNote>)>;

/// Reads a run file, or imports a log of another program with `flags` for what it does not state.
pub(super) fn read_runs(path: &Path, flags: &Flags, output: &Output) -> Result<RunsRead, Failure> {
    let error = match read_run(path) {
        Ok(found) => return Ok(vec![found]),
        Err(error) => error,
    };
    match kind(path, &error.problem) {
        Kind::Run => Err(Failure::input(error)),
        Kind::NoLog(what) => Err(no_run(path, what)),
        Kind::Log => imported(path, flags, output),
    }
}

/// Refuses flags for foreign logs if all files are runs; those of the configuration file are kept for the next log.
pub(super) fn refuse_unused(flags: &Flags, runs: &[Run], output: &Output) -> Result<(), Failure> {
    let given = flags.given().flags();
    let explicit = |(flag, _): &&(&str, String)| {
        let name = flag.split('=').next().unwrap_or(flag);
        !output
            .configured
            .iter()
            .any(|configured| configured == name)
    };
    match given.iter().find(explicit) {
        Some((flag, _)) if !runs.iter().any(Run::is_foreign) => Err(Failure::wrong(
            format!(
                "{flag}: it describes a log of another program, and these are run files, which describe themselves"
            ),
            format!("leave {flag} out"),
        )),
        _ => Ok(()),
    }
}

fn no_run(path: &Path, what: String) -> Failure {
    let path = path.to_owned();
    let failure = NoRun {
        path: path.clone(),
        what,
    };
    Failure::input(failure).at(&path)
}

/// Imports a log into a temporary folder and reads the runs.
fn imported(path: &Path, flags: &Flags, output: &Output) -> Result<RunsRead, Failure> {
    let name = name_of(path);
    let mut source = Source::new(Box::new(FileProgress::new(open(path)?, &name)), &name)
        .map_err(|error| no_run(path, error.to_string()))?;
    let reading = source.understand(&name, &flags.given(), &command_line());
    let reading = reading.map_err(|error| Failure::input(In::new(&*name, error)))?;
    let ready = match reading.map {
        Ok(ready) => ready,
        Err(unclear @ (Unclear::NoTable(_) | Unclear::NoText(_))) => {
            return Err(no_run(path, unclear.to_string()));
        }
        Err(unclear) => {
            print_understood(output, &name, &reading.understood, &reading.notes);
            return Err(Failure::input(In::new(&*name, unclear)).at(path));
        }
    };
    print_understood(output, &name, &reading.understood, &reading.notes);
    let directory = tempfile::tempdir().map_err(Failure::device)?;
    let target = directory.path().join("run.csv");
    let imported = import(source.read(), &name, &ready.map, &target)
        .map_err(|error| Failure::input(error).at(path))?;
    print_rows(output, &name, &imported, None);
    let of_run = |at: &Path| {
        let file = File::open(at).map_err(Failure::device)?;
        let (mut run, notes) = read_run_from(file, &name).map_err(Failure::input)?;
        run.path = Some(path.to_owned());
        Ok((run, notes))
    };
    imported.runs.iter().map(|run| of_run(&run.path)).collect()
}

/// The command line of this call without the flags about a log, which are added again.
fn command_line() -> String {
    let known = Flags::augment_args(clap::Command::new("log"));
    let takes_value = |word: &str| {
        let name = word.strip_prefix("--")?;
        let (name, has_value) = match name.split_once('=') {
            Some((name, _)) => (name, true),
            None => (name, false),
        };
        let flag = known
            .get_arguments()
            .find(|flag| flag.get_long() == Some(name))?;
        let takes = flag.get_action().takes_values() && !flag.is_require_equals_set();
        Some(takes && !has_value)
    };
    let mut words = std::env::args().skip(1);
    let mut line = "motorlab".to_owned();
    while let Some(word) = words.next() {
        match takes_value(&word) {
            Some(true) => drop(words.next()),
            Some(false) => {}
            None => {
                line.push(' ');
                line.push_str(&quoted(&word));
            }
        }
    }
    line
}

/// Error of a run file that cannot be read; for a foreign log with the command that imports it.
pub fn unreadable(path: &Path, error: ReadError) -> Failure {
    match import_line(path, &error.problem) {
        Found::NoLog(what) => no_run(path, what),
        Found::Log(line, blanks) => Failure::input(ForeignLog {
            error,
            blanks,
            line,
            run: quoted(&run_name(path).display().to_string()),
        }),
        Found::Run => Failure::input(error),
    }
}

/// Kind of a file that cannot be read as a run.
enum Found {
    /// A damaged run file, or an unreadable file.
    Run,
    /// A log of another program: the command line that imports it, and its open parts.
    Log(String, &'static str),
    /// Neither, with its description.
    NoLog(String),
}

/// Distinguishes a foreign log from a damaged run file.
fn kind(path: &Path, problem: &ReadProblem) -> Kind {
    match head(path, problem) {
        Some(head) => Kind::of(&head, &name_of(path)),
        None => Kind::Run,
    }
}

fn name_of(path: &Path) -> Cow<'_, str> {
    path.file_name().unwrap_or_default().to_string_lossy()
}

/// The beginning of a file that is not a run; `None` if it cannot be read, or is a run that is too long.
fn head(path: &Path, problem: &ReadProblem) -> Option<Vec<u8>> {
    if matches!(
        problem,
        ReadProblem::Io(_) | ReadProblem::Format(_) | ReadProblem::TooLong { .. }
    ) {
        return None;
    }
    let mut head = Vec::new();
    open(path)
        .ok()?
        .take(EXAMINED_BYTES)
        .read_to_end(&mut head)
        .ok()?;
    Some(head)
}

fn form(path: &Path, head: &[u8]) -> Option<Form> {
    Form::of(head).or_else(|| Form::of_name(&name_of(path)))
}

fn import_line(path: &Path, problem: &ReadProblem) -> Found {
    match kind(path, problem) {
        Kind::Run => return Found::Run,
        Kind::NoLog(what) => return Found::NoLog(what),
        Kind::Log => {}
    }
    let Some(head) = head(path, problem) else {
        return Found::Run;
    };
    let command = format!("motorlab import {}", quoted(&path.display().to_string()));
    if form(path, &head).is_some() {
        return Found::Log(command, "");
    }
    let is_whole = (head.len() as u64) < EXAMINED_BYTES;
    let name = name_of(path);
    match understand(&head, is_whole, &name, &GivenFlags::default(), &command).map {
        Ok(_) => Found::Log(command, ""),
        Err(Unclear::Missing { line, .. }) => Found::Log(line, " (in capitals: to be filled in)"),
        Err(unclear) => Found::NoLog(unclear.to_string()),
    }
}
