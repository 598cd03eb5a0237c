//! From scores to probabilities: pseudo Bayesian model averaging with a bootstrap (Yao, Vehtari, Simpson, Gelman, 2018), and for
//! "is there anything" the odds of the gain against the most that chance makes.

use crate::diagnose::fit::Fit;
use crate::diagnose::selection::{Forward, Judged, simpler_of};
use crate::diagnose::settings::{CLOSES, LEAST_GAIN, MOST_WANDER, WITHIN_TOLERANCES};
use crate::diagnose::validation::Unknown;

/// Probabilities of everything that may be there. `none`, `unknown` and those of all sets add to 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Weights {
    /// No effect, and nothing unknown.
    pub none: f64,
    /// Something unknown, alone or beside effects.
    pub unknown: f64,
    /// Exactly these effects and nothing unknown, likeliest first.
    pub sets: Vec<(Vec<&'static str>, f64)>,
}

/// Least probability of nothing unknown.
const LEAST_LEFT: f64 = 1e-6;

/// Sets that are less probable than this are not listed: nothing can be added to a 1 that it could be read off.
const LEAST_SHARE: f64 = 1e-12;

/// Probability of odds whose logarithm these nats are.
fn logistic(nats: f64) -> f64 {
    1.0 / (1.0 + (-nats).exp())
}

/// Probabilities after a search.
pub(crate) fn weights(forward: &Forward, unknown: &Unknown) -> Weights {
    let mut none = 0.0;
    let mut sets: Vec<(Vec<&'static str>, f64)> = Vec::new();
    let mut put =
        |set: Vec<&'static str>, share: f64| match sets.iter_mut().find(|(other, _)| *other == set)
        {
            _ if set.is_empty() => none += share,
            Some((_, sum)) => *sum += share,
            None => sets.push((set, share)),
        };
    // Of the class that the search goes on from: its members, each with its share.
    let mut class: Vec<(Vec<&'static str>, f64)> = vec![(Vec::new(), 1.0)];
    let levels: Vec<&Judged> = (forward.levels.iter())
        .filter(|level| !level.is_set_aside)
        .collect();
    for (k, level) in levels.iter().enumerate() {
        // What predicts is asked anew beside what scatters.
        if !level.is_kept && levels[k + 1..].iter().any(|later| later.is_kept) {
            continue;
        }
        let beyond = level.presence.beyond_chance();
        let there = if level.is_kept {
            logistic(beyond)
        } else {
            // What is not kept has at most even odds, and none where it is not what the gap is.
            logistic(beyond.min(0.0)) * f64::from(level.matters)
        };
        let of_rivals: f64 = level
            .fits
            .iter()
            .zip(&level.standings)
            .map(|s| s.1.weight)
            .sum();
        // Weights add to 1 but for the last digit.
        let goes_on = (there * of_rivals).min(1.0);
        let mass: f64 = class.iter().map(|(_, share)| share).sum();
        let tied: Vec<Vec<&'static str>> = level.tied().map(|(fit, _)| fit.model.ids()).collect();
        // What a level does not keep is beside the class that it was looked for beside.
        let mut next = Vec::new();
        for (set, share) in class.drain(..) {
            let left = share * (1.0 - goes_on);
            if level.is_kept {
                put(set, left);
            } else {
                next.push((set, left));
            }
        }
        for (fit, tie) in level.fits.iter().zip(&level.standings) {
            let share = mass * there * tie.weight;
            let ids = fit.model.ids();
            if level.is_kept && tie.is_tied {
                next.push((simpler_of(&ids, &tied).unwrap_or(ids), share));
            } else {
                put(ids, share);
            }
        }
        class = next;
    }
    for (set, share) in class {
        put(set, share);
    }
    // Which sets are there is said beside something unknown too, however sure that is.
    let left = (1.0 - more(forward, unknown)).max(LEAST_LEFT);
    for (_, share) in &mut sets {
        *share *= left;
    }
    sets.retain(|(_, share)| *share > LEAST_SHARE);
    sets.sort_by(|a, b| b.1.total_cmp(&a.1));
    Weights {
        none: none * left,
        unknown: 1.0 - left,
        sets,
    }
}

/// Probability that no known effect plays a part in what is unknown. What promises more than chance makes and is not borne out has even
/// odds: the levels ask the same question, so the one that promises most beyond chance counts.
pub(crate) fn without_any_known(forward: &Forward) -> f64 {
    let beyond = (forward.levels.iter()).map(|level| level.presence.beyond_chance());
    1.0 - logistic(beyond.fold(f64::NEG_INFINITY, f64::max).min(0.0))
}

/// Probability of something more than the best set: a flexible torque that gains, a piece that is predicted worse than chance makes
/// any, or a motor whose own numbers are beyond their tolerances.
fn more(forward: &Forward, unknown: &Unknown) -> f64 {
    let bent = forward.best.model.bent(&forward.best.x);
    let bends = 0.5 * (bent * bent - WITHIN_TOLERANCES * WITHIN_TOLERANCES);
    // A law that is a little other leaves a little: less above rounding than rounding does, and than a tenth of what it explains.
    let above = |fit: &Fit| fit.mean_square() - forward.still;
    let least = match forward.best.model.members.is_empty() {
        true => forward.still,
        false => (CLOSES * above(&forward.refitted)).min(forward.still),
    };
    let gains = if above(&forward.best) < least {
        f64::NEG_INFINITY
    } else {
        (unknown.gain - unknown.chance().max(LEAST_GAIN)).max(unknown.worst_beyond())
    };
    let shakes = LEAST_GAIN * (forward.best.noise.strength / MOST_WANDER - 1.0);
    logistic(gains.max(bends).max(shakes))
}

impl Weights {
    /// The same with this share of what is unknown; the rest goes to the others in proportion.
    pub fn with_unknown(mut self, share: f64) -> Self {
        let named: f64 = self.sets.iter().map(|(_, share)| share).sum();
        let others = (self.none + named).max(f64::MIN_POSITIVE);
        let times = 1.0 + self.unknown * (1.0 - share) / others;
        self.unknown *= share;
        self.none *= times;
        for (_, share) in &mut self.sets {
            *share *= times;
        }
        self
    }

    /// The same where what is named predicts no worse than without it with this probability: where it does, something unknown is there in
    /// its place.
    pub fn borne_out(mut self, share: f64) -> Self {
        let named: f64 = self.sets.iter().map(|(_, share)| share).sum();
        for (_, own) in &mut self.sets {
            *own *= share;
        }
        self.unknown += named * (1.0 - share);
        self
    }

    /// Gives what a set has to another one, or to none where that is empty.
    pub fn rename(&mut self, set: &[&'static str], other: Vec<&'static str>) {
        let Some(k) = self.sets.iter().position(|(own, _)| own == set) else {
            return;
        };
        let (_, share) = self.sets.remove(k);
        match self.sets.iter_mut().find(|(own, _)| *own == other) {
            _ if other.is_empty() => self.none += share,
            Some((_, sum)) => *sum += share,
            None => self.sets.push((other, share)),
        }
        self.sets.sort_by(|a, b| b.1.total_cmp(&a.1));
    }

    /// The same with nothing more probable than `most`: what is taken from something unknown goes to the others in proportion, what is
    /// taken from them goes to something unknown.
    pub fn at_most(mut self, most: f64) -> Self {
        let named: f64 = self.sets.iter().map(|(_, share)| share).sum();
        if self.unknown > most {
            let others = self.none + named;
            if others <= 0.0 {
                self.none = 1.0 - most;
                self.unknown = most;
                return self;
            }
            let times = (1.0 - most) / others;
            self.none *= times;
            for (_, share) in &mut self.sets {
                *share *= times;
            }
            self.unknown = most;
        } else if self.none > most {
            self.unknown += self.none - most;
            self.none = most;
        } else if named > most {
            for (_, share) in &mut self.sets {
                *share *= most / named;
            }
            self.unknown += named - most;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_moved_between_causes_is_not_lost() {
        let sets = vec![(vec!["backlash"], 0.3), (vec!["stribeck"], 0.1)];
        let mut weights = Weights {
            none: 0.1,
            unknown: 0.5,
            sets,
        };
        let sum = |weights: &Weights| {
            let named: f64 = weights.sets.iter().map(|(_, share)| share).sum();
            weights.none + weights.unknown + named
        };
        weights.rename(&["stribeck"], vec!["backlash"]);
        assert_eq!(weights.sets.len(), 1);
        assert!((weights.sets[0].1 - 0.4).abs() < 1e-12, "{weights:?}");
        let known = weights.clone().with_unknown(0.2);
        assert!((known.unknown - 0.1).abs() < 1e-12, "{known:?}");
        assert!(
            (known.sets[0].1 / known.none - 4.0).abs() < 1e-9,
            "{known:?}"
        );
        assert!((sum(&known) - 1.0).abs() < 1e-12, "{known:?}");
        let half = weights.clone().borne_out(0.5);
        assert!((half.unknown - 0.7).abs() < 1e-12, "{half:?}");
        assert!((sum(&half) - 1.0).abs() < 1e-12, "{half:?}");
        let capped = weights.clone().borne_out(0.0).at_most(0.8);
        assert!((capped.none - 0.2).abs() < 1e-12, "{capped:?}");
        assert!((sum(&capped) - 1.0).abs() < 1e-12, "{capped:?}");
        let nothing_else = Weights {
            none: 0.0,
            unknown: 1.0,
            sets: Vec::new(),
        };
        let capped = nothing_else.at_most(0.8);
        assert!((sum(&capped) - 1.0).abs() < 1e-12, "{capped:?}");
        weights.rename(&["backlash"], Vec::new());
        assert!((weights.none - 0.5).abs() < 1e-12, "{weights:?}");
        assert!((sum(&weights) - 1.0).abs() < 1e-12, "{weights:?}");
    }
}
