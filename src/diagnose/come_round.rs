//! A torque at some angles that has not come round.
//!
//! Cogging repeats several times a turn. Over a travel of `n` turns an order below `1/n` has not repeated: what was found is
//! a torque that differs with the angle, as that of a load that is lifted does, and its order is hardly told. So where a set
//! has cogging of such an order, the same set is weighed with gravity in its place, from the set's own numbers; and a name that
//! says that it repeats counts [`NOT_SEEN`] against it. Of rough recordings only: where laws are exact, their counts tell an
//! order from less than a turn.

use rayon::prelude::*;

use super::candidate::{Candidate, dedup};
use super::growth::Field;
use super::problem::Problem;
use super::rivals::{catalogue, find};

/// Odds against what was not seen to repeat.
const NOT_SEEN: f64 = 100.0;
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
        .filter_map(|(c, m)| field.with_instead(c, m, gravity, None))
        .collect();
    discount(field.problem, candidates);
    candidates.extend(instead);
    dedup(candidates);
}

/// Counts against sets what they have that was not seen to repeat.
pub(super) fn discount(problem: &Problem<'_>, candidates: &mut [Candidate]) {
    for c in candidates {
        if unfinished(problem, c).is_some() {
            c.log_weight -= NOT_SEEN.ln();
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

#[cfg(test)]
mod tests {
    use super::super::data::RunData;
    use super::super::samples::{held_at, index, motor_with, problem, ready, recording};
    use super::*;
    use crate::compare::{FLOOR_COUNTS, rms};
    use crate::motor::Motor;

    /// A quarter of a turn of this motor.
    fn a_quarter(motor: &Motor) -> Vec<RunData> {
        let run = ready(&recording(motor)).remove(0);
        let quarter = 0.25 * run.counts_per_rev;
        let samples = (run.counts.iter())
            .take_while(|counts| counts.abs() < quarter)
            .count();
        vec![run.head(samples).expect("a beginning")]
    }

    fn with_cogging(problem: &Problem<'_>, order: f64) -> Candidate {
        let values: &[f64] = &[3e-4, order, 0.5];
        Candidate {
            effects: vec![index("cogging")],
            fit: held_at(problem, &[("cogging", values)]),
            log_weight: 0.0,
            probability: 0.0,
        }
    }

    #[test]
    fn an_order_that_has_not_come_round_counts_a_hundred_to_one() {
        let nominal = motor_with(&[]);
        let runs = a_quarter(&nominal);
        let problem = problem(&nominal, &runs);
        let mut sets = [2.0, 6.0].map(|order| with_cogging(&problem, order));
        discount(&problem, &mut sets);
        assert!((sets[0].log_weight + 100.0_f64.ln()).abs() < 1e-12);
        assert_eq!(sets[1].log_weight, 0.0);
    }

    #[test]
    fn what_has_come_round_has_no_gravity_put_in_its_place_and_what_has_not_has() {
        let nominal = motor_with(&[]);
        let runs = a_quarter(&motor_with(&[("gravity_load", &[2e-3, 1.0])]));
        let problem = problem(&nominal, &runs);
        let field = Field::new(&problem, &[]);
        let weighed = |order: f64| {
            let mut sets = vec![with_cogging(&problem, order)];
            weigh(&field, &mut sets);
            sets
        };
        let gravity = [index("gravity_load")];
        assert!(weighed(6.0).iter().all(|c| c.effects != gravity));
        let sets = weighed(2.0);
        let found = sets.iter().find(|c| c.effects == gravity);
        let found = found.expect("gravity in its place");
        // The encoder's own floor, about where inside a count the shaft started.
        let left = problem.runs[0].counts.iter();
        let left: Vec<f64> = (left.zip(&found.fit.predictions[0]))
            .map(|(n, x)| n - x)
            .collect();
        let start = left.iter().sum::<f64>() / left.len() as f64;
        let left = rms(left.iter().map(|x| x - start));
        assert!(left < 1.1 * FLOOR_COUNTS, "{left} counts");
    }
}
