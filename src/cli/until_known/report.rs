//! Texts after each round and at the end.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::bound::Bound;
use super::plan::{Next, Plan};
use crate::check::Finding;
use crate::cli::{Failure, Output, Status};
use crate::diagnose::{Diagnosis, KnownChange, NextExperiment, Verdict};
use crate::plain::{quoted, shown};
use crate::recording::Captured;
use crate::report::number::{probability, probability_of};

/// Version of the document.
const SHAPE: &str = "motorlab-until-known/1";
/// Most causes named in a round's line.
const NAMED: usize = 3;
/// Least inclusion probability of an effect named there.
const NAMED_FROM: f64 = 0.02;

/// Reason for the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Ended {
    Known,
    Bound,
    Stopped,
    /// The proposed recording needs a change on the bench.
    ByHand,
    BadRecording,
}

/// One recording and the verdict after it.
#[derive(Debug, Serialize)]
pub(super) struct Round {
    path: PathBuf,
    profile: String,
    duration_s: f64,
    samples: u64,
    lost: u64,
    /// Known change on the bench for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    change: Option<KnownChange>,
    /// `None` if Ctrl-C came before the end of the diagnosis.
    verdict: Option<Verdict>,
    probability: Option<f64>,
    effects: Vec<&'static str>,
    /// The next recording, and its purpose.
    next: Option<String>,
    why: Option<String>,
}

impl Round {
    pub fn of(plan: &Plan, captured: &Captured) -> Self {
        Self {
            path: captured.path.clone(),
            profile: plan.profile.clone(),
            duration_s: captured.statistics.duration_s,
            samples: captured.statistics.samples,
            lost: captured.statistics.lost,
            change: plan.change.clone(),
            verdict: None,
            probability: None,
            effects: Vec::new(),
            next: None,
            why: None,
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Records the diagnosis of all runs so far.
    pub fn diagnosed(&mut self, found: &Diagnosis) {
        self.verdict = Some(found.verdict);
        self.probability = Some(found.probability);
        self.effects.clone_from(&found.effects);
    }

    /// Records the next step.
    pub fn then(&mut self, next: &Next) {
        if let Next::Record(plan) = next {
            self.next = Some(plan.profile.clone());
            self.why = Some(plan.why.clone());
        }
    }
}

/// The line of a round: recording, verdict, next recording and its purpose.
pub(super) fn round_line(number: usize, round: &Round, found: &Diagnosis, next: &Next) -> String {
    let lost = match round.lost {
        0 => String::new(),
        lost => format!(", {lost} samples lost"),
    };
    let change = |change: &Option<KnownChange>| {
        (change.as_ref()).map_or(String::new(), |change| format!(" with {}", change.words()))
    };
    let then = match next {
        Next::Nothing => "known".to_owned(),
        Next::Record(plan) => format!(
            "next {}{}, {}",
            plan.profile,
            change(&plan.change),
            plan.why
        ),
        Next::ByHand => "the next recording needs a change on the bench".to_owned(),
    };
    format!(
        "{number}  {} ({}{}{lost}): {}; {then}",
        shown(&round.path),
        round.profile,
        change(&round.change),
        outcome(found)
    )
}

fn outcome(found: &Diagnosis) -> String {
    let named = found.effects.join(" and ");
    let p = |event: &str| probability_of(event, found.probability);
    match found.verdict {
        Verdict::Effect => format!("{named}, {}", p("")),
        Verdict::Partial => format!("{named}, {}, and an unexplained part", p("")),
        Verdict::NoGap => format!("no gap, {}", p("no effect is present")),
        Verdict::Parameters => {
            format!("parameter mismatch, {}", p("no effect is present"))
        }
        Verdict::Ambiguous => format!("ambiguous: {}", most_probable(found)),
        Verdict::OutsideCatalogue => {
            format!("outside the catalogue, {}", p("no effect is present"))
        }
        Verdict::NoChange => format!("no change, {}", p("no effect has changed")),
        Verdict::BadRecording => "a finding about the recording is fatal".to_owned(),
    }
}

fn most_probable(found: &Diagnosis) -> String {
    let causes = (found.causes.iter().take(NAMED)).filter(|cause| cause.inclusion >= NAMED_FROM);
    let named: Vec<String> = causes
        .map(|cause| format!("{} {}", cause.effect, probability(cause.inclusion)))
        .collect();
    named.join(", ")
}

pub(super) fn command_line(rounds: &[Round], motor: Option<&PathBuf>) -> String {
    let word = |path: &Path| quoted(&path.to_string_lossy());
    let runs: Vec<String> = rounds.iter().map(|round| word(round.path())).collect();
    let motor = motor.map_or(String::new(), |motor| format!(" --motor {}", word(motor)));
    format!("motorlab diagnose {}{motor}", runs.join(" "))
}

#[derive(Debug)]
pub(super) struct SessionResult<'a> {
    pub ended: Ended,
    pub bound: Bound,
    pub rounds: &'a [Round],
    pub found: Option<&'a Diagnosis>,
    pub findings: &'a [Finding],
    pub diagnose: String,
}

#[derive(Serialize)]
struct Document<'a> {
    shape: &'static str,
    ended: Ended,
    recorded_s: f64,
    rounds: &'a [Round],
    verdict: Option<Verdict>,
    probability: Option<f64>,
    effects: &'a [&'static str],
    sentence: Option<&'a str>,
    findings: &'a [Finding],
    next_experiment: Option<&'a NextExperiment>,
    diagnose: &'a str,
}

impl SessionResult<'_> {
    pub fn say(&self, output: &Output) -> Result<Status, Failure> {
        let next = self.found.and_then(|found| found.next_experiment.as_ref());
        let next = next.filter(|_| self.ended != Ended::Known);
        if output.json {
            output.document(&Document {
                shape: SHAPE,
                ended: self.ended,
                recorded_s: self.recorded_s(),
                rounds: self.rounds,
                verdict: self.found.map(|found| found.verdict),
                probability: self.found.map(|found| found.probability),
                effects: self.found.map_or(&[], |found| &found.effects),
                sentence: self.found.map(|found| found.sentence.as_str()),
                findings: self.findings,
                next_experiment: next,
                diagnose: &self.diagnose,
            })?;
        } else {
            output.line(&format!("\n{}", self.in_words()))?;
            if let Some(found) = self.found {
                output.line(&found.sentence)?;
            }
            if !self.rounds.is_empty() {
                output.line(&format!("to repeat the diagnosis: {}", self.diagnose))?;
            }
        }
        Ok(match self.ended {
            Ended::Known => Status::Done,
            _ => Status::FellShort,
        })
    }

    fn recorded_s(&self) -> f64 {
        self.rounds.iter().map(|round| round.duration_s).sum()
    }

    fn in_words(&self) -> String {
        let files = match self.rounds {
            [] => return "stopped; nothing was recorded".to_owned(),
            [_] => "one recording".to_owned(),
            several => format!("{} recordings", several.len()),
        };
        let made = format!("{files}, {:.0} s in all", self.recorded_s());
        match self.ended {
            Ended::Known => format!("known after {made}"),
            Ended::Bound => format!(
                "not known yet after {made}; the limit is {}",
                self.bound.words()
            ),
            Ended::Stopped => format!("stopped after {made}; what was recorded is kept"),
            Ended::ByHand => {
                format!(
                    "not known yet after {made}: the next recording needs a change on the bench"
                )
            }
            Ended::BadRecording => {
                format!("ended after {made}: a finding about the recording is fatal")
            }
        }
    }
}
