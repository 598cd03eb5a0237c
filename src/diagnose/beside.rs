//! Which effects are there beside something unknown.
//!
//! The unknown's model is a named set and an acceleration that nobody has written an equation for (`unknown.rs`): it is no
//! rival of the set's effects. Given that it is there, an effect `e` is there too with
//!
//! `P(e | unknown) = (sum over S with e of v(S)) / (sum over all S of v(S))`,  `ln v(S) = (ln w(S) + ln B(S)) / 9`
//!
//! where `ln B(S)` is what a flexible acceleration of all kinds at once gains beside the set `S`. Sets with and without the
//! effect are both weighed with it, since it may imitate the effect: a smooth function of speed a Stribeck curve. Where
//! something is unknown, no law is quite the motor's: what it lacks is an error of its own, three times what noise hides, as
//! in `discrepancy.rs`, so that logarithms count a ninth. Of a rough recording the shares are averaged over blocks drawn
//! again, as in `bagging.rs`.
//!
//! An acceleration cannot stand for what is unknown in counting or timing, so that lost edges or a slow clock would win
//! whatever it is: of those nothing is said. Neither of what only says that a number of the motor file is another (a supply,
//! an inertia): that number bends to whatever is missing. Nor is it enough that an effect bends more like the unknown than
//! the flexible acceleration does. It must be needed: without it, the best set refitted must leave [`NEEDED`] times as much
//! of the data kept from the fit. And of a set that leaves so many times as much there as refitting alone nothing is said.
//!
//! An effect that is needed, though sets without it and a flexible acceleration are as likely, is a stated tie with the
//! unknown where that acceleration does the same: where what is left of the set's prediction, once it has given way beside
//! the set without the effect, is less than another law of the motor's own could make it (`discrepancy.rs`).

use rayon::prelude::*;

use super::bagging::{Blocks, of_one_more, over_draws};
use super::candidate::{Candidate, excess_wander};
use super::effort::ALL;
use super::fit::Fit;
use super::levels::climb;
use super::other_law::OF_A_LAW;
use super::problem::Problem;
use super::rank::Ranking;
use super::rivals::catalogue;
use super::rungs::{left_by, left_of_runs_by};
use super::shapes::Group;
use super::ties::TIE;
use super::unknown::{flexed, separation_beside};
use super::verdict::Gap;
use crate::motor::catalogue::Stage;

/// How many sets are weighed: the best, its parts, none, and those that come next; fewer of these where the limit is reached.
const SETS: usize = 8;
const SETS_LATE: usize = 4;
/// From this probability of the unknown on it is worth the time.
const WORTH: f64 = 0.02;
/// How many times as much of kept data the best set must leave without an effect.
const NEEDED: f64 = 2.0;
/// An effect that is less probable is not said to be there.
const LIKELY: f64 = 0.5;
/// Effects that say that a number of the motor file is another.
const RETUNED: [&str; 4] = [
    "supply_error",
    "coulomb_friction",
    "viscous_friction",
    "inertia",
];

/// A set with a flexible acceleration beside it.
struct Weighed {
    /// Indices of its effects in the catalogue.
    effects: Vec<usize>,
    /// Logarithm of its weight.
    log_weight: f64,
    /// The part of that which is the likelihood of each block.
    parts: Vec<f64>,
}

/// Gives the effects of the best set their probability beside something unknown; none where data kept from the fit, or runs
/// kept from everything, refute the set.
pub(super) fn weigh(
    problem: &Problem<'_>,
    ranking: &mut Ranking,
    gap: &Gap,
    scale: f64,
    is_rough: bool,
) {
    let Some(best) = ranking.candidates.first() else {
        return;
    };
    if is_refuted(gap) {
        return;
    }
    if ranking.unknown < WORTH {
        return;
    }
    // Quickly told, and mostly none is: those without which the set leaves much more.
    let told: Vec<(usize, &Candidate)> = (best.effects.iter().copied())
        .filter(|&index| can_be_told(index))
        .filter_map(|index| Some((index, without(&ranking.candidates, index)?)))
        .collect();
    let needed = needed(problem, best, told, is_rough);
    if needed.is_empty() {
        return;
    }
    let blocks = Blocks::of(problem.runs);
    let groups = ranking.flexible.all_groups();
    let most = if problem.effort.is_left(ALL) {
        SETS
    } else {
        SETS_LATE
    };
    let sets: Vec<Weighed> = looked_at(&ranking.candidates, most)
        .into_par_iter()
        .filter_map(|set| weighed(problem, set, &groups, scale, &blocks))
        .collect();
    let parts: Vec<&[f64]> = sets.iter().map(|set| set.parts.as_slice()).collect();
    let weights: Vec<f64> = sets.iter().map(|set| set.log_weight).collect();
    let shares = if is_rough {
        over_draws(&weights, &parts, shares)
    } else {
        shares(&weights)
    };
    let share_of = |index: usize| {
        let with = sets.iter().zip(&shares);
        let with = with.filter(|(set, _)| set.effects.contains(&index));
        with.map(|(_, share)| share).sum::<f64>()
    };
    let (mut beside, mut imitated) = (Vec::new(), Vec::new());
    for (index, rest) in needed {
        let share = share_of(index);
        let separation = (share < LIKELY)
            .then(|| separation_beside(problem, &best.fit, &rest.fit, &groups, scale))
            .flatten()
            .filter(|d| *d < OF_A_LAW * TIE);
        if share < LIKELY && separation.is_none() {
            continue;
        }
        match separation {
            Some(d) => imitated.push((index, d)),
            None => beside.push((index, of_one_more(problem.runs, share))),
        }
    }
    (ranking.beside, ranking.imitated) = (beside, imitated);
}

/// Whether the set leaves so much more of kept data than the motor refitted alone that it is no part of what is there.
fn is_refuted(gap: &Gap) -> bool {
    gap.after_effect > NEEDED * gap.after_parameters
}

/// The best set without this effect, refitted.
fn without(candidates: &[Candidate], index: usize) -> Option<&Candidate> {
    let best = candidates.first()?;
    let is_rest = |c: &&Candidate| {
        c.effects.len() + 1 == best.effects.len()
            && (best.effects.iter()).all(|e| *e == index || c.effects.contains(e))
    };
    candidates.iter().find(is_rest)
}

/// The effects without which the best set leaves much more of kept data than with them.
fn needed<'a>(
    problem: &Problem<'_>,
    best: &Candidate,
    told: Vec<(usize, &'a Candidate)>,
    is_rough: bool,
) -> Vec<(usize, &'a Candidate)> {
    if told.is_empty() {
        return told;
    }
    let rests = told.iter().map(|(_, rest)| &rest.fit);
    let fits: Vec<&Fit> = std::iter::once(&best.fit).chain(rests).collect();
    let of_pieces = is_rough.then(|| left_by(problem, &fits)).flatten();
    let left = of_pieces.unwrap_or_else(|| left_of_runs_by(problem, &fits));
    let without = told.into_iter().zip(&left[1..]);
    without
        .filter(|(_, without)| **without > NEEDED * left[0])
        .map(|(told, _)| told)
        .collect()
}

/// The best set, its parts, none, and the next.
fn looked_at(candidates: &[Candidate], most: usize) -> Vec<&Candidate> {
    let Some(best) = candidates.first() else {
        return Vec::new();
    };
    let is_part = |c: &&Candidate| c.effects.iter().all(|e| best.effects.contains(e));
    let parts = candidates.iter().filter(is_part);
    let others = candidates.iter().filter(|c| !is_part(c));
    parts.chain(others).take(most).collect()
}

fn weighed(
    problem: &Problem<'_>,
    set: &Candidate,
    groups: &[Group],
    scale: f64,
    blocks: &Blocks,
) -> Option<Weighed> {
    let own = &set.fit;
    // A named set pays for a wander that is not ordinary, beside something unknown it does not.
    let weight = set.log_weight + excess_wander(problem, own.wander, scale);
    let at = |level: usize| {
        let fit = problem.on_wander(own, problem.levels[level])?;
        let with = flexed(problem, &fit, groups, scale)?;
        let gain = fit.log_evidence - own.log_evidence + with.log_gain;
        Some((gain, (fit, with)))
    };
    // From its own level to stronger ones as long as that is better, and to weaker ones.
    let first = problem.level_of(own.wander);
    let mut best = at(first)?;
    let (stronger, weaker) = ((0..first).rev(), first + 1..problem.levels.len());
    climb(&mut best, stronger, at);
    climb(&mut best, weaker, at);
    let (gain, (fit, with)) = best;
    Some(Weighed {
        effects: set.effects.clone(),
        log_weight: weight + gain,
        parts: blocks.log_likelihoods(problem, &fit, &with.residual),
    })
}

/// Each weight's share of all, with laws that lack something.
fn shares(log_weights: &[f64]) -> Vec<f64> {
    let top = log_weights
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = (log_weights.iter())
        .map(|w| ((w - top) / (OF_A_LAW * OF_A_LAW)).exp())
        .collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / total).collect()
}

/// Whether a flexible acceleration is a rival of it at all, and the motor file's own numbers are none.
fn can_be_told(index: usize) -> bool {
    let kind = &catalogue()[index];
    !matches!(kind.stage, Stage::Sensor | Stage::Timing) && !RETUNED.contains(&kind.id)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine nats count as one: 1 of 1 + e.
    #[test]
    fn weights_count_by_their_ninth_root() {
        let found = shares(&[-100.0, -109.0]);
        let expected = 1.0 / (1.0 + (-1.0_f64).exp());
        assert!((found[0] - expected).abs() < 1e-12, "{found:?}");
        assert!((found[0] + found[1] - 1.0).abs() < 1e-12, "{found:?}");
    }
}
