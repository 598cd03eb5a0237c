//! Diagnosis of the sim-to-real gap: runs and a motor in, a [`Diagnosis`] out.
//!
//! ```text
//! runs -> segments -> re-identification -> relevance -> search -> posterior -> nested fits -> error budget -> verdict -> sentence
//! ```
//!
//! One measure: the multi-step prediction error of the position over segments, initial states corrected (`segments`).
//! It is fitted (`fit`), scored (`score`), held out (`budget`) and reported. Sets of effects are compared by one
//! score; the verdict follows from the error budget and the posterior alone (`verdict`).

mod budget;
mod classes;
mod command_units;
mod design;
mod document;
mod error;
mod fit;
mod identifiable;
mod intervals;
mod inverse;
mod model;
mod nested;
mod noise;
mod nominal;
mod pipeline;
mod random;
mod reference;
mod relevance;
mod report;
mod robust;
mod run_facts;
#[cfg(test)]
mod samples;
mod score;
mod search;
mod segments;
mod sentence;
mod settings;
mod verdict;

pub use design::{Beyond, Isolability, Pair, Plan, beyond_parameters, isolability};
pub use error::DiagnoseError;
pub use nominal::{NominalFit, nominal_fit};
pub use report::{
    Alternative, BadRecording, BudgetStep, Cause, CommandInterval, Diagnosis, EffectClass,
    EffectSet, Fitted, FloorParts, Gap, GoodEnough, Identifiable, Interval, KnownChange,
    KnownTorque, MotorFileValues, NextExperiment, NominalSource, Place, PredictedRun, Quick,
    ReferenceRuns, Regime, Region, SHAPE, Scoring, SearchStep, Unexplained, Verdict,
};
pub use run_facts::{Role, RunFacts, WithRuns};
pub use settings::Settings;

pub(crate) use classes::class_of;
pub(crate) use model::is_parameter_change;
pub(crate) use report::{HELD_OUT_RUNS, without_assumed_unit};
pub(crate) use sentence::{
    is_cross_validated, is_nominal_fitted, is_undescribed, name, no_recording_reason,
};
pub(crate) use settings::conventions::LEAST_PRINTED;

use std::borrow::Cow;

use crate::check::{check, misread_or_stale};
use crate::motor::Motor;
use crate::platform::time::Instant;
use crate::recording::Run;
use error::usable;
use pipeline::{Prepared, searched};
use segments::Segments;
use settings::conventions::SEARCH_SHARE;

/// Options of a diagnosis besides its runs and its motor.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Held-out runs, on which the error budget is measured.
    pub held_out: &'a [Run],
    /// Earlier runs of the same axis, or runs of another of its kind: the diagnosis is of the difference from them.
    pub reference: &'a [Run],
    /// Groups of runs that repeat each other, in addition to those with the same commands.
    pub repeats: &'a [Vec<usize>],
    /// The accepted error.
    pub good_enough: Option<GoodEnough>,
    /// Whether a finding about the recordings is fatal.
    pub is_doubtful: bool,
    /// Source of the motor's parameters.
    pub nominal_source: NominalSource,
    /// The command line, which the proposed next step repeats. `None` if the runs' names suffice.
    pub asked: Option<&'a str>,
    /// Motors whose sets of effects are fitted in any case, from their values, in case the search misses them.
    pub proposed: &'a [Motor],
    /// Receives the present activity.
    pub progress: &'a dyn Fn(&str),
    /// Receives an estimate of the share of the work that is done.
    pub done: &'a dyn Fn(f64),
    /// Whether the search is restricted to a tenth of the samples.
    pub quick: bool,
    /// Settings of the method.
    pub settings: Settings,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            held_out: &[],
            reference: &[],
            repeats: &[],
            good_enough: None,
            is_doubtful: false,
            nominal_source: NominalSource::Given,
            asked: None,
            proposed: &[],
            progress: &|_| (),
            done: &|_| (),
            quick: false,
            settings: Settings::default(),
        }
    }
}

/// Diagnoses runs of one motor: location of the error between recording and simulation, the unmodelled effects that
/// cause it, and the share that they remove.
///
/// # Errors
/// No runs, runs that are too short or of different axes, runs or motors that cannot be simulated.
///
/// ```
/// use motorlab::diagnose::{Options, Verdict, diagnose};
/// use motorlab::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};
/// use motorlab::recording::Run;
///
/// let motor = Motor::default();
/// let t_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.01).collect();
/// let command = vec![4.5; 400];
/// let drive = Drive { t_s: &t_s, command: &command, kind: CommandKind::Voltage };
/// let counts = simulate(&motor, &drive, &SimulationOptions::default())?.counts;
/// let run = Run { sample_time_s: 0.01, counts_per_rev: 720.0, t_s, command, counts, ..Run::default() };
/// let diagnosis = diagnose(&[run], &motor, &Options::default())?;
/// assert_eq!(diagnosis.verdict, Verdict::NoGap);
/// println!("{}", diagnosis.sentence);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn diagnose(
    runs: &[Run],
    motor: &Motor,
    options: &Options<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    let started = Instant::now();
    let settings = &options.settings;
    let data = check(runs, Some(motor));
    let runs = &without_named_samples(runs)[..];
    let held_out = &without_named_samples(options.held_out)[..];
    let prepared = Prepared::new(runs, motor, settings, options.quick)?;
    let mut stated =
        budget::stated_floor(runs, &prepared.all, options.repeats, options.good_enough);
    let earlier = &without_named_samples(options.reference)[..];
    let (prepared, found, reference) = match earlier {
        [] => {
            let found = searched(
                &prepared,
                stated.largest(),
                options.proposed,
                options.progress,
                &|share| (options.done)(SEARCH_SHARE * share),
            )?;
            (prepared, found, None)
        }
        _ => reference::compared(prepared, stated.largest(), earlier, motor, options)?,
    };
    // The reference's error on its own runs is its error for an unchanged motor.
    if let Some(reference) = &reference {
        stated.repeats = Some(stated.repeats.unwrap_or(0.0).max(reference.rms_counts));
    }
    let held = match held_out {
        [] => None,
        _ => {
            usable(&[&runs[..1], held_out].concat())?;
            let tau_s = score::fitted_time_constant_s(&found.none);
            let held = Segments::new(held_out, &prepared.base.motor, settings)?;
            Some(held.with_time_constant(tau_s))
        }
    };
    let asked = options.asked.map_or_else(
        || report::asked(runs, held_out, options.reference),
        str::to_owned,
    );
    let floor = (stated, reference);
    let made = document::document(&prepared, &found, floor, held.as_ref(), options, &asked);
    let mut diagnosis = made.ok_or(DiagnoseError::NoFit)?;
    diagnosis.data = data;
    diagnosis.simulated_samples = found.segments.work.samples();
    diagnosis.elapsed_s = started.elapsed().as_secs_f64();
    Ok(diagnosis)
}

/// Runs without the samples that `check` names as misread or stale.
fn without_named_samples(runs: &[Run]) -> Cow<'_, [Run]> {
    let named: Vec<Vec<usize>> = runs.iter().map(misread_or_stale).collect();
    if named.iter().all(Vec::is_empty) {
        return runs.into();
    }
    let pairs = runs.iter().zip(&named);
    pairs.map(|(run, samples)| run.without(samples)).collect()
}
