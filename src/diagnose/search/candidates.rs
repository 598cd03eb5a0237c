//! Columns of all effects: how each, from each of its starts, changes the prediction.

use crate::motor::catalogue::ids;
use rayon::prelude::*;

use super::periodic;
use crate::diagnose::classes::is_by_direction;
use crate::diagnose::fit::Fit;
use crate::diagnose::model::{BASE, Base, Member, freed_width, predict, range_of};
use crate::diagnose::segments::Segments;
use crate::diagnose::settings::conventions::EDGES_COUNTED;
use crate::diagnose::settings::solver::{CLOSE_STARTS, FURTHER_STARTS, SIGNED_STARTS, STARTS};
use crate::motor::ActiveEffect;
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior, Stage, catalogue};

/// How an effect changes the prediction.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// By this column in counts, times a coefficient from 0 to about 2.
    One(Vec<f64>),
    /// By any sum of these two, sine and cosine, with the effect's amplitude for a coefficient of 1.
    Pair([Vec<f64>; 2], f64),
    /// By the derivative of this base parameter, whose prior it widens to this precision.
    Widens(usize, f64),
}

/// An effect with values to start from.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub member: Member,
    pub shape: Shape,
}

/// Values that a parameter of an effect starts from.
pub(crate) fn starts(parameter: &EffectParameter, kind: &EffectKind, base: &Base) -> Vec<f64> {
    if let Prior::OneOf(values) = parameter.prior
        && parameter.key != "max_rate_hz"
    {
        let mut values = values.to_vec();
        if parameter.key == "counts_per_rev" {
            let own = base.motor.parameters.counts_per_rev;
            values.extend(EDGES_COUNTED.map(|times| times * own));
        }
        return values;
    }
    if parameter.key == "encoder_side" {
        return vec![0.0, 1.0];
    }
    if let (Some((seen, _)), ids::CLOCK_ERROR) = (base.clock, kind.id) {
        return vec![seen];
    }
    let (lo, hi) = range_of(parameter, base);
    if lo < 0.0 {
        return SIGNED_STARTS.iter().map(|share| share * hi).collect();
    }
    let first = &kind.parameters[0];
    let is_like_first = parameter.unit == first.unit && parameter.scale == first.scale;
    if let (false, Some((neutral, _))) = (is_like_first, parameter.neutral(&base.motor.parameters))
    {
        return vec![neutral];
    }
    let shares: &[f64] = if !is_like_first {
        &FURTHER_STARTS
    } else if !parameter.smooth && kind.parameters.len() == 1 {
        &CLOSE_STARTS
    } else {
        &STARTS
    };
    let at = |share: &f64| match parameter.prior {
        Prior::LogUniform => (lo.ln() + share * (hi / lo).ln()).exp(),
        _ => lo + share * (hi - lo),
    };
    let mut starts: Vec<f64> = shares.iter().map(at).collect();
    if parameter.key == "delay_s" && base.dead_time_s > lo {
        starts.push(base.dead_time_s);
    }
    starts
}

/// Values to start from, of every parameter of an effect.
pub(super) fn grid(kind: &EffectKind, base: &Base) -> Vec<Vec<f64>> {
    let mut grid = vec![Vec::new()];
    for parameter in kind.parameters {
        let values = starts(parameter, kind, base);
        grid = (grid.into_iter())
            .flat_map(|begun: Vec<f64>| {
                values.iter().map(move |value| {
                    let mut all = begun.clone();
                    all.push(*value);
                    all
                })
            })
            .collect();
    }
    if kind.id == ids::MISSED_COUNTS {
        let lost: Vec<f64> = starts(&kind.parameters[0], kind, base);
        let (lo, hi) = range_of(&kind.parameters[1], base);
        grid = lost.into_iter().map(|p| vec![p, 0.0]).collect();
        let rates = CLOSE_STARTS
            .iter()
            .map(|share| vec![0.0, lo + share * (hi - lo)]);
        grid.extend(rates);
    }
    grid
}

/// Whether an effect may be added to a fit: it is in no model twice, transmission effects exclude each other, and what the time stamps
/// cannot show is left out.
fn is_admissible(segments: &Segments, base: &Base, fit: &Fit, kind: &EffectKind) -> bool {
    let is_member = |id: &str| fit.model.members.iter().any(|member| member.id() == id);
    let is_present = |id: &str| {
        is_member(id) || (base.reference.is_none() && base.motor.effects.get(id).is_some())
    };
    let couples = [ids::BACKLASH, ids::COMPLIANCE];
    let is_timed = kind.stage == Stage::Timing || kind.id == ids::TRANSPORT_DELAY;
    let is_integrated = segments.runs.iter().all(|run| run.is_integrated);
    let is_excluded = is_present(kind.id)
        // Differences by direction are not identifiable from one.
        || (is_by_direction(kind.id) && !turns_both_ways(segments, base.settings.unexplained_share))
        || (couples.contains(&kind.id) && couples.iter().any(|id| is_present(id)))
        || (base.is_host_timed && is_timed)
        || (is_integrated && kind.random);
    !is_excluded
}

/// Whether the shaft turns in both directions, by more than an immaterial share of the travel in one.
fn turns_both_ways(segments: &Segments, immaterial: f64) -> bool {
    let (mut forward, mut back) = (0.0, 0.0);
    for pair in segments.runs.iter().flat_map(|run| run.counts.windows(2)) {
        let step: f64 = pair[1] - pair[0];
        forward += step.max(0.0);
        back += (-step).max(0.0);
    }
    forward.min(back) > immaterial * forward.max(back)
}

/// Effects that may be added to a fit, but those that free a base parameter and those that repeat with the angle, from each of their starts.
pub(super) fn members(segments: &Segments, base: &Base, fit: &Fit) -> Vec<Member> {
    let kinds = (catalogue().iter().enumerate())
        .filter(|(_, kind)| is_admissible(segments, base, fit, kind))
        .filter(|(_, kind)| base.frees(kind.id).is_none() && !repeats(kind));
    kinds
        .flat_map(|(index, kind)| {
            let grid = grid(kind, base).into_iter();
            grid.map(move |values| Member { index, values })
        })
        .collect()
}

/// Whether an effect repeats with the angle.
fn repeats(kind: &EffectKind) -> bool {
    (kind.parameters.iter()).any(|p| matches!(p.prior, Prior::Phase))
}

/// Every effect that may be added to a fit, from each of its starts.
pub(crate) fn candidates(segments: &Segments, base: &Base, fit: &Fit) -> Vec<Candidate> {
    let motor = fit.model.motor(&fit.x);
    let mut out = Vec::new();
    for (index, kind) in catalogue().iter().enumerate() {
        if !is_admissible(segments, base, fit, kind) {
            continue;
        }
        if let Some(number) = base.frees(kind.id) {
            let place = (fit.model.parameters.iter()).position(|p| p.id.key() == BASE[number]);
            let values = vec![0.0];
            out.extend(place.map(|place| Candidate {
                member: Member { index, values },
                shape: Shape::Widens(place, freed_width(base, index, number).powi(-2)),
            }));
        } else if repeats(kind) {
            let before = base.reference.as_ref().and_then(|then| then.effect(index));
            if before.is_none() {
                out.extend(periodic::candidates(segments, base, fit, index));
            }
        }
    }
    let Some(without) = predict(segments, &motor) else {
        return out;
    };
    let simulated: Vec<Candidate> = (members(segments, base, fit).into_par_iter())
        .filter_map(|member| {
            let mut with = motor.clone();
            let effect = ActiveEffect::new(member.id(), &member.values).ok()?;
            with.effects.set(effect);
            let mut column = predict(segments, &with)?;
            column.iter_mut().zip(&without).for_each(|(a, b)| *a -= b);
            Some(Candidate {
                member,
                shape: Shape::One(column),
            })
        })
        .collect();
    out.extend(simulated);
    out
}
