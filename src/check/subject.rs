//! A run under examination: the input of every kind of finding.

use std::collections::BTreeMap;

use super::finding::{Finding, Kind, Severity};
use crate::motor::Motor;
use crate::recording::Run;

/// A run, its name, and its motor file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Subject<'a> {
    /// The run. It has at least one sample.
    pub run: &'a Run,
    /// Path of the run, or its number from 1.
    pub name: &'a str,
    /// The motor file, where one is given.
    pub motor: Option<&'a Motor>,
}

impl Subject<'_> {
    /// A finding about the samples `from` to `to` (inclusive; both are clamped to the run).
    pub fn finding<const N: usize>(
        &self,
        id: Kind,
        severity: Severity,
        (from, to): (usize, usize),
        message: String,
        evidence: [(&'static str, f64); N],
        remedy: impl Into<String>,
    ) -> Finding {
        let last = self.run.t_s.len().saturating_sub(1);
        let at = |sample: usize| self.run.t_s.get(sample.min(last)).copied().unwrap_or(0.0);
        Finding {
            id,
            severity,
            run: self.name.to_owned(),
            from_s: at(from),
            to_s: at(to),
            message,
            evidence: BTreeMap::from(evidence),
            remedy: remedy.into(),
        }
    }

    /// The whole run as an interval for [`Subject::finding`].
    pub fn whole(&self) -> (usize, usize) {
        (0, self.run.len().saturating_sub(1))
    }

    /// Whether the log had this channel (`position` or `command`).
    pub fn has(&self, channel: &str) -> bool {
        has(self.run, channel)
    }
}

/// Whether the log had this channel (`position` or `command`); an import without it fills the column with zeros.
pub(super) fn has(run: &Run, channel: &str) -> bool {
    let imported = run.header.get("imported");
    let said = imported.and_then(|imported| imported.get(channel));
    said.and_then(toml::Value::as_str) != Some("not recorded")
}
