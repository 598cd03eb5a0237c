//! What several test files share.

use std::io::Write;

/// Says by name that a test cannot run here. `tests/run` lists these lines at its end.
#[allow(
    dead_code,
    reason = "not every test file that includes this can be skipped"
)]
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
