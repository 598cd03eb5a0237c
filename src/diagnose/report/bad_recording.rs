//! Diagnosis of a recording with a fatal finding, without statements about the motor.

use serde::Serialize;

use super::{SHAPE, Verdict};
use crate::check::{Finding, Severity};

/// The document in the shape [`SHAPE`] with the verdict `bad_recording`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BadRecording {
    /// [`SHAPE`].
    pub shape: &'static str,
    /// [`Verdict::BadRecording`].
    pub verdict: Verdict,
    /// Fatal findings first, with their remedies.
    pub sentence: String,
    /// Probability of the verdict: a finding is a fact.
    pub probability: f64,
    /// Every finding, the fatal ones first.
    pub data: Vec<Finding>,
    /// Computing time in s.
    pub elapsed_s: f64,
    #[serde(flatten)]
    nothing: Nothing,
}

/// Empty parts: the next experiment is the same one, corrected.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
struct Nothing {
    effects: [(); 0],
    classes: [(); 0],
    budget: [(); 0],
    causes: [(); 0],
    sets: [(); 0],
    steps: [(); 0],
    unexplained: Option<()>,
    identifiable: Option<()>,
    r#where: Option<()>,
    gap: Option<()>,
    next_experiment: Option<()>,
    scoring: Option<()>,
}

impl BadRecording {
    /// The document for these findings, at least one of which is fatal.
    pub fn of(findings: Vec<Finding>) -> Self {
        let is_fatal = |finding: &&Finding| finding.severity == Severity::Fatal;
        let fatal: Vec<&Finding> = findings.iter().filter(is_fatal).collect();
        Self {
            shape: SHAPE,
            verdict: Verdict::BadRecording,
            sentence: sentence(&fatal),
            probability: 1.0,
            data: findings,
            elapsed_s: 0.0,
            nothing: Nothing::default(),
        }
    }
}

fn sentence(fatal: &[&Finding]) -> String {
    let mut whats: Vec<&str> = fatal.iter().map(|found| found.message.as_str()).collect();
    let mut remedies: Vec<&str> = fatal.iter().map(|found| found.remedy.as_str()).collect();
    for words in [&mut whats, &mut remedies] {
        words.dedup();
    }
    format!(
        "bad_recording: the model error was not measured, because the recording is wrong: {}. Next, {}; then check the new recording with `motorlab check`. \
         If the recording is right, `--despite-findings` diagnoses it.",
        whats.join("; "),
        remedies.join("; ")
    )
}
