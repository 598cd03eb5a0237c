//! The search for what a model lacks, judged by what it predicts: runs in, rivals with their scores and a verdict out.
//!
//! `motorlab search` prints it. `motorlab diagnose` does not use it yet: this room takes its place when it is whole.
//!
//! ```text
//! Runs -> Pieces -> base fit -> level: screening, fits, presence -> ... -> unknown -> Search
//! ```
//!
//! One measure: the position error in counts over a piece of a run, from the piece's own measured start. A model is fitted to it
//! (`fit`), whitened by rounding and a load that wanders (`noise`), and scored on pieces that it was not fitted to. Whatever is
//! said to be there gains more than chance makes of recordings simulated from the smaller model (`validation`).

mod fit;
mod noise;
mod pieces;
mod report;
mod screening;
mod selection;
mod settings;
mod validation;

pub use report::{Found, Rival, Search, Step};

use crate::motor::{Motor, SimulationError};
use crate::recording::Run;
use fit::{Base, Fit, Model};
use pieces::Pieces;
use settings::{
    CHANCE, CLOCK_READING_S, CLOSES, FEW_PIECES, FEW_PIECES_SURE, LEAST_GAIN, MOST_EFFECTS,
    ROUNDING,
};
use validation::standing;

/// Why nothing can be searched.
#[derive(Debug, thiserror::Error)]
pub enum SearchError {
    /// Nothing to look at.
    #[error("no run: name at least one run file")]
    NoRuns,
    /// A run with too few samples.
    #[error("run {run} has {samples} samples, {LEAST_SAMPLES} at least are needed")]
    TooShort {
        /// Number of the run, from 1.
        run: usize,
        /// Its samples.
        samples: usize,
    },
    /// Runs of different axes.
    #[error("run {run} commands {found}, the first run commands {first}: search them apart")]
    Mixed {
        /// Number of the run, from 1.
        run: usize,
        /// Its command column.
        found: &'static str,
        /// That of the first.
        first: &'static str,
    },
    /// A run that cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The motor makes no motion at all.
    #[error("the motor cannot be fitted to these runs: are its numbers and units right?")]
    NoFit,
}

/// Fewest samples of a run.
const LEAST_SAMPLES: usize = 20;

/// Searches for the effects that runs of one motor show beyond its nominal model.
///
/// # Errors
/// No runs, runs that are too short or of different axes, runs or motors that cannot be simulated.
///
/// ```
/// use motorlab::diagnosis::{Found, search};
/// use motorlab::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};
/// use motorlab::recording::Run;
///
/// let motor = Motor::default();
/// let t_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.01).collect();
/// let command = vec![4.5; 400];
/// let drive = Drive { t_s: &t_s, command: &command, kind: CommandKind::Voltage };
/// let counts = simulate(&motor, &drive, &SimulationOptions::default())?.counts;
/// let run = Run { sample_time_s: 0.01, counts_per_rev: 720.0, t_s, command, counts, ..Run::default() };
/// assert_eq!(search(&[run], &motor)?.found, Found::Nothing);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn search(runs: &[Run], motor: &Motor) -> Result<Search, SearchError> {
    let kind = usable(runs)?;
    let pieces = Pieces::new(runs, motor)?;
    let clocks = pieces.runs.iter().filter_map(|run| run.clock);
    let longest = clocks.max_by(|a, b| a.1.total_cmp(&b.1));
    let base = Base {
        motor: motor.clone(),
        kind,
        sample_time_s: pieces.runs[0].sample_time_s,
        clock: longest.map(|(error, span_s)| (error, CLOCK_READING_S / span_s)),
    };
    let model = Model::new(&base, Vec::new());
    let mut best = fit::fit(&pieces, &model, kind, &[model.start()]).ok_or(SearchError::NoFit)?;
    let mut steps = Vec::new();
    let mut sets: Vec<Vec<&'static str>> = Vec::new();
    let mut probability = 1.0;
    while best.model.members.len() < MOST_EFFECTS {
        let Some(level) = selection::level(&pieces, &base, &best) else {
            break;
        };
        let rivals: Vec<&Fit> = level.fits.iter().chain(std::iter::once(&best)).collect();
        let standings = standing(&rivals);
        let (Some(first), Some(presence)) = (level.fits.first(), &level.presence) else {
            break;
        };
        let gained = first.score() - best.score();
        let unbends = best.prior - first.prior > LEAST_GAIN;
        let closes = closed(&best, first);
        let is_there =
            presence.p_value() <= CHANCE && gained >= LEAST_GAIN && (closes >= CLOSES || unbends);
        steps.push(Step {
            from: best.model.ids(),
            left_counts: best.rms(),
            rivals: (level.fits.iter().zip(&standings))
                .map(|(fit, standing)| Rival {
                    effects: fit.model.ids(),
                    gains: fit.score() - best.score(),
                    behind: standing.behind,
                    error: standing.error,
                    is_tied: standing.is_tied,
                    left_counts: fit.rms(),
                    wander: fit.noise.strength,
                })
                .collect(),
            screened: level.screened.clone(),
            gain: presence.gain,
            chance: presence.by_chance.last().copied().unwrap_or(0.0),
            p_value: presence.p_value(),
            closes,
            is_kept: is_there,
        });
        if !is_there {
            break;
        }
        let tied = || {
            level
                .fits
                .iter()
                .zip(&standings)
                .filter(|(_, standing)| standing.is_tied)
        };
        probability *= tied().map(|(_, standing)| standing.weight).sum::<f64>();
        let names: Vec<Vec<&'static str>> = tied().map(|(fit, _)| fit.model.ids()).collect();
        sets = names
            .iter()
            .filter(|set| !has_simpler(set, &names))
            .cloned()
            .collect();
        let chosen = level
            .fits
            .iter()
            .find(|fit| sets.first() == Some(&fit.model.ids()));
        best = chosen.unwrap_or(first).clone();
    }
    if pieces.pieces.len() < FEW_PIECES {
        probability = probability.min(FEW_PIECES_SURE);
    }
    let unknown = validation::unknown(&pieces, &best);
    let found = match (sets.len(), unknown.is_there()) {
        (0, false) => Found::Nothing,
        (0, true) => Found::Unknown,
        (_, true) => Found::Partial,
        (1, false) => Found::Effects,
        (_, false) => Found::Several,
    };
    Ok(Search {
        found,
        sets,
        probability,
        left_counts: best.rms(),
        wander: best.noise.strength,
        unknown_gain: unknown.gain,
        unknown_chance: unknown.chance(),
        motor: best.model.motor(&best.x),
        pieces: pieces.pieces.len(),
        steps,
    })
}

/// What the runs command, where they can be searched together.
fn usable(runs: &[Run]) -> Result<crate::motor::CommandKind, SearchError> {
    let first = runs.first().ok_or(SearchError::NoRuns)?;
    for (k, run) in runs.iter().enumerate() {
        if run.len() < LEAST_SAMPLES {
            let samples = run.len();
            return Err(SearchError::TooShort {
                run: k + 1,
                samples,
            });
        }
        if run.command_kind != first.command_kind {
            return Err(SearchError::Mixed {
                run: k + 1,
                found: run.command_kind.column(),
                first: first.command_kind.column(),
            });
        }
    }
    Ok(first.command_kind)
}

/// Share of the mean square above what rounding leaves (of a sample, and of the start) that a fit closes.
fn closed(before: &Fit, after: &Fit) -> f64 {
    let floor = 2.0 * ROUNDING;
    let above = before.rms().powi(2) - floor;
    if above <= 0.0 {
        return 0.0;
    }
    (before.rms().powi(2) - after.rms().powi(2)) / above
}

/// Whether a set is one of the others with an effect by direction in the place of the plain one.
fn has_simpler(set: &[&'static str], sets: &[Vec<&'static str>]) -> bool {
    set.iter().any(|id| {
        let Some(plain) = id.strip_prefix("asymmetric_") else {
            return false;
        };
        let mut simpler: Vec<&str> = set
            .iter()
            .map(|other| if other == id { plain } else { other })
            .collect();
        simpler.sort_unstable();
        sets.contains(&simpler)
    })
}
