//! Findings about recordings as text, for several subcommands.

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

/// Findings as text, the most severe first. Short: one per kind and severity, with the other runs that have it; long:
/// each with its figures.
pub(super) fn listed(findings: &[Finding], at_length: bool) -> Vec<String> {
    if at_length {
        return findings
            .iter()
            .map(|finding| format!("{}: {}", short(finding), figures(finding)))
            .collect();
    }
    let mut told: Vec<(&Finding, Vec<&Finding>)> = Vec::new();
    for finding in findings {
        let same = |(first, _): &&mut (&Finding, Vec<&Finding>)| {
            (first.id, first.severity) == (finding.id, finding.severity)
        };
        match told.iter_mut().find(same) {
            Some((_, more)) => more.push(finding),
            None => told.push((finding, Vec::new())),
        }
    }
    told.iter()
        .map(|(first, more)| {
            let mut text = short(first);
            if !more.is_empty() {
                let mut runs: Vec<&str> = more.iter().map(|finding| finding.run.as_str()).collect();
                runs.dedup();
                let named: Vec<_> = runs
                    .iter()
                    .take(MOST_RUNS)
                    .map(|run| one_line(run))
                    .collect();
                let others = match runs.len().saturating_sub(MOST_RUNS) {
                    0 => String::new(),
                    1 => " and another run".to_owned(),
                    others => format!(" and {others} other runs"),
                };
                text.push_str(&format!(
                    "\n  and {} more in {}{others} (motorlab check --verbose)",
                    more.len(),
                    named.join(", ")
                ));
            }
            text
        })
        .collect()
}

/// Most further runs named with a finding.
const MOST_RUNS: usize = 3;

/// Message and remedy, then severity and place.
fn short(finding: &Finding) -> String {
    format!(
        "{}\n  {} ({}), {}, {:.3} to {:.3} s",
        finding.sentence(),
        finding.severity.word(),
        finding.id(),
        one_line(&finding.run),
        finding.from_s,
        finding.to_s,
    )
}

fn figures(finding: &Finding) -> String {
    let figures: Vec<String> = (finding.evidence.iter())
        .map(|(name, value)| format!("{name} = {}", figure(*value, 4)))
        .collect();
    figures.join(", ")
}

/// Checks runs and prints the findings, each kind once.
pub(super) fn check_and_print(
    runs: &[Run],
    motor: Option<&Motor>,
    output: &Output,
) -> Vec<Finding> {
    print_findings(check(runs, motor), output)
}

/// Prints findings, each kind once.
pub(super) fn print_findings(findings: Vec<Finding>, output: &Output) -> Vec<Finding> {
    for text in listed(&findings, false) {
        output.message(&text);
    }
    findings
}

/// Longest part of a written file that is checked, in bytes: some 80,000 samples, four minutes at 3 ms, so that a
/// recording of hours is not loaded into memory.
const EXAMINED_BYTES: u64 = 4 << 20;

/// As [`check_and_print`] for files that were just written. The flag: one of them has a fatal finding other than too
/// short or a constant command, which may be intended. A file that cannot be read back (empty, or ended by a reported
/// error) has no findings.
pub(super) fn check_written(paths: &[&Path], output: &Output) -> (Vec<Finding>, bool) {
    let runs: Vec<Run> = paths
        .iter()
        .filter_map(|path| beginning(path, output).ok())
        .collect();
    let findings = check_and_print(&runs, None, output);
    let contradicts = findings.iter().any(|finding| {
        let is_meant = matches!(finding.id, Kind::TooShort | Kind::CommandConstant);
        finding.severity == Severity::Fatal && !is_meant
    });
    (findings, contradicts)
}

/// The beginning of a run file, up to its last complete row.
fn beginning(path: &Path, output: &Output) -> Result<Run, Box<dyn Error>> {
    let file = File::open(path)?;
    let is_longer = file.metadata()?.len() > EXAMINED_BYTES;
    let mut text = Vec::new();
    file.take(EXAMINED_BYTES).read_to_end(&mut text)?;
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
