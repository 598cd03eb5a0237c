//! A torque at some angles that has not come round.
//!
//! Cogging repeats several times a turn. Over a travel of `n` turns an order below `1/n` has not repeated: what was found is
//! a torque that differs with the angle, as that of a load that is lifted does, and its order is hardly told. So where a set
//! has cogging of such an order, the same set is weighed with gravity in its place, from the set's own numbers; and a name that
//! says that it repeats counts [`NOT_SEEN`] against it. Of rough recordings only: where laws are exact, their counts tell an
//! order from less than a turn.

use rayon::prelude::*;

use super::candidate::{Candidate, candidate, dedup};
use super::fit::Problem;
use super::growth::{FINAL_STEPS, Field};
use super::looks::first_fit;
use super::search::Search;
use crate::motor::effects::{catalogue, find};

/// Odds against what was not seen to repeat, in nats: a hundred to one.
const NOT_SEEN: f64 = 4.605;
/// Sets this many nats behind the best at most are looked at, and how many.
const NEAR: f64 = 36.0;
const MOST: usize = 6;

/// Weighs sets with a torque that has not come round against those with gravity in its place.
pub(super) fn weigh(field: &Field<'_>, candidates: &mut Vec<Candidate>) {
    let Some((gravity, _)) = find("gravity_load") else {
        return;
    };
    let best = candidates.first().map_or(0.0, |best| best.log_weight);
    let instead: Vec<Candidate> = candidates
        .iter()
        .take_while(|c| c.log_weight > best - NEAR)
        .filter_map(|c| Some((c, unfinished(field.problem, c)?)))
        .filter(|(c, m)| is_torque(c, *m) && !c.effects.contains(&gravity))
        .take(MOST)
        .collect::<Vec<_>>()
        .into_par_iter()
        .with_max_len(1)
        .filter_map(|(c, m)| exchanged(field, c, m, gravity))
        .collect();
    discount(field.problem, candidates);
    candidates.extend(instead);
    dedup(candidates);
}

/// Counts against sets what they have that was not seen to repeat.
pub(super) fn discount(problem: &Problem<'_>, candidates: &mut [Candidate]) {
    for c in candidates {
        if unfinished(problem, c).is_some() {
            c.log_weight -= NOT_SEEN;
        }
    }
}

/// The member of a set whose order has not come round.
fn unfinished(problem: &Problem<'_>, c: &Candidate) -> Option<usize> {
    (0..c.effects.len()).find(|&m| {
        let order = c.fit.hypothesis.order(m, &c.fit.p);
        order.is_some_and(|order| order * problem.setting.travel_turns < 1.0)
    })
}

fn is_torque(c: &Candidate, m: usize) -> bool {
    catalogue()[c.effects[m]].id == "cogging"
}

/// A set with another effect in the place of its member `m`, from its own numbers.
fn exchanged(field: &Field<'_>, full: &Candidate, m: usize, other: usize) -> Option<Candidate> {
    let problem = field.problem;
    let mut effects = full.effects.clone();
    let removed = effects.remove(m);
    let level = field.search_level(&full.fit);
    let (hypothesis, start) =
        (full.fit.hypothesis).without(removed, problem.nominal, &problem.setting, &full.fit.p);
    let rest = problem.fit_at(&hypothesis, &start, problem.levels[level], 0)?;
    let search = Search::new(problem, &rest, level)?;
    let fit = first_fit(problem, search.starts(other, None), level)?;
    effects.push(other);
    let fit = problem.fit_from(level, &fit.hypothesis, &fit.p, FINAL_STEPS)?;
    Some(candidate(problem, effects, fit, field.scale))
}

#[cfg(test)]
mod tests {
    use super::super::samples::{held_at, index, motor_with, problem, ready, recording};
    use super::*;

    /// What is counted against cogging of this order over about a quarter of a turn.
    fn counted_against(order: f64) -> f64 {
        let nominal = motor_with(&[]);
        let run = ready(&recording(&nominal)).remove(0);
        let quarter = 0.25 * run.counts_per_rev;
        let samples = (run.counts.iter())
            .take_while(|counts| counts.abs() < quarter)
            .count();
        let runs = [run.head(samples).expect("a beginning")];
        let problem = problem(&nominal, &runs);
        let values: &[f64] = &[3e-4, order, 0.5];
        let mut set = [Candidate {
            effects: vec![index("cogging")],
            fit: held_at(&problem, &[("cogging", values)]),
            log_weight: 0.0,
            probability: 0.0,
        }];
        discount(&problem, &mut set);
        -set[0].log_weight
    }

    #[test]
    fn an_order_that_has_not_come_round_counts_a_hundred_to_one() {
        assert!((counted_against(2.0) - 100.0_f64.ln()).abs() < 1e-3);
        assert_eq!(counted_against(6.0), 0.0);
    }
}
