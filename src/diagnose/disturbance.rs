//! What disturbs a real motor besides rounding and a slow wander, estimated from what the best model leaves.
//!
//! Teeth, brushes and bearings shake a shaft faster than the wander's second; about standstill friction builds up and
//! lets go by laws of its own; slots of an encoder are uneven. So the speed may walk at random (its variance grows by
//! `speed_walk` in (counts/s)^2 a second, by `slow_walk` besides where the shaft turns slowly) and the counts scatter
//! (variance `scatter`). With rounding and wander alone a recording that has such noise makes every probability 0 or 1.
//!
//! The three are the same for all hypotheses: those that make what the best named set leaves likeliest, one after the
//! other over a grid until none gains, with the wander free beside them. A recording in which they gain little has none.
//! Edges lost by chance and samples taken late are a noise too, and beside one of them little may be left to gain: so the
//! best set without either, with such noise, is asked as well whether it is the likelier one.
//! Where they are needed, runs are cut into pieces (`data.rs`), each simulated from the recorded angle and speed.

use rayon::prelude::*;

use super::candidate::{Candidate, candidate};
use super::data::RunData;
use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::noise::{Carried, NoiseLevel, Whitener};
use super::problem::Problem;
use super::rank::Ranking;
use super::shapes::Group;

/// Noise beyond rounding and wander.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Disturbance {
    /// Growth of the speed's variance in (counts/s)^2 in a second.
    pub speed_walk: f64,
    /// The same besides, where the shaft turns slowly.
    pub slow_walk: f64,
    /// Variance of a count beyond that of rounding.
    pub scatter: f64,
}

/// Standard deviations of an acceleration that lasts [`BRIEF_S`], as shares of the largest acceleration.
const SHAKES: [f64; 12] = [
    0.0, 1e-4, 3e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.3, 1.0,
];
/// How long one of them lasts in s.
const BRIEF_S: f64 = 0.01;
/// Standard deviations of the scatter in counts.
const SCATTERS: [f64; 9] = [0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 100.0];
/// Rounds over the three.
const MOST_ROUNDS: usize = 4;
/// How often a set is fitted to its own disturbance, and with how many steps.
const ITERATIONS: usize = 2;
const STEPS: usize = 5;
/// An estimate must be worth this many nats more than what there was, and this many for each sample.
const WORTH: f64 = 50.0;
const WORTH_A_SAMPLE: f64 = 0.05;
/// How many sets without a noise of their own are asked, where the best has one.
const RIVALS: usize = 3;
/// What three numbers picked from a grid gain by chance at most, in nats: the logarithm of how many there are.
const CHOICE: f64 = 7.2;
/// Most steps of their fits on each level of the wander.
const RIVAL_STEPS: usize = 12;
/// How many sets of one effect tell the noise of pieces where work has a limit.
const SINGLES: usize = 8;
/// Length in s of the blocks in which noise is looked for, their least number of samples, and in which share of them it must
/// be there.
const BLOCK_S: f64 = 0.1;
const LEAST_BLOCK: usize = 5;
const WIDESPREAD: f64 = 0.5;

impl Disturbance {
    /// Growth of the speed's variance where the shaft turns slowly or not.
    pub fn speed_walk(&self, slowly: bool) -> f64 {
        if slowly {
            self.speed_walk + self.slow_walk
        } else {
            self.speed_walk
        }
    }
}

/// The disturbance that makes likeliest what a fit leaves; `None` where the problem's is as good.
pub(super) fn disturbance(
    problem: &Problem<'_>,
    fit: &Fit,
    largest_acceleration: f64,
) -> Option<Disturbance> {
    worthwhile(problem, fit, largest_acceleration).map(|(_, rough)| rough)
}

/// The disturbance of a recording that was ranked without one. A noise among the effects of the best set may stand for the
/// recording's own: where a set without either, fitted with a disturbance, is likelier, also than something unknown beside
/// the best set.
pub(super) fn disturbance_of(
    problem: &Problem<'_>,
    ranking: &Ranking,
    largest_acceleration: f64,
) -> Option<Disturbance> {
    let sets = &ranking.candidates;
    let best = sets.first()?;
    if let Some((gain, rough)) = worthwhile(problem, &best.fit, largest_acceleration) {
        // What swings at one frequency is no noise.
        let is_swing = matches!(ranking.flexible.group, Group::Oscillation(_));
        return (!is_swing || gain > ranking.unknown_gain).then_some(rough);
    }
    let is_noisy = |set: &&Candidate| set.fit.hypothesis.noise_numbers().next().is_some();
    let bar = best.log_weight + CHOICE + ranking.unknown_gain.max(0.0);
    let mut likeliest = (bar, None);
    if is_noisy(&best) {
        let rivals: Vec<&Candidate> = sets
            .iter()
            .filter(|set| !is_noisy(set))
            .take(RIVALS)
            .collect();
        let found: Vec<Option<(f64, Disturbance)>> = rivals
            .into_par_iter()
            .with_max_len(1)
            .map(|set| {
                let (_, rough) = worthwhile(problem, &set.fit, largest_acceleration)?;
                let problem = problem.beside(rough);
                let fit = problem.fit(&set.fit.hypothesis, &set.fit.p, RIVAL_STEPS)?;
                let again = candidate(&problem, set.effects.clone(), fit, largest_acceleration);
                Some((again.log_weight, rough))
            })
            .collect();
        for (weight, rough) in found.into_iter().flatten() {
            if weight > likeliest.0 {
                likeliest = (weight, Some(rough));
            }
        }
    }
    likeliest.1
}

/// The disturbance that makes likeliest what a fit leaves and the nats that it gains, where that is worth it.
fn worthwhile(
    problem: &Problem<'_>,
    fit: &Fit,
    largest_acceleration: f64,
) -> Option<(f64, Disturbance)> {
    let (gain, _, level) = likeliest(problem, fit, largest_acceleration);
    let samples: usize = problem.runs.iter().map(RunData::len).sum();
    let worth = WORTH.max(WORTH_A_SAMPLE * samples as f64);
    let is_rough = gain > worth
        && level.rough != problem.rough
        && share_of_blocks(problem, fit, &level) >= WIDESPREAD;
    is_rough.then_some((gain, level.rough))
}

/// In which share of the blocks of [`BLOCK_S`] in which the shaft moves a noise explains what a fit leaves better than the
/// problem's own. Noise is there throughout; a few jumps that nothing explains are no noise.
fn share_of_blocks(problem: &Problem<'_>, fit: &Fit, level: &NoiseLevel) -> f64 {
    let own = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
    let (mut moving, mut better) = (0, 0);
    let likelihoods = |level: &NoiseLevel| -> Vec<Vec<f64>> {
        let mut carried = Carried::default();
        let runs = problem.runs.iter().zip(&fit.predictions);
        runs.zip(Whitener::all(problem.runs, &problem.responses, level))
            .map(|((run, x), whitener)| {
                let mut r: Vec<f64> = run.counts.iter().zip(x).map(|(n, x)| n - x - 0.5).collect();
                whitener.whiten_on(&mut carried, &mut r);
                whitener.log_likelihoods(run, &r).collect()
            })
            .collect()
    };
    let (before, after) = (likelihoods(&own), likelihoods(level));
    for ((run, before), after) in problem.runs.iter().zip(&before).zip(&after) {
        let length = ((BLOCK_S / run.sample_time_s).round() as usize).max(LEAST_BLOCK);
        for from in (0..run.len()).step_by(length) {
            let to = (from + length).min(run.len());
            if run.moving[from..to].contains(&true) {
                moving += 1;
                let sum = |values: &[f64]| values[from..to].iter().sum::<f64>();
                better += usize::from(sum(after) > sum(before));
            }
        }
    }
    f64::from(better as u32) / f64::from((moving as u32).max(1))
}

/// The disturbance of the set of effects that explains the runs best with a disturbance of its own: that of a wrong one
/// would swallow what the right one explains. Sets of one effect at most are tried, where work has a limit the likeliest; `start` is
/// where each begins.
pub(super) fn least_disturbance(
    problem: &Problem<'_>,
    sets: &[Candidate],
    start: Disturbance,
    largest_acceleration: f64,
) -> Disturbance {
    let strongest = problem.levels.first().copied().unwrap_or(0.0);
    let of_set = |hypothesis: &Hypothesis, mut p: Vec<f64>| {
        let mut problem = problem.beside(start);
        let mut best = (f64::NEG_INFINITY, start);
        for _ in 0..ITERATIONS {
            let Some(fit) = problem.fit_at(hypothesis, &p, strongest, STEPS) else {
                break;
            };
            let (_, likelihood, level) = likeliest(&problem, &fit, largest_acceleration);
            if likelihood > best.0 {
                best = (likelihood, level.rough);
            }
            problem.set_rough(level.rough);
            p = fit.p;
        }
        best
    };
    let most = if problem.effort.is_unlimited() {
        sets.len()
    } else {
        SINGLES
    };
    let singles = sets.iter().filter(|set| set.effects.len() == 1);
    let null = sets.iter().find(|set| set.effects.is_empty());
    let singles: Vec<&Candidate> = singles.take(most).chain(null).collect();
    let found: Vec<(f64, Disturbance)> = singles
        .into_par_iter()
        .with_max_len(1)
        .map(|set| of_set(&set.fit.hypothesis, set.fit.p.clone()))
        .collect();
    let likelier = |a: (f64, Disturbance), b: (f64, Disturbance)| if b.0 > a.0 { b } else { a };
    found
        .into_iter()
        .fold((f64::NEG_INFINITY, start), likelier)
        .1
}

/// What the likeliest disturbance gains over the problem's in nats, its log-likelihood, and the noise with it.
fn likeliest(
    problem: &Problem<'_>,
    fit: &Fit,
    largest_acceleration: f64,
) -> (f64, f64, NoiseLevel) {
    let residuals: Vec<Vec<f64>> = problem
        .runs
        .iter()
        .zip(&fit.predictions)
        .map(|(run, x)| run.counts.iter().zip(x).map(|(n, x)| n - x - 0.5).collect())
        .collect();
    let likelihood = |level: &NoiseLevel| -> f64 {
        let mut carried = Carried::default();
        let filters = Whitener::all(problem.runs, &problem.responses, level);
        let parts = filters.iter().zip(&residuals).map(|(whitener, r)| {
            let mut r = r.clone();
            whitener.whiten_on(&mut carried, &mut r);
            let squares: f64 = r.iter().map(|x| x * x).sum();
            -0.5 * (squares + whitener.log_determinant)
        });
        parts.sum()
    };
    let walk = |share: f64| (share * largest_acceleration).powi(2) * BRIEF_S;
    let with = |from: NoiseLevel, change: &dyn Fn(&mut NoiseLevel)| {
        let mut tried = from;
        change(&mut tried);
        tried
    };
    let speed_walks = |from: NoiseLevel| {
        let of = |share: f64| with(from, &|to| to.rough.speed_walk = walk(share));
        SHAKES.map(of).to_vec()
    };
    let slow_walks = |from: NoiseLevel| {
        let of = |share: f64| with(from, &|to| to.rough.slow_walk = walk(share));
        SHAKES.map(of).to_vec()
    };
    let scatters = |from: NoiseLevel| {
        let of = |counts: f64| with(from, &|to| to.rough.scatter = counts * counts);
        SCATTERS.map(of).to_vec()
    };
    let wanders = |from: NoiseLevel| {
        let of = |wander: &f64| with(from, &|to| to.wander = *wander);
        problem.levels.iter().map(of).collect::<Vec<NoiseLevel>>()
    };
    let grids: [&dyn Fn(NoiseLevel) -> Vec<NoiseLevel>; 4] =
        [&speed_walks, &slow_walks, &scatters, &wanders];
    let mut level = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
    let before = likelihood(&level);
    let mut best = before;
    // Where each grid was left: nothing is to be found there as long as the others leave it.
    let mut left: [Option<NoiseLevel>; 4] = [None; 4];
    for _ in 0..MOST_ROUNDS {
        let last = level;
        for (grid, left) in grids.iter().zip(&mut left) {
            if *left == Some(level) {
                continue;
            }
            let mut tried = grid(level);
            tried.retain(|tried| *tried != level);
            let likelihoods: Vec<f64> = tried.par_iter().map(likelihood).collect();
            for (found, tried) in likelihoods.into_iter().zip(tried) {
                if found > best {
                    (best, level) = (found, tried);
                }
            }
            *left = Some(level);
        }
        if level == last {
            break;
        }
    }
    (best - before, best, level)
}
