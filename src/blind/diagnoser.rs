//! The diagnoser: a program with the interface of `motorlab diagnose`. Run files and a motor file in, a diagnosis
//! out, without access to the labels.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::BlindError;
use super::bounded::run_bounded;
use super::files::sha256_of;
use crate::plain::{clipped, one_line, shown};

/// Longest document read, in bytes: this program's have less than one megabyte.
const MOST_OUTPUT_BYTES: u64 = 64 << 20;
/// Characters of a failed diagnoser's messages that are kept in its verdict.
const MOST_OUTPUT_CHARACTERS: usize = 2000;
/// Longest version read, in bytes: one line.
const MOST_VERSION_BYTES: u64 = 200;
/// Longest motor file read, in bytes: as for any motor file.
const MOST_MODEL_BYTES: u64 = 1 << 20;
/// Time limit for its version.
const VERSION_WITHIN: Duration = Duration::from_secs(60);

/// Result of a diagnoser for one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The document `motorlab-diagnosis/1`, `/2` or `/3`; `null` after a failure.
    pub diagnosis: Value,
    /// The motor file with the identified effect, if it wrote one.
    pub model: Option<String>,
    /// Why there is no document.
    pub failure: Option<String>,
    /// Wall time from start to end in s.
    pub wall_s: f64,
}

/// A diagnoser of runs.
pub trait Diagnoser: Sync {
    /// Name and version.
    fn name(&self) -> String;

    /// Diagnoses the runs of one motor. A failure is part of the verdict.
    ///
    /// # Errors
    /// Only if no case can be diagnosed, as when the program does not start.
    fn diagnose(&self, runs: &[PathBuf], motor: &Path) -> Result<Verdict, BlindError>;
}

/// A program, called as `PROGRAM diagnose RUN... --motor MOTOR --model-out FILE --json`: a separate process for every
/// case, in a directory with copies of the case's runs and nominal motor only. Neither its arguments nor its
/// directory reveal the location of the set.
#[derive(Debug, Clone)]
pub struct Program {
    program: PathBuf,
    threads: usize,
    name: String,
}

impl Program {
    /// A program whose processes may each use this many threads (as `RAYON_NUM_THREADS`).
    ///
    /// # Errors
    /// The program cannot be read.
    pub fn new(program: &Path, threads: usize) -> Result<Self, BlindError> {
        let program = program.canonicalize().map_err(BlindError::file(program))?;
        let hash = sha256_of(&program)?;
        let file = program.file_name().unwrap_or_default().to_string_lossy();
        let version = version_of(&program).map_err(BlindError::file(&std::env::temp_dir()))?;
        Ok(Self {
            name: format!(
                "{} (sha256 {})",
                version.unwrap_or(one_line(&file).into_owned()),
                &hash[..16]
            ),
            program,
            threads,
        })
    }
}

impl Diagnoser for Program {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn diagnose(&self, runs: &[PathBuf], motor: &Path) -> Result<Verdict, BlindError> {
        let room = EmptyDirectory::new().map_err(BlindError::file(&std::env::temp_dir()))?;
        let mut names = Vec::with_capacity(runs.len());
        for (k, run) in runs.iter().enumerate() {
            let name = format!("run{}.csv", k + 1);
            fs::copy(run, room.0.join(&name)).map_err(BlindError::file(run))?;
            names.push(name);
        }
        fs::copy(motor, room.0.join("motor.toml")).map_err(BlindError::file(motor))?;
        let started = Instant::now();
        let mut command = in_room(&self.program, &room);
        command
            .arg("diagnose")
            .args(names)
            .args([
                "--motor",
                "motor.toml",
                "--model-out",
                "diagnosed.toml",
                "--json",
            ])
            .env("RAYON_NUM_THREADS", self.threads.to_string());
        let finished = run_bounded(&mut command, MOST_OUTPUT_BYTES, None).map_err(|source| {
            BlindError::Diagnoser {
                program: shown(&self.program),
                source,
            }
        })?;
        let wall_s = started.elapsed().as_secs_f64();
        let model = model_in(&room.0.join("diagnosed.toml"));
        let document = serde_json::from_slice(&finished.output);
        // Status 1: done with a shortfall; the document is complete.
        let (diagnosis, failure) =
            match (finished.status.and_then(|status| status.code()), document) {
                (Some(0 | 1), Ok(document)) => (document, None),
                (Some(0 | 1), Err(error)) => {
                    (Value::Null, Some(format!("no JSON document: {error}")))
                }
                (_, _) => {
                    let words = String::from_utf8_lossy(&finished.messages);
                    let words = clipped(words.trim(), MOST_OUTPUT_CHARACTERS);
                    let status = finished
                        .status
                        .map_or(String::new(), |status| status.to_string());
                    (Value::Null, Some(format!("{status}: {words}")))
                }
            };
        Ok(Verdict {
            diagnosis,
            model,
            failure,
            wall_s,
        })
    }
}

/// The written motor file, unless it is too long.
fn model_in(path: &Path) -> Option<String> {
    let mut text = String::new();
    let file = fs::File::open(path).ok()?.take(MOST_MODEL_BYTES + 1);
    io::BufReader::new(file).read_to_string(&mut text).ok()?;
    (text.len() as u64 <= MOST_MODEL_BYTES).then_some(text)
}

/// The first line of `PROGRAM --version`, also run in an empty directory.
fn version_of(program: &Path) -> io::Result<Option<String>> {
    let room = EmptyDirectory::new()?;
    let mut command = in_room(program, &room);
    command.arg("--version");
    let Ok(finished) = run_bounded(&mut command, MOST_VERSION_BYTES, Some(VERSION_WITHIN)) else {
        return Ok(None);
    };
    let text = String::from_utf8_lossy(&finished.output);
    let line = text.lines().next().unwrap_or_default().trim();
    let says = finished.status.is_some_and(|status| status.success()) && !line.is_empty();
    Ok(says.then(|| one_line(line).into_owned()))
}

/// The command of a program in a directory that does not reveal the location of the set.
fn in_room(program: &Path, room: &EmptyDirectory) -> Command {
    let mut command = Command::new(program);
    command
        .current_dir(&room.0)
        .env("PWD", &room.0)
        .env_remove("OLDPWD");
    command
}

/// A temporary directory, removed on drop.
struct EmptyDirectory(PathBuf);

impl EmptyDirectory {
    fn new() -> io::Result<Self> {
        let mut k = 0_u32;
        loop {
            let name = format!("motorlab-blind-{}-{k}", std::process::id());
            let path = std::env::temp_dir().join(name);
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Self(path)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => k += 1,
                Err(error) => return Err(error),
            }
        }
    }
}

impl Drop for EmptyDirectory {
    fn drop(&mut self) {
        // A leftover contains only copies.
        let _ = fs::remove_dir_all(&self.0);
    }
}
