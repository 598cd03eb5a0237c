//! The isolability matrix: what a planned profile shows of every effect, and which it tells apart.
//!
//! Every effect stands at a typical magnitude (the middle of its range, or well away from the value that
//! changes nothing) as the truth, and at several magnitudes as the rival; the nearest rival counts, its
//! numbers free within their ranges and the base within its tolerances.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::super::rivals::catalogue;
use super::planned::{Planned, Sampling, View};
use crate::board::Profile;
use crate::diagnose::disturbance::Disturbance;
use crate::diagnose::hypothesis::{Hypothesis, Member};
use crate::diagnose::noise::NoiseLevel;
use crate::diagnose::rivals::rivals;
use crate::diagnose::scales::damping_of;
use crate::diagnose::setting::Setting;
use crate::diagnose::ties::TIE;
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior};
use crate::motor::{KnownDifferences, Motor};
use crate::recording::CommandKind;

/// An ordinary wander as a share of the largest acceleration.
const ORDINARY_WANDER: f64 = 0.001;
/// Where in its range a rival's first number is tried.
const RIVALS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Where in its range a number stands whose middle is near the value that changes nothing.
const AWAY: f64 = 0.8;

/// What is to be recorded.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The profile.
    pub profile: Profile,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// How long in s.
    pub duration_s: f64,
}

/// Two effects and the separation of the one from the other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// One.
    pub a: &'static str,
    /// The other.
    pub b: &'static str,
    /// The smaller of the two ways round, in standard deviations.
    pub separation: f64,
}

/// What a planned profile can tell: the document `motorlab-isolability/1`.
#[derive(Debug, Clone, Serialize)]
pub struct Isolability {
    /// `motorlab-isolability/1`.
    pub shape: &'static str,
    /// Name of the profile.
    pub profile: String,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Samples.
    pub samples: usize,
    /// Supply in V.
    pub supply_v: f64,
    /// Rows and columns of the matrix: `none`, then the catalogue.
    pub effects: Vec<&'static str>,
    /// The magnitudes that stand for each effect.
    pub magnitudes: BTreeMap<&'static str, BTreeMap<&'static str, f64>>,
    /// `separation[i][j]`: of truth `i` from rival `j`, in standard deviations.
    pub separation: Vec<Vec<f64>>,
    /// Below this two are one class.
    pub tie_below: f64,
    /// Effects that look like none, with their separation from it.
    pub cannot_see: Vec<Pair>,
    /// Pairs of effects, each seen, that look like each other.
    pub cannot_tell_apart: Vec<Pair>,
}

/// The isolability matrix of a plan for a motor; `None` where the motor cannot be simulated on it.
pub fn isolability(motor: &Motor, plan: &Plan) -> Option<Isolability> {
    let sample_time_s = plan.sample_time_s;
    let samples = (plan.duration_s / sample_time_s).round().max(1.0) as usize;
    let level = NoiseLevel {
        wander: ORDINARY_WANDER * largest_acceleration(motor, plan.profile.largest_command()),
        lost_share: 0.0,
        late_s: 0.0,
        supply: 0.0,
        rounding: 1.0,
        rough: Disturbance::default(),
        goes_on: false,
    };
    let at = Sampling {
        sample_time_s,
        samples,
    };
    let damping = damping_of(motor, CommandKind::Voltage);
    let planned = Planned::new(
        motor,
        &plan.profile,
        at,
        damping,
        level,
        &KnownDifferences::default(),
    )?;
    // Effects that the motor file has already are part of its model.
    let kinds: Vec<usize> = rivals()
        .filter(|&index| motor.effects.get(catalogue()[index].id).is_none())
        .collect();
    let setting = Setting::new(motor, std::slice::from_ref(&planned.run));
    let hypothesis = |members| Hypothesis::new(motor, members, &setting);
    let mut truths = vec![hypothesis(Vec::new())];
    let mut rivals: Vec<(usize, Hypothesis)> = vec![(0, hypothesis(Vec::new()))];
    let mut effects = vec!["none"];
    let mut magnitudes = BTreeMap::new();
    for &index in &kinds {
        let kind = &catalogue()[index];
        let typical = typical(kind, motor, sample_time_s);
        let keys = kind.parameters.iter().map(|parameter| parameter.key);
        magnitudes.insert(kind.id, keys.zip(typical.iter().copied()).collect());
        for values in magnitudes_of(kind, &typical, motor, sample_time_s) {
            rivals.push((truths.len(), hypothesis(vec![Member { index, values }])));
        }
        let values = typical;
        truths.push(hypothesis(vec![Member { index, values }]));
        effects.push(kind.id);
    }
    let views: Vec<Option<View>> = truths
        .par_iter()
        .map(|truth| planned.truth(motor, truth, &truth.start()))
        .collect();
    // A rival at a time: its columns are large.
    let nearest = rivals
        .par_iter()
        .map(|(column, rival)| {
            let mut matrix = vec![vec![f64::INFINITY; truths.len()]; truths.len()];
            if let Some(seen) = planned.view(motor, rival, &rival.start()) {
                for (row, truth) in views.iter().enumerate() {
                    let precision = |i, j| rival.precision(i, j);
                    let d = truth
                        .as_ref()
                        .and_then(|truth| planned.separation(truth, &seen, precision));
                    matrix[row][*column] = d.unwrap_or(f64::INFINITY);
                }
            }
            matrix
        })
        .reduce_with(|a, b| {
            let rows = a.into_iter().zip(b);
            rows.map(|(a, b)| a.into_iter().zip(b).map(|(a, b)| a.min(b)).collect())
                .collect()
        })?;
    let mut found = Isolability {
        shape: "motorlab-isolability/1",
        profile: plan.profile.name.clone(),
        sample_time_s,
        samples,
        supply_v: motor.parameters.supply_v,
        effects,
        magnitudes,
        separation: nearest,
        tie_below: TIE,
        cannot_see: Vec::new(),
        cannot_tell_apart: Vec::new(),
    };
    found.name_classes();
    Some(found)
}

impl Isolability {
    /// The smaller separation of the two ways round; from `none` that of the effect as the truth, because as a
    /// rival of nothing an effect is as small as it likes.
    pub fn between(&self, i: usize, j: usize) -> f64 {
        match (i, j) {
            (0, effect) | (effect, 0) => self.separation[effect][0],
            _ => self.separation[i][j].min(self.separation[j][i]),
        }
    }

    fn name_classes(&mut self) {
        let n = self.effects.len();
        let seen: Vec<bool> = (0..n).map(|i| self.between(i, 0) >= TIE).collect();
        for i in 1..n {
            if !seen[i] {
                self.cannot_see.push(Pair {
                    a: self.effects[i],
                    b: "none",
                    separation: self.between(i, 0),
                });
                continue;
            }
            for (j, _) in seen
                .iter()
                .enumerate()
                .skip(i + 1)
                .filter(|(_, seen)| **seen)
            {
                let separation = self.between(i, j);
                if separation < TIE {
                    let (a, b) = (self.effects[i], self.effects[j]);
                    self.cannot_tell_apart.push(Pair { a, b, separation });
                }
            }
        }
        let by_size = |x: &Pair, y: &Pair| x.separation.total_cmp(&y.separation);
        self.cannot_see.sort_by(by_size);
        self.cannot_tell_apart.sort_by(by_size);
    }
}

/// Largest acceleration that a voltage asks for, in counts/s^2.
fn largest_acceleration(motor: &Motor, largest_v: f64) -> f64 {
    let p = &motor.parameters;
    let torque_nm = largest_v * p.torque_constant_nm_per_a / p.resistance_ohm;
    torque_nm / p.inertia_kg_m2 * p.counts_per_rev / std::f64::consts::TAU
}

/// The value a share of the way through a parameter's range.
fn quantile(parameter: &EffectParameter, motor: &Motor, sample_time_s: f64, share: f64) -> f64 {
    let (lo, hi) = parameter.range(&motor.parameters, sample_time_s);
    match parameter.prior {
        Prior::LogUniform => lo * (hi / lo).powf(share),
        Prior::OneOf(values) => {
            let others: Vec<f64> = values
                .iter()
                .copied()
                .filter(|value| *value != motor.parameters.counts_per_rev)
                .collect();
            let place = (share * others.len() as f64) as usize;
            let last = others.len().saturating_sub(1);
            others.get(place.min(last)).copied().unwrap_or(lo)
        }
        _ => lo + share * (hi - lo),
    }
}

/// Typical values of an effect.
fn typical(kind: &EffectKind, motor: &Motor, sample_time_s: f64) -> Vec<f64> {
    let parameters = kind.parameters.iter().enumerate();
    let value = |(k, parameter): (usize, &EffectParameter)| {
        if k > 0 {
            return parameter.default(&motor.parameters, sample_time_s);
        }
        let middle = quantile(parameter, motor, sample_time_s, 0.5);
        let distance = parameter
            .neutral(&motor.parameters)
            .map(|(neutral, least)| match parameter.prior {
                Prior::LogUniform => (middle / neutral).ln().abs() / least,
                _ => (middle - neutral).abs() / least,
            });
        if distance.is_some_and(|distance| distance < 2.0) {
            quantile(parameter, motor, sample_time_s, AWAY)
        } else {
            middle
        }
    };
    parameters.map(value).collect()
}

/// The values with which an effect is tried as a rival: the first number through its range.
fn magnitudes_of(
    kind: &EffectKind,
    typical: &[f64],
    motor: &Motor,
    sample_time_s: f64,
) -> Vec<Vec<f64>> {
    let Some(first) = kind.parameters.first() else {
        return vec![Vec::new()];
    };
    let tried = RIVALS.map(|share| {
        let mut values = typical.to_vec();
        values[0] = quantile(first, motor, sample_time_s, share);
        values
    });
    tried.into_iter().collect()
}
