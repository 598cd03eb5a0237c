//! Starts of every effect, and how each changes the prediction: simulated with the effect less without.

use rayon::prelude::*;

use super::periodic;
use crate::diagnose::fit::range_of;
use crate::diagnose::fit::{Base, Fit, Member, jitter_s, loss, response};
use crate::diagnose::noise::{Noise, Surroundings, likeliest};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{
    EDGES_COUNTED, FURTHER_STARTS, SIGNED_STARTS, STARTS, STEPPED_STARTS,
};
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior, Stage, catalogue};
use crate::motor::{ActiveEffect, Motor};

/// How a candidate changes what is predicted.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// By this column in counts, times something positive.
    One(Vec<f64>),
    /// By any sum of these two: sine and cosine. With what turns the coefficients into amplitude and phase.
    Pair([Vec<f64>; 2], periodic::Wave),
    /// By this column in counts, and what scatters about it is another noise: beside it a load seems to wander so.
    Scatter(Vec<f64>, Surroundings, Noise),
    /// Not at all: a base number becomes free.
    Frees,
}

/// An effect with values to start from.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub member: Member,
    pub shape: Shape,
}

fn starts(parameter: &EffectParameter, kind: &EffectKind, base: &Base) -> Vec<f64> {
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
    if let (Some((seen, _)), "clock_error") = (base.clock, kind.id) {
        return vec![seen];
    }
    let (lo, hi) = range_of(parameter, base);
    if lo < 0.0 {
        return SIGNED_STARTS.iter().map(|share| share * hi).collect();
    }
    let first = &kind.parameters[0];
    // What is measured as the first number is (volts in both directions) is looked at as closely.
    let is_like_first = parameter.unit == first.unit && parameter.scale == first.scale;
    // A nuisance starts where it changes nothing.
    if let (false, Some((neutral, _))) = (is_like_first, parameter.neutral(&base.motor.parameters))
    {
        return vec![neutral];
    }
    let shares: &[f64] = if !is_like_first {
        &FURTHER_STARTS
    } else if !parameter.smooth && kind.parameters.len() == 1 {
        &STEPPED_STARTS
    } else {
        &STARTS
    };
    let at = |share: &f64| match parameter.prior {
        Prior::LogUniform => (lo.ln() + share * (hi / lo).ln()).exp(),
        _ => lo + share * (hi - lo),
    };
    shares.iter().map(at).collect()
}

/// Values to start from, of every number of an effect.
fn grid(kind: &EffectKind, base: &Base) -> Vec<Vec<f64>> {
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
    if kind.id == "missed_counts" {
        let lost: Vec<f64> = starts(&kind.parameters[0], kind, base);
        let (lo, hi) = range_of(&kind.parameters[1], base);
        grid = lost.into_iter().map(|p| vec![p, 0.0]).collect();
        grid.extend(
            STEPPED_STARTS
                .iter()
                .map(|share| vec![0.0, lo + share * (hi - lo)]),
        );
    }
    grid
}

/// Everything that might be added to a model.
pub(crate) fn candidates(pieces: &Pieces, base: &Base, fit: &Fit) -> Vec<Candidate> {
    let motor = fit.model.motor(&fit.x);
    // What the motor file has already is part of its model; what reference runs had may be another now.
    let has = |id: &str| {
        (base.then.is_none() && base.motor.effects.get(id).is_some())
            || fit.model.members.iter().any(|member| member.id() == id)
    };
    // Where the shaft goes round between two samples, nothing tells what repeats with the angle; and times that are the host's
    // arrivals tell of the line, not of the board. Edges lost by chance are errors of logged speeds like any other.
    let goes_round = pieces.runs.iter().any(|run| run.goes_round);
    let is_integrated = pieces.runs.iter().all(|run| run.is_integrated);
    let is_hidden = |kind: &EffectKind| {
        let is_timed = kind.stage == Stage::Timing || kind.id == "transport_delay";
        let repeats = || (kind.parameters.iter()).any(|p| matches!(p.prior, Prior::Phase));
        let is_scatter = kind.id == "missed_counts" && is_integrated;
        (base.is_host_timed && is_timed) || (goes_round && repeats()) || is_scatter
    };
    let mut members = Vec::new();
    let mut out = Vec::new();
    for (index, kind) in catalogue().iter().enumerate() {
        if has(kind.id) || is_hidden(kind) {
            continue;
        }
        if let Some(number) = base.frees(kind.id) {
            if fit
                .model
                .numbers
                .iter()
                .any(|n| n.id.key() == crate::diagnose::fit::BASE[number])
            {
                out.push(Candidate {
                    member: Member {
                        index,
                        values: vec![0.0],
                    },
                    shape: Shape::Frees,
                });
            }
            continue;
        }
        let before = base.then.as_ref().and_then(|then| then.effect(index));
        if let (Some(member), Some(then)) = (before, &base.then)
            && then.is_fitted(index)
        {
            out.push(Candidate {
                member: member.clone(),
                shape: Shape::Frees,
            });
        }
        if (kind.parameters.iter()).any(|p| matches!(p.prior, Prior::Phase)) {
            if before.is_none() {
                out.extend(periodic::candidates(pieces, base, fit, index));
            }
            continue;
        }
        let couples = |id: &str| id == "backlash" || id == "compliance";
        let other = |id: &str| id != kind.id && couples(id);
        if couples(kind.id) && motor.effects.iter().any(|effect| other(effect.kind().id)) {
            continue;
        }
        members.extend(
            grid(kind, base)
                .into_iter()
                .map(|values| Member { index, values }),
        );
    }
    let Some(without) = response(pieces, &motor, &fit.starts) else {
        return out;
    };
    let simulated: Vec<Candidate> = (members.into_par_iter())
        .filter_map(|member| {
            let mut with = motor.clone();
            with.effects
                .set(ActiveEffect::new(member.id(), &member.values).ok()?);
            let around = scattering(pieces, fit, &with);
            let with = response(pieces, &with, &fit.starts)?;
            let column: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
            let shape = if around == fit.around {
                Shape::One(column)
            } else {
                let left = fit.residual.iter().zip(&column).map(|(r, x)| r - x);
                let noise = likeliest(pieces, &around, &left.collect::<Vec<f64>>());
                Shape::Scatter(column, around, noise)
            };
            Some(Candidate { member, shape })
        })
        .collect();
    out.extend(simulated);
    out
}

/// What the filter has to know of a motor with one effect more than the fitted one: of edges lost by chance and of samples that are late.
fn scattering(pieces: &Pieces, fit: &Fit, with: &Motor) -> Surroundings {
    Surroundings {
        jitter_s: jitter_s(with).hypot(pieces.arrivals_s),
        loss: loss(with),
        ..fit.around
    }
}
