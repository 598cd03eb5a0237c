//! A class: one folder of recordings per student, each recording checked, compared and diagnosed.
//!
//! Every recording is diagnosed alone, and all usable ones of a student together, against the student's motor file or
//! the common one. Unreadable recordings and those with fatal findings are listed without a diagnosis.

use serde::Serialize;

use super::Progress;
use super::outcome::Outcome;
use crate::check::{Finding, Severity, check, is_fatal};
use crate::compare::compare;
use crate::diagnose::{Diagnosis, NominalSource, Options, diagnose, nominal_fit};
use crate::hint::on_one_line;
use crate::motor::{Model, Motor};
use crate::recording::Run;
use crate::report::Panel;
use crate::report::diagnosis::{bad_recording_page, overlays, page, recorded_speed};

/// A class; serialized as `motorlab-class/1`.
#[derive(Debug, Clone, Serialize)]
pub struct Class {
    /// Name of the document's shape.
    pub shape: &'static str,
    /// The folder.
    pub folder: String,
    /// Number of folders; fewer are diagnosed if the work was stopped.
    pub folders: usize,
    /// Students whose folders were diagnosed.
    pub students: Vec<Student>,
}

/// One student's folder.
#[derive(Debug, Clone, Serialize)]
pub struct Student {
    /// The folder's name.
    pub name: String,
    /// Reason, if there is no diagnosis.
    pub problem: Option<String>,
    /// Its recordings, by name.
    pub recordings: Vec<Recording>,
    /// Diagnosis of all usable recordings together.
    pub together: Option<Outcome>,
    /// Reason, if they are not diagnosed together.
    pub undiagnosed: Option<String>,
}

/// One recording.
#[derive(Debug, Clone, Serialize)]
pub struct Recording {
    /// The file's name.
    pub name: String,
    /// Why it is unusable, with the remedy; `None` if it is usable.
    pub unusable: Option<String>,
    /// Findings of `check`.
    pub findings: Vec<Finding>,
    /// Its figures; `None` if it cannot be read.
    pub figures: Option<Figures>,
    /// Diagnosis of this recording alone.
    pub outcome: Option<Outcome>,
    /// Recorded speed, with that of the models if it is diagnosed; `None` if it cannot be read.
    #[serde(skip)]
    pub picture: Option<Panel>,
    /// Its page.
    #[serde(skip)]
    pub page: Option<String>,
    /// Path of its page relative to the page of the class.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_file: Option<String>,
}

/// Figures of a recording.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Figures {
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Duration in s.
    pub duration_s: f64,
    /// Recorded against simulated counts over the whole run, RMS; `None` if it cannot be simulated.
    pub position_rmse_counts: Option<f64>,
}

/// Contents of a student's folder.
#[derive(Debug, Clone)]
pub struct Folder {
    /// Name.
    pub name: String,
    /// The motor of the comparison, and whether it was given.
    pub motor: Result<(Motor, bool), String>,
    /// Files with their runs, or read errors.
    pub runs: Vec<(String, Result<Run, String>)>,
}

impl Student {
    /// A student whose folder cannot be read.
    pub fn unreadable(name: String, why: String) -> Self {
        Self {
            name,
            problem: Some(why),
            recordings: Vec::new(),
            together: None,
            undiagnosed: None,
        }
    }

    /// Checks, compares and diagnoses all recordings.
    pub fn of(folder: Folder, progress: Progress<'_>) -> Self {
        let Folder { name, motor, runs } = folder;
        let (motor, is_given) = match motor {
            Ok(motor) => motor,
            Err(why) => return Self::unreadable(name, why),
        };
        if runs.is_empty() {
            let why = "no recording (a file NAME.csv) in this folder".to_owned();
            return Self::unreadable(name, why);
        }
        let mut work = Work {
            motor,
            is_given,
            progress,
            samples: runs.iter().flat_map(|(_, run)| run).map(Run::len).sum(),
            done: 0,
        };
        let mut recordings = Vec::new();
        let mut usable = Vec::new();
        for (file, run) in runs {
            let recording = match &run {
                Ok(run) => work.recording(file, run),
                Err(why) => Recording::unreadable(file, why.clone()),
            };
            work.done += run.as_ref().map_or(0, Run::len);
            if let (Ok(run), None) = (run, &recording.unusable) {
                usable.push(run);
            }
            recordings.push(recording);
        }
        let only = (recordings.iter()).find_map(|recording| recording.outcome.clone());
        let (together, undiagnosed) = match usable.len() {
            0 => (None, Some("no recording is usable".to_owned())),
            1 if only.is_some() => (only, None),
            _ => match work.diagnosed(&usable) {
                Ok(found) => (Some(Outcome::of(&found)), None),
                Err(why) => (None, Some(why)),
            },
        };
        Self {
            name,
            problem: None,
            recordings,
            together,
            undiagnosed,
        }
    }

    /// Unusable recordings.
    pub fn unusable(&self) -> impl Iterator<Item = &Recording> {
        let recordings = self.recordings.iter();
        recordings.filter(|recording| recording.unusable.is_some())
    }

    /// Whether all of it is readable and usable.
    pub fn is_sound(&self) -> bool {
        self.problem.is_none() && self.together.is_some() && self.unusable().next().is_none()
    }

    /// Recordings to repeat with their remedies, and the next experiment; empty if nothing is open.
    pub fn record_again(&self) -> Vec<String> {
        let repeat = |recording: &Recording| {
            let why = recording.unusable.as_deref().unwrap_or_default();
            format!("{} again: {why}", recording.name)
        };
        let mut all: Vec<String> = self.unusable().map(repeat).collect();
        if let Some(why) = &self.problem {
            all.push(why.clone());
        }
        let next = self
            .together
            .as_ref()
            .and_then(|outcome| outcome.next.as_ref());
        all.extend(next.map(|command| format!("next: `{command}`")));
        all
    }

    /// Summary: the result of all recordings together, or why there is none.
    pub fn words(&self) -> String {
        let why = self.problem.as_ref().or(self.undiagnosed.as_ref());
        match (&self.together, why) {
            (Some(outcome), _) => outcome.words(),
            (None, Some(why)) => why.clone(),
            (None, None) => "nothing".to_owned(),
        }
    }
}

impl Recording {
    fn unreadable(name: String, why: String) -> Self {
        Self {
            name,
            unusable: Some(why),
            findings: Vec::new(),
            figures: None,
            outcome: None,
            picture: None,
            page: None,
            page_file: None,
        }
    }
}

struct Work<'a> {
    motor: Motor,
    is_given: bool,
    progress: Progress<'a>,
    /// Samples of all recordings, and of the finished ones. Each is diagnosed twice: alone and with all others.
    samples: usize,
    done: usize,
}

impl Work<'_> {
    fn recording(&self, name: String, run: &Run) -> Recording {
        let given = self.is_given.then_some(&self.motor);
        let findings = check(std::slice::from_ref(run), given);
        let laid = compare(run, &self.motor, Model::default()).ok();
        let fatal = findings
            .iter()
            .find(|found| found.severity == Severity::Fatal);
        let fatal = fatal.map(Finding::sentence);
        let runs = std::slice::from_ref(run);
        let (unusable, found) = match fatal {
            Some(why) => (Some(why), None),
            None => match self.diagnosed(runs) {
                Ok(found) => (None, Some(found)),
                Err(why) => (Some(why), None),
            },
        };
        let speed = found.as_ref().and_then(|found| {
            let over = overlays(found, runs).into_iter().next()?;
            over.figure.panels.into_iter().next()
        });
        let is_fatal = is_fatal(&findings);
        let drawn = match &found {
            Some(found) => page(found, runs, &name).ok(),
            None => is_fatal.then(|| bad_recording_page(&findings, runs)),
        };
        Recording {
            name,
            unusable,
            findings,
            figures: Some(Figures {
                sample_time_s: run.sample_time_s,
                samples: run.len(),
                duration_s: run.t_s.last().copied().unwrap_or(0.0),
                position_rmse_counts: laid.map(|laid| laid.figures.position_rmse_counts),
            }),
            outcome: found.as_ref().map(Outcome::of),
            picture: Some(speed.unwrap_or_else(|| recorded_speed(run))),
            page: drawn,
            page_file: None,
        }
    }

    /// Diagnosis of these runs; a foreign log without a motor file is diagnosed against a fitted model.
    fn diagnosed(&self, runs: &[Run]) -> Result<Diagnosis, String> {
        if is_fatal(&check(runs, self.is_given.then_some(&self.motor))) {
            return Err("the recordings contradict each other; see motorlab check".to_owned());
        }
        let mut motor = self.motor.clone();
        let own: usize = runs.iter().map(Run::len).sum();
        let done = |share: f64| {
            let samples = self.done as f64 + share * own as f64;
            (self.progress.done)(0.5 * samples / self.samples as f64);
        };
        let mut options = Options {
            nominal_source: match self.is_given {
                true => NominalSource::Given,
                false => NominalSource::Handout,
            },
            progress: &self.progress.doing,
            done: &done,
            ..Options::default()
        };
        if !self.is_given && runs.iter().any(Run::is_foreign) {
            let fit = nominal_fit(runs, &motor, &options.settings)
                .map_err(|why| on_one_line(&why.to_string()))?;
            if !fit.is_given {
                options.nominal_source = NominalSource::Fit;
            }
            motor = fit.motor;
        }
        diagnose(runs, &motor, &options).map_err(|why| on_one_line(&why.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::motor::{CommandKind, Drive, SimulationOptions, simulate};

    fn step(volts: f64) -> Run {
        let motor = Motor::default();
        let t_s: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.01).collect();
        let command = vec![volts; t_s.len()];
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let simulated = simulate(&motor, &drive, &SimulationOptions::default());
        Run {
            sample_time_s: 0.01,
            counts_per_rev: 720.0,
            counts: simulated.expect("a run").counts,
            command,
            t_s,
            ..Run::default()
        }
    }

    /// The remaining time is estimated from the share, which increases over all diagnoses of a student and ends with
    /// them.
    #[test]
    fn the_completed_share_rises_over_all_recordings() {
        let folder = Folder {
            name: "anna".to_owned(),
            motor: Ok((Motor::default(), true)),
            runs: [("a.csv", 3.0), ("b.csv", 4.5)]
                .map(|(name, volts)| (name.to_owned(), Ok(step(volts))))
                .into(),
        };
        let shares = Mutex::new(Vec::new());
        let done = |share| shares.lock().expect("one thread").push(share);
        let progress = Progress {
            doing: &|_| (),
            done: &done,
        };
        assert!(Student::of(folder, progress).is_sound());
        let shares = shares.into_inner().expect("one thread");
        assert!(shares.is_sorted(), "{shares:?}");
        let (first, last) = (shares[0], shares[shares.len() - 1]);
        assert!(first > 0.0 && first < 0.25, "{shares:?}");
        assert!(last > 0.75 && last <= 1.0, "{shares:?}");
    }
}
