//! Shared parts of tests of `check`: findings as lines of a snapshot, and reversed runs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use motorlab::check::{Finding, Kind, Severity, check};
use motorlab::recording::Run;

/// `id (severity)` of each, sorted and unique.
pub fn words(findings: &[Finding]) -> String {
    let mut words: Vec<String> = findings
        .iter()
        .map(|finding| format!("{} ({})", finding.id(), finding.severity.word()))
        .collect();
    words.sort();
    words.dedup();
    if words.is_empty() {
        return "nothing".to_owned();
    }
    words.join(", ")
}

/// A line per group: number of runs, and number of runs by finding.
pub fn grouped(groups: &BTreeMap<String, Vec<Vec<Finding>>>) -> String {
    let mut table = String::new();
    for (name, runs) in groups {
        let mut fires: BTreeMap<String, usize> = BTreeMap::new();
        for findings in runs {
            let mut ids: Vec<String> = findings
                .iter()
                .map(|finding| format!("{} ({})", finding.id(), finding.severity.word()))
                .collect();
            ids.sort();
            ids.dedup();
            for id in ids {
                *fires.entry(id).or_default() += 1;
            }
        }
        let fires: Vec<String> = fires.iter().map(|(id, n)| format!("{id} in {n}")).collect();
        let fires = if fires.is_empty() {
            "nothing".to_owned()
        } else {
            fires.join(", ")
        };
        let _ = writeln!(table, "{name}, {} runs: {fires}", runs.len());
    }
    table
}

pub fn above_a_note(groups: &BTreeMap<String, Vec<Vec<Finding>>>) -> Vec<String> {
    let mut found = Vec::new();
    for (name, runs) in groups {
        for finding in runs
            .iter()
            .flatten()
            .filter(|f| f.severity != Severity::Note)
        {
            found.push(format!("{name}: {} {}", finding.id(), finding.message));
        }
    }
    found
}

pub fn negated(run: &Run) -> Run {
    let mut run = run.clone();
    run.counts.iter_mut().for_each(|n| *n = n.saturating_neg());
    run
}

pub fn is_reversed(runs: &[Run]) -> bool {
    check(runs, None)
        .iter()
        .any(|finding| finding.id == Kind::EncoderReversed)
}
