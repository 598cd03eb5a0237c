//! A log of another program where a run file is wanted: the message has the command line that imports it.

use std::io::Read;
use std::path::Path;

use thiserror::Error;

use super::Failure;
use super::import::{open, run_name};
use crate::import::{Form, Said, Unclear, understand};
use crate::plain::quoted;
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

/// Why a run file cannot be read; of a foreign log with the way to import it.
pub fn unreadable(path: &Path, error: ReadError) -> Failure {
    match import_line(path, &error.problem) {
        Some((line, blanks)) => Failure::input(ForeignLog {
            error,
            blanks,
            line,
            run: quoted(&run_name(path).display().to_string()),
        }),
        None => Failure::input(error),
    }
}

/// The command line that imports a file, if it is a log of another program.
fn import_line(path: &Path, problem: &ReadProblem) -> Option<(String, &'static str)> {
    if matches!(
        problem,
        ReadProblem::Io(_) | ReadProblem::Format(_) | ReadProblem::TooLong { .. }
    ) {
        return None;
    }
    let mut head = Vec::new();
    let file = open(path).ok()?;
    file.take(LOOKED_AT_BYTES).read_to_end(&mut head).ok()?;
    let command = format!("motorlab import {}", quoted(&path.display().to_string()));
    match Form::of(&head) {
        Some(Form::NotRead(..)) => return None,
        Some(_) => return Some((command, "")),
        None => {}
    }
    let is_whole = (head.len() as u64) < LOOKED_AT_BYTES;
    let text = String::from_utf8_lossy(&head);
    let is_of_a_run = |line: &str| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        OWN_COLUMNS.iter().all(|name| cells.contains(name))
    };
    if text.contains("motorlab-run/") || text.lines().any(is_of_a_run) {
        return None;
    }
    let name = path.file_name()?.to_string_lossy().into_owned();
    match understand(&head, is_whole, &name, &Said::default(), &command).map {
        Ok(_) => Some((command, "")),
        Err(Unclear::Missing { line, .. }) => Some((line, " (in capitals: to be filled in)")),
        Err(_) => None,
    }
}
