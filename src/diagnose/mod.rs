//! Where the gap lies, which effect causes it, how far it shrinks.
//!
//! [`diagnose`] weighs every effect of the catalogue, pairs of them, none, and something unknown, by
//! their evidence on recorded counts: `ln Z = ln p(counts | effect)`, with a load that wanders as part of
//! the noise. The steps: `checks` look at the recording, `search` finds where fits start, `fit` fits,
//! `rank` weighs, `unknown` is the rival of all, `ties` says what cannot be told apart, `rungs`
//! measures the gap on data kept from the fit, `regimes` says where it lies, `design` what to record next.

mod candidate;
mod checks;
mod conclusions;
mod data;
mod design;
mod fit;
mod growth;
mod hypothesis;
mod looks;
mod matter;
mod noise;
mod periodic;
mod rank;
mod regimes;
mod rungs;
mod search;
mod sentence;
mod setting;
mod ties;
mod tones;
mod unknown;
mod verdict;

use std::time::Instant;

use crate::motor::{Motor, SimulationError};
use crate::recording::Run;
use conclusions::{Ties, base, causes, ids, place, sets, verdict_of};
use data::RunData;
use fit::Problem;
use rank::rank;
use search::{damping_of, largest_acceleration};
use sentence::sentence;

pub use design::{Isolability, Pair, Plan, isolability};
pub use verdict::{
    Cause, DataProblem, Diagnosis, EffectSet, Gap, Interval, NextExperiment, Place, Regime, Region,
    SHAPE, Verdict,
};

/// Levels of the wander as shares of the largest acceleration, strongest first.
const WANDER_LEVELS: [f64; 6] = [0.03, 0.01, 0.003, 0.001, 0.0003, 0.0001];

/// Why runs cannot be diagnosed.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// Nothing to look at.
    #[error("no run: name at least one run file")]
    NoRuns,
    /// A run that is too short.
    #[error("{run}: {samples} samples are too few for a diagnosis, record at least 20")]
    TooShort {
        /// Path or number of the run.
        run: String,
        /// Its samples.
        samples: usize,
    },
    /// Runs of different axes.
    #[error("{run}: commands {found}, the first run commands {first}: diagnose them apart")]
    Mixed {
        /// Path or number of the run.
        run: String,
        /// Its command column.
        found: &'static str,
        /// That of the first.
        first: &'static str,
    },
    /// A run that cannot be simulated.
    #[error("{run}: {source}")]
    Simulation {
        /// Path or number of the run.
        run: String,
        /// Why.
        source: SimulationError,
    },
    /// The nominal motor makes no motion at all.
    #[error("the nominal motor cannot be fitted to these runs: are its numbers and units right?")]
    NoFit,
}

/// Diagnoses runs of one motor against its nominal model; `progress` is told what is being done.
///
/// # Errors
/// No runs, runs that are too short or of different axes, runs or motors that cannot be simulated.
pub fn diagnose(
    runs: &[Run],
    motor: &Motor,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let begin = Instant::now();
    let first = runs.first().ok_or(DiagnoseError::NoRuns)?;
    let mut problems = Vec::new();
    let mut data = Vec::new();
    let mut names = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        let name = match &run.path {
            Some(path) => path.display().to_string(),
            None => (k + 1).to_string(),
        };
        if run.len() < 20 {
            return Err(DiagnoseError::TooShort {
                run: name,
                samples: run.len(),
            });
        }
        if run.command_kind != first.command_kind {
            return Err(DiagnoseError::Mixed {
                run: name,
                found: run.command_kind.column(),
                first: first.command_kind.column(),
            });
        }
        problems.extend(checks::problems(&name, run));
        data.push(
            RunData::new(run).map_err(|source| DiagnoseError::Simulation {
                run: name.clone(),
                source,
            })?,
        );
        names.push(name);
    }
    let scale = largest_acceleration(motor, &data);
    let levels = WANDER_LEVELS.iter().map(|share| share * scale).collect();
    let problem = Problem::new(motor, &data, damping_of(motor, first.command_kind), levels);
    let mut ranking = rank(&problem, progress).ok_or(DiagnoseError::NoFit)?;
    progress("holding data back to measure the gap");
    let gap = match (ranking.candidates.first(), ranking.null()) {
        (Some(best), Some(null)) => rungs::rungs(&problem, &null.fit, &best.fit),
        _ => return Err(DiagnoseError::NoFit),
    };
    ranking.judge(&gap);
    let (Some(best), Some(null)) = (ranking.candidates.first(), ranking.null()) else {
        return Err(DiagnoseError::NoFit);
    };
    let ties = Ties::among(&problem, &ranking);
    let verdict = verdict_of(&ranking, &gap, &ties);
    let effects = match verdict {
        Verdict::Effect | Verdict::Ambiguous => ids(best),
        _ => Vec::new(),
    };
    let place = place(&problem, &ranking, &names, scale);
    let causes = causes(&problem, &ranking, &ties);
    let mut diagnosis = Diagnosis {
        shape: SHAPE,
        verdict,
        sentence: String::new(),
        effects,
        probability: best.probability,
        causes,
        sets: sets(&ranking),
        base: base(&best.fit),
        place,
        gap,
        data: problems,
        next_experiment: design::next_experiment(&problem, &ranking),
        model: best.fit.hypothesis.motor(motor, &best.fit.p),
        refitted: null.fit.hypothesis.motor(motor, &null.fit.p),
        elapsed_s: 0.0,
    };
    diagnosis.sentence = sentence(&diagnosis);
    diagnosis.elapsed_s = begin.elapsed().as_secs_f64();
    Ok(diagnosis)
}
