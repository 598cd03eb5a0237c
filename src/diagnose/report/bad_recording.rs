//! What a diagnosis comes to where a finding about the recording is fatal: nothing is asserted about the motor.

use serde::Serialize;

use super::{SHAPE, Verdict};
use crate::check::{Finding, Severity};
use crate::plain::quoted;

/// The document in the shape [`SHAPE`] with the verdict `bad_recording`.
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
    /// No effect is identified.
    pub effects: [&'static str; 0],
    /// No class is identified.
    pub classes: [&'static str; 0],
    /// No error is measured.
    pub budget: [&'static str; 0],
    /// No error is measured.
    pub unexplained: Option<()>,
    /// No effect has a probability.
    pub causes: [&'static str; 0],
    /// No set has a probability.
    pub sets: [&'static str; 0],
    /// Nothing is determined of the motor.
    pub identifiable: Option<()>,
    /// Nothing is located.
    #[serde(rename = "where")]
    pub place: Option<()>,
    /// No error is measured.
    pub gap: Option<()>,
    /// Every finding, the fatal ones first.
    pub data: Vec<Finding>,
    /// The next experiment is the same one, mended.
    pub next_experiment: Option<()>,
    /// Nothing was fitted.
    pub steps: [&'static str; 0],
    /// Nothing was scored.
    pub scoring: Option<()>,
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
            classes: [],
            budget: [],
            unexplained: None,
            causes: [],
            sets: [],
            identifiable: None,
            place: None,
            gap: None,
            data: findings,
            next_experiment: None,
            steps: [],
            scoring: None,
            elapsed_s: 0.0,
        }
    }
}

/// What is wrong, and what to do.
fn sentence(fatal: &[&Finding]) -> String {
    let mut whats: Vec<&str> = fatal.iter().map(|found| found.message.as_str()).collect();
    let mut remedies: Vec<&str> = fatal.iter().map(|found| found.remedy.as_str()).collect();
    let mut runs: Vec<String> = fatal.iter().map(|found| quoted(&found.run)).collect();
    for words in [&mut whats, &mut remedies] {
        words.dedup();
    }
    runs.dedup();
    format!(
        "No gap is measured, because the recording is wrong: {}. Next, {}; then check it again: `motorlab check {}` \
         (--despite-findings diagnoses it all the same).",
        whats.join("; "),
        remedies.join("; "),
        runs.join(" ")
    )
}
