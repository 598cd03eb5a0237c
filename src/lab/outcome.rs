//! The result of a diagnosis: verdict, effects and errors, and the verdict as text.

use serde::Serialize;

use crate::diagnose::{Diagnosis, Verdict};
use crate::report::number::probability_of;

/// The result of a diagnosis.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// Its verdict.
    pub verdict: Verdict,
    /// The verdict's probability.
    pub probability: f64,
    /// The effects that it names.
    pub effects: Vec<&'static str>,
    /// The verdict as a sentence.
    pub sentence: String,
    /// Held-out prediction error of the nominal model over segments, in counts RMS.
    pub gap_counts: f64,
    /// The same with the identified effects.
    pub after_counts: f64,
    /// Noise floor.
    pub floor_counts: f64,
    /// The command that records the next experiment.
    pub next: Option<String>,
}

impl Outcome {
    pub(super) fn of(found: &Diagnosis) -> Self {
        Self {
            verdict: found.verdict,
            probability: found.probability,
            effects: found.effects.clone(),
            sentence: found.sentence.clone(),
            gap_counts: found.gap.before,
            after_counts: found.gap.after_effect,
            floor_counts: found.gap.floor,
            next: (found.next_experiment.as_ref()).map(|next| next.command.clone()),
        }
    }

    /// The verdict as a sentence.
    pub fn verdict_words(&self) -> String {
        let names: Vec<String> = self.effects.iter().map(|id| id.replace('_', " ")).collect();
        let named = names.join(" and ");
        let p = probability_of("", self.probability);
        match self.verdict {
            Verdict::BadRecording => "The recording has a fatal finding.".to_owned(),
            Verdict::NoGap => "The model describes the recordings; nothing is missing.".to_owned(),
            Verdict::Parameters => {
                format!("Other parameters describe the recordings; no effect is missing ({p}).")
            }
            Verdict::Effect => format!("Cause: {named} ({p})."),
            Verdict::Partial => {
                format!("Cause: {named} ({p}); a part of the error is unexplained.")
            }
            Verdict::Ambiguous => {
                format!("An effect is present ({p}); the recordings do not show which.")
            }
            Verdict::OutsideCatalogue => "No known effect describes the error.".to_owned(),
            Verdict::NoChange => "Nothing has changed since the reference.".to_owned(),
        }
    }

    /// The verdict in a few words.
    pub fn words(&self) -> String {
        let named = self.effects.join(" and ");
        match self.verdict {
            Verdict::BadRecording => "fatal finding".to_owned(),
            Verdict::NoGap => "no gap".to_owned(),
            Verdict::Parameters => "parameter mismatch".to_owned(),
            Verdict::Effect => named,
            Verdict::Partial => format!("{named} and an unexplained part"),
            Verdict::Ambiguous => "ambiguous".to_owned(),
            Verdict::OutsideCatalogue => "outside the catalogue".to_owned(),
            Verdict::NoChange => "no change".to_owned(),
        }
    }
}
