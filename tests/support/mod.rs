//! Shared by the tests: one folder of `tests` is one test binary, each file in it a module, and this one is a module
//! of all.
#![allow(dead_code, reason = "no test binary uses all of it")]

pub mod command;
pub mod fires;
pub mod foreign_logs;
pub mod json_schema;
pub mod log_by_hand;
pub mod pages;
pub mod process;
pub mod reversed;
pub mod table;

use std::io::Write;

/// Reports that a test cannot run here. `tests/run` lists these lines at its end.
pub fn skip(test: &str, why: &str) {
    eprintln!("SKIPPED {test}: {why}");
    let Some(path) = std::env::var_os("MOTORLAB_SKIP_LOG") else {
        return;
    };
    let log = std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(path);
    if let Ok(mut log) = log {
        writeln!(log, "{test}: {why}").expect("the skip log can be written");
    }
}

/// Folder of the recordings of real motors; without it the test is skipped.
pub fn real_recordings(test: &str) -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("MOTORLAB_REAL").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/real"),
        std::path::PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    skip(test, "no recordings in ../shared/real (or MOTORLAB_REAL)");
    None
}
