//! A further effect that may stand for another law of the first.
//!
//! No catalogue's law is a motor's own: a Stribeck curve is measured as exponential, Gaussian or rational, flanks of a
//! gap give way. What the best law of one effect leaves then, a second one may explain. With
//! `D^2 = min over dp of |W (x_with - x_without - J dp)|^2 + dp' P dp` (see `ties`), exact laws of known noise are told apart
//! from D = 3 on. Laws that differ by up to [`OF_A_LAW`] times as much are allowed for here: below `D = 9` the set without
//! that effect is taken to be as likely as the set with it, and the result is said to be a tie. Counting and timing have no
//! other laws, nor are they part of one; what builds up over a run, as heat does, is no part of the law of anything else.
//! The flanks of a real gap are springs (Nordin and Gutman 2002), the catalogue's are rigid: beside backlash a compliance may
//! stand for them up to `D = 30`.

use super::candidate::Candidate;
use super::problem::Problem;
use super::rank::Ranking;
use super::rivals::catalogue;
use super::ties::{TIE, separation};
use crate::motor::catalogue::Stage;

/// By how many times the separation that noise hides two laws of the same effect may differ.
pub(super) const OF_A_LAW: f64 = 3.0;
/// The same of a compliance beside backlash.
const OF_FLANKS: f64 = 10.0;
/// Share of the probability that another law gets then.
const SHARE: f64 = 0.5;

/// Effects of the best set that something else may stand for.
#[derive(Debug, Clone)]
pub(super) struct Doubtful {
    /// Their indices in the catalogue.
    pub effects: Vec<usize>,
    /// Those of what may stand for them; none where that is no effect.
    pub instead: Vec<usize>,
    /// How far the best set is from the set that has the others instead.
    pub separation: f64,
}

/// The effects of the best set that may be none, the probability shared out with the set without the likeliest of them.
pub(super) fn weigh(problem: &Problem<'_>, ranking: &mut Ranking) -> Option<Doubtful> {
    let best = ranking.candidates.first()?;
    if best.effects.len() < 2 {
        return None;
    }
    let is_part = |c: &Candidate| {
        c.effects.len() + 1 == best.effects.len()
            && c.effects.iter().all(|e| best.effects.contains(e))
    };
    // They are sorted: the heaviest part first.
    let place = ranking.candidates.iter().position(is_part)?;
    let part = &ranking.candidates[place];
    let effect = (best.effects.iter().copied()).find(|e| !part.effects.contains(e))?;
    if !may_be_of_a_law(effect) || !part.effects.iter().any(|&e| has_laws(e)) {
        return None;
    }
    let separation = separation(problem, &best.fit, &part.fit)?;
    let is = |e: usize, id: &str| catalogue()[e].id == id;
    let are_flanks = is(effect, "compliance") && part.effects.iter().any(|&e| is(e, "backlash"));
    let most = if are_flanks { OF_FLANKS } else { OF_A_LAW };
    if !(TIE..most * TIE).contains(&separation) {
        return None;
    }
    let moved = SHARE * best.probability;
    ranking.candidates[0].probability -= moved;
    ranking.candidates[place].probability += moved;
    Some(Doubtful {
        effects: vec![effect],
        instead: Vec::new(),
        separation,
    })
}

/// Whether an effect has laws that differ from motor to motor.
pub(super) fn has_laws(effect: usize) -> bool {
    let stage = catalogue()[effect].stage;
    !matches!(stage, Stage::Command | Stage::Sensor | Stage::Timing)
}

/// Whether an effect may be what another law of another effect leaves.
fn may_be_of_a_law(effect: usize) -> bool {
    let kind = &catalogue()[effect];
    !matches!(kind.stage, Stage::Sensor | Stage::Timing) && kind.id != "winding_heating"
}

#[cfg(test)]
mod tests {
    use super::super::candidate::Candidate;
    use super::super::samples::{held_at, index, motor_with, problem, ranking, ready, recording};
    use super::*;

    const STRIBECK: (&str, &[f64]) = ("stribeck", &[0.002, 0.5]);

    /// Stribeck friction and one more effect of this size, the pair at 98 % and Stribeck friction alone at 1 %: what is said
    /// of it, the two probabilities then, and how far the two are apart.
    fn weighed(further: &str, size: f64) -> (Option<Doubtful>, [f64; 2], f64) {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[STRIBECK, (further, &[size])])));
        let problem = problem(&nominal, &runs);
        let set = |members: &[(&str, &[f64])], probability| Candidate {
            effects: members.iter().map(|(id, _)| index(id)).collect(),
            fit: held_at(&problem, members),
            log_weight: f64::ln(probability),
            probability,
        };
        let both = set(&[STRIBECK, (further, &[size])], 0.98);
        let alone = set(&[STRIBECK], 0.01);
        let apart = separation(&problem, &both.fit, &alone.fit).expect("a separation");
        let mut ranking = ranking(vec![both, alone], 0.01);
        let doubtful = weigh(&problem, &mut ranking);
        let probabilities = [0, 1].map(|k| ranking.candidates[k].probability);
        (doubtful, probabilities, apart)
    }

    /// The size of an effect at which it is about so many standard deviations away, from one that it is tried at.
    fn size_at(further: &str, tried: f64, separation: f64) -> f64 {
        (0..4).fold(tried, |size, _| {
            let (_, _, apart) = weighed(further, size);
            size * separation / apart
        })
    }

    #[test]
    fn a_small_further_effect_of_friction_may_be_another_law_of_friction() {
        let size = size_at("quadratic_drag", 1e-4, 6.0);
        let (doubtful, [both, alone], apart) = weighed("quadratic_drag", size);
        assert!((4.0..8.0).contains(&apart), "{apart}");
        let doubtful = doubtful.expect("it is in doubt");
        assert_eq!(doubtful.effects, [index("quadratic_drag")]);
        assert!(doubtful.instead.is_empty());
        assert!((both - 0.49).abs() < 1e-9 && (alone - 0.50).abs() < 1e-9);
    }

    #[test]
    fn a_large_one_and_one_of_the_clock_are_findings() {
        let size = size_at("quadratic_drag", 1e-4, 30.0);
        let (doubtful, [both, _], apart) = weighed("quadratic_drag", size);
        assert!(apart > 3.0 * TIE && doubtful.is_none(), "{apart}");
        assert!((both - 0.98).abs() < 1e-9);
        let size = size_at("clock_error", 0.002, 6.0);
        let (doubtful, _, apart) = weighed("clock_error", size);
        assert!(
            (TIE..3.0 * TIE).contains(&apart) && doubtful.is_none(),
            "{apart}"
        );
    }
}
