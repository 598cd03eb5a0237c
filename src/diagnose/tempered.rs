//! Likelihoods that count for less, since the best set does not predict what it was not fitted to.
//!
//! The likelihood of a wrong law against another grows with every sample, as if its noise were all there is. What a law lacks
//! (Kennedy and O'Hagan 2001) is an error of its own beside that noise. Data kept from the fit tell whether a set may be the
//! motor's law: it leaves the encoder's floor of them and less than a count more, or at most half of what the motor refitted
//! without it leaves. Where the best set does neither, though numbers that are known badly can do that too, the wander is
//! asked: with a law that is the motor's it is ordinary (at most 0.3 % of the largest acceleration), with another it stands for
//! what the law lacks, and a recording that is too short says neither,
//!
//! `P = E_ordinary / (E_ordinary + E_larger)`,  `E` = mean evidence of the best set over those levels of the wander.
//!
//! With `P` the probabilities stay. Otherwise the law errs by [`OF_A_LAW`] times what noise hides, as elsewhere
//! (`other_law.rs`), and with that in the noise the logarithms of the named sets' weights count the less,
//!
//! `p_i' = P p_i + (1 - P) (sum of p) w_i^(1/k) / (sum of w^(1/k))`,  `k = 1 + (9 - 1) (1 - a)`,
//!
//! with `a = 1` where the set leaves half of what refitting leaves and `a = 0` where it leaves as much. What edges lost by
//! chance leave is no error of a law. That it is something unknown stays as likely as it was: that has been judged by the same
//! data (`judged.rs`).

use super::bagging::shared_out;
use super::candidate::ORDINARY_WANDER;
use super::fit::{Fit, wander_penalty};
use super::judged::is_explained;
use super::other_law::OF_A_LAW;
use super::problem::Problem;
use super::rank::Ranking;
use super::verdict::Gap;

/// How many times as much the motor refitted without the set leaves of kept data as one that has found its law.
const CONFIRMED: f64 = 2.0;

/// Shares out the probabilities of named sets anew where the best of them predicts badly. `by_chance` as in `Ranking::judge`,
/// `scale` is the largest acceleration in counts/s^2.
pub(super) fn temper(
    problem: &Problem<'_>,
    ranking: &mut Ranking,
    gap: &Gap,
    by_chance: f64,
    scale: f64,
) {
    let Some(best) = ranking.candidates.first() else {
        return;
    };
    let outdone = ranking.unknown > best.probability;
    if best.effects.is_empty() || outdone || is_explained(gap, by_chance) {
        return;
    }
    let lawful = wanders_little(problem, &best.fit, scale);
    share_out(ranking, gap, lawful);
}

/// The same, where the best set is the motor's law with this probability.
fn share_out(ranking: &mut Ranking, gap: &Gap, lawful: f64) {
    let better = gap.after_parameters / gap.after_effect;
    let confirmed = ((better - 1.0) / (CONFIRMED - 1.0)).clamp(0.0, 1.0);
    let counts_for = 1.0 / (1.0 + (OF_A_LAW * OF_A_LAW - 1.0) * (1.0 - confirmed));
    let together: f64 = ranking.candidates.iter().map(|c| c.probability).sum();
    let logarithms: Vec<f64> = (ranking.candidates.iter())
        .map(|c| counts_for * c.log_weight)
        .collect();
    let shares = shared_out(&logarithms, None);
    for (candidate, share) in ranking.candidates.iter_mut().zip(shares) {
        candidate.probability = lawful * candidate.probability + (1.0 - lawful) * together * share;
    }
}

/// How probable it is that what disturbs a motor with this law is no more than is ordinary.
fn wanders_little(problem: &Problem<'_>, fit: &Fit, scale: f64) -> f64 {
    let evidence = |is_ordinary: bool| {
        let of_kind = |wander: &&f64| (**wander <= ORDINARY_WANDER * scale) == is_ordinary;
        let found: Vec<f64> = (problem.levels.iter().filter(of_kind))
            .filter_map(|&wander| problem.on_wander(fit, wander))
            .map(|fit| fit.log_evidence + wander_penalty(fit.wander, &problem.levels))
            .collect();
        let top = found.iter().copied().reduce(f64::max)?;
        let sum: f64 = found.iter().map(|value| (value - top).exp()).sum();
        Some(top + (sum / found.len() as f64).ln())
    };
    match (evidence(true), evidence(false)) {
        (Some(ordinary), Some(larger)) => 1.0 / (1.0 + (larger - ordinary).exp()),
        (Some(_), None) => 1.0,
        (None, _) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::Candidate;
    use super::super::samples::{
        fit, gap, held_at, index, motor_with, problem, ranking, ready, recording,
    };
    use super::super::scales::largest_acceleration;
    use super::*;

    /// Odds of Stribeck friction against load friction nine nats behind, and the probability of something unknown, where the
    /// first leaves so many counts of a hundred of kept data and is the law with this probability; before, 0.9 is shared out
    /// by `e^9` to 1.
    fn odds(after_effect: f64, lawful: f64) -> (f64, f64) {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let fit = held_at(&problem, &[]);
        let best = 0.9 / (1.0 + (-9.0_f64).exp());
        let set = |id: &str, log_weight: f64| Candidate {
            effects: vec![index(id)],
            fit: fit.clone(),
            log_weight,
            probability: best * log_weight.exp(),
        };
        let sets = vec![set("stribeck", 0.0), set("load_friction", -9.0)];
        let mut ranking = ranking(sets, 0.1);
        share_out(&mut ranking, &gap(after_effect), lawful);
        let [first, second] = [0, 1].map(|k: usize| ranking.candidates[k].probability);
        assert!((first + second + ranking.unknown - 1.0).abs() < 1e-12);
        (first / second, ranking.unknown)
    }

    #[test]
    fn nats_count_a_ninth_where_the_best_set_predicts_badly_and_the_unknown_stays() {
        for left in [50.0, 60.0] {
            let (odds, unknown) = odds(left, 0.0);
            assert!((odds - 1.0_f64.exp()).abs() < 1e-9, "{left}: {odds}");
            assert!((unknown - 0.1).abs() < 1e-12, "{left}: {unknown}");
        }
    }

    #[test]
    fn a_law_and_what_predicts_much_better_than_refitting_count_in_full() {
        let full = 9.0_f64.exp();
        for (left, lawful) in [(50.0, 1.0), (25.0, 0.0), (10.0, 0.0)] {
            let (odds, _) = odds(left, lawful);
            assert!((odds / full - 1.0).abs() < 1e-9, "{left}: {odds}");
        }
    }

    /// Refitting leaves one and a half times as much: a variance of 1 + 8/2 times the noise's.
    #[test]
    fn what_predicts_a_little_better_counts_for_a_little_more() {
        let (odds, _) = odds(50.0 / 1.5, 0.0);
        assert!((odds.ln() - 9.0 / 5.0).abs() < 1e-9, "{odds}");
    }

    /// With even chances the shares are the mean of `e^9` to 1 and `e` to 1.
    #[test]
    fn a_law_that_may_be_the_motors_counts_between() {
        let (odds, _) = odds(50.0, 0.5);
        let second = |nats: f64| 1.0 / (1.0 + nats.exp());
        let behind = 0.5 * (second(9.0) + second(1.0));
        assert!(
            (odds * behind / (1.0 - behind) - 1.0).abs() < 1e-9,
            "{odds}"
        );
    }

    /// Whether the handout's motor is the law of what this one does, in so many samples.
    fn lawful(of: &[(&str, &[f64])], samples: usize) -> f64 {
        let nominal = motor_with(&[]);
        let mut run = recording(&motor_with(of));
        for values in [&mut run.t_s, &mut run.command] {
            values.truncate(samples);
        }
        run.counts.truncate(samples);
        let runs = ready(&run);
        let problem = problem(&nominal, &runs);
        let scale = largest_acceleration(&nominal, &runs);
        wanders_little(&problem, &fit(&problem, &[]), scale)
    }

    #[test]
    fn a_law_wanders_little_another_much_and_a_tenth_of_a_second_tells_neither() {
        let whole = usize::MAX;
        let own = lawful(&[], whole);
        assert!(own > 0.999, "{own}");
        let other = lawful(&[("asymmetric_friction", &[0.3])], whole);
        assert!(other < 0.001, "{other}");
        let open = lawful(&[], 33);
        assert!((0.2..0.8).contains(&open), "{open}");
    }
}
