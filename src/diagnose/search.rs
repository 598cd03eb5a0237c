//! Where fits of an effect start.
//!
//! A fit by least squares finds the nearest hollow; these searches find the right one. Every effect is
//! tried over a grid of its plausible range, and the starts that leave least, after the base model has
//! given way linearly, are fitted. Effects that repeat with the angle have a search of their own (`periodic`).

use rayon::prelude::*;

use super::anchor::Anchor;
use super::data::RunData;
use super::fit::Fit;
use super::grid::{Grid, Values};
use super::hypothesis::{BASE, Hypothesis, Member};
use super::noise::{NoiseLevel, Whitener};
use super::periodic::{is_scanned, periodic, repeats};
use super::predict::{predict, predict_alike};
use super::problem::{Columns, Problem};
use super::prospect::Prospect;
use super::rivals::{catalogue, find};
use crate::motor::Motor;
use crate::motor::catalogue::{EffectKind, Stage};
use crate::motor::fit::move_alike;

/// How many starts of an effect are fitted.
const STARTS: usize = 3;
/// How many of one that goes in steps.
const STEPPED_STARTS: usize = 6;
/// Of more values than this, those that leave least beside the fit are tried beside a base that is not bent.
const FEW_VALUES: usize = 8;
/// Samples of all starts that are judged at once, and the least number of starts: what is held in memory.
const AT_ONCE: usize = 2_000_000;
const LEAST_AT_ONCE: usize = 8;
/// How many orders of an angle-periodic effect are fitted.
pub(super) const ORDERS: usize = 4;

/// Squares of the prior's standard deviations from which on a base counts as bent.
const STRAINED: f64 = 6.0;

/// Farthest that a regression moves a number of the base before the fit.
const WIDEST_SHIFT: f64 = 0.2;

/// Values of an effect to try: what they leave, the values, by how much the base moves.
pub(super) type Try = (f64, Vec<f64>, [f64; BASE]);

/// A hypothesis and where its fit starts.
pub(super) type Start = (Hypothesis, Vec<f64>);

/// Starts of an effect with what they leave, and what the effect promises.
#[derive(Default)]
struct Found {
    scored: Vec<(f64, Start)>,
    promise: f64,
}

impl Found {
    /// The effect's values at so many starts that leave least.
    fn best(&self, most: usize) -> Vec<Values> {
        let mut scored: Vec<&(f64, Start)> = self.scored.iter().collect();
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let members = scored.iter().map(|(_, start)| start.0.members.last());
        let values = members.flatten().map(|member| member.values.clone());
        values.take(most).collect()
    }
}

/// How many starts of an effect are fitted.
fn starts_of(id: &str) -> usize {
    match id {
        _ if is_scanned(id) => ORDERS,
        "resolution_error" | "dead_zone" | "missed_counts" => STEPPED_STARTS,
        _ => STARTS,
    }
}

/// What a search looks at: the fit so far, and what is left of it on short horizons.
pub(super) struct Search<'a> {
    problem: &'a Problem<'a>,
    members: Vec<Member>,
    level: NoiseLevel,
    anchors: Vec<Anchor>,
    /// The fit as it is, on its own horizon.
    own: Anchor,
    own_level: NoiseLevel,
}

impl<'a> Search<'a> {
    /// Looks from `fit` on, on the level of the wander with this number; `None` where that cannot be simulated.
    pub fn new(problem: &'a Problem<'a>, fit: &Fit, level: usize) -> Option<Self> {
        // Short horizons: the search must not depend on what happened seconds ago.
        let strongest = problem
            .levels
            .get(level)
            .or(problem.levels.last())
            .copied()?;
        let derivatives = problem.base_derivatives(fit)?;
        let own = Anchor::new(problem, fit, derivatives.clone());
        let mut at_level = fit.clone();
        at_level.wander = strongest;
        let mut anchors = vec![Anchor::new(problem, &at_level, derivatives)];
        // A base that bent itself far to explain an effect is a bad place to look for it from.
        if fit.hypothesis.strain(&fit.p) > STRAINED {
            let mut start = fit.p.clone();
            start[..BASE].fill(0.0);
            let nominal = problem.fit_at(&fit.hypothesis, &start, strongest, 0);
            let anchor = |fit| Some(Anchor::new(problem, &fit, problem.base_derivatives(&fit)?));
            anchors.extend(nominal.and_then(anchor));
        }
        Some(Self {
            problem,
            members: fit.hypothesis.members.clone(),
            level: problem.noise(&fit.hypothesis, &fit.p, strongest),
            anchors,
            own,
            own_level: problem.noise(&fit.hypothesis, &fit.p, fit.wander),
        })
    }

    /// The most promising hypotheses with effect `index` added, each with its starting numbers; `known` are the
    /// effect's values in a fit, near which to look more closely.
    pub fn starts(&self, index: usize, known: Option<&[f64]>) -> Vec<Start> {
        self.prospect(index, known).starts
    }

    /// The same with what they promise.
    pub fn prospect(&self, index: usize, known: Option<&[f64]>) -> Prospect {
        let kind = &catalogue()[index];
        let mut found = Found::default();
        for (place, anchor) in self.anchors.iter().enumerate() {
            if repeats(kind.id) {
                let before = self.anchors[0].left;
                for (left, values, shift) in
                    periodic(self.problem, &self.level, anchor, index, kind.id)
                {
                    found.promise = found.promise.max(before - left);
                    let start = self.start(anchor, index, values, shift);
                    found.scored.push((left, start));
                }
            } else {
                let values = self.tried(place, kind, known, &found);
                self.judge(place, index, values, &mut found);
            }
        }
        let mut scored = found.scored;
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        scored.truncate(starts_of(kind.id));
        let starts = scored.into_iter().map(|(_, start)| start).collect();
        Prospect {
            index,
            starts,
            promise: found.promise,
        }
    }

    /// The values of an effect to try beside the anchor with this number: of a large grid those that left least beside the first
    /// one. (What an encoder says costs no simulation of its own.)
    fn tried(
        &self,
        place: usize,
        kind: &'static EffectKind,
        known: Option<&[f64]>,
        found: &Found,
    ) -> Vec<Values> {
        let values = Grid::new(self.problem, kind).beside(&self.members, known);
        if place > 0 && values.len() > FEW_VALUES && kind.stage != Stage::Sensor {
            found.best(starts_of(kind.id))
        } else {
            values
        }
    }

    /// Where a fit starts beside an anchor from these values of an effect, the base moved by a shift.
    fn start(&self, anchor: &Anchor, index: usize, values: Vec<f64>, shift: [f64; BASE]) -> Start {
        let mut members = self.members.clone();
        members.push(Member { index, values });
        let hypothesis = Hypothesis::new(self.problem.nominal, members, &self.problem.setting);
        let mut start = hypothesis.start();
        start[..anchor.p.len()].copy_from_slice(&anchor.p);
        for (value, shift) in start.iter_mut().zip(shift) {
            *value += shift.clamp(-WIDEST_SHIFT, WIDEST_SHIFT);
        }
        hypothesis.clamp(&mut start);
        (hypothesis, start)
    }

    /// Adds what these values of an effect leave beside the anchor with this number, and promise.
    fn judge(&self, place: usize, index: usize, values: Vec<Values>, found: &mut Found) {
        let Some(anchor) = self.anchors.get(place) else {
            return;
        };
        let start = |values| self.start(anchor, index, values, [0.0; BASE]);
        let starts: Vec<Start> = values.into_iter().map(start).collect();
        let samples: usize = self.problem.runs.iter().map(RunData::len).sum();
        let at_once = (AT_ONCE / samples.max(1)).max(LEAST_AT_ONCE);
        let judged: Vec<(f64, f64)> = starts
            .chunks(at_once)
            .flat_map(|some| self.judged(place, some))
            .collect();
        for ((left, promised), start) in judged.into_iter().zip(starts) {
            found.promise = found.promise.max(promised);
            found.scored.push((left, start));
        }
    }

    /// The rate in 1/s at which starts part that differ little, where a torque that repeats with the angle holds the
    /// shaft: with an acceleration `A sin(N theta)` that is `sqrt(N A)`, and it holds what turns slower than
    /// `sqrt(2 A/N)`. None where nothing does.
    pub fn parting_rate(&self) -> Option<f64> {
        let anchor = self.anchors.first()?;
        let (index, kind) = find("cogging")?;
        let best = periodic(self.problem, &self.level, anchor, index, kind.id)
            .into_iter()
            .next()?;
        let (amplitude, order) = (
            best.1[0] / self.problem.nominal.parameters.inertia_kg_m2,
            best.1[1],
        );
        let mut speeds: Vec<f64> = Vec::new();
        for run in self.problem.runs {
            let rad = std::f64::consts::TAU / run.counts_per_rev;
            let turning = run.speed_counts_s.iter().zip(&run.moving);
            speeds.extend(turning.filter_map(|(v, moving)| moving.then_some(v.abs() * rad)));
        }
        speeds.sort_by(f64::total_cmp);
        let median = speeds.get(speeds.len() / 2)?;
        (*median < (2.0 * amplitude / order).sqrt()).then_some((amplitude * order).sqrt())
    }

    /// Squares left on short horizons by each start beside the anchor with this number, once the base has given way linearly;
    /// and by how many fewer they may be than those of the fit so far.
    fn judged(&self, place: usize, starts: &[Start]) -> Vec<(f64, f64)> {
        let mut judged = vec![(f64::INFINITY, 0.0); starts.len()];
        let (Some(anchor), Some(first)) = (self.anchors.get(place), self.anchors.first()) else {
            return judged;
        };
        // A noise of its own is no column of a regression, and has filters of its own.
        let mut alike = Vec::new();
        let simulated = self.predictions_of(starts);
        for ((k, (hypothesis, p)), predictions) in starts.iter().enumerate().zip(simulated) {
            let Some(predictions) = predictions else {
                continue;
            };
            let level = self.problem.noise(hypothesis, p, self.level.wander);
            if level == self.level {
                alike.push((k, predictions));
                continue;
            }
            let whiteners = self.problem.whiteners(&level);
            let r = self.problem.whitened(&predictions, &whiteners);
            let left = anchor.left_over(&r, p) + determinants(&whiteners);
            judged[k] = (left, first.left - left);
        }
        let (places, alike): (Vec<usize>, Vec<_>) = alike.into_iter().unzip();
        let whiteners = self.problem.whiteners(&self.level);
        let residuals = self.problem.whitened_together(&alike, &whiteners);
        for (&k, r) in places.iter().zip(&residuals) {
            let left = anchor.left_over(r, &starts[k].1) + determinants(&whiteners);
            let scaled = anchor.left - anchor.gain_along(r);
            judged[k] = (left, first.left - left.min(scaled));
        }
        if place == 0 && self.own_level != self.level {
            let whiteners = self.problem.whiteners(&self.own_level);
            let residuals = self.problem.whitened_together(&alike, &whiteners);
            for (&k, r) in places.iter().zip(&residuals) {
                judged[k].1 = judged[k].1.max(self.own.gain_along(r));
            }
        }
        judged
    }

    fn predictions(&self, hypothesis: &Hypothesis, p: &[f64]) -> Option<Columns> {
        let motor = hypothesis.motor(self.problem.nominal, p);
        let runs = self.problem.runs.iter();
        runs.map(|run| predict(&motor, run, &self.problem.effort))
            .collect()
    }

    /// Those of many starts: of motors that move alike, one after the other, from one simulation.
    fn predictions_of(&self, starts: &[Start]) -> Vec<Option<Columns>> {
        let nominal = self.problem.nominal;
        let motors = starts
            .iter()
            .map(|(hypothesis, p)| hypothesis.motor(nominal, p));
        let motors: Vec<Motor> = motors.collect();
        let alike: Vec<&[Motor]> = motors.chunk_by(move_alike).collect();
        let predicted = |motors: &[Motor]| {
            let runs = self.problem.runs.iter();
            let of_runs: Option<Vec<Columns>> = runs
                .map(|run| predict_alike(motors, run, &self.problem.effort))
                .collect();
            let Some(of_runs) = of_runs else {
                return vec![None; motors.len()];
            };
            let mut of_motors = vec![Columns::new(); motors.len()];
            for of_run in of_runs {
                for (of_motor, column) in of_motors.iter_mut().zip(of_run) {
                    of_motor.push(column);
                }
            }
            of_motors.into_iter().map(Some).collect()
        };
        alike
            .into_par_iter()
            .with_max_len(1)
            .flat_map_iter(predicted)
            .collect()
    }

    /// Where it looks from, and on which level of the noise.
    pub fn anchor(&self) -> Option<(&Anchor, &NoiseLevel)> {
        Some((self.anchors.first()?, &self.level))
    }

    /// What a start takes off the whitened residual there.
    pub fn taken_off(&self, (hypothesis, p): &Start) -> Option<Vec<f64>> {
        let anchor = self.anchors.first()?;
        let mut at_anchor = p.clone();
        at_anchor[..BASE].copy_from_slice(&anchor.p[..BASE]);
        let predictions = self.predictions(hypothesis, &at_anchor)?;
        let whiteners = self.problem.whiteners(&self.level);
        let mut r = self.problem.whitened(&predictions, &whiteners);
        for (r, before) in r.iter_mut().zip(&anchor.residual) {
            *r = before - *r;
        }
        Some(r)
    }
}

fn determinants(whiteners: &[Whitener]) -> f64 {
    whiteners.iter().map(|w| w.log_determinant).sum()
}

#[cfg(test)]
mod tests {
    use super::super::samples::{fit, index, motor_with, problem, ready, recording};
    use super::*;

    /// What a regression promises against what a fit then takes off: twice the gain in log-likelihood.
    #[test]
    fn an_effect_that_is_there_promises_what_its_fit_keeps_and_one_that_is_not_promises_little() {
        let drag = ("quadratic_drag", &[1e-3][..]);
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[drag])));
        let problem = problem(&nominal, &runs);
        let level = problem.levels.len() - 1;
        let without = fit(&problem, &[]);
        let with = fit(&problem, &[drag]);
        let kept = 2.0 * (with.log_evidence - without.log_evidence);
        let search = Search::new(&problem, &without, level).expect("it can be simulated");
        let promise = search.prospect(index(drag.0), None).promise;
        assert!(
            promise > 0.5 * kept && kept > 30.0,
            "{promise}, kept {kept}"
        );
        // Beside what is there, what is not.
        let search = Search::new(&problem, &with, level).expect("it can be simulated");
        for absent in ["load_friction", "supply_sag", "asymmetric_friction"] {
            let promise = search.prospect(index(absent), None).promise;
            assert!(promise < 9.0, "{absent}: {promise}");
        }
    }

    /// Noise of its own is no column: its promise is what the likelihood gains.
    #[test]
    fn late_samples_promise_what_they_explain_and_nothing_where_there_are_none() {
        let late = ("sample_jitter", &[2e-3][..]);
        let nominal = motor_with(&[]);
        let promise = |there: &[(&str, &[f64])]| {
            let runs = ready(&recording(&motor_with(there)));
            let problem = problem(&nominal, &runs);
            let level = problem.levels.len() - 1;
            let without = fit(&problem, &[]);
            let search = Search::new(&problem, &without, level).expect("it can be simulated");
            search.prospect(index(late.0), None).promise
        };
        let there = promise(&[late]);
        assert!(there > 30.0 && there.is_finite(), "{there}");
        assert!(promise(&[]) < 9.0);
    }

    /// In long runs starts are scored a few at a time: to the bit what they leave all at once.
    #[test]
    fn a_few_starts_at_a_time_leave_what_they_leave_all_at_once() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let without = fit(&problem, &[]);
        let search = Search::new(&problem, &without, 1).expect("it can be simulated");
        for id in ["compliance", "missed_counts", "quadratic_drag"] {
            let kind = &catalogue()[index(id)];
            let values = search.tried(0, kind, None, &Found::default());
            let anchor = &search.anchors[0];
            let start = |values| search.start(anchor, index(id), values, [0.0; BASE]);
            let starts: Vec<Start> = values.into_iter().map(start).collect();
            let few = starts.chunks(LEAST_AT_ONCE);
            let few: Vec<(f64, f64)> = few.flat_map(|some| search.judged(0, some)).collect();
            assert!(few.iter().all(|(left, _)| left.is_finite()), "{id}");
            assert_eq!(few, search.judged(0, &starts), "{id}");
        }
    }

    /// Beside a base that is not bent all of a small grid is tried, of a large one the best of what was tried beside the fit.
    #[test]
    fn of_a_large_grid_the_best_are_tried_beside_a_base_that_is_not_bent() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let without = fit(&problem, &[]);
        let search = Search::new(&problem, &without, 1).expect("it can be simulated");
        for (id, first, second) in [
            ("compliance", 64, STARTS),
            ("quadratic_drag", 6, 6),
            ("missed_counts", 16, 16),
        ] {
            let kind = &catalogue()[index(id)];
            let mut found = Found::default();
            let all = search.tried(0, kind, None, &found);
            search.judge(0, index(id), all.clone(), &mut found);
            let then = search.tried(1, kind, None, &found);
            assert_eq!((all.len(), then.len()), (first, second), "{id}");
            let left = |values: &Values| {
                let of_values = |(_, start): &&(f64, Start)| {
                    let member = start.0.members.last();
                    member.is_some_and(|member| member.values == *values)
                };
                let found = found.scored.iter().find(of_values);
                found.map_or(f64::NAN, |(left, _)| *left)
            };
            let worst = then.iter().map(left).fold(f64::NEG_INFINITY, f64::max);
            let others = all.iter().filter(|values| !then.contains(values));
            assert!(
                others.into_iter().all(|values| left(values) >= worst),
                "{id}"
            );
        }
    }
}
