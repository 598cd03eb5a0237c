//! Findings about recordings in words, as several subcommands say them.

use super::Output;
use crate::check::{Finding, Kind, Severity, check};
use crate::motor::Motor;
use crate::recording::{Run, read_run};
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
        finding.run,
        finding.from_s,
        finding.to_s,
        figures.join(", ")
    )
}

/// Checks runs and says what is fatal or a warning; notes are left to `motorlab check`.
pub(super) fn check_and_say(runs: &[Run], motor: Option<&Motor>, output: &Output) -> Vec<Finding> {
    let findings = check(runs, motor);
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

/// The same of run files that were just written, and whether one of them contradicts itself: something fatal, other than that it is
/// short, which a recording may be meant to be. A file that cannot be read back (empty, or ended by an error that has been
/// said) has no findings.
pub(super) fn check_written(paths: &[&std::path::Path], output: &Output) -> (Vec<Finding>, bool) {
    let runs: Vec<Run> = paths
        .iter()
        .filter_map(|path| read_run(path).ok())
        .map(|(run, _)| run)
        .collect();
    let findings = check_and_say(&runs, None, output);
    let contradicts = (findings.iter())
        .any(|finding| finding.severity == Severity::Fatal && finding.id != Kind::TooShort);
    (findings, contradicts)
}
