//! Probabilities that hold on another piece of a rough recording.
//!
//! No named set is the truth about a real motor. The evidence of one wrong set against another then grows with every
//! sample, and soon says that one of them is certain, though on another minute of the same motor the other may win. So
//! the evidence is asked how it depends on what happened to be recorded: blocks of half a second are drawn with
//! replacement, as many as there are, the sets weighed on them, and their probabilities averaged over the draws (the
//! bagged posterior; Bühlmann 2014, Huggins and Miller 2023). Numbers stay as all data fit them. Where every block
//! speaks for the same set, that changes nothing.

use rand::{RngExt, SeedableRng};

use super::candidate::Candidate;
use super::data::RunData;
use super::fit::Problem;
use super::rank::Ranking;

/// Length of a block in s.
const BLOCK_S: f64 = 0.5;
/// Draws.
const DRAWS: usize = 400;

/// Averages the probabilities of a ranking over draws of blocks.
pub(super) fn bag(problem: &Problem<'_>, ranking: &mut Ranking) {
    let (block, count) = blocks(problem.runs);
    let Some(best) = ranking.candidates.first() else {
        return;
    };
    // The unknown is the best set and something beside it: it keeps its odds against that, of an axis that is held
    // against the best of each draw. Of other recordings that has not been measured.
    let odds = (ranking.unknown.max(1e-300) / best.probability.max(1e-300)).ln();
    let parts: Vec<Vec<f64>> = ranking
        .candidates
        .iter()
        .map(|candidate| log_likelihoods(problem, candidate, &block, count))
        .collect();
    let offsets: Vec<f64> = ranking
        .candidates
        .iter()
        .zip(&parts)
        .map(|(candidate, parts)| candidate.log_weight - parts.iter().sum::<f64>())
        .collect();
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let mut sums = vec![0.0; parts.len()];
    let mut unknown = 0.0;
    for _ in 0..DRAWS {
        let mut times = vec![0.0; count];
        for _ in 0..count {
            times[rng.random_range(0..count)] += 1.0;
        }
        let weights: Vec<f64> = offsets
            .iter()
            .zip(&parts)
            .map(|(offset, parts)| {
                offset + parts.iter().zip(&times).map(|(p, n)| p * n).sum::<f64>()
            })
            .collect();
        let best = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let named = if problem.setting.is_held {
            best
        } else {
            weights[0]
        };
        let log_unknown = named + odds;
        let top = best.max(log_unknown);
        let total: f64 =
            weights.iter().map(|w| (w - top).exp()).sum::<f64>() + (log_unknown - top).exp();
        for (sum, weight) in sums.iter_mut().zip(&weights) {
            *sum += (weight - top).exp() / total;
        }
        unknown += (log_unknown - top).exp() / total;
    }
    for (candidate, sum) in ranking.candidates.iter_mut().zip(sums) {
        candidate.probability = sum / DRAWS as f64;
    }
    ranking.unknown = unknown / DRAWS as f64;
    ranking.candidates.sort_by(|a, b| {
        let by_probability = b.probability.total_cmp(&a.probability);
        by_probability.then(b.log_weight.total_cmp(&a.log_weight))
    });
}

/// The block of each sample of all runs end to end, and how many there are.
fn blocks(runs: &[RunData]) -> (Vec<usize>, usize) {
    let mut numbers = Vec::new();
    let mut last = None;
    let mut count = 0;
    for run in runs {
        for t in &run.t_s {
            let place = (run.origin, (t / BLOCK_S).floor());
            if last != Some(place) {
                count += 1;
                last = Some(place);
            }
            numbers.push(count - 1);
        }
    }
    (numbers, count)
}

/// Log-likelihood of each block under a set's fit.
fn log_likelihoods(
    problem: &Problem<'_>,
    candidate: &Candidate,
    block: &[usize],
    count: usize,
) -> Vec<f64> {
    let fit = &candidate.fit;
    let level = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
    let whiteners = problem.whiteners(&level);
    let mut sums = vec![0.0; count];
    let mut block = block.iter();
    for ((run, whitener), innovations) in problem
        .runs
        .iter()
        .zip(whiteners.iter())
        .zip(problem.innovations_by_run(fit))
    {
        for (value, &number) in whitener
            .log_likelihoods(run, &innovations)
            .zip(block.by_ref())
        {
            sums[number] += value;
        }
    }
    sums
}
