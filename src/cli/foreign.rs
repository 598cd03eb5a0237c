//! A log of another program where a run file is wanted: the message has the command line that imports it.

use std::io::Read;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::Failure;
use super::import::{open, run_name};
use crate::import::{Form, Said, Unclear, understand};
use crate::plain::{quoted, shown};
use crate::recording::{ReadError, ReadProblem};

/// Bytes of the file that are looked at.
const LOOKED_AT_BYTES: u64 = 1 << 18;
/// Columns that a run file made by hand has.
const OWN_COLUMNS: [&str; 2] = ["t_s", "counts"];

/// Not a run file, but a log that can become one.
#[derive(Debug, Error)]
#[error(
    "{error}; this is a log of another program: import it first{blanks}:\n  {line}\nand take {run}"
)]
struct ForeignLog {
    #[source]
    error: ReadError,
    blanks: &'static str,
    line: String,
    run: String,
}

/// Neither a run file nor a log that can become one.
#[derive(Debug, Error)]
#[error("{}: it is no run file of motorlab: {what}", shown(path))]
struct NoRun {
    path: PathBuf,
    what: String,
}

/// Why a run file cannot be read; of a foreign log with the way to import it.
pub fn unreadable(path: &Path, error: ReadError) -> Failure {
    match import_line(path, &error.problem) {
        Found::NoLog(what) => Failure::input(NoRun {
            path: path.to_owned(),
            what,
        })
        .at(path),
        Found::Log(line, blanks) => Failure::input(ForeignLog {
            error,
            blanks,
            line,
            run: quoted(&run_name(path).display().to_string()),
        }),
        Found::Run => Failure::input(error),
    }
}

/// What a file is that cannot be read as a run.
enum Found {
    /// A run file with something wrong in it, or what cannot be read at all.
    Run,
    /// A log of another program: the command line that imports it, and what is open in it.
    Log(String, &'static str),
    /// Neither, and what it is.
    NoLog(String),
}

/// Tells a log of another program from a run file with something wrong in it.
fn import_line(path: &Path, problem: &ReadProblem) -> Found {
    if matches!(
        problem,
        ReadProblem::Io(_) | ReadProblem::Format(_) | ReadProblem::TooLong { .. }
    ) {
        return Found::Run;
    }
    let mut head = Vec::new();
    let read = open(path).map(|file| file.take(LOOKED_AT_BYTES).read_to_end(&mut head));
    if !matches!(read, Ok(Ok(_))) {
        return Found::Run;
    }
    if head.is_empty() {
        return Found::NoLog("it is empty".to_owned());
    }
    let command = format!("motorlab import {}", quoted(&path.display().to_string()));
    match Form::of(&head) {
        Some(form @ Form::NotRead(..)) => {
            let why = form.read(&[]).err().map(|error| error.to_string());
            return Found::NoLog(why.unwrap_or_default());
        }
        Some(_) => return Found::Log(command, ""),
        None => {}
    }
    let is_whole = (head.len() as u64) < LOOKED_AT_BYTES;
    let text = String::from_utf8_lossy(&head);
    let is_of_a_run = |line: &str| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        OWN_COLUMNS.iter().all(|name| cells.contains(name))
    };
    if text.contains("motorlab-run/") || text.lines().any(is_of_a_run) {
        return Found::Run;
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match understand(&head, is_whole, &name, &Said::default(), &command).map {
        Ok(_) => Found::Log(command, ""),
        Err(Unclear::Missing { line, .. }) => Found::Log(line, " (in capitals: to be filled in)"),
        Err(unclear) => Found::NoLog(unclear.to_string()),
    }
}
