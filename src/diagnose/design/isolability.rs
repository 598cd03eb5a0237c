//! The isolability matrix: what a planned profile shows of every effect, and which it tells apart.
//!
//! Every effect stands at a typical magnitude (the middle of its range, or well away from the value that changes nothing) as the
//! truth, and at several magnitudes as the rival; the nearest rival counts, its numbers free within their ranges and the base
//! within its tolerances.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::planned::{ORDINARY, Planned, Sampling, View};
use super::supposed::{Supposed, as_rivals, typical};
use crate::board::Profile;
use crate::diagnose::fit::{Base, Member, Model};
use crate::diagnose::settings::TIE;
use crate::motor::catalogue::catalogue;
use crate::motor::{CommandKind, KnownDifferences, Motor};

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
    let samples = (plan.duration_s / plan.sample_time_s).round().max(1.0) as usize;
    let base = Base {
        motor: motor.clone(),
        kind: CommandKind::Voltage,
        sample_time_s: plan.sample_time_s,
        clock: None,
        is_host_timed: false,
        knows_torque: false,
        then: None,
    };
    let at = Sampling {
        sample_time_s: plan.sample_time_s,
        samples,
        counts_per_rev: motor.parameters.counts_per_rev,
        supply_v: motor.parameters.supply_v,
    };
    let model = Model::new(&base, Vec::new());
    let own = model.start();
    let with = |member| Supposed::beside(&base, (&model, &own), member);
    let none = with(None);
    let known = KnownDifferences::default();
    let planned = Planned::new(&base, none.numbers(), &plan.profile, at, ORDINARY, &known)?;
    let mut truths = vec![none.clone()];
    let mut rivals = vec![(0, none)];
    let mut effects = vec!["none"];
    let mut magnitudes = BTreeMap::new();
    // Effects that the motor file has already are part of its model.
    let kinds = catalogue().iter().enumerate();
    for (index, kind) in kinds.filter(|(_, kind)| motor.effects.get(kind.id).is_none()) {
        let values = typical(kind, &base);
        let keys = kind.parameters.iter().map(|parameter| parameter.key);
        magnitudes.insert(kind.id, keys.zip(values.iter().copied()).collect());
        for values in as_rivals(kind, &values, &base) {
            rivals.push((truths.len(), with(Some(Member { index, values }))));
        }
        truths.push(with(Some(Member { index, values })));
        effects.push(kind.id);
    }
    let views: Vec<Option<View>> = truths
        .par_iter()
        .map(|truth| planned.truth(truth.numbers()))
        .collect();
    // A rival at a time: its columns are large.
    let columns: Vec<(usize, Vec<f64>)> = rivals
        .par_iter()
        .map(|(column, rival)| {
            let seen = planned.rival(&base, rival.numbers(), rival.precision());
            let from = |truth: &Option<View>| match (truth, &seen) {
                (Some(truth), Some(seen)) => planned.separation(truth, seen),
                _ => f64::INFINITY,
            };
            (*column, views.iter().map(from).collect())
        })
        .collect();
    let mut nearest = vec![vec![f64::INFINITY; truths.len()]; truths.len()];
    for (column, separations) in columns {
        for (row, separation) in nearest.iter_mut().zip(separations) {
            row[column] = separation.min(row[column]);
        }
    }
    let mut found = Isolability {
        shape: "motorlab-isolability/1",
        profile: plan.profile.name.clone(),
        sample_time_s: plan.sample_time_s,
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
    /// The smaller separation of the two ways round; from `none` that of the effect as the truth, because as a rival of nothing an
    /// effect is as small as it likes.
    pub fn between(&self, i: usize, j: usize) -> f64 {
        match (i, j) {
            (0, effect) | (effect, 0) => self.separation[effect][0],
            _ => self.separation[i][j].min(self.separation[j][i]),
        }
    }

    fn name_classes(&mut self) {
        let n = self.effects.len();
        let (seen, unseen): (Vec<usize>, Vec<usize>) =
            (1..n).partition(|&i| self.between(i, 0) >= TIE);
        let pair = |i: usize, j: usize| Pair {
            a: self.effects[i],
            b: self.effects[j],
            separation: self.between(i, j),
        };
        let pairs = seen.iter().enumerate();
        let pairs = pairs.flat_map(|(k, &i)| seen[k + 1..].iter().map(move |&j| (i, j)));
        let mut alike: Vec<Pair> = pairs
            .map(|(i, j)| pair(i, j))
            .filter(|pair| pair.separation < TIE)
            .collect();
        let mut nothing: Vec<Pair> = unseen.iter().map(|&i| pair(i, 0)).collect();
        let by_size = |x: &Pair, y: &Pair| x.separation.total_cmp(&y.separation);
        alike.sort_by(by_size);
        nothing.sort_by(by_size);
        (self.cannot_see, self.cannot_tell_apart) = (nothing, alike);
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
        isolability(&Motor::default(), &plan).expect("a motor")
    }

    fn between(found: &Isolability, a: &str, b: &str) -> f64 {
        let place = |id: &str| found.effects.iter().position(|effect| *effect == id);
        found.between(place(a).expect("an effect"), place(b).expect("an effect"))
    }

    /// In one direction at one level `Kt/R (u - Vd - Kb w) - Tf` has one constant: a drop is friction. A dead zone under the level, and
    /// what happens at 0 V, leave no trace.
    #[test]
    fn one_step_hides_what_theory_says_it_hides() {
        let step = matrix("step", 0.03);
        assert!(between(&step, "voltage_drop", "coulomb_friction") < TIE);
        assert!(between(&step, "constant_load", "coulomb_friction") < TIE);
        for effect in ["dead_zone", "coast_at_zero", "static_friction"] {
            assert!(between(&step, "none", effect) < 0.1, "{effect}");
        }
        let both = matrix("reversing", 0.03);
        assert!(between(&both, "none", "coast_at_zero") > TIE);
        assert!(between(&both, "none", "constant_load") > TIE);
        // Turning, a load that pushes one way is friction that differs by direction: no profile parts them.
        assert!(between(&both, "constant_load", "asymmetric_friction") < TIE);
        assert_eq!(both.effects.len(), catalogue().len() + 1);
    }

    /// Ten times as many samples of the same motion have a tenth of the rounding's variance.
    #[test]
    fn a_shorter_sample_time_separates_more() {
        let (slow, fast) = (matrix("square", 0.03), matrix("square", 0.003));
        let ratio = between(&fast, "none", "compliance") / between(&slow, "none", "compliance");
        assert!(ratio > 1.5, "{ratio}");
    }
}
