//! What a diagnosis comes to where a finding about the recording is fatal: nothing is asserted about the motor.

use serde::Serialize;

use super::{SHAPE, Verdict};
use crate::check::{Finding, Severity};
use crate::plain::quoted;

/// The document in the shape `motorlab-diagnosis/2` with the verdict `bad_recording`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BadRecording {
    /// [`SHAPE`].
    pub shape: &'static str,
    /// [`Verdict::BadRecording`].
    pub verdict: Verdict,
    /// What is fatal first, and what to do.
    pub sentence: String,
    /// Probability of what the verdict says: a finding is read off the recording.
    pub probability: f64,
    /// No effect is named.
    pub effects: [&'static str; 0],
    /// No cause is weighed.
    pub causes: [&'static str; 0],
    /// Nothing is located.
    #[serde(rename = "where")]
    pub place: Option<()>,
    /// No gap is measured.
    pub gap: Option<()>,
    /// No set is weighed.
    pub sets: [&'static str; 0],
    /// Every finding, the fatal ones first.
    pub data: Vec<Finding>,
    /// The next experiment is the same one, mended.
    pub next_experiment: Option<()>,
    /// Nothing was fitted.
    pub steps: [&'static str; 0],
    /// How long the diagnosis took in s.
    pub elapsed_s: f64,
}

impl BadRecording {
    /// The document of these findings, of which one at least is fatal.
    pub fn of(findings: Vec<Finding>) -> Self {
        let fatal: Vec<&Finding> = findings
            .iter()
            .filter(|finding| finding.severity == Severity::Fatal)
            .collect();
        Self {
            shape: SHAPE,
            verdict: Verdict::BadRecording,
            sentence: sentence(&fatal),
            probability: 1.0,
            effects: [],
            causes: [],
            place: None,
            gap: None,
            sets: [],
            data: findings,
            next_experiment: None,
            steps: [],
            elapsed_s: 0.0,
        }
    }
}

/// The same four parts as of every verdict: no gap is measured, the cause is in the recording, what to do.
fn sentence(fatal: &[&Finding]) -> String {
    let mut whats: Vec<&str> = fatal.iter().map(|found| found.message.as_str()).collect();
    let mut remedies: Vec<&str> = fatal.iter().map(|found| found.remedy.as_str()).collect();
    let mut runs: Vec<String> = fatal.iter().map(|found| quoted(&found.run)).collect();
    for words in [&mut whats, &mut remedies] {
        words.dedup();
    }
    runs.dedup();
    format!(
        "No gap is measured: the recording itself is wrong. The cause, read off the recording: {}. \
         How far a gap would shrink is not known before that is mended. Next, {}; then look again: `motorlab check {}` \
         (--despite-findings goes on all the same).",
        whats.join("; "),
        remedies.join("; "),
        runs.join(" ")
    )
}
