//! Posterior and fitted values of each effect and of each parameter.

use std::collections::BTreeMap;

use crate::diagnose::classes::{class_of, members_of};
use crate::diagnose::command_units::CommandUnits;
use crate::diagnose::fit::Fit;
use crate::diagnose::intervals::{covariance, interval};
use crate::diagnose::model::{BASE, Base};
use crate::diagnose::report::{Alternative, Cause, EffectClass, EffectSet, Interval};
use crate::diagnose::score::posterior;
use crate::diagnose::search::Scored;
use crate::diagnose::segments::Segments;
use crate::diagnose::settings::Settings;
use crate::diagnose::settings::conventions::LISTED_FROM;
use crate::diagnose::verdict::{Identified, Weighed, inclusion};
use crate::motor::catalogue::{EffectParameter, find, kind};
use crate::motor::fit::ParameterId;

/// Sets with their posterior probabilities.
pub(crate) fn weighed(sets: &[Scored], settings: &Settings) -> Vec<Weighed> {
    let scores: Vec<f64> = sets.iter().map(|set| set.score).collect();
    let probabilities = posterior(&scores, settings.learning_rate);
    (sets.iter().zip(probabilities))
        .map(|(set, probability)| Weighed {
            ids: set.fit.ids(),
            probability,
            at_bound: at_bound(&set.fit),
        })
        .collect()
}

/// Effects with a parameter at a bound of its range.
pub(super) fn at_bound(fit: &Fit) -> Vec<&'static str> {
    let parameters = fit.model.parameters.iter().zip(&fit.x);
    parameters
        .filter_map(|(parameter, x)| match parameter.id {
            ParameterId::Effect(index, _) if parameter.is_at_bound(*x) => Some(kind(index).id),
            _ => None,
        })
        .collect()
}

/// Effects that would remove as much in place of one: members of its class that have a probability, and rivals, which
/// probable sets without it have in its place.
pub(super) fn alternatives(id: &str, weighed: &[Weighed]) -> Vec<Alternative> {
    let members = class_of(id).map_or(&[][..], members_of);
    let is_listed = |other: &&'static str| inclusion(weighed, &[other]) >= LISTED_FROM;
    let mut ids: Vec<&'static str> = members.iter().copied().filter(is_listed).collect();
    ids.extend(rivals(id, weighed));
    ids.retain(|other| *other != id);
    ids.sort_unstable();
    ids.dedup();
    let mut found: Vec<Alternative> = (ids.into_iter())
        .map(|effect| Alternative {
            effect,
            probability: inclusion(weighed, &[effect]),
        })
        .collect();
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    found
}

/// Effects that sets without `id` have beyond the most probable set with it, and more often than sets with it.
fn rivals(id: &str, weighed: &[Weighed]) -> Vec<&'static str> {
    let has = |set: &&Weighed| set.ids.contains(&id);
    let best = (weighed.iter().filter(has)).max_by(|a, b| a.probability.total_cmp(&b.probability));
    let Some(best) = best else {
        return Vec::new();
    };
    let mut others: Vec<&'static str> = (weighed.iter().filter(|set| !has(set)))
        .flat_map(|set| set.ids.iter().copied())
        .filter(|other| !best.ids.contains(other))
        .collect();
    others.sort_unstable();
    others.dedup();
    let together = |other: &str, is_with: bool| -> f64 {
        let sets = weighed.iter().filter(|set| has(set) == is_with);
        let sets = sets.filter(|set| set.ids.contains(&other));
        sets.map(|set| set.probability).sum()
    };
    others.retain(|other| {
        let without = together(other, false);
        without >= LISTED_FROM && without > together(other, true)
    });
    others
}

pub(super) fn classes(weighed: &[Weighed], named: &[Identified]) -> Vec<EffectClass> {
    let of = |one: &Identified| {
        let class = one.class?;
        let mut members: Vec<&'static str> = members_of(class)
            .iter()
            .copied()
            .filter(|id| inclusion(weighed, &[id]) >= LISTED_FROM)
            .collect();
        members.sort_by(|a, b| inclusion(weighed, &[b]).total_cmp(&inclusion(weighed, &[a])));
        Some(EffectClass {
            class,
            probability: one.probability,
            members,
        })
    };
    named.iter().filter_map(of).collect()
}

/// All effects with a probability, their parameters from the reported fit where it has them, else from the fit that ended at a bound, else
/// from the most probable set.
pub(super) fn causes(
    segments: &Segments,
    base: &Base,
    sets: &[Scored],
    weighed: &[Weighed],
    reported: Option<&Fit>,
    (named, bounded, rejected): (&[&'static str], &[(&'static str, Fit)], &[&'static str]),
    units: Option<CommandUnits>,
) -> Vec<Cause> {
    let mut ids: Vec<&'static str> = weighed.iter().flat_map(|set| set.ids.clone()).collect();
    ids.sort_unstable();
    ids.dedup();
    let mut found: Vec<Cause> = (ids.into_iter())
        .filter_map(|id| {
            let own = inclusion(weighed, &[id]);
            if own < LISTED_FROM && !named.contains(&id) {
                return None;
            }
            let class = class_of(id);
            let of_class = class.map_or(own, |class| inclusion(weighed, members_of(class)));
            let is_separated = own >= base.settings.confident * of_class;
            let ended = bounded.iter().find(|(at_bound, _)| *at_bound == id);
            let probable = || sets.iter().find(|set| set.fit.ids().contains(&id));
            let from = (reported.filter(|_| named.contains(&id)))
                .or(ended.map(|(_, fit)| fit))
                .or_else(|| probable().map(|set| &set.fit))?;
            Some(Cause {
                effect: id,
                stage: find(id).map_or("", |(_, kind)| kind.stage.id()),
                inclusion: own,
                class: class.filter(|_| !is_separated),
                class_probability: (!is_separated).then_some(of_class),
                at_bound: at_bound(from).contains(&id),
                immaterial: rejected.contains(&id),
                parameters: parameters(segments, base, from, id, units),
            })
        })
        .collect();
    found.sort_by(|a, b| b.inclusion.total_cmp(&a.inclusion));
    found
}

/// Effects about which no recording needs to decide: probable ones with a parameter at a bound, and immaterial ones.
pub(super) fn settled(causes: &[Cause], settings: &Settings) -> Vec<&'static str> {
    let is_settled = |cause: &&Cause| {
        cause.immaterial || cause.at_bound && cause.inclusion >= settings.identified
    };
    (causes.iter().filter(is_settled))
        .map(|cause| cause.effect)
        .collect()
}

/// Parameters of one effect of a fit; of an effect that widens a base parameter, that parameter in SI.
fn parameters(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
    id: &'static str,
    units: Option<CommandUnits>,
) -> BTreeMap<&'static str, Interval> {
    let covariance = covariance(segments, base, fit);
    let Some((index, kind)) = find(id) else {
        return BTreeMap::new();
    };
    let reference = |parameter: ParameterId, own: &EffectParameter| {
        let then = base.reference.as_ref()?;
        let known = then
            .parameters
            .iter()
            .find(|(known, _)| known.id == parameter);
        // Effects that the reference lacks change nothing there.
        let neutral = || own.neutral(&base.motor.parameters).map(|(value, _)| value);
        known.map(|(known, x)| known.value(*x)).or_else(neutral)
    };
    let mut found = BTreeMap::new();
    for (k, parameter) in fit.model.parameters.iter().enumerate() {
        match parameter.id {
            ParameterId::Effect(of, which) if of == index => {
                let mut one = interval(segments, fit, &covariance, k, units);
                one.at_bound = parameter.is_at_bound(fit.x[k]);
                one.reference = reference(parameter.id, &kind.parameters[which]);
                let reference = units.and_then(|units| units.of(&one)?.reference);
                if let Some(own) = &mut one.in_command {
                    own.reference = reference;
                }
                found.insert(kind.parameters[which].key, one);
            }
            ParameterId::Nominal(_)
                if base
                    .frees(id)
                    .is_some_and(|number| BASE[number] == parameter.id.key()) =>
            {
                let mut one = interval(segments, fit, &covariance, k, None);
                one.unit = kind.parameters[0].unit;
                one.reference = base.reference.as_ref().map(|_| parameter.unit);
                one.in_command = units.and_then(|units| units.of(&one));
                found.insert(kind.parameters[0].key, one);
            }
            _ => {}
        }
    }
    // Discrete values have no interval.
    let motor = fit.model.motor(&fit.x);
    for (parameter, value) in motor
        .effects
        .get(id)
        .iter()
        .flat_map(|effect| effect.parameters())
    {
        found.entry(parameter.key).or_insert(Interval {
            value,
            lo95: value,
            hi95: value,
            unit: parameter.unit,
            at_bound: false,
            reference: None,
            in_command: None,
        });
    }
    found
}

pub(super) fn sets(sets: &[Scored], weighed: &[Weighed]) -> Vec<EffectSet> {
    (sets.iter().zip(weighed))
        .map(|(set, weighed)| EffectSet {
            effects: weighed.ids.clone(),
            probability: weighed.probability,
            score: set.score,
            rms_counts: set.fit.rms(),
        })
        .collect()
}

/// Base parameters as shares of the motor file's, with intervals.
pub(super) fn base_parameters(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
) -> BTreeMap<&'static str, Interval> {
    let covariance = covariance(segments, base, fit);
    let parameters = fit.model.parameters.iter().enumerate();
    parameters
        .filter(|(_, parameter)| matches!(parameter.id, ParameterId::Nominal(_)))
        .map(|(k, parameter)| {
            let mut one = interval(segments, fit, &covariance, k, None);
            for end in [&mut one.value, &mut one.lo95, &mut one.hi95] {
                *end /= parameter.unit;
            }
            (parameter.id.key(), one)
        })
        .collect()
}

/// Base parameters outside their tolerances that no effect widens, as shares of the motor file's.
pub(super) fn outside(fit: &Fit, settings: &Settings) -> Vec<(&'static str, f64)> {
    let model = &fit.model;
    let freed: Vec<usize> = model
        .members
        .iter()
        .filter_map(|m| model.frees(m))
        .collect();
    let is_freed = |key: &str| freed.iter().any(|k| BASE[*k] == key);
    let off = model.off(&fit.x);
    (model.parameters.iter().zip(off).enumerate())
        .filter(|(_, (parameter, off))| {
            matches!(parameter.id, ParameterId::Nominal(_))
                && *off > settings.separable
                && !is_freed(parameter.id.key())
        })
        .map(|(k, (parameter, _))| (parameter.id.key(), fit.x[k]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Backlash is of another class, and stands in place of the dead zone; cogging only stands beside it.
    #[test]
    fn alternatives_are_members_of_the_class_and_rivals_in_place_of_the_effect() {
        let set = |ids: &[&'static str], probability: f64| Weighed {
            ids: ids.to_vec(),
            probability,
            at_bound: Vec::new(),
        };
        let weighed = [
            set(&["dead_zone"], 0.5),
            set(&["backlash"], 0.3),
            set(&["dead_zone", "cogging"], 0.1),
            set(&["stribeck"], 0.1),
        ];
        let found = alternatives("dead_zone", &weighed);
        let ids: Vec<&str> = found.iter().map(|one| one.effect).collect();
        assert_eq!(ids, ["backlash", "stribeck"]);
    }
}
