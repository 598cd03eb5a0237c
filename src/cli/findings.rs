//! Findings about recordings in words, as several subcommands say them.

use std::error::Error;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::Output;
use crate::check::{Finding, Kind, Severity, check};
use crate::motor::Motor;
use crate::plain::{one_line, shown};
use crate::recording::{Run, read_run_from};
use crate::report::number::figure;

/// One finding: what it is and what to do, and beneath it how much it weighs, where, and by which figures.
pub(super) fn words(finding: &Finding) -> String {
    let figures: Vec<String> = (finding.evidence.iter())
        .map(|(name, value)| format!("{name} = {}", figure(*value, 4)))
        .collect();
    format!(
        "{}\n  {} ({}), {}, {:.3} to {:.3} s: {}",
        finding.sentence(),
        finding.severity.word(),
        finding.id(),
        one_line(&finding.run),
        finding.from_s,
        finding.to_s,
        figures.join(", ")
    )
}

/// Checks runs and says what is fatal or a warning; notes are left to `motorlab check`.
pub(super) fn check_and_say(runs: &[Run], motor: Option<&Motor>, output: &Output) -> Vec<Finding> {
    said(check(runs, motor), output)
}

/// Says what is fatal or a warning.
pub(super) fn said(findings: Vec<Finding>, output: &Output) -> Vec<Finding> {
    let (heavy, notes): (Vec<_>, Vec<_>) = findings
        .iter()
        .partition(|finding| finding.severity != Severity::Note);
    for finding in heavy {
        output.message(&words(finding));
    }
    if !notes.is_empty() {
        let ids: Vec<String> = notes.iter().map(|finding| finding.id()).collect();
        output.message(&format!(
            "notes: {} (motorlab check tells more)",
            ids.join(", ")
        ));
    }
    findings
}

/// Longest part of a file that was just written that is looked at, in bytes: some 80,000 samples, four minutes at 3 ms. A recording of
/// hours is not held in memory at its end.
const LOOKED_AT_BYTES: u64 = 4 << 20;

/// The same of run files that were just written, and whether one of them contradicts itself: something fatal, other than that it is
/// short or that nothing was commanded, which a recording may be meant to be. A file that cannot be read back (empty, or ended by an error
/// that has been said) has no findings.
pub(super) fn check_written(paths: &[&Path], output: &Output) -> (Vec<Finding>, bool) {
    let runs: Vec<Run> = paths
        .iter()
        .filter_map(|path| beginning(path, output).ok())
        .collect();
    let findings = check_and_say(&runs, None, output);
    let contradicts = findings.iter().any(|finding| {
        let is_meant = matches!(finding.id, Kind::TooShort | Kind::CommandConstant);
        finding.severity == Severity::Fatal && !is_meant
    });
    (findings, contradicts)
}

/// The beginning of a run file, up to the last whole row of it.
fn beginning(path: &Path, output: &Output) -> Result<Run, Box<dyn Error>> {
    let file = File::open(path)?;
    let is_longer = file.metadata()?.len() > LOOKED_AT_BYTES;
    let mut text = Vec::new();
    file.take(LOOKED_AT_BYTES).read_to_end(&mut text)?;
    if is_longer {
        let whole = text
            .iter()
            .rposition(|byte| *byte == b'\n')
            .map_or(0, |k| k + 1);
        text.truncate(whole);
    }
    let (mut run, _) = read_run_from(text.as_slice(), &path.display().to_string())?;
    run.path = Some(path.to_owned());
    if is_longer && let Some(last_s) = run.t_s.last() {
        output.message(&format!(
            "checked are the first {last_s:.1} s; all of it: motorlab check {}",
            shown(path)
        ));
    }
    Ok(run)
}
