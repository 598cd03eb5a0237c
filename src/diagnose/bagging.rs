//! Probabilities that hold on another piece of a real recording.
//!
//! No named set is the truth about a real motor. The evidence of one wrong set against another then grows with every
//! sample, and soon says that one of them is certain, though on another minute of the same motor the other may win. So
//! the evidence is asked how it depends on what happened to be recorded: blocks of half a second are drawn with
//! replacement, as many as there are, the sets weighed on them, and their probabilities averaged over the draws (the
//! bagged posterior; Bühlmann 2014, Huggins and Miller 2023). Numbers stay as all data fit them. Where every block
//! speaks for the same set, that changes nothing. Of rough recordings all sets are weighed so, of others something unknown
//! against the best of them: there the noise of named sets is known.

use rand::{RngExt, SeedableRng};

use super::data::RunData;
use super::fit::Fit;
use super::noise::WANDER_S;
use super::problem::Problem;
use super::rank::{PRIOR_UNKNOWN, Ranking};

/// Length of a block in s.
const BLOCK_S: f64 = 0.5;
/// From this probability on something is taken to be unknown, and the named sets are asked which is nearest.
pub(super) const MOSTLY: f64 = 0.5;
/// Least probability of all named sets together: less is no number to share out.
const LEAST: f64 = 1e-200;
/// Draws.
const DRAWS: usize = 400;

/// Averages the probabilities of a ranking over draws of blocks.
pub(super) fn bag(problem: &Problem<'_>, ranking: &mut Ranking) {
    let blocks = Blocks::of(problem.runs);
    let Some(best) = ranking.candidates.first() else {
        return;
    };
    // The unknown is the best set and something beside it: it keeps its odds against that, of an axis that is held
    // against the best of each draw. Of other recordings that has not been measured.
    let odds = (ranking.unknown.max(1e-300) / best.probability.max(1e-300)).ln();
    let parts: Vec<Vec<f64>> = ranking
        .candidates
        .iter()
        .map(|c| blocks.log_likelihoods(problem, &c.fit, &problem.innovations(&c.fit)))
        .collect();
    let parts: Vec<&[f64]> = parts.iter().map(Vec::as_slice).collect();
    let weights: Vec<f64> = ranking.candidates.iter().map(|c| c.log_weight).collect();
    let count = weights.len();
    let mut shares = over_draws(&weights, &parts, |weights| {
        let best = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let named = if problem.setting.is_held {
            best
        } else {
            weights[0]
        };
        let log_unknown = named + odds;
        let mut all = shared_out(weights, Some(log_unknown));
        all.extend(shared_out(weights, None));
        all
    });
    let among_named = shares.split_off(count + 1);
    ranking.unknown = shares.pop().unwrap_or(0.0);
    if ranking.unknown > MOSTLY {
        // Which set is nearest is asked of every draw alike, not of the few in which the unknown is least likely.
        let named = shares.iter().sum::<f64>().max(LEAST);
        shares = among_named.into_iter().map(|s| named * s).collect();
    }
    for (candidate, share) in ranking.candidates.iter_mut().zip(shares) {
        candidate.probability = share;
    }
    ranking.candidates.sort_by(|a, b| {
        let by_probability = b.probability.total_cmp(&a.probability);
        by_probability.then(b.log_weight.total_cmp(&a.log_weight))
    });
}

/// The same of the unknown alone, where it is likelier than all named sets, for a recording that is not rough: half a second
/// that nothing in the catalogue explains need not have its like in the next half-minute of the motor. `judged` are the nats
/// by which data kept from the fit and jumps speak for it, which stand as they are; `scale` is the largest acceleration in
/// counts/s^2.
pub(super) fn bag_unknown(problem: &Problem<'_>, ranking: &mut Ranking, judged: f64, scale: f64) {
    let Some(best) = ranking.candidates.first() else {
        return;
    };
    if ranking.unknown <= MOSTLY {
        return;
    }
    let Some((fit, with)) = ranking.flexible.beside(problem, &best.fit, scale) else {
        return;
    };
    let blocks = Blocks::of(problem.runs);
    let parts = [
        blocks.log_likelihoods(problem, &best.fit, &problem.innovations(&best.fit)),
        blocks.log_likelihoods(problem, &fit, &with.residual),
    ];
    let of_best: Vec<f64> = (ranking.candidates.iter())
        .map(|c| (c.log_weight - best.log_weight).exp())
        .collect();
    let named: f64 = of_best.iter().sum();
    let unknown = ranking.unknown_gain + PRIOR_UNKNOWN.ln() + judged;
    let weights = [named.ln(), unknown];
    let shares = over_draws(&weights, &parts.each_ref().map(Vec::as_slice), |weights| {
        shared_out(weights, None)
    });
    ranking.unknown = shares[1];
    for (candidate, share) in ranking.candidates.iter_mut().zip(of_best) {
        candidate.probability = shares[0] * share / named;
    }
}

/// What so short a recording does not show: whether something is unknown is asked of each of the `n` independent values that
/// what wanders takes in it, and of two answers that `n` of `n` trials agree on, the next gives the same with
/// `(n + 1/2) / (n + 1)` (Jeffreys' prior of a share). So
///
/// `P'(unknown) = (n P(unknown) + 1/2) / (n + 1)`
///
/// and the named sets share the rest as they did.
pub(super) fn allow_for_more(problem: &Problem<'_>, ranking: &mut Ranking) {
    let sets = &mut ranking.candidates;
    let mut shares: Vec<f64> = sets.iter().map(|set| set.probability).collect();
    if shares.iter().sum::<f64>() < f64::MIN_POSITIVE {
        let weights: Vec<f64> = sets.iter().map(|set| set.log_weight).collect();
        shares = shared_out(&weights, None);
    }
    let named: f64 = shares.iter().sum();
    ranking.unknown = of_one_more(problem.runs, ranking.unknown);
    for (set, share) in sets.iter_mut().zip(shares) {
        set.probability = (1.0 - ranking.unknown) * share / named;
    }
}

/// The probability that one more value of what wanders says what those of these runs say with this probability,
/// `allow_for_more`'s. A mean over the time `T` of what has the correlation time `tau` varies as one of `n = T / 2 tau`
/// independent values does (Priestley 1981, section 5.3).
pub(super) fn of_one_more(runs: &[RunData], probability: f64) -> f64 {
    let spans = runs
        .iter()
        .filter_map(|run| Some(run.t_s.last()? - run.t_s.first()?));
    let n = spans.sum::<f64>() / (2.0 * WANDER_S);
    (n * probability + 0.5) / (n + 1.0)
}

/// Each weight's share of all, the unknown's last where it has one.
pub(super) fn shared_out(log_weights: &[f64], log_unknown: Option<f64>) -> Vec<f64> {
    let all = log_weights.iter().copied().chain(log_unknown);
    let top = all.clone().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = all.map(|weight| (weight - top).exp()).collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / total).collect()
}

/// The mean over draws of blocks of what the weights of that draw come to; `parts` are the log-likelihoods of each block
/// that are part of each weight.
pub(super) fn over_draws(
    log_weights: &[f64],
    parts: &[&[f64]],
    shares: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let count = parts.first().map_or(0, |parts| parts.len());
    let offsets: Vec<f64> = log_weights
        .iter()
        .zip(parts)
        .map(|(weight, parts)| weight - parts.iter().sum::<f64>())
        .collect();
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let mut sums: Vec<f64> = Vec::new();
    for _ in 0..DRAWS {
        let mut times = vec![0.0; count];
        for _ in 0..count {
            times[rng.random_range(0..count)] += 1.0;
        }
        let weights: Vec<f64> = offsets
            .iter()
            .zip(parts)
            .map(|(offset, parts)| {
                offset + parts.iter().zip(&times).map(|(p, n)| p * n).sum::<f64>()
            })
            .collect();
        let found = shares(&weights);
        sums.resize(found.len(), 0.0);
        for (sum, share) in sums.iter_mut().zip(found) {
            *sum += share;
        }
    }
    sums.into_iter().map(|sum| sum / DRAWS as f64).collect()
}

/// The blocks of runs.
pub(super) struct Blocks {
    /// The block of each sample of all runs end to end.
    numbers: Vec<usize>,
    count: usize,
}

impl Blocks {
    /// Of these runs.
    pub fn of(runs: &[RunData]) -> Self {
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
        Self { numbers, count }
    }

    /// Log-likelihood of each block, of the whitened residuals of all runs end to end with a fit's noise.
    pub fn log_likelihoods(&self, problem: &Problem<'_>, fit: &Fit, residuals: &[f64]) -> Vec<f64> {
        let level = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
        let whiteners = problem.whiteners(&level);
        let mut sums = vec![0.0; self.count];
        let mut number = self.numbers.iter();
        let mut left = residuals;
        for (run, whitener) in problem.runs.iter().zip(whiteners.iter()) {
            let (own, others) = left.split_at(run.len());
            left = others;
            for (value, &number) in whitener.log_likelihoods(run, own).zip(number.by_ref()) {
                sums[number] += value;
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{Candidate, candidate};
    use super::super::samples::{fit, motor_with, problem, ranking, ready, recording};
    use super::super::scales::largest_acceleration;
    use super::super::unknown::likeliest;
    use super::*;
    use crate::recording::Run;

    /// The unknown's probability beside the model without effects, before and after averaging.
    fn unknown(run: &Run) -> (f64, f64) {
        let nominal = motor_with(&[]);
        let runs = ready(run);
        let problem = problem(&nominal, &runs);
        let scale = largest_acceleration(&nominal, &runs);
        let null = candidate(&problem, Vec::new(), fit(&problem, &[]), scale);
        let (flexible, gain) = likeliest(&problem, &null.fit, scale);
        let shares = shared_out(&[0.0], Some(gain + PRIOR_UNKNOWN.ln()));
        let null = Candidate {
            probability: shares[0],
            ..null
        };
        let mut ranking = Ranking {
            flexible,
            unknown_gain: gain,
            ..ranking(vec![null], shares[1])
        };
        bag_unknown(&problem, &mut ranking, 0.0, scale);
        (shares[1], ranking.unknown)
    }

    /// Friction that no part of the model has speaks for the unknown whenever the shaft moves.
    #[test]
    fn what_shows_throughout_stays_certain() {
        let (before, after) = unknown(&recording(&motor_with(&[("asymmetric_friction", &[0.3])])));
        assert!(before > 0.99 && after > 0.99, "{before} {after}");
    }

    /// A shaft that is pushed once, by a smooth bump of so many counts, half a second long about this time.
    fn pushed(counts: f64, at_s: f64) -> Run {
        let mut run = recording(&motor_with(&[]));
        for (t_s, n) in run.t_s.iter().zip(&mut run.counts) {
            let x = (t_s - at_s) / 0.25;
            if x.abs() < 1.0 {
                *n += (counts * (1.0 - x * x).powi(2)).round() as i64;
            }
        }
        run
    }

    #[test]
    fn what_shows_once_is_in_two_thirds_of_the_draws() {
        let (before, after) = unknown(&pushed(40.0, 3.25));
        assert!(
            before > 0.99 && (after - 0.632).abs() < 0.08,
            "{before} {after}"
        );
    }

    fn of_the_first(parts: &[&[f64]]) -> f64 {
        let weights: Vec<f64> = parts.iter().map(|parts| parts.iter().sum()).collect();
        let shares = |weights: &[f64]| {
            let second = (weights[1] - weights[0]).exp();
            vec![1.0 / (1.0 + second), second / (1.0 + second)]
        };
        over_draws(&weights, parts, shares)[0]
    }

    /// A block is in a draw of as many with `1 - 1/e`: evidence in one block only gets no farther.
    #[test]
    fn evidence_in_one_block_is_in_two_thirds_of_the_draws() {
        let none = [0.0; 40];
        let mut one = [-5.0; 40];
        one[7] = 1000.0;
        let share = of_the_first(&[&one, &none]);
        assert!((share - 0.632).abs() < 0.08, "{share}");
    }

    #[test]
    fn evidence_in_every_block_is_certain() {
        let share = of_the_first(&[&[1.0; 40], &[0.0; 40]]);
        assert!(share > 0.999_999, "{share}");
    }

    /// Ten seconds are five times two seconds, twice the second over which a load wanders, and of one time more nobody knows: 5.5
    /// of 6 for what all of them say, and of that the sets keep their odds, even those too small for a number.
    #[test]
    fn what_all_of_it_says_the_next_two_seconds_need_not() {
        let nominal = motor_with(&[]);
        let mut run = recording(&nominal);
        for of in [&mut run.t_s, &mut run.command] {
            of.truncate(3334);
        }
        run.counts.truncate(3334);
        let runs = ready(&run);
        let problem = problem(&nominal, &runs);
        let scale = largest_acceleration(&nominal, &runs);
        let null = candidate(&problem, Vec::new(), fit(&problem, &[]), scale);
        for (named, unknown) in [(1.0, 0.5 / 6.0), (0.5, 3.0 / 6.0), (0.0, 5.5 / 6.0)] {
            let sets = [0.0, -1.0].map(|log_weight| Candidate {
                log_weight,
                probability: named * f64::exp(log_weight) / (1.0 + (-1.0_f64).exp()),
                ..null.clone()
            });
            let mut ranking = ranking(sets.to_vec(), 1.0 - named);
            allow_for_more(&problem, &mut ranking);
            let [first, second] = [0, 1].map(|k: usize| ranking.candidates[k].probability);
            assert!((ranking.unknown - unknown).abs() < 1e-4, "{named}");
            assert!(
                (first + second + ranking.unknown - 1.0).abs() < 1e-12,
                "{named}"
            );
            assert!((first / second - 1.0_f64.exp()).abs() < 1e-9, "{named}");
        }
    }
}
