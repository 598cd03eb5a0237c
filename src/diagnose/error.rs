//! Errors of a diagnosis, and the checks of runs before anything is fitted.

use super::settings::conventions::{MOST_APART_S, PAUSE};
use crate::motor::{CommandKind, SimulationError};
use crate::plain::shown;
use crate::recording::Run;

/// Fewest samples of a run: five each for gain, time constant, initial and final value.
const LEAST_SAMPLES: usize = crate::check::FEWEST_SAMPLES;

/// Errors of a diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// No runs.
    #[error("no run is given\nhint: name at least one run file")]
    NoRuns,
    /// A run with too few samples.
    #[error(
        "{run}: {samples} samples are too few for a diagnosis\nhint: record at least {LEAST_SAMPLES}", run = shown(run))]
    TooShort {
        /// Path or number of the run.
        run: String,
        /// Its number of samples.
        samples: usize,
    },
    /// The sample time is too long for a motor's response.
    #[error(
        "{run}: samples lie {mean_s:.3} s apart on average, {MOST_APART_S} s at most can be diagnosed\n\
         hint: record with a sample time that resolves the motor's start; `motorlab check RUN` names wrong units", run = shown(run))]
    TooFarApart {
        /// Path or number of the run.
        run: String,
        /// Mean interval in s.
        mean_s: f64,
    },
    /// Pauses are longer than the recording.
    #[error(
        "{run}: {missing_s:.1} s of its {lasts_s:.1} s lie in pauses without a sample\n\
         hint: cut the file at its pauses and diagnose the parts together", run = shown(run))]
    MostlyPauses {
        /// Path or number of the run.
        run: String,
        /// Total length of the pauses in s.
        missing_s: f64,
        /// Length of the run in s.
        lasts_s: f64,
    },
    /// A run without position or command.
    #[error(
        "{run}: the {what} was not recorded (its header says so under `imported`), and a diagnosis needs it\n\
         hint: import the log with the column of the {what}, or see `motorlab check RUN` for the rest", run = shown(run))]
    NotRecorded {
        /// Path or number of the run.
        run: String,
        /// `position` or `command`.
        what: &'static str,
    },
    /// Runs of different axes.
    #[error("{run}: commands {found}, the first run commands {first}\nhint: diagnose them in separate calls", run = shown(run))]
    Mixed {
        /// Path or number of the run.
        run: String,
        /// Its kind of command.
        found: &'static str,
        /// That of the first run.
        first: &'static str,
    },
    /// A run that cannot be simulated.
    #[error("{run}: {source}", run = shown(run))]
    Simulation {
        /// Path or number of the run.
        run: String,
        /// Cause.
        source: SimulationError,
    },
    /// The nominal motor does not move.
    #[error(
        "the nominal motor cannot be fitted to these runs\nhint: check its parameters and their units: `motorlab motor FILE` lists them"
    )]
    NoFit,
    /// No first-order motor fits these runs.
    #[error(
        "no first-order motor fits these runs: the best leaves {left_counts:.1} counts RMS, a shaft at rest {at_rest_counts:.1}\n\
         hint: check that the command's column is this motor's, in volts and with the right sign; a motor file (--motor) needs no fit"
    )]
    FitFailed {
        /// Residual of the best fit, in counts RMS.
        left_counts: f64,
        /// Residual of a shaft at rest.
        at_rest_counts: f64,
    },
}

pub(crate) fn name_of(k: usize, run: &Run) -> String {
    match &run.path {
        Some(path) => path.display().to_string(),
        None => (k + 1).to_string(),
    }
}

/// Command kind of the runs, if they can be diagnosed together.
pub(crate) fn usable(runs: &[Run]) -> Result<CommandKind, DiagnoseError> {
    let first = runs.first().ok_or(DiagnoseError::NoRuns)?;
    for (k, run) in runs.iter().enumerate() {
        let name = name_of(k, run);
        if run.len() < LEAST_SAMPLES {
            return Err(DiagnoseError::TooShort {
                run: name,
                samples: run.len(),
            });
        }
        sampled_enough(&name, run)?;
        if run.command_kind != first.command_kind {
            return Err(DiagnoseError::Mixed {
                run: name,
                found: run.command_kind.column(),
                first: first.command_kind.column(),
            });
        }
        if let Some(what) = not_recorded(run) {
            return Err(DiagnoseError::NotRecorded { run: name, what });
        }
    }
    Ok(first.command_kind)
}

/// A column that an imported log lacks and a diagnosis needs; it is filled with zeros.
fn not_recorded(run: &Run) -> Option<&'static str> {
    let imported = run.header.get("imported")?;
    ["position", "command"]
        .into_iter()
        .find(|what| imported.get(what).and_then(toml::Value::as_str) == Some("not recorded"))
}

/// Checks that samples are close enough for a motor's response, and that the recording is longer than its pauses.
fn sampled_enough(name: &str, run: &Run) -> Result<(), DiagnoseError> {
    let mut steps: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let lasts_s = run.t_s[run.len() - 1] - run.t_s[0];
    let mean_s = lasts_s / steps.len() as f64;
    steps.sort_by(f64::total_cmp);
    let median_s = steps[steps.len() / 2];
    let paused = steps.iter().filter(|step_s| **step_s > PAUSE * median_s);
    let missing_s: f64 = paused.sum();
    let run = name.to_owned();
    if missing_s > 0.5 * lasts_s {
        return Err(DiagnoseError::MostlyPauses {
            run,
            missing_s,
            lasts_s,
        });
    }
    if mean_s > MOST_APART_S {
        return Err(DiagnoseError::TooFarApart { run, mean_s });
    }
    Ok(())
}
