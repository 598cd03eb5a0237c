//! The lab handout: its three parts computed for a motor, its questions answered with figures.
//!
//! | file | what is computed there |
//! | --- | --- |
//! | [`transfer`] | the transfer functions with numbers: poles, time constants, step response |
//! | [`step_response`] | Part 1: five curves; first against second order |
//! | [`damping`] | Part 1: what damps the motor |
//! | [`sampling`] | Part 2: encoder, sampling, difference |
//! | [`recorded`] | Part 3: recordings against simulations |
//! | [`missing`] | Part 3: effects that explain the error |
//! | [`not_shown`] | Part 3: effects that the diagnosis may miss |
//! | [`answers`] | every question of the handout, answered |
//! | [`outcome`] | the result of a diagnosis as text |
//! | [`class`], [`class_page`] | many students' recordings side by side, and their page |
//! | [`page`], [`columns`] | the report: one HTML page, drawings; CSV |

pub mod answers;
pub mod class;
pub mod class_page;
pub mod columns;
pub mod damping;
pub mod missing;
pub mod not_shown;
pub mod outcome;
pub mod page;
pub mod recorded;
pub mod sampling;
pub mod step_response;
pub mod transfer;

use serde::Serialize;

use crate::check::{Finding, check};
use crate::motor::{Motor, Parameters, SimulationError};
use crate::plain::shown;
use crate::recording::Run;

use answers::Answer;
use damping::Damping;
use missing::Missing;
use not_shown::NotShown;
use recorded::Recorded;
use sampling::Sampling;
use step_response::{CURVES, Curve, OrderDifference};

/// Progress of a long computation: its present step, and an estimate of the share that is done.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    /// Receives the present activity.
    pub doing: &'a (dyn Fn(&str) + Sync),
    /// Receives the share.
    pub done: &'a (dyn Fn(f64) + Sync),
}

/// Share of the diagnosis in the work of Part 3; the rest is the computation of effects that are hardly visible.
const DIAGNOSIS_SHARE: f64 = 0.9;

/// Source of the recordings of Part 3.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Recorded runs.
    Recorded,
    /// Simulated by this virtual board.
    VirtualBoard(String),
}

/// Part 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepResponses {
    /// Times of the curves in s.
    pub t_s: Vec<f64>,
    /// The five curves.
    pub curves: Vec<Curve>,
    /// First against second order, with viscous friction.
    pub order: OrderDifference,
    /// Damping terms of the motor.
    pub damping: Damping,
}

/// The lab; serialized as `motorlab-lab/1`.
#[derive(Debug, Clone, Serialize)]
pub struct Lab {
    /// Name of the document's shape.
    pub shape: &'static str,
    /// The motor's parameters.
    pub parameters: Parameters,
    /// Ids of the motor file's effects, which only Part 3 uses.
    pub effects: Vec<&'static str>,
    /// Part 1.
    pub part_1: StepResponses,
    /// Part 2.
    pub part_2: Sampling,
    /// Part 3.
    pub part_3: Vec<Recorded>,
    /// Findings in its recordings.
    pub findings: Vec<Finding>,
    /// Causes of the error in Part 3.
    pub missing: Missing,
    /// Effects that are hardly visible in the recordings, so that the diagnosis may miss them; empty without a
    /// diagnosis.
    pub not_shown: Vec<NotShown>,
    /// Source of the recordings.
    pub source: Source,
    /// Every question of the handout, answered.
    pub answers: Vec<Answer>,
    #[serde(skip)]
    motor: Motor,
}

/// Errors of the computation.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    /// The motor cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A recording cannot be simulated.
    #[error("{run}: {error}", run = shown(run))]
    Run {
        /// The recording's file.
        run: String,
        /// The error.
        error: SimulationError,
    },
    /// A recording without samples.
    #[error("{}: the recording has fewer than two samples\nhint: record at least one whole step", shown(.0))]
    Empty(String),
}

impl Lab {
    /// Computes all three parts of the motor, which is described by a motor file or, if `is_described` is false, the
    /// handout's in place of an unknown one. `runs` have the notes of their reader; `progress` receives the steps of
    /// the diagnosis of Part 3, which is left out without it.
    ///
    /// # Errors
    /// The motor or a recording cannot be simulated.
    pub fn of(
        (motor, is_described): (Motor, bool),
        runs: Vec<(Run, Vec<String>)>,
        source: Source,
        progress: Option<Progress<'_>>,
    ) -> Result<Self, LabError> {
        let p = motor.parameters;
        let curves = CURVES
            .iter()
            .map(|contents| Curve::simulated(contents, &p))
            .collect::<Result<Vec<_>, _>>()?;
        let part_1 = StepResponses {
            t_s: curves[0].t_s.clone(),
            order: OrderDifference::between(&curves[0], &curves[1], &p),
            damping: Damping::of(&p),
            curves,
        };
        let part_2 = Sampling::of(&p)?;
        let part_3 = runs
            .into_iter()
            .map(|(run, notes)| {
                let name = run
                    .path
                    .as_ref()
                    .map_or_else(String::new, |path| path.display().to_string());
                if run.len() < 2 {
                    return Err(LabError::Empty(name));
                }
                Recorded::of(run, &motor, &notes)
                    .map_err(|error| LabError::Run { run: name, error })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let effects = motor
            .effects
            .iter()
            .map(|effect| effect.kind().id)
            .collect();
        let runs = as_diagnosed(&part_3, &source);
        let findings = check(&runs, None);
        let part_3: Vec<_> = (part_3.into_iter())
            .map(|recorded| recorded.checked(&findings))
            .collect();
        let (missing, not_shown) = match progress {
            Some(progress) => explained((&motor, is_described), &runs, &findings, progress),
            None => {
                let why = "it was not asked for".to_owned();
                (Missing::Undiagnosed(why), Vec::new())
            }
        };
        let why = (&missing, &not_shown[..]);
        let answers = answers::all(&part_1, &part_2, &part_3, why, &source);
        Ok(Self {
            shape: "motorlab-lab/1",
            parameters: p,
            effects,
            part_1,
            part_2,
            part_3,
            findings,
            missing,
            not_shown,
            source,
            answers,
            motor,
        })
    }

    /// Whether every recording is usable.
    pub fn is_sound(&self) -> bool {
        self.part_3.iter().all(Recorded::is_usable)
    }

    /// The motor.
    pub fn motor(&self) -> &Motor {
        &self.motor
    }
}

/// Causes of the error, and effects that are hardly visible.
fn explained(
    described: (&Motor, bool),
    runs: &[Run],
    findings: &[Finding],
    progress: Progress<'_>,
) -> (Missing, Vec<NotShown>) {
    let of_diagnosis = |share| (progress.done)(DIAGNOSIS_SHARE * share);
    let diagnosing = Progress {
        done: &of_diagnosis,
        ..progress
    };
    let (missing, motor) = Missing::in_simulation_of(described, runs, findings, diagnosing);
    (progress.doing)("effects that the recordings hardly show");
    let done = |share| (progress.done)(DIAGNOSIS_SHARE + (1.0 - DIAGNOSIS_SHARE) * share);
    let not_shown = (missing.diagnosis()).map_or_else(Vec::new, |found| {
        not_shown::not_shown(&motor, runs, found, &done)
    });
    (missing, not_shown)
}

/// The recordings as they are checked and diagnosed. A virtual board plays faster than real time, so that arrival
/// times carry no information about its clock and are left out.
fn as_diagnosed(recorded: &[Recorded], source: &Source) -> Vec<Run> {
    let mut runs: Vec<Run> = recorded.iter().map(|laid| laid.run.clone()).collect();
    if matches!(source, Source::VirtualBoard(_)) {
        for run in &mut runs {
            run.host_t_s = None;
        }
    }
    runs
}
