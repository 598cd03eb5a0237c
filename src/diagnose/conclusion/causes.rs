//! Every cause and how likely it is, with its numbers.

use std::collections::BTreeMap;

use super::Weights;
use super::intervals::{chosen, ends, interval, widened};
use crate::diagnose::fit::{BASE, Base, Fit};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::report::{Cause, EffectSet, Evidence, Interval};
use crate::diagnose::selection::Forward;
use crate::diagnose::settings::NUMBERS_FROM;
use crate::motor::catalogue::{EffectParameter, Prior, Stage, catalogue, find};
use crate::motor::fit::ParameterId;

/// The base number that voltage and angle tell by itself.
const BACK_EMF: &str = "back_emf_v_s_per_rad";

/// Effects that one recording seldom parts, by the name of the class.
const CLASSES: [(&str, &[&str]); 6] = [
    (
        "direction_offset",
        &[
            "asymmetric_friction",
            "constant_load",
            "asymmetric_voltage_drop",
            "asymmetric_dead_zone",
        ],
    ),
    ("direction_gain", &["asymmetric_viscous", "asymmetric_gain"]),
    (
        "large_command",
        &[
            "supply_sag",
            "current_limit",
            "winding_heating",
            "quadratic_drag",
        ],
    ),
    ("start", &["static_friction", "stribeck", "dead_zone"]),
    (
        "lag",
        &[
            "transport_delay",
            "speed_filter",
            "inductance",
            "command_offset",
        ],
    ),
    ("driving", &["load_friction", "voltage_drop"]),
];

/// The class whose members alone tell sets apart: each set is the same effects and one of the class.
pub(crate) fn class_of(sets: &[Vec<&'static str>]) -> Option<&'static str> {
    if sets.len() < 2 {
        return None;
    }
    let common = common(sets);
    let own: Vec<&str> = (sets.iter().flatten())
        .filter(|id| !common.contains(id))
        .copied()
        .collect();
    let is_one_each = sets.iter().all(|set| set.len() == common.len() + 1);
    let has_all = |members: &[&str]| own.iter().all(|id| members.contains(id));
    let found = CLASSES.iter().find(|(_, members)| has_all(members));
    found.filter(|_| is_one_each).map(|(class, _)| *class)
}

/// Effects that are in all of some sets.
pub(crate) fn common(sets: &[Vec<&'static str>]) -> Vec<&'static str> {
    let Some((first, others)) = sets.split_first() else {
        return Vec::new();
    };
    let is_in_all = |id: &&&'static str| others.iter().all(|set| set.contains(*id));
    first.iter().filter(is_in_all).copied().collect()
}

/// The stages of a set in the order of the chain, joined by `+`.
pub(crate) fn stages(set: &[&str]) -> Option<String> {
    let of_set: Vec<Stage> = (set.iter())
        .filter_map(|id| find(id).map(|(_, kind)| kind.stage))
        .collect();
    let ids: Vec<&str> = (Stage::ALL.iter())
        .filter(|stage| of_set.contains(stage))
        .map(|stage| stage.id())
        .collect();
    (!ids.is_empty()).then(|| ids.join("+"))
}

impl Weights {
    /// Probability of exactly one of some sets and nothing unknown.
    pub(crate) fn of(&self, sets: &[Vec<&'static str>]) -> f64 {
        let named = self.sets.iter().filter(|(set, _)| sets.contains(set));
        named.map(|(_, share)| share).sum()
    }

    /// Probability that all of a set's effects are there: alone, with others or beside something unknown.
    pub(crate) fn inclusion(&self, set: &[&'static str]) -> f64 {
        let has = |(other, _): &&(Vec<&'static str>, f64)| set.iter().all(|id| other.contains(id));
        let named: f64 = self.sets.iter().filter(has).map(|(_, share)| share).sum();
        // What is unknown beside them is asked apart from which they are.
        (named / (1.0 - self.unknown).max(f64::MIN_POSITIVE)).min(1.0)
    }

    /// Probability of each stage, given that a named effect is there; of a set each effect has an equal share.
    pub(crate) fn stages(&self) -> BTreeMap<&'static str, f64> {
        let named: f64 = self.sets.iter().map(|(_, share)| share).sum();
        let mut stages = BTreeMap::new();
        for (set, share) in &self.sets {
            for (_, kind) in set.iter().filter_map(|id| find(id)) {
                *stages.entry(kind.stage.id()).or_insert(0.0) += share / named / set.len() as f64;
            }
        }
        stages
    }
}

/// Every cause, likeliest first.
pub(crate) fn causes(
    pieces: &Pieces,
    base: &Base,
    found: &Forward,
    weights: &Weights,
) -> Vec<Cause> {
    let tied = tied(found);
    let class = class_of(&found.sets);
    let of_class = weights.of(&found.sets);
    let named = weights.sets.iter().map(|(set, share)| {
        let is_tied = found.sets.contains(set) && found.sets.len() > 1;
        let others = tied
            .iter()
            .filter(|other| tied.contains(set) && *other != set);
        let fit = fit_of(found, set);
        let inclusion = weights.inclusion(set);
        let shown = fit.filter(|_| inclusion >= NUMBERS_FROM);
        Cause {
            effect: set.join("+"),
            stage: stages(set),
            probability: *share,
            inclusion,
            parameters: shown.map_or_else(BTreeMap::new, |fit| numbers(pieces, base, fit)),
            indistinguishable_from: others.map(|other| other.join("+")).collect(),
            class: class.filter(|_| is_tied),
            class_probability: class.filter(|_| is_tied).map(|_| of_class),
            evidence: fit.map(|fit| evidence(pieces, &found.refitted, fit)),
        }
    });
    let plain = |effect: &str, probability: f64| Cause {
        effect: effect.to_owned(),
        stage: None,
        probability,
        inclusion: probability,
        parameters: BTreeMap::new(),
        indistinguishable_from: Vec::new(),
        class: None,
        class_probability: None,
        evidence: None,
    };
    let mut causes: Vec<Cause> = named.collect();
    causes.push(plain("none", weights.none));
    causes.push(plain("unknown", weights.unknown));
    causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    causes
}

/// Sets that are not told from the best one, those too that another one is simpler than.
pub(crate) fn tied(found: &Forward) -> Vec<Vec<&'static str>> {
    let kept = found.levels.iter().rfind(|level| level.is_kept);
    let rivals = kept.iter().flat_map(|level| level.tied());
    rivals.map(|(fit, _)| fit.model.ids()).collect()
}

/// Every set with its probability and how far its score is behind the best.
pub(crate) fn sets(found: &Forward, weights: &Weights) -> Vec<EffectSet> {
    let none = (Vec::new(), weights.none);
    let scored: Vec<(&(Vec<&'static str>, f64), f64)> = (weights.sets.iter().chain(Some(&none)))
        .filter_map(|set| Some((set, fit_of(found, &set.0)?.score())))
        .collect();
    let best = scored
        .iter()
        .map(|(_, score)| *score)
        .fold(f64::NEG_INFINITY, f64::max);
    let mut sets: Vec<EffectSet> = (scored.into_iter())
        .map(|((effects, probability), score)| EffectSet {
            effects: effects.clone(),
            probability: *probability,
            behind_nats: best - score,
        })
        .collect();
    sets.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    sets
}

/// The fit of a set.
fn fit_of<'a>(found: &'a Forward, set: &[&'static str]) -> Option<&'a Fit> {
    let of_levels = found.levels.iter().flat_map(|level| &level.fits);
    let mut fits = std::iter::once(&found.refitted)
        .chain(std::iter::once(&found.best))
        .chain(of_levels);
    fits.find(|fit| fit.model.ids() == set)
}

/// What a fit gains over the motor refitted without effects, on pieces not fitted.
fn evidence(pieces: &Pieces, refitted: &Fit, fit: &Fit) -> Evidence {
    let gains: Vec<f64> = (fit.elpd.iter().zip(&refitted.elpd))
        .map(|(a, b)| a - b)
        .collect();
    let mut of_pieces = vec![0.0; pieces.pieces.len()];
    for (stretch, gain) in pieces.stretches.iter().zip(&gains) {
        of_pieces[stretch.piece] += gain;
    }
    let n = gains.len() as f64;
    let sum: f64 = gains.iter().sum();
    let spread: f64 = gains.iter().map(|gain| (gain - sum / n).powi(2)).sum();
    Evidence {
        gain_nats: sum,
        error_nats: (spread * n / (n - 1.0).max(1.0)).sqrt(),
        gaining_pieces: of_pieces.iter().filter(|gain| **gain > 0.0).count(),
        pieces: of_pieces.len(),
    }
}

/// Whether a parameter is a quantity of which a few values are common; two values are a choice.
fn is_one_of_many(parameter: &EffectParameter) -> bool {
    matches!(parameter.prior, Prior::OneOf(values) if values.len() > 2)
}

/// The numbers of a set's effects with their intervals.
fn numbers(pieces: &Pieces, base: &Base, fit: &Fit) -> BTreeMap<String, Interval> {
    let mut out = BTreeMap::new();
    let members = &fit.model.members;
    for member in members {
        let kind = &catalogue()[member.index];
        let name = |key: &str| match members.len() {
            1 => key.to_owned(),
            _ => format!("{}.{key}", kind.id),
        };
        for (k, parameter) in kind.parameters.iter().enumerate() {
            // An effect that sets a base number free is that number.
            let id = match fit.model.frees(member) {
                Some(number) => ParameterId::nominal(BASE[number]),
                None => Some(ParameterId::Effect(member.index, k)),
            };
            let free = fit.model.numbers.iter().position(|n| Some(n.id) == id);
            let mut number = match free {
                Some(k) => interval(pieces, fit, k, parameter.unit),
                // Chosen among a few values, not fitted.
                None => (id.filter(|_| is_one_of_many(parameter)))
                    .and_then(|id| chosen(pieces, fit, id, parameter.unit))
                    .unwrap_or_else(|| {
                        let value = member.values[k];
                        widened(value, (value, value), 0.0, parameter.unit)
                    }),
            };
            number.reference =
                base.then
                    .as_ref()
                    .and_then(|then| match then.effect(member.index) {
                        Some(then) => then.values.get(k).copied(),
                        None if fit.model.frees(member).is_some() => {
                            id.and_then(|id| id.get(&base.motor))
                        }
                        None => {
                            (parameter.neutral(&base.motor.parameters)).map(|neutral| neutral.0)
                        }
                    });
            out.insert(name(parameter.key), number);
        }
    }
    out
}

/// The base model's numbers relative to the motor file's.
pub(crate) fn base(pieces: &Pieces, fit: &Fit) -> BTreeMap<&'static str, Interval> {
    let mut out = BTreeMap::new();
    for (k, number) in fit.model.numbers.iter().enumerate() {
        if matches!(number.id, ParameterId::Nominal(_)) {
            let (lo, hi) = ends(pieces, fit, k);
            // What is fitted is its share of the motor file's.
            let is_scaled = number.id.key() != BACK_EMF;
            let scale = if is_scaled { fit.model.scale } else { 0.0 };
            let interval = widened(fit.x[k], (lo, hi), scale * fit.x[k], "");
            out.insert(number.id.key(), interval);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_is_named_where_its_members_alone_differ() {
        let sets = |sets: &[&[&'static str]]| -> Vec<Vec<&'static str>> {
            sets.iter().map(|set| set.to_vec()).collect()
        };
        let alone = sets(&[&["asymmetric_friction"], &["constant_load"]]);
        assert_eq!(class_of(&alone), Some("direction_offset"));
        let beside = sets(&[&["cogging", "stribeck"], &["cogging", "dead_zone"]]);
        assert_eq!(class_of(&beside), Some("start"));
        assert_eq!(common(&beside), ["cogging"]);
        assert_eq!(class_of(&sets(&[&["stribeck"], &["inductance"]])), None);
        assert_eq!(class_of(&sets(&[&["stribeck"]])), None);
        let larger = sets(&[&["stribeck"], &["stribeck", "dead_zone"]]);
        assert_eq!(class_of(&larger), None);
    }

    #[test]
    fn members_of_classes_are_of_the_catalogue() {
        for id in CLASSES.iter().flat_map(|(_, members)| *members) {
            assert!(find(id).is_some(), "{id}");
        }
    }

    #[test]
    fn inclusion_counts_every_set_that_has_it() {
        let sets = vec![(vec!["backlash"], 0.1), (vec!["backlash", "stribeck"], 0.3)];
        let weights = Weights {
            none: 0.1,
            unknown: 0.5,
            sets,
        };
        assert!((weights.inclusion(&["backlash"]) - 0.8).abs() < 1e-12);
        assert!((weights.inclusion(&["backlash", "stribeck"]) - 0.6).abs() < 1e-12);
        let stages = weights.stages();
        assert!((stages["transmission"] - 0.625).abs() < 1e-12, "{stages:?}");
        assert!((stages["mechanical"] - 0.375).abs() < 1e-12, "{stages:?}");
        assert_eq!(
            super::stages(&["backlash", "stribeck"]).as_deref(),
            Some("mechanical+transmission")
        );
        let capped = weights.at_most(0.2);
        let sum = capped.none + capped.unknown + capped.sets.iter().map(|s| s.1).sum::<f64>();
        assert!(
            (sum - 1.0).abs() < 1e-12 && (capped.unknown - 0.2).abs() < 1e-12,
            "{capped:?}"
        );
    }
}
