//! What a diagnosis comes to where a finding about the recording is fatal: nothing is asserted about the motor.

use serde::Serialize;

use super::{SHAPE, Verdict};
use crate::check::{Finding, Severity};

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
        let fatal = findings
            .iter()
            .filter(|finding| finding.severity == Severity::Fatal);
        let said: Vec<String> = fatal.map(Finding::sentence).collect();
        Self {
            shape: SHAPE,
            verdict: Verdict::BadRecording,
            sentence: format!(
                "{}. Nothing is diagnosed before that is mended (--despite-findings goes on)",
                said.join(". ")
            ),
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
