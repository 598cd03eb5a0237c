//! A rough recording: everything is weighed on pieces of its runs, with the noise that it has.
//!
//! What disturbs it is estimated, and sets are ranked, in turn: the noise of a wrong set would swallow what the right one
//! explains, and which sets there are to choose from is known after a ranking only.

use super::bagging::bag;
use super::candidate::{Candidate, candidate};
use super::data::{PIECE_S, RunData, spread};
use super::disturbance::{Disturbance, disturbance, least_disturbance};
use super::effort::MOST;
use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::nearest;
use super::problem::Problem;
use super::rank::{Ranking, beginning, exchange, rank, singles};
use super::search::Search;

/// Levels of the wander that are stronger than an ordinary motor's, as shares of the largest acceleration: the command
/// of an axis that is held in place is as large as what disturbs it.
const STRONG_WANDER_LEVELS: [f64; 2] = [0.3, 0.1];
/// Share of the pieces that tell the noise where work has a limit.
const SOME: f64 = 0.3;
/// Most times that the noise of pieces is estimated anew.
const MOST_ESTIMATES: usize = 2;
/// Of motions that part at a rate, how many times the rate's inverse a piece lasts.
const PARTED: f64 = 2.0;
/// Most steps of the first fit of an axis that is held.
const FIRST_STEPS: usize = 6;

/// What is known of a rough recording before it is cut to pieces.
pub(super) struct Rough {
    /// What disturbs it, by the best set so far.
    pub noise: Disturbance,
    /// How long a piece of it is in s.
    pub length_s: f64,
    sets: Vec<Candidate>,
}

/// The levels of the wander of an axis that is held, strongest first.
pub(super) fn held_levels(levels: &[f64], scale: f64) -> Vec<f64> {
    let stronger = STRONG_WANDER_LEVELS.iter().map(|share| share * scale);
    stronger.chain(levels.iter().copied()).collect()
}

impl Rough {
    /// Of a recording that was ranked whole.
    pub fn of(problem: &Problem<'_>, ranking: Ranking, noise: Disturbance) -> Self {
        let null = ranking.null().map(|null| &null.fit);
        Self {
            noise,
            length_s: null.map_or(PIECE_S, |null| length_s(problem, null)),
            sets: ranking.candidates,
        }
    }

    /// Of an axis that is held, by pieces of a second: open loop says nothing of it.
    pub fn of_held(problem: &Problem<'_>, scale: f64) -> Option<Self> {
        let hypothesis = Hypothesis::new(problem.nominal, Vec::new(), &problem.setting);
        let strongest = problem.levels.first().copied()?;
        let null = problem.fit_at(&hypothesis, &hypothesis.start(), strongest, FIRST_STEPS)?;
        Some(Self {
            noise: Disturbance::default(),
            length_s: length_s(problem, &null),
            sets: vec![candidate(problem, Vec::new(), null, scale)],
        })
    }

    /// Weighs all hypotheses on the pieces of `problem`; `None` where not even the nominal motor can be simulated.
    pub fn weighed(
        self,
        problem: &mut Problem<'_>,
        scale: f64,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Option<Ranking> {
        let mut ranking = if problem.setting.is_held {
            let noise = least_disturbance(problem, &self.sets, self.noise, scale);
            problem.set_rough(noise);
            let alone = singles(problem, progress)?;
            let noise = least_disturbance(problem, &alone, self.noise, scale);
            problem.set_rough(noise);
            rank(problem, progress)?
        } else {
            let mut ranking = self.ranked(problem, scale, progress)?;
            if problem.effort.is_left(MOST) {
                exchange(problem, &mut ranking);
            }
            ranking
        };
        bag(problem, &mut ranking);
        nearest::share_out(problem, &mut ranking);
        Some(ranking)
    }

    /// Ranks with the noise of the sets that were known before, and again where the best set then has another.
    fn ranked(
        self,
        problem: &mut Problem<'_>,
        scale: f64,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Option<Ranking> {
        let mut sets = self.sets;
        let mut estimates = 0;
        loop {
            let some = (!problem.effort.is_unlimited()).then(|| {
                let samples: usize = problem.runs.iter().map(RunData::len).sum();
                spread(problem.runs.to_vec(), (SOME * samples as f64) as usize)
            });
            let noise = match &some {
                Some(runs) => {
                    least_disturbance(&beginning(problem, runs), &sets, self.noise, scale)
                }
                None => least_disturbance(problem, &sets, self.noise, scale),
            };
            problem.set_rough(noise);
            let ranking = rank(problem, progress)?;
            estimates += 1;
            let best = ranking.candidates.first()?;
            let is_settled =
                estimates == MOST_ESTIMATES || disturbance(problem, &best.fit, scale).is_none();
            if is_settled || !problem.effort.is_left(MOST) {
                return Some(ranking);
            }
            sets = ranking.candidates;
        }
    }
}

/// How long a piece is: a second, or shorter where motions part faster.
fn length_s(problem: &Problem<'_>, null: &Fit) -> f64 {
    let rate = Search::new(problem, null, 0).and_then(|search| search.parting_rate());
    rate.map_or(PIECE_S, |rate| PIECE_S.min(PARTED / rate))
}
