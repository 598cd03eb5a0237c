//! Starts of every effect, and how each changes the prediction: simulated with the effect less without.

use rayon::prelude::*;

use super::periodic;
use crate::diagnosis::fit::range_of;
use crate::diagnosis::fit::{Base, Fit, Member, response};
use crate::diagnosis::pieces::Pieces;
use crate::motor::ActiveEffect;
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior, catalogue};

/// How a candidate changes what is predicted.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// By this column in counts, times something positive.
    One(Vec<f64>),
    /// By any sum of these two: sine and cosine. With what turns the coefficients into amplitude and phase.
    Pair([Vec<f64>; 2], periodic::Wave),
    /// Not at all: a base number becomes free.
    Frees,
}

/// An effect with values to start from.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub member: Member,
    pub shape: Shape,
}

/// Shares of a range from which a number starts.
const STARTS: [f64; 3] = [0.15, 0.5, 0.85];
const MORE_STARTS: [f64; 5] = [0.08, 0.25, 0.45, 0.65, 0.85];
const SIGNED_STARTS: [f64; 4] = [-0.5, -0.12, 0.12, 0.5];

fn starts(parameter: &EffectParameter, kind: &EffectKind, number: usize, base: &Base) -> Vec<f64> {
    if let Prior::OneOf(values) = parameter.prior
        && parameter.key != "max_rate_hz"
    {
        return values.to_vec();
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
    let shares: &[f64] = if number > 0
        && kind.id != "asymmetric_dead_zone"
        && kind.id != "asymmetric_voltage_drop"
    {
        &[0.2, 0.7]
    } else if !parameter.smooth && kind.parameters.len() == 1 {
        &MORE_STARTS
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
    for (number, parameter) in kind.parameters.iter().enumerate() {
        let values = starts(parameter, kind, number, base);
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
        let lost: Vec<f64> = starts(&kind.parameters[0], kind, 0, base);
        let (lo, hi) = range_of(&kind.parameters[1], base);
        grid = lost.into_iter().map(|p| vec![p, 0.0]).collect();
        grid.extend(
            MORE_STARTS
                .iter()
                .map(|share| vec![0.0, lo + share * (hi - lo)]),
        );
    }
    grid
}

/// Everything that might be added to a model.
pub(crate) fn candidates(pieces: &Pieces, base: &Base, fit: &Fit) -> Vec<Candidate> {
    let motor = fit.model.motor(&fit.x);
    let has = |id: &str| fit.model.members.iter().any(|member| member.id() == id);
    let mut members = Vec::new();
    let mut out = Vec::new();
    for (index, kind) in catalogue().iter().enumerate() {
        if has(kind.id) {
            continue;
        }
        if let Some(number) = crate::diagnosis::fit::frees(kind.id) {
            if fit
                .model
                .numbers
                .iter()
                .any(|n| n.id.key() == crate::diagnosis::fit::BASE[number])
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
        if kind
            .parameters
            .iter()
            .any(|p| matches!(p.prior, Prior::Phase))
        {
            out.extend(periodic::candidates(pieces, base, fit, index));
            continue;
        }
        let couples = |id: &str| id == "backlash" || id == "compliance";
        if couples(kind.id) && fit.model.members.iter().any(|m| couples(m.id())) {
            continue;
        }
        members.extend(
            grid(kind, base)
                .into_iter()
                .map(|values| Member { index, values }),
        );
    }
    let Some(without) = response(pieces, &motor) else {
        return out;
    };
    let simulated: Vec<Candidate> = (members.into_par_iter())
        .filter_map(|member| {
            let mut with = motor.clone();
            with.effects
                .set(ActiveEffect::new(member.id(), &member.values).ok()?);
            let with = response(pieces, &with)?;
            let column = with.iter().zip(&without).map(|(a, b)| a - b).collect();
            Some(Candidate {
                member,
                shape: Shape::One(column),
            })
        })
        .collect();
    out.extend(simulated);
    out
}
