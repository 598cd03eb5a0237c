//! The isolability matrix: effects that a planned profile shows and separates.
//!
//! The true effect has a typical magnitude. Its rival has each of the magnitudes from which the search starts; the
//! nearest counts, with its parameters free within their ranges and the base parameters within their tolerances.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;

use super::planned::{Errors, Planned, Prediction, Sampling};
use crate::board::Profile;
use crate::diagnose::model::{BASE, Base, Member, Model};
use crate::diagnose::noise::Noise;
use crate::diagnose::search::starts;
use crate::diagnose::settings::Settings;
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior, catalogue};
use crate::motor::{CommandKind, Motor};

/// Planned recording.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The profile.
    pub profile: Profile,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Duration in s.
    pub duration_s: f64,
}

/// Two effects and their separation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// One effect.
    pub a: &'static str,
    /// The other.
    pub b: &'static str,
    /// The smaller of the two directions, in standard deviations.
    pub separation: f64,
}

/// Effects that a planned profile shows: the document `motorlab-isolability/1`.
#[derive(Debug, Clone, Serialize)]
pub struct Isolability {
    /// `motorlab-isolability/1`.
    pub shape: &'static str,
    /// Name of the profile.
    pub profile: String,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Supply in V.
    pub supply_v: f64,
    /// Rows and columns of the matrix: `none`, then the catalogue.
    pub effects: Vec<&'static str>,
    /// The typical magnitude of each effect.
    pub magnitudes: BTreeMap<&'static str, BTreeMap<&'static str, f64>>,
    /// `separation[i][j]`: truth `i` from rival `j`, in standard deviations.
    pub separation: Vec<Vec<f64>>,
    /// Threshold of the separation below which two effects are not separable.
    pub tie_below: f64,
    /// Effects that are not separable from `none`.
    pub cannot_see: Vec<Pair>,
    /// Pairs of visible effects that are not separable from each other.
    pub cannot_tell_apart: Vec<Pair>,
}

/// Data shared by all models of a motor before any recording.
pub(super) fn base_of(motor: &Motor, sample_time_s: f64, settings: &Settings) -> Base {
    Base {
        motor: motor.clone(),
        kind: CommandKind::Voltage,
        sample_time_s,
        clock: None,
        is_host_timed: false,
        torque_identifiable: false,
        reference: None,
        dead_time_s: 0.0,
        settings: *settings,
    }
}

/// The isolability matrix of a plan for a motor; `None` if the motor cannot be simulated with it. `done` receives the
/// share of finished simulations.
pub fn isolability(
    motor: &Motor,
    plan: &Plan,
    settings: &Settings,
    done: &(dyn Fn(f64) + Sync),
) -> Option<Isolability> {
    let base = base_of(motor, plan.sample_time_s, settings);
    let at = Sampling {
        sample_time_s: plan.sample_time_s,
        samples: (plan.duration_s / plan.sample_time_s).round().max(1.0) as usize,
        counts_per_rev: motor.parameters.counts_per_rev,
        supply_v: motor.parameters.supply_v,
    };
    let errors = Errors::Noise(Noise::of_a_clean_bench(settings));
    let planned = Planned::new(&base, motor, &plan.profile, at, errors, None)?;
    let none = with(&base, None);
    let mut truths = vec![none.clone()];
    let mut rivals = vec![(0, none)];
    let mut effects = vec!["none"];
    let mut magnitudes = BTreeMap::new();
    // Effects of the motor file are part of its model.
    let kinds = catalogue().iter().enumerate();
    for (index, kind) in kinds.filter(|(_, kind)| motor.effects.get(kind.id).is_none()) {
        let (values, others) = magnitudes_of(kind, &base);
        let keys = kind.parameters.iter().map(|parameter| parameter.key);
        magnitudes.insert(kind.id, keys.zip(values.iter().copied()).collect());
        for values in others {
            rivals.push((truths.len(), with(&base, Some(Member { index, values }))));
        }
        truths.push(with(&base, Some(Member { index, values })));
        effects.push(kind.id);
    }
    let (made, all) = (AtomicUsize::new(0), truths.len() + rivals.len());
    let one_more = || done((made.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
    let predictions: Vec<Option<Prediction>> = (truths.par_iter())
        .map(|(model, x)| planned.prediction((model, x), None))
        .inspect(|_| one_more())
        .collect();
    // One rival at a time: its columns are large.
    let columns: Vec<(usize, Vec<f64>)> = (rivals.par_iter())
        .map(|(column, (model, x))| {
            let rival = planned.prediction((model, x), Some(&model.precision));
            let from = |truth: &Option<Prediction>| match (truth, &rival) {
                (Some(truth), Some(rival)) => planned.separation(truth, rival),
                _ => f64::INFINITY,
            };
            (*column, predictions.iter().map(from).collect())
        })
        .inspect(|_| one_more())
        .collect();
    let mut separation = vec![vec![f64::INFINITY; truths.len()]; truths.len()];
    for (column, separations) in columns {
        for (row, own) in separation.iter_mut().zip(separations) {
            row[column] = own.min(row[column]);
        }
    }
    let mut found = Isolability {
        shape: "motorlab-isolability/1",
        profile: plan.profile.name.clone(),
        sample_time_s: plan.sample_time_s,
        samples: at.samples,
        supply_v: motor.parameters.supply_v,
        effects,
        magnitudes,
        separation,
        tie_below: settings.separable,
        cannot_see: Vec::new(),
        cannot_tell_apart: Vec::new(),
    };
    found.list();
    Some(found)
}

impl Isolability {
    /// The smaller separation of the two directions; from `none` that of the effect as the truth, because a rival of
    /// any magnitude may be arbitrarily small.
    pub fn between(&self, i: usize, j: usize) -> f64 {
        match (i, j) {
            (0, effect) | (effect, 0) => self.separation[effect][0],
            _ => self.separation[i][j].min(self.separation[j][i]),
        }
    }

    /// Lists inseparable effects, the smallest separation first.
    fn list(&mut self) {
        let n = self.effects.len();
        let (visible, hidden): (Vec<usize>, Vec<usize>) =
            (1..n).partition(|&i| self.between(i, 0) >= self.tie_below);
        let listed = |pairs: Vec<(usize, usize)>| -> Vec<Pair> {
            let pairs = pairs.into_iter().map(|(i, j)| Pair {
                a: self.effects[i],
                b: self.effects[j],
                separation: self.between(i, j),
            });
            let mut alike: Vec<Pair> = pairs.filter(|p| p.separation < self.tie_below).collect();
            alike.sort_by(|x, y| x.separation.total_cmp(&y.separation));
            alike
        };
        let pairs = visible.iter().enumerate();
        let pairs = pairs.flat_map(|(k, &i)| visible[k + 1..].iter().map(move |&j| (i, j)));
        let apart = listed(pairs.collect());
        self.cannot_see = listed(hidden.iter().map(|&i| (i, 0)).collect());
        self.cannot_tell_apart = apart;
    }
}

/// The motor with one effect, and its parameters.
fn with(base: &Base, member: Option<Member>) -> (Model, Vec<f64>) {
    let model = Model::new(base, member.iter().cloned().collect());
    let mut x = model.start();
    // An effect that widens a base parameter has its value there.
    if let Some(member) = member
        && let Some(number) = base.frees(member.id())
        && let Some(k) = model
            .parameters
            .iter()
            .position(|p| p.id.key() == BASE[number])
    {
        x[k] = member.values[0] / model.parameters[k].unit;
    }
    model.clamp(&mut x);
    (model, x)
}

/// Typical values of an effect, and its values as a rival: they differ in the first parameter, the others are the
/// catalogue's defaults.
fn magnitudes_of(kind: &EffectKind, base: &Base) -> (Vec<f64>, Vec<Vec<f64>>) {
    let p = &base.motor.parameters;
    let mut values: Vec<f64> = (kind.parameters.iter())
        .map(|parameter| parameter.default(p, base.sample_time_s))
        .collect();
    let Some(first) = kind.parameters.first() else {
        return (values.clone(), vec![values]);
    };
    let tried = starts(first, kind, base);
    let largest = tried
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    // Half of the largest, or the nearest value that differs from the neutral one.
    let off = |value: &f64| (value - 0.5 * largest).abs();
    let typical = tried.iter().filter(|value| changes(first, base, **value));
    let typical = typical.min_by(|a, b| off(a).total_cmp(&off(b))).copied();
    let mut rivals: Vec<Vec<f64>> = Vec::new();
    // An effect that widens a base parameter is tried at the motor file's value too.
    let own = base.frees(kind.id).and_then(|number| p.get(BASE[number]));
    for value in tried.iter().copied().chain(own) {
        values[0] = value;
        rivals.push(values.clone());
    }
    values[0] = typical.or(tried.last().copied()).unwrap_or(values[0]);
    (values, rivals)
}

/// Whether a value differs plausibly from the neutral one.
fn changes(parameter: &EffectParameter, base: &Base, value: f64) -> bool {
    let Some((neutral, least)) = parameter.neutral(&base.motor.parameters) else {
        return value != base.motor.parameters.counts_per_rev || parameter.key != "counts_per_rev";
    };
    match parameter.prior {
        Prior::LogUniform => (value / neutral).ln().abs() >= least,
        _ => (value - neutral).abs() >= least,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(profile: &str, sample_time_s: f64) -> Isolability {
        let plan = Plan {
            profile: Profile::named(profile, 4.5, 4.0).expect("built in"),
            sample_time_s,
            duration_s: 4.0,
        };
        isolability(&Motor::default(), &plan, &Settings::default(), &|_| ()).expect("a motor")
    }

    fn between(found: &Isolability, a: &str, b: &str) -> f64 {
        let place = |id: &str| found.effects.iter().position(|effect| *effect == id);
        found.between(place(a).expect("an effect"), place(b).expect("an effect"))
    }

    /// In one direction at one level `Kt/R (u - Vd - Kb w) - Tf` has one constant: a voltage drop is friction. A dead
    /// zone below the level, and coasting at 0 V, have no influence.
    #[test]
    fn one_step_does_not_separate_theoretically_inseparable_effects() {
        let step = matrix("step", 0.03);
        let least = step.tie_below;
        assert!(between(&step, "voltage_drop", "coulomb_friction") < least);
        assert!(between(&step, "constant_load", "coulomb_friction") < least);
        for effect in ["dead_zone", "coast_at_zero", "static_friction"] {
            assert!(between(&step, "none", effect) < 0.1, "{effect}");
        }
        let both = matrix("reversing", 0.03);
        assert!(between(&both, "none", "coast_at_zero") > least);
        assert!(between(&both, "none", "constant_load") > least);
        // For a turning shaft, a load in one direction is asymmetric friction: no profile separates them.
        assert!(between(&both, "constant_load", "asymmetric_friction") < least);
        assert_eq!(both.effects.len(), catalogue().len() + 1);
    }

    /// Ten times as many samples of the same motion reduce the variance of quantization to a tenth.
    #[test]
    fn a_shorter_sample_time_separates_more() {
        let (slow, fast) = (matrix("square", 0.03), matrix("square", 0.003));
        let ratio = between(&fast, "none", "compliance") / between(&slow, "none", "compliance");
        assert!(ratio > 1.5, "{ratio}");
    }
}
