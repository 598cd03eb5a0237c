//! Where the gap lies, which effect causes it, how far it shrinks.
//!
//! [`diagnose`] weighs every effect of the catalogue, pairs of them, none, and something unknown, by
//! their evidence on recorded counts: `ln Z = ln p(counts | effect)`, with a load that wanders as part of
//! the noise. The steps: `checks` look at the recording, `search` finds where fits start, `fit` fits,
//! `rank` weighs, `unknown` is the rival of all, `ties` says what cannot be told apart, `rungs`
//! measures the gap on data kept from the fit, `effort` limits the work, `regimes` says where it lies,
//! `design` what to record next.

mod anchor;
mod bad_recording;
mod bagging;
mod beside;
mod candidate;
mod checks;
mod come_round;
mod conclusions;
mod covariance;
mod data;
mod design;
mod despite;
mod discrepancy;
mod disturbance;
mod effort;
mod fit;
mod further;
mod grid;
mod growth;
mod held;
mod hypothesis;
mod judged;
mod jumps;
mod kept;
mod kept_filters;
mod levels;
mod log_sum;
mod looks;
mod marginal;
mod matter;
mod nearest;
mod noise;
mod noise_numbers;
mod nominal;
mod oscillation;
mod other_law;
mod other_means;
mod other_noise;
mod outlook;
mod pairs;
mod periodic;
mod predict;
mod problem;
mod prospect;
mod rank;
mod refined;
mod regimes;
mod response;
mod rivals;
mod rough;
mod rounds;
mod rung_intervals;
mod rungs;
#[cfg(test)]
mod samples;
mod scales;
mod search;
mod sentence;
mod setting;
mod shapes;
mod sums;
mod tempered;
mod ties;
mod tones;
mod unknown;
mod unseen;
mod verdict;

use std::sync::Arc;
use std::time::Instant;

use crate::motor::{Motor, SimulationError};
use crate::recording::{CommandKind, Run};
use conclusions::{Ties, base, causes, ids, place, sets, verdict_of};
use data::{PIECE_S, RunData, pieces, spread};
use disturbance::{Disturbance, disturbance_of};
use effort::Effort;
use fit::Fit;
use held::is_held;
use hypothesis::Hypothesis;
use problem::Problem;
use rank::{heads, rank};
use rough::{Rough, held_levels};
use scales::{damping_of, largest_acceleration};
use sentence::sentence;

pub use bad_recording::{BAD_RECORDING, BadRecording};
pub use design::{Isolability, Pair, Plan, isolability};
pub use despite::despite_findings;
pub use nominal::{NominalFit, fitted_nominal, nominal_fit};
pub use other_means::other_means;
pub use verdict::{
    Cause, DataProblem, Diagnosis, EffectSet, Gap, Interval, KnownChange, NextExperiment, Place,
    Regime, Region, SHAPE, Verdict,
};

/// Levels of the wander as shares of the largest acceleration, strongest first.
const WANDER_LEVELS: [f64; 6] = [0.03, 0.01, 0.003, 0.001, 0.0003, 0.0001];

/// Most steps of the fit that tells the variance of rounding.
const SETTLING_STEPS: usize = 6;

/// Most times that it is told anew beside edges lost by chance.
const SETTLINGS: usize = 4;

/// A recording of more samples than this, all runs together, is first judged to be rough or not by its beginning, of
/// [`LOOK`] samples, and diagnosed by pieces of this many samples where it is.
const ENOUGH: usize = 10_000;
const LOOK: usize = 2000;

/// Longest mean time between samples in s. Tables of steady speeds have a row a second; three are no motor's log, and a simulation takes
/// a thousand steps for each.
const MOST_APART_S: f64 = 3.0;

/// A step of time that is so many times the median is a pause.
const PAUSE: f64 = 10.0;

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
    /// Samples so far apart that no motor's response is seen between them.
    #[error(
        "{run}: samples lie {mean_s:.3} s apart on average, {MOST_APART_S} s at most can be diagnosed; record with a sample time that \
         sees the motor start (motorlab check names wrong units)"
    )]
    TooFarApart {
        /// Path or number of the run.
        run: String,
        /// Mean interval in s.
        mean_s: f64,
    },
    /// More pause than recording.
    #[error(
        "{run}: {missing_s:.1} s of its {lasts_s:.1} s lie in pauses without a sample; cut the file at its pauses and diagnose the parts \
         together"
    )]
    MostlyPauses {
        /// Path or number of the run.
        run: String,
        /// Time in pauses in s.
        missing_s: f64,
        /// Time from the first sample to the last in s.
        lasts_s: f64,
    },
    /// A run without what a model is judged by, or driven by.
    #[error(
        "{run}: the {what} was not recorded (its header says so under `imported`), without which nothing can be diagnosed{found}"
    )]
    NotRecorded {
        /// Path or number of the run.
        run: String,
        /// `position` or `command`.
        what: &'static str,
        /// What can be said of the recording all the same.
        found: String,
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
    /// No first-order motor follows these runs.
    #[error(
        "no first-order motor fits these runs: the best leaves {left_counts:.1} counts where a shaft that stands still leaves {at_rest_counts:.1}. Does the column of the command belong to this motor, in volts, with the right sign? A motor file with --motor needs no fit"
    )]
    FitFailed {
        /// What the best fit leaves, in counts RMS.
        left_counts: f64,
        /// What a shaft that never turns leaves.
        at_rest_counts: f64,
    },
}

/// Diagnoses runs of one motor against its nominal model; `progress` is told what is being done.
///
/// The search for what explains the runs of a motor that is driven by a voltage ends at a limit of work, which
/// [`Diagnosis::cut_short`] says.
///
/// # Errors
/// No runs, runs that are too short or of different axes, runs or motors that cannot be simulated.
pub fn diagnose(
    runs: &[Run],
    motor: &Motor,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    diagnose_holding_out(runs, &[], motor, progress)
}

/// The same with further runs of the motor that nothing is fitted to and nothing is chosen by: the gap is measured
/// on them.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_holding_out(
    runs: &[Run],
    held_out: &[Run],
    motor: &Motor,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    diagnose_within(Effort::limited_for, runs, held_out, motor, progress)
}

/// The same without a limit: some more sets of two and three effects are found, and where nothing explains the runs it takes several
/// times as long.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_thoroughly(
    runs: &[Run],
    held_out: &[Run],
    motor: &Motor,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    diagnose_within(|_| Effort::default(), runs, held_out, motor, progress)
}

/// The same with as much work as there may be for so many samples.
fn diagnose_within(
    effort: impl Fn(usize) -> Effort,
    runs: &[Run],
    held_out: &[Run],
    motor: &Motor,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let begin = Instant::now();
    let first = runs.first().ok_or(DiagnoseError::NoRuns)?;
    let mut problems = Vec::new();
    let (mut names, data) = ready(runs, first.command_kind, &mut problems)?;
    let (_, mut kept) = ready(held_out, first.command_kind, &mut problems)?;
    let scale = largest_acceleration(motor, &data);
    let levels: Vec<f64> = WANDER_LEVELS.iter().map(|share| share * scale).collect();
    let damping = damping_of(motor, first.command_kind);
    let samples: usize = data.iter().map(RunData::len).sum();
    let is_long = samples > ENOUGH;
    let beginnings = heads(&data, LOOK as f64 / samples as f64);
    let is_held = is_held(&data);
    let effort = Arc::new(if first.command_kind == CommandKind::Voltage && !is_held {
        effort(samples)
    } else {
        Effort::default()
    });
    let problem_of = |runs| {
        let levels = levels.clone();
        let problem = Problem::new(motor, runs, damping, levels, Disturbance::default());
        settled(problem.with_effort(&effort)).ok_or(DiagnoseError::NoFit)
    };
    let simulation = |source| DiagnoseError::Simulation {
        run: "a piece of a run".to_owned(),
        source,
    };
    let judged_whole = if is_held {
        problems.push(held::note());
        progress("looking at an axis that is held by its controller, piece by piece");
        let pieces = spread(pieces(&data, PIECE_S).map_err(simulation)?, ENOUGH);
        let problem = Problem::new(
            motor,
            &pieces,
            damping,
            held_levels(&levels, scale),
            Disturbance::default(),
        )
        .holding(true)
        .with_effort(&effort);
        Err(Rough::of_held(&problem, scale).ok_or(DiagnoseError::NoFit)?)
    } else {
        let mut problem = problem_of(if is_long { &beginnings } else { &data })?;
        let mut ranking = rank(&problem, progress).ok_or(DiagnoseError::NoFit)?;
        let mut noise = disturbance_of(&problem, &ranking, scale);
        if noise.is_none() && is_long {
            problem = problem_of(&data)?;
            ranking = rank(&problem, progress).ok_or(DiagnoseError::NoFit)?;
            noise = disturbance_of(&problem, &ranking, scale);
        }
        match noise {
            None => Ok((problem, ranking)),
            Some(noise) => Err(Rough::of(&problem, ranking, noise)),
        }
    };
    let is_rough = judged_whole.is_err();
    let cut;
    let (mut problem, mut ranking) = match judged_whole {
        Ok(judged) => judged,
        Err(rough) => {
            // A model that forgets within seconds is not judged by where it went in a minute.
            progress("weighing everything piece by piece with the noise of this recording");
            kept = pieces(&kept, rough.length_s).map_err(simulation)?;
            let all = pieces(&data, rough.length_s).map_err(simulation)?;
            cut = if is_long { spread(all, ENOUGH) } else { all };
            names = cut
                .iter()
                .map(|piece| names[piece.origin].clone())
                .collect();
            let levels = if is_held {
                held_levels(&levels, scale)
            } else {
                levels.clone()
            };
            // Of a long one only so many samples are weighed that the search may go to its end.
            let effort = if is_long {
                Arc::default()
            } else {
                effort.clone()
            };
            let mut problem = Problem::new(motor, &cut, damping, levels, rough.noise)
                .holding(is_held)
                .with_effort(&effort);
            let ranking = rough
                .weighed(&mut problem, scale, progress)
                .ok_or(DiagnoseError::NoFit)?;
            (problem, ranking)
        }
    };
    if let Some(best) = ranking.candidates.first_mut()
        && best.fit.hypothesis.loses_by_chance()
    {
        problem = resettled(problem, &mut best.fit);
    }
    progress("holding data back to measure the gap");
    let gap = match (ranking.candidates.first(), ranking.null()) {
        (Some(best), Some(null)) if is_rough => {
            rungs::by_pieces(&problem, &null.fit, &best.fit, &kept)
        }
        (Some(best), Some(null)) if kept.is_empty() => rungs::rungs(&problem, &null.fit, &best.fit),
        (Some(best), Some(null)) => rungs::held_out(&problem, &null.fit, &best.fit, &kept),
        _ => return Err(DiagnoseError::NoFit),
    };
    let by_chance =
        (ranking.candidates.first()).map_or(0.0, |best| rungs::lost_by_chance(&problem, &best.fit));
    let judged = ranking.judge(&gap, by_chance);
    let alike = if is_rough {
        let alike = discrepancy::share_out(&problem, &mut ranking);
        bagging::allow_for_more(&problem, &mut ranking);
        alike
    } else {
        bagging::bag_unknown(&problem, &mut ranking, judged, scale);
        tempered::temper(&problem, &mut ranking, &gap, by_chance, scale);
        if !judged::is_explained(&gap, by_chance) {
            bagging::allow_for_more(&problem, &mut ranking);
        }
        Vec::new()
    };
    let doubtful = if alike.is_empty() {
        other_noise::weigh(&problem, &mut ranking)
            .or_else(|| other_law::weigh(&problem, &mut ranking))
    } else {
        None
    };
    beside::weigh(&problem, &mut ranking, &gap, scale, is_rough);
    let (Some(best), Some(null)) = (ranking.candidates.first(), ranking.null()) else {
        return Err(DiagnoseError::NoFit);
    };
    let ties = Ties::among(&problem, &ranking, doubtful, &alike);
    let verdict = verdict_of(&ranking, &gap, &ties);
    if matches!(verdict, Verdict::Ambiguous | Verdict::OutsideCatalogue) {
        problems.extend(unseen::unseen(&data));
    }
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
        cut_short: problem.effort.was_cut(),
        elapsed_s: 0.0,
    };
    diagnosis.sentence = sentence(&diagnosis);
    diagnosis.elapsed_s = begin.elapsed().as_secs_f64();
    Ok(diagnosis)
}

/// A problem with rounding of the variance that it has in these runs: what the nominal model leaves on short horizons,
/// on which any model is right, tells.
fn settled<'a>(problem: Problem<'a>) -> Option<Problem<'a>> {
    let nominal = Hypothesis::new(problem.nominal, Vec::new(), &problem.setting);
    let strongest = problem.levels.first().copied()?;
    let fit = problem.fit_at(&nominal, &nominal.start(), strongest, SETTLING_STEPS)?;
    let share = problem.likeliest_rounding(&fit);
    Some(problem.with_rounding(share))
}

/// The same once edges lost by chance are told apart from rounding, and the fit's numbers with it.
fn resettled<'a>(mut problem: Problem<'a>, fit: &mut Fit) -> Problem<'a> {
    for _ in 0..SETTLINGS {
        let share = problem.likeliest_rounding(fit);
        if share == problem.rounding {
            break;
        }
        problem = problem.with_rounding(share);
        let again = problem.fit_at(&fit.hypothesis, &fit.p, fit.wander, SETTLING_STEPS);
        if let Some(again) = again {
            *fit = again;
        }
    }
    problem
}

/// Refuses runs that would take hours to simulate and say nothing: samples too far apart, and mostly pauses.
fn sampled_enough(name: &str, run: &Run) -> Result<(), DiagnoseError> {
    let mut steps_s: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let lasts_s: f64 = steps_s.iter().sum();
    let mean_s = lasts_s / steps_s.len().max(1) as f64;
    steps_s.sort_by(f64::total_cmp);
    let median_s = steps_s.get(steps_s.len() / 2).copied().unwrap_or(0.0);
    let longest_s = PAUSE * median_s;
    let missing_s: f64 = steps_s.iter().filter(|step| **step > longest_s).sum();
    if missing_s > 0.5 * lasts_s {
        return Err(DiagnoseError::MostlyPauses {
            run: name.to_owned(),
            missing_s,
            lasts_s,
        });
    }
    if mean_s > MOST_APART_S {
        return Err(DiagnoseError::TooFarApart {
            run: name.to_owned(),
            mean_s,
        });
    }
    Ok(())
}

/// Runs made ready, with their names; what is wrong with them goes to `problems`.
fn ready(
    runs: &[Run],
    kind: CommandKind,
    problems: &mut Vec<DataProblem>,
) -> Result<(Vec<String>, Vec<RunData>), DiagnoseError> {
    let mut names = Vec::new();
    let mut data = Vec::new();
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
        sampled_enough(&name, run)?;
        if run.command_kind != kind {
            return Err(DiagnoseError::Mixed {
                run: name,
                found: run.command_kind.column(),
                first: kind.column(),
            });
        }
        if let Some(what) = checks::not_recorded(run) {
            let found = checks::of_what_there_is(&name, run);
            return Err(DiagnoseError::NotRecorded {
                run: name,
                what,
                found,
            });
        }
        problems.extend(checks::problems(&name, run));
        data.push(
            RunData::new(run, k).map_err(|source| DiagnoseError::Simulation {
                run: name.clone(),
                source,
            })?,
        );
        names.push(name);
    }
    Ok((names, data))
}
