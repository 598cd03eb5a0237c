//! Models with one more effect of a supposed magnitude, before any recording shows it.

use nalgebra::DMatrix;

use crate::diagnose::fit::{BASE, Base, Member, Model, range_of};
use crate::diagnose::settings::{AWAY, RIVAL_PLACES, WELL_AWAY};
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior};
use crate::motor::fit::ParameterId;

/// A model with the numbers that are supposed of it.
#[derive(Debug, Clone)]
pub(super) struct Supposed {
    model: Model,
    x: Vec<f64>,
}

impl Supposed {
    /// A model with one more effect of these values.
    pub fn beside(base: &Base, (model, x): (&Model, &[f64]), member: Option<Member>) -> Self {
        let members = model.members.iter().cloned().chain(member.clone());
        let larger = Model::new(base, members.collect());
        let mut numbers = larger.start_from(model, x);
        // An effect that frees a number of the motor has its value there.
        if let Some((number, member)) = member.and_then(|m| Some((base.frees(m.id())?, m)))
            && let Some(id) = ParameterId::nominal(BASE[number])
            && let Some(k) = larger.numbers.iter().position(|n| n.id == id)
        {
            numbers[k] = member.values[0] / larger.numbers[k].unit;
        }
        larger.clamp(&mut numbers);
        Self {
            model: larger,
            x: numbers,
        }
    }

    pub fn numbers(&self) -> (&Model, &[f64]) {
        (&self.model, &self.x)
    }

    /// How well its numbers are known before any recording.
    pub fn precision(&self) -> &DMatrix<f64> {
        &self.model.precision
    }
}

/// The value a share of the way through a parameter's range.
fn place(parameter: &EffectParameter, base: &Base, share: f64) -> f64 {
    let (lo, hi) = range_of(parameter, base);
    match parameter.prior {
        Prior::LogUniform => lo * (hi / lo).powf(share),
        Prior::OneOf(values) => {
            let own = base.motor.parameters.counts_per_rev;
            let others: Vec<f64> = values.iter().copied().filter(|v| *v != own).collect();
            let last = others.len().saturating_sub(1);
            let k = ((share * others.len() as f64) as usize).min(last);
            others.get(k).copied().unwrap_or(lo)
        }
        _ => lo + share * (hi - lo),
    }
}

/// Typical values of an effect.
pub(super) fn typical(kind: &EffectKind, base: &Base) -> Vec<f64> {
    let parameters = &base.motor.parameters;
    let value = |(k, parameter): (usize, &EffectParameter)| {
        if k > 0 {
            return parameter.default(parameters, base.sample_time_s);
        }
        let middle = place(parameter, base, 0.5);
        let distance =
            parameter
                .neutral(parameters)
                .map(|(neutral, least)| match parameter.prior {
                    Prior::LogUniform => (middle / neutral).ln().abs() / least,
                    _ => (middle - neutral).abs() / least,
                });
        if distance.is_some_and(|distance| distance < WELL_AWAY) {
            place(parameter, base, AWAY)
        } else {
            middle
        }
    };
    kind.parameters.iter().enumerate().map(value).collect()
}

/// Values of an effect whose first number is this share of the way through its range.
pub(super) fn with_first(kind: &EffectKind, typical: &[f64], base: &Base, share: f64) -> Vec<f64> {
    let mut values = typical.to_vec();
    if let (Some(first), Some(parameter)) = (values.first_mut(), kind.parameters.first()) {
        *first = place(parameter, base, share);
    }
    values
}

/// The values with which an effect is tried as a rival: the first number through its range.
pub(super) fn as_rivals(kind: &EffectKind, typical: &[f64], base: &Base) -> Vec<Vec<f64>> {
    let Some(first) = kind.parameters.first() else {
        return vec![Vec::new()];
    };
    let places = RIVAL_PLACES.iter();
    let mut tried: Vec<Vec<f64>> = places
        .map(|share| with_first(kind, typical, base, *share))
        .collect();
    // What frees a number of the motor is tried where the motor file has it too.
    if let (Some(_), Some((own, _))) = (base.frees(kind.id), first.neutral(&base.motor.parameters))
    {
        tried.push(vec![own]);
    }
    tried
}
