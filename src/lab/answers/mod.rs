//! Answers to the questions of the handout, by number and topic, with computed figures.
//!
//! The handout does not number its questions: `1.2` is the second one of Part 1. Letters are its objectives, which
//! are no questions.

mod recorded;
mod sampling;
mod step_response;

use serde::Serialize;

use super::missing::Missing;
use super::not_shown::NotShown;
use super::recorded::Recorded;
use super::sampling::Sampling;
use super::{Source, StepResponses};

/// One question and its answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// Part and question, such as `1.2`; a letter for an objective.
    pub number: &'static str,
    /// Question, paraphrased.
    pub topic: &'static str,
    /// The answer in one or two sentences.
    pub short: String,
    /// Basis of the answer.
    pub because: Vec<String>,
}

/// The usable recordings.
fn usable(runs: &[Recorded]) -> Vec<&Recorded> {
    runs.iter()
        .filter(|recorded| recorded.is_usable())
        .collect()
}

/// Why the others are unusable, and their remedies, as sentences after an answer.
fn not_usable(runs: &[Recorded]) -> String {
    let told = runs.iter().filter_map(|recorded| {
        let why = recorded.unusable.as_ref()?;
        Some(format!(" {} is not usable: {why}.", recorded.name()))
    });
    told.collect()
}

const NO_USABLE_RECORDING: &str =
    "Not usable before the fatal finding in the recording is corrected.";

/// All answers, in the handout's order.
pub fn all(
    part_1: &StepResponses,
    part_2: &Sampling,
    part_3: &[Recorded],
    (missing, not_shown): (&Missing, &[NotShown]),
    source: &Source,
) -> Vec<Answer> {
    vec![
        step_response::first_order(part_1),
        step_response::damping(part_1),
        step_response::experiment(part_3, missing, source),
        sampling::plots(part_2),
        sampling::quantisation(part_2),
        sampling::delay(part_2),
        sampling::int16(part_2),
        sampling::smaller_sample_time(part_2),
        recorded::plots(part_3, source),
        recorded::match_now(part_3),
        recorded::missing(part_3, missing, not_shown, source),
    ]
}
