//! Check, compare and diagnose for the page. Documents are those of the program's `--json`, pages those of `--html`.

use std::path::PathBuf;

use motorlab::check::{Finding, check, check_training, is_fatal};
use motorlab::compare::{Comparison, Overlay, compare as compared};
use motorlab::diagnose::{
    BadRecording, NominalSource, Options, Role, RunFacts, Settings, WithRuns,
    diagnose as diagnosed, nominal_fit,
};
use motorlab::motor::{Model, Motor};
use motorlab::recording::{Run, read_run_from};
use motorlab::report::comparison::page as comparison_page;
use motorlab::report::diagnosis::{bad_recording_page, page_held_out};
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

use crate::failure::{Answer, document, failed};

#[derive(Debug, Deserialize)]
struct RunFile {
    name: String,
    text: String,
}

#[derive(Debug, Deserialize)]
struct Question {
    runs: Vec<RunFile>,
    /// The motor file; `None` for the handout's motor.
    #[serde(default)]
    motor: Option<String>,
    /// The nominal motor is fitted to the runs.
    #[serde(default)]
    fit: Option<bool>,
    #[serde(default)]
    quick: bool,
    #[serde(default)]
    despite_findings: bool,
    /// The equivalent command line, for the sentence about the next step.
    #[serde(default)]
    asked: Option<String>,
}

/// Runs, the motor, and whether a motor file is given.
struct Given {
    question: Question,
    runs: Vec<Run>,
    notes: Vec<Vec<String>>,
    motor: Motor,
}

impl Given {
    fn of(question: &str) -> Result<Self, JsError> {
        let question: Question = serde_json::from_str(question).map_err(failed)?;
        let mut runs = Vec::new();
        let mut notes = Vec::new();
        for file in &question.runs {
            let read = read_run_from(file.text.as_bytes(), &file.name);
            let (mut run, remarks) = read.map_err(failed)?;
            run.path = Some(PathBuf::from(&file.name));
            runs.push(run);
            notes.push(remarks.iter().map(ToString::to_string).collect());
        }
        let motor = match &question.motor {
            Some(text) => Motor::from_toml(text).map_err(failed)?,
            None => Motor::default(),
        };
        Ok(Self {
            question,
            runs,
            notes,
            motor,
        })
    }

    fn motor_file(&self) -> Option<&Motor> {
        self.question.motor.is_some().then_some(&self.motor)
    }
}

#[derive(Debug, Serialize)]
struct Checked<'a> {
    shape: &'static str,
    findings: &'a [Finding],
}

/// Findings about the recordings: the document of `motorlab check --json`.
#[wasm_bindgen]
pub fn check_runs(question: &str) -> Answer {
    let given = Given::of(question)?;
    document(&Checked {
        shape: "motorlab-check/1",
        findings: &check(&given.runs, given.motor_file()),
    })
}

/// A document, its page, and the motor file of a diagnosis or a fit.
#[derive(Debug, Serialize)]
struct Told {
    document: String,
    page: String,
    motor: Option<String>,
}

/// Recorded and simulated runs: the document and the page of `motorlab compare`.
#[wasm_bindgen]
pub fn compare_runs(question: &str) -> Answer {
    let mut given = Given::of(question)?;
    let fits = given.question.fit == Some(true);
    if fits {
        given.motor = nominal_fit(&given.runs, &given.motor, &Settings::default())
            .map_err(failed)?
            .motor;
    }
    let mut overlays: Vec<Overlay> = Vec::new();
    for (run, notes) in given.runs.iter().zip(&given.notes) {
        let name = run.path.as_deref().unwrap_or("run".as_ref()).display();
        let overlay = compared(run, &given.motor, Model::SecondOrder);
        let mut overlay = overlay.map_err(|error| failed(format!("{name}: {error}")))?;
        overlay.figures.notes.clone_from(notes);
        overlays.push(overlay);
    }
    let findings = check(&given.runs, given.motor_file());
    let pairs: Vec<_> = given.runs.iter().zip(&overlays).collect();
    let title = "Recorded against simulated (second order, viscous and Coulomb friction)";
    document(&Told {
        document: document(&Comparison::of(&overlays))?,
        page: comparison_page(&pairs, &findings, &given.motor, title),
        motor: fits.then(|| given.motor.to_toml()),
    })
}

/// Progress of a diagnosis.
#[derive(Debug, Serialize)]
struct Progress<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    what: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    share: Option<f64>,
}

/// The cause of the error: the document, the page and the motor file of `motorlab diagnose`.
#[wasm_bindgen]
pub fn diagnose_runs(question: &str) -> Answer {
    let Given {
        question,
        runs,
        mut motor,
        ..
    } = Given::of(question)?;
    let is_given = question.motor.is_some();
    let facts = RunFacts::of([(Role::Diagnosed, &runs)]);
    let findings = check_training(
        &runs,
        std::slice::from_ref(&(0..runs.len())),
        is_given.then_some(&motor),
    );
    let is_bad = is_fatal(&findings);
    if is_bad && !question.despite_findings {
        let page = bad_recording_page(&findings, &runs);
        let bad = BadRecording::of(findings);
        return document(&Told {
            document: document(&WithRuns::new(&bad, &facts))?,
            page,
            motor: None,
        });
    }
    let mut nominal_source = match is_given {
        true => NominalSource::Given,
        false => NominalSource::Handout,
    };
    let fits = question
        .fit
        .unwrap_or_else(|| !is_given && runs.iter().any(Run::is_foreign));
    if fits {
        let fit = nominal_fit(&runs, &motor, &Settings::default()).map_err(failed)?;
        if !fit.is_given {
            nominal_source = NominalSource::Fit;
        }
        motor = fit.motor;
    }
    let progress = |what: &str| {
        crate::report(&Progress {
            what: Some(what),
            share: None,
        });
    };
    let done = |share: f64| {
        crate::report(&Progress {
            what: None,
            share: Some(share),
        });
    };
    let options = Options {
        is_doubtful: is_bad,
        nominal_source,
        asked: question.asked.as_deref(),
        progress: &progress,
        done: &done,
        quick: question.quick,
        ..Options::default()
    };
    let mut diagnosis = diagnosed(&runs, &motor, &options).map_err(failed)?;
    diagnosis.set_findings(findings);
    let known = &diagnosis.identifiable;
    diagnosis.model.resistance_assumed =
        known.si.is_none() && known.electrical_time_constant_s.is_some();
    let title = "Diagnosis of the sim-to-real gap (second order, viscous and Coulomb friction)";
    let page = page_held_out(&diagnosis, &runs, &[], title).map_err(failed)?;
    document(&Told {
        document: document(&WithRuns::new(&diagnosis, &facts))?,
        page,
        motor: Some(diagnosis.model.to_toml()),
    })
}
