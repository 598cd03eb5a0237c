//! A diagnosis: asked as the program asks it, on a thread of its own.

use motorlab::check::{check_training, is_fatal};
use motorlab::diagnose as diagnosing;
use motorlab::diagnose::{
    BadRecording, DiagnoseError, GoodEnough, NominalSource, Options, Role, RunFacts, Settings,
    WithRuns, nominal_fit,
};
use motorlab::hint::Hinted;
use motorlab::motor;
use motorlab::recording;
use motorlab::report::diagnosis::page_held_out;
use pyo3::prelude::*;

use crate::apart::{Given, apart};
use crate::asked::asked;
use crate::failure::refused;
use crate::motor::Motor;
use crate::run::Run;

/// Options besides runs and motor.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Asked<'py> {
    hold_out: Vec<PyRef<'py, Run>>,
    reference: Vec<PyRef<'py, Run>>,
    /// Numbers of runs that repeat each other.
    repeats: Vec<Vec<usize>>,
    good_enough_counts: Option<f64>,
    good_enough_share: Option<f64>,
    despite_findings: bool,
    /// `file` or `fit`; `None` as the program chooses.
    nominal: Option<String>,
}

/// A diagnosis, or the findings that forbid one.
#[pyclass(module = "motorlab._motorlab", frozen)]
pub(crate) struct Diagnosis {
    found: Found,
    runs: Vec<recording::Run>,
    held_out: Vec<recording::Run>,
    facts: Vec<RunFacts>,
}

enum Found {
    Bad(Box<BadRecording>),
    Diagnosis(Box<diagnosing::Diagnosis>),
}

#[pymethods]
impl Diagnosis {
    /// The document `motorlab-diagnosis/3`.
    fn document(&self, py: Python<'_>) -> PyResult<String> {
        let text = match &self.found {
            Found::Bad(document) => serde_json::to_string(&WithRuns::new(document, &self.facts)),
            Found::Diagnosis(diagnosis) => {
                serde_json::to_string(&WithRuns::new(diagnosis, &self.facts))
            }
        };
        text.map_err(|error| refused(py, error))
    }

    /// Motors: nominal, with re-identified parameters, and with the identified effects.
    fn motors(&self) -> Option<(Motor, Motor, Motor)> {
        let of = |inner: &motor::Motor| Motor {
            inner: inner.clone(),
        };
        match &self.found {
            Found::Bad(_) => None,
            Found::Diagnosis(found) => {
                Some((of(&found.nominal), of(&found.refitted), of(&found.model)))
            }
        }
    }

    /// The search, round by round.
    fn explained(&self) -> String {
        match &self.found {
            Found::Bad(document) => document.sentence.clone(),
            Found::Diagnosis(diagnosis) => {
                let rounds = diagnosis.steps.iter();
                rounds.map(|step| step.to_string()).collect()
            }
        }
    }

    /// The page of the program's `--html`.
    fn page(&self, py: Python<'_>, title: &str) -> PyResult<String> {
        match &self.found {
            Found::Bad(document) => Err(refused(
                py,
                Hinted::new(
                    &document.sentence,
                    "correct the recording first: its `findings` name what and how",
                ),
            )),
            Found::Diagnosis(diagnosis) => py
                .detach(|| page_held_out(diagnosis, &self.runs, &self.held_out, title))
                .map_err(|error| refused(py, error)),
        }
    }
}

/// Error budget and identified effects of runs of one motor.
#[pyfunction]
pub(crate) fn diagnose(
    py: Python<'_>,
    runs: Vec<PyRef<'_, Run>>,
    motor: Option<&Motor>,
    asked: Asked<'_>,
) -> PyResult<Diagnosis> {
    let owned = |runs: &[PyRef<'_, Run>]| -> Vec<recording::Run> {
        runs.iter().map(|run| (*run.inner).clone()).collect()
    };
    let question = Question {
        runs: owned(&runs),
        held_out: owned(&asked.hold_out),
        reference: owned(&asked.reference),
        repeats: asked.repeats,
        good_enough: match (asked.good_enough_counts, asked.good_enough_share) {
            (Some(counts), _) => Some(GoodEnough::Counts(counts)),
            (None, share) => share.map(GoodEnough::Share),
        },
        despite_findings: asked.despite_findings,
        is_fitted: match asked.nominal.as_deref() {
            None => None,
            Some("fit") => Some(true),
            Some("file") => Some(false),
            Some(other) => {
                return Err(refused(
                    py,
                    Hinted::new(format!("nominal is '{other}'"), "it is 'file' or 'fit'"),
                ));
            }
        },
        motor: motor.map(|motor| motor.inner.clone()),
    };
    let (runs, held_out) = (question.runs.clone(), question.held_out.clone());
    let facts = RunFacts::of([
        (Role::Diagnosed, &runs),
        (Role::HoldOut, &held_out),
        (Role::Reference, &question.reference),
    ]);
    let found = apart(py, move |given| question.answer(given))?;
    let found = found.map_err(|error| refused(py, error))?;
    Ok(Diagnosis {
        found,
        runs,
        held_out,
        facts,
    })
}

/// Options in the library's types.
pub(crate) struct Question {
    pub(crate) runs: Vec<recording::Run>,
    pub(crate) held_out: Vec<recording::Run>,
    pub(crate) reference: Vec<recording::Run>,
    /// Numbers of runs that repeat each other.
    pub(crate) repeats: Vec<Vec<usize>>,
    pub(crate) good_enough: Option<GoodEnough>,
    pub(crate) despite_findings: bool,
    /// Whether the nominal motor is fitted first; `None` as the program chooses.
    pub(crate) is_fitted: Option<bool>,
    pub(crate) motor: Option<motor::Motor>,
}

impl Question {
    fn answer(self, given: &Given) -> Result<Found, DiagnoseError> {
        let all = [&self.runs[..], &self.held_out, &self.reference].concat();
        // Runs in which nothing moves teach nothing, whatever moves in those that are held out.
        let held_from = self.runs.len();
        let training = [0..held_from, held_from + self.held_out.len()..all.len()];
        let findings = check_training(&all, &training, self.motor.as_ref());
        let is_bad = is_fatal(&findings);
        if is_bad && !self.despite_findings {
            return Ok(Found::Bad(Box::new(BadRecording::of(findings))));
        }
        // The motor file, or the fit in its place, is that of the reference where there is one.
        let first = match self.reference.is_empty() {
            true => &self.runs,
            false => &self.reference,
        };
        let line = asked(&self);
        let is_unknown = self.motor.is_none() && first.iter().any(recording::Run::is_foreign);
        let mut nominal_source = match self.motor {
            Some(_) => NominalSource::Given,
            None => NominalSource::Handout,
        };
        let mut motor = self.motor.unwrap_or_default();
        if self.is_fitted.unwrap_or(is_unknown) {
            let fit = nominal_fit(first, &motor, &Settings::default())?;
            if !fit.is_given {
                nominal_source = NominalSource::Fit;
            }
            motor = fit.motor;
        }
        let options = Options {
            held_out: &self.held_out,
            reference: &self.reference,
            repeats: &self.repeats,
            good_enough: self.good_enough,
            is_doubtful: is_bad,
            nominal_source,
            asked: Some(&line),
            progress: &|_| given.go_on(),
            ..Options::default()
        };
        let mut diagnosis = diagnosing::diagnose(&self.runs, &motor, &options)?;
        diagnosis.set_findings(findings);
        Ok(Found::Diagnosis(Box::new(diagnosis)))
    }
}
