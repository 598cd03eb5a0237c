//! Sets of effects that a rough recording does not tell apart, since no law of the catalogue is its motor's own.
//!
//! In the noise of a recording the likelihood of one wrong law against another grows with every sample. In three seconds of
//! a servo load-dependent friction wins nearly every block, in the next three, which turn further, Stribeck friction:
//! drawing blocks again shows nothing of that. What a model lacks (Kennedy and O'Hagan; Brynjarsdottir and O'Hagan 2014) is
//! an error of its own, here taken to be three times what noise hides, as in `other_law`. With it in the noise, log-likelihoods
//! count a ninth. So of the sets that are alike to the best
//!
//! - by their predictions: a separation `D < 9` (see `ties`),
//! - by what they leave of pieces kept from the fit: at most twice what the best leaves, unless `D < 3` says that the
//!   recording cannot tell them apart at all,
//! - and by kind: no more effects, and what differs has laws (not counting, timing or the command)
//!
//! the probabilities are shared out anew, `p_i' = (sum of p) p_i^(1/9) / (sum of p^(1/9))`, and they are a stated tie. A set
//! that leaves as little as the encoder has found the motor's law, and is left alone.
//!
//! Only sets that were fitted can be alike: so the best set is fitted with each of its effects exchanged for another.

use super::candidate::Candidate;
use super::other_law::{OF_A_LAW, has_laws};
use super::problem::Problem;
use super::rank::Ranking;
use super::rungs::left_by;
use super::ties::{TIE, separation};
use crate::compare::FLOOR_COUNTS;

/// How many times what the best set leaves of kept pieces a set leaves that is as good.
const AS_GOOD: f64 = 2.0;
/// Most sets that are looked at.
const RIVALS: usize = 24;

/// Shares out the probabilities of the sets that are alike to the best; their effects.
pub(super) fn share_out(problem: &Problem<'_>, ranking: &mut Ranking) -> Vec<Vec<usize>> {
    let places = alike(problem, ranking).unwrap_or_default();
    if places.is_empty() {
        return Vec::new();
    }
    let all: Vec<usize> = std::iter::once(0).chain(places.iter().copied()).collect();
    let of = |place: &usize| ranking.candidates[*place].probability;
    let shared = tempered(&all.iter().map(of).collect::<Vec<f64>>());
    for (place, probability) in all.into_iter().zip(shared) {
        ranking.candidates[place].probability = probability;
    }
    let effects = |place: &usize| ranking.candidates[*place].effects.clone();
    let alike = places.iter().map(effects).collect();
    ranking
        .candidates
        .sort_by(|a, b| b.probability.total_cmp(&a.probability));
    alike
}

/// Probabilities shared out with the log-likelihoods counting a ninth, their sum kept.
fn tempered(probabilities: &[f64]) -> Vec<f64> {
    let total: f64 = probabilities.iter().sum();
    let root = |p: &f64| p.powf(1.0 / (OF_A_LAW * OF_A_LAW));
    let sum: f64 = probabilities.iter().map(root).sum();
    (probabilities.iter().map(|p| total * root(p) / sum)).collect()
}

/// Places of the sets that are alike to the best.
fn alike(problem: &Problem<'_>, ranking: &Ranking) -> Option<Vec<usize>> {
    let best = ranking.candidates.first()?;
    if best.effects.is_empty() || ranking.unknown > best.probability {
        return None;
    }
    let near: Vec<(usize, f64)> = (1..ranking.candidates.len())
        .filter(|&place| is_of_a_kind(best, &ranking.candidates[place]))
        .take(RIVALS)
        .filter_map(|place| {
            let rival = &ranking.candidates[place].fit;
            Some((place, separation(problem, &best.fit, rival)?))
        })
        .filter(|(_, separation)| *separation < OF_A_LAW * TIE)
        .collect();
    let of = |near: &(usize, f64)| &ranking.candidates[near.0].fit;
    let fits: Vec<_> = std::iter::once(&best.fit)
        .chain(near.iter().map(of))
        .collect();
    let left = left_by(problem, &fits)?;
    if left[0] < AS_GOOD * FLOOR_COUNTS {
        return None;
    }
    let places = near.into_iter().zip(&left[1..]);
    let alike =
        places.filter(|((_, separation), rival)| *separation < TIE || **rival <= AS_GOOD * left[0]);
    Some(alike.map(|((place, _), _)| place).collect())
}

/// Whether a set differs from the best in effects only that have laws, and has no more of them.
fn is_of_a_kind(best: &Candidate, rival: &Candidate) -> bool {
    let only = |a: &Candidate, b: &Candidate| {
        let own = a.effects.iter().filter(|e| !b.effects.contains(e));
        own.copied().collect::<Vec<usize>>()
    };
    let mut differing = only(best, rival).into_iter().chain(only(rival, best));
    !rival.effects.is_empty()
        && rival.effects.len() <= best.effects.len()
        && differing.all(has_laws)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 512 to 1 is 2 to 1 by the ninth root.
    #[test]
    fn odds_count_by_their_ninth_root() {
        let shared = tempered(&[0.9 * 512.0 / 513.0, 0.9 / 513.0]);
        assert!((shared[0] - 0.6).abs() < 1e-12, "{shared:?}");
        assert!((shared[1] - 0.3).abs() < 1e-12, "{shared:?}");
    }
}
