//! Diagnoses all cases of a set in parallel; an interrupted run keeps its finished verdicts.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use serde::{Deserialize, Serialize};

use super::files::{now, sha256, sha256_of, write_whole};
use super::seal::SealedCase;
use super::{BlindError, Diagnoser, Ledger, Manifest, Verdict};
use crate::plain::shown;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct VerdictFile {
    /// `motorlab-blind-verdict/1`.
    pub(super) format: String,
    pub(super) case: String,
    /// The commitment of the case, which ties the verdict to this set.
    pub(super) commitment: String,
    /// Program that made the verdict.
    pub(super) diagnoser: String,
    #[serde(flatten)]
    pub(super) verdict: Verdict,
}

/// Format of a verdict's file.
pub(super) const VERDICT: &str = "motorlab-blind-verdict/1";

/// Progress of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Number of verdicts.
    pub done: usize,
    /// Number of cases in the set.
    pub cases: usize,
    /// Verdicts of this call without a diagnosis.
    pub failed: usize,
}

pub(super) fn verdict_path(directory: &Path, case: &str) -> PathBuf {
    directory.join("verdicts").join(format!("{case}.json"))
}

/// Diagnoses every case without a verdict, `jobs` at a time, and appends the verdicts to the chain. `stop` ends it
/// after the current cases; the next call continues.
///
/// # Errors
/// An opened set, a broken chain, changed files, or a diagnoser that does not start.
pub fn run(
    directory: &Path,
    diagnoser: &dyn Diagnoser,
    jobs: usize,
    stop: &AtomicBool,
    told: &(dyn Fn(Progress) + Sync),
) -> Result<Ledger, BlindError> {
    let manifest = Manifest::read(directory)?;
    if super::opening::opened_path(directory).exists() {
        return Err(BlindError::refused(
            format!(
                "{} has been opened: a verdict from now on would not be blind",
                shown(directory)
            ),
            "make a new set: motorlab blind make DIRECTORY",
        ));
    }
    let _lock = lock_verdicts(directory)?;
    let ledger = Ledger::read(directory)?;
    let left: Vec<&SealedCase> = manifest
        .cases
        .iter()
        .filter(|case| ledger.of(&case.name).is_none())
        .collect();
    let cases = manifest.cases.len();
    told(Progress {
        done: ledger.entries.len(),
        cases,
        failed: 0,
    });
    let failed_cases = AtomicUsize::new(0);
    let next = AtomicUsize::new(0);
    let shared = Mutex::new((ledger, None::<BlindError>));
    let work = || {
        loop {
            let Some(case) = left.get(next.fetch_add(1, Ordering::Relaxed)) else {
                return;
            };
            if stop.load(Ordering::Relaxed) {
                return;
            }
            let outcome = judge_one(directory, case, diagnoser);
            let mut guard = shared.lock().unwrap_or_else(PoisonError::into_inner);
            let (ledger, failed) = &mut *guard;
            let written = outcome.and_then(|(bytes, has_failed)| {
                failed_cases.fetch_add(usize::from(has_failed), Ordering::Relaxed);
                write_whole(&verdict_path(directory, &case.name), &bytes)?;
                ledger.append(&case.name, sha256(&bytes), now())
            });
            match written {
                Ok(()) => told(Progress {
                    done: ledger.entries.len(),
                    cases,
                    failed: failed_cases.load(Ordering::Relaxed),
                }),
                Err(error) => {
                    failed.get_or_insert(error);
                    stop.store(true, Ordering::Relaxed);
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, left.len().max(1)) {
            scope.spawn(work);
        }
    });
    let (ledger, failed) = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.map_or(Ok(ledger), Err)
}

/// Refuses a second run on the same set, as both would append to the chain. The lock lives as long as the returned
/// file.
fn lock_verdicts(directory: &Path) -> Result<File, BlindError> {
    let path = directory.join("verdicts.lock");
    let lock = File::options()
        .create(true)
        .append(true)
        .open(&path)
        .map_err(BlindError::file(&path))?;
    match lock.try_lock() {
        Ok(()) => Ok(lock),
        Err(TryLockError::WouldBlock) => Err(BlindError::refused(
            format!("another `blind run` is running on {}", shown(directory)),
            "wait until it is done; a further call then judges what is left",
        )),
        Err(TryLockError::Error(error)) => Err(BlindError::file(&path)(error)),
    }
}

/// Verifies the files of a case, diagnoses it, and returns the content of the verdict's file and whether it failed.
fn judge_one(
    directory: &Path,
    case: &SealedCase,
    diagnoser: &dyn Diagnoser,
) -> Result<(Vec<u8>, bool), BlindError> {
    for file in case.runs.iter().chain([&case.motor]) {
        check_file(directory, case, file)?;
    }
    let runs: Vec<PathBuf> = case.runs.iter().map(|file| directory.join(file)).collect();
    let verdict = diagnoser.diagnose(&runs, &directory.join(&case.motor))?;
    let file = VerdictFile {
        format: VERDICT.to_owned(),
        case: case.name.clone(),
        commitment: case.commitment.clone(),
        diagnoser: diagnoser.name(),
        verdict,
    };
    serde_json::to_vec_pretty(&file)
        .map(|bytes| (bytes, file.verdict.failure.is_some()))
        .map_err(|error| BlindError::content(&verdict_path(directory, &case.name), error))
}

/// Refuses a file that differs from the sealed one.
pub(super) fn check_file(
    directory: &Path,
    case: &SealedCase,
    file: &str,
) -> Result<(), BlindError> {
    let path = directory.join(file);
    let found = sha256_of(&path)?;
    match case.sha256.get(file) {
        Some(expected) if *expected == found => Ok(()),
        Some(_) => Err(BlindError::altered(format!(
            "{file} was changed after it was sealed"
        ))),
        None => Err(BlindError::altered(format!(
            "{file} has no hash in the manifest"
        ))),
    }
}
