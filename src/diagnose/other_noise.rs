//! Edges lost by chance, or samples taken late, that the recording's own noise may stand for.
//!
//! Both move the angle on average, as a resolution or a delay would, and scatter it. Where a set without them moves it alike
//! (separation `D < 3`, which takes the averages alone), the scatter decides: and that is the noise of the recording, whose
//! law is not known to a hair. A noise whose deviation is `f` times the model's makes another likelier by
//! `n/2 (f^2 - 1 - ln f^2)` nats in `n` samples. So an advantage of fewer than that, with `f = 1.1`, is none: the set without is
//! taken to be as likely, and the result is said to be a tie.

use super::data::RunData;
use super::other_law::Doubtful;
use super::problem::Problem;
use super::rank::Ranking;
use super::ties::{TIE, separation};

/// How well the deviation of a recording's noise is known, as a factor.
const KNOWN: f64 = 1.1;
/// Share of the probability that a set without such a noise gets then.
const SHARE: f64 = 0.5;

/// The effects of the best set that only the noise tells from another set's, the probability shared out with that.
pub(super) fn weigh(problem: &Problem<'_>, ranking: &mut Ranking) -> Option<Doubtful> {
    let samples: usize = problem.runs.iter().map(RunData::len).sum();
    let best = ranking.candidates.first()?;
    best.fit.hypothesis.noise_numbers().next()?;
    let within = advantage(samples);
    let (place, separation) = (ranking.candidates.iter().enumerate().skip(1))
        .take_while(|(_, rival)| best.log_weight - rival.log_weight < within)
        .filter(|(_, rival)| rival.fit.hypothesis.noise_numbers().next().is_none())
        .filter_map(|(place, rival)| Some((place, separation(problem, &best.fit, &rival.fit)?)))
        .find(|(_, separation)| *separation < TIE)?;
    let rival = &ranking.candidates[place];
    let only = |a: &[usize], b: &[usize]| a.iter().copied().filter(|e| !b.contains(e)).collect();
    let doubtful = Doubtful {
        effects: only(&best.effects, &rival.effects),
        instead: only(&rival.effects, &best.effects),
        separation,
    };
    let moved = SHARE * best.probability;
    ranking.candidates[0].probability -= moved;
    ranking.candidates[place].probability += moved;
    Some(doubtful)
}

/// What a deviation that is known so well may gain by chance, in nats.
fn advantage(samples: usize) -> f64 {
    let square = KNOWN * KNOWN;
    0.5 * samples as f64 * (square - 1.0 - square.ln())
}
