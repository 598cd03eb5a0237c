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
use super::fit::Problem;
use super::rank::Ranking;
use super::ties::{TIE, separation};
use crate::motor::effects::{Stage, catalogue};

/// By how many times the separation that noise hides two laws of the same effect may differ.
pub(super) const OF_A_LAW: f64 = 3.0;
/// The same of a compliance beside backlash.
const OF_FLANKS: f64 = 10.0;
/// Share of the probability that another law gets then.
const SHARE: f64 = 0.5;

/// A further effect that another law of the others may stand for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Doubtful {
    /// Its index in the catalogue.
    pub effect: usize,
    /// How far the set without it is from the set with it.
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
    Some(Doubtful { effect, separation })
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
