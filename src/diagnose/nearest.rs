//! Which named set is nearest to a motor of which something is unknown.
//!
//! Where no set of the catalogue is the motor, how likely each makes the recording says little of which of them describes it:
//! laws that all lack something bend their numbers to it, and tens of nats part sets of which one predicts and the others do
//! not. What is asked of the nearest set is that it predicts. So of a rough recording that is outside the catalogue the
//! sets whose likelihoods a ninth could turn (`other_law.rs`) share their probability anew,
//!
//! `ln p_i = ln w_i / 9 - n ln e_i + const`,
//!
//! with what each leaves, refitted to the first part, of the `n` pieces kept: `e_i` counts RMS. That is the likelihood of `n`
//! errors of one unknown size, a piece of a second counting for one and a shorter one for less, at the size that suits it best.

use super::bagging::{MOSTLY, shared_out};
use super::candidate::Candidate;
use super::other_law::OF_A_LAW;
use super::problem::Problem;
use super::rank::Ranking;
use super::rungs::{kept_pieces, left_by};
use crate::compare::FLOOR_COUNTS;

/// Sets so many nats behind the best one could be the better after all: odds of one in fifty-five by the ninth root.
const NEAR: f64 = 36.0;
/// Most sets that are looked at.
const RIVALS: usize = 8;

/// Shares out the probabilities of the sets that come near the best where something unknown is likelier than all of them.
pub(super) fn share_out(problem: &Problem<'_>, ranking: &mut Ranking) {
    let sets = &ranking.candidates;
    if ranking.unknown <= MOSTLY {
        return;
    }
    let weights = sets.iter().map(|set| set.log_weight);
    let top = weights.fold(f64::NEG_INFINITY, f64::max);
    let is_near = |set: &Candidate| !set.effects.is_empty() && set.log_weight > top - NEAR;
    let places: Vec<usize> = (0..sets.len())
        .filter(|&k| is_near(&sets[k]))
        .take(RIVALS)
        .collect();
    let fits: Vec<_> = places.iter().map(|&k| &sets[k].fit).collect();
    if fits.len() < 2 {
        return;
    }
    let Some(left) = left_by(problem, &fits) else {
        return;
    };
    let pieces = kept_pieces(problem);
    let logarithms: Vec<f64> = places
        .iter()
        .zip(left)
        .map(|(&k, left)| logarithm(sets[k].log_weight - top, left, pieces))
        .collect();
    if !logarithms.iter().any(|x| x.is_finite()) {
        return;
    }
    let together: f64 = places.iter().map(|&k| sets[k].probability).sum();
    for (k, share) in places.into_iter().zip(shared_out(&logarithms, None)) {
        ranking.candidates[k].probability = together * share;
    }
    ranking
        .candidates
        .sort_by(|a, b| b.probability.total_cmp(&a.probability));
}

/// Of a set that weighs so much more than another and leaves so many counts RMS of each of so many pieces: less than the
/// encoder's floor tells no more than the floor, and what cannot be simulated predicts nothing.
fn logarithm(nats: f64, left: f64, pieces: f64) -> f64 {
    if left.is_finite() {
        nats / (OF_A_LAW * OF_A_LAW) - pieces * left.max(FLOOR_COUNTS).ln()
    } else {
        f64::NEG_INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half the error in each of ten pieces is 2^10 to 1; nine nats are e to 1.
    #[test]
    fn pieces_count_one_by_one_and_nats_by_their_ninth() {
        let odds = |a: f64, b: f64| {
            let found = shared_out(&[a, b], None);
            assert!((found[0] + found[1] - 1.0).abs() < 1e-12);
            found[0] / found[1]
        };
        let by_pieces = odds(logarithm(0.0, 50.0, 10.0), logarithm(0.0, 100.0, 10.0));
        assert!((by_pieces / 1024.0 - 1.0).abs() < 1e-9, "{by_pieces}");
        let by_nats = odds(logarithm(0.0, 50.0, 10.0), logarithm(-9.0, 50.0, 10.0));
        assert!((by_nats - 1.0_f64.exp()).abs() < 1e-9, "{by_nats}");
    }

    #[test]
    fn what_cannot_be_simulated_does_not_win_nor_what_is_below_the_floor() {
        let [good, failed, below, at] =
            [50.0, f64::NAN, 1e-6, FLOOR_COUNTS].map(|left| logarithm(0.0, left, 10.0));
        assert_eq!(shared_out(&[good, failed], None), [1.0, 0.0]);
        assert_eq!(shared_out(&[below, at], None), [0.5, 0.5]);
    }
}
