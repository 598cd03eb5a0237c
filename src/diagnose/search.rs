//! Where fits of an effect start.
//!
//! A fit by least squares finds the nearest hollow; these searches find the right one. Every effect is
//! tried over a grid of its plausible range, and the starts that leave least, after the base model has
//! given way linearly, are fitted. Effects that repeat with the angle have a search of their own (`periodic`).

use rayon::prelude::*;

use super::anchor::Anchor;
use super::data::RunData;
use super::fit::Fit;
use super::hypothesis::{BASE, Hypothesis, Member, is_limited};
use super::noise::{NoiseLevel, Whitener};
use super::periodic::{is_scanned, periodic};
use super::predict::predict;
use super::problem::{Columns, Problem};
use super::prospect::Prospect;
use crate::motor::Motor;
use crate::motor::effects::{EffectParameter, Prior, catalogue, find};
use crate::recording::CommandKind;

/// How many starts of an effect are fitted.
const STARTS: usize = 3;
/// How many of one that goes in steps.
const STEPPED_STARTS: usize = 6;
/// Reversing brakes with up to twice of what the command asks for; this many times it is none of the command's doing.
const FAR_LARGER: f64 = 4.0;
/// How many orders of an angle-periodic effect are fitted.
pub(super) const ORDERS: usize = 4;

/// Limits of the edge rate to try, as shares of the fastest that was counted (smoothed, so that it may be higher).
const RATES: [f64; 12] = [
    0.80, 0.86, 0.92, 0.97, 1.0, 1.03, 1.06, 1.1, 1.15, 1.2, 1.3, 1.4,
];

/// Most thresholds of a dead zone to try, and how far from that of a fit to try all.
const MOST_THRESHOLDS: usize = 40;
const NEARBY: f64 = 1.25;

/// Frequencies to try, as shares of the logarithm of their range: a resonance is some damping ratios wide.
const RESONANCES: [f64; 8] = [0.04, 0.16, 0.28, 0.4, 0.52, 0.64, 0.76, 0.9];

/// By how much less than the least of its range an effect does next to nothing.
const NEXT_TO_NOTHING: f64 = 5.0;

/// Squares of the prior's standard deviations from which on a base counts as bent.
const STRAINED: f64 = 6.0;

/// Farthest that a regression moves a number of the base before the fit.
const WIDEST_SHIFT: f64 = 0.2;

/// Values of an effect to try: what they leave where that is known, the values, by how much the base moves.
pub(super) type Try = (Option<f64>, Vec<f64>, [f64; BASE]);

fn unrated(values: Vec<Vec<f64>>) -> Vec<Try> {
    values
        .into_iter()
        .map(|values| (None, values, [0.0; BASE]))
        .collect()
}

/// A hypothesis and where its fit starts.
pub(super) type Start = (Hypothesis, Vec<f64>);

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
        let mut scored: Vec<(f64, Start)> = Vec::new();
        let before = self.anchors.first().map_or(0.0, |anchor| anchor.left);
        let mut promise: f64 = 0.0;
        for (place, anchor) in self.anchors.iter().enumerate() {
            let tried: Vec<Try> = match kind.id {
                "cogging" | "torque_ripple" | "gravity_load" | "encoder_eccentricity" => {
                    periodic(self.problem, &self.level, anchor, index, kind.id)
                }
                "dead_zone" => {
                    let mut values = self.thresholds(None);
                    if let Some(known) = known {
                        values.extend(self.thresholds(known.first().copied()));
                    }
                    unrated(values)
                }
                "missed_counts" => {
                    let mut values = self.grid(kind.parameters);
                    values.extend(self.fastest_rates());
                    unrated(values)
                }
                _ if self.members.iter().any(is_limited) => {
                    let mut values = self.grid(kind.parameters);
                    values.push(self.next_to_nothing(kind.parameters));
                    unrated(values)
                }
                _ => unrated(self.grid(kind.parameters)),
            };
            let mut unrated: Vec<Start> = Vec::new();
            for (rating, values, base) in tried {
                let mut members = self.members.clone();
                members.push(Member { index, values });
                let nominal = self.problem.nominal;
                let hypothesis = Hypothesis::new(nominal, members, &self.problem.setting);
                let mut start = hypothesis.start();
                start[..anchor.p.len()].copy_from_slice(&anchor.p);
                for (value, shift) in start.iter_mut().zip(base) {
                    *value += shift.clamp(-WIDEST_SHIFT, WIDEST_SHIFT);
                }
                hypothesis.clamp(&mut start);
                match rating {
                    Some(rating) => {
                        promise = promise.max(before - rating);
                        scored.push((rating, (hypothesis, start)));
                    }
                    None => unrated.push((hypothesis, start)),
                }
            }
            for ((cost, promised), start) in self.judged(place, &unrated).into_iter().zip(unrated) {
                promise = promise.max(promised);
                scored.push((cost, start));
            }
        }
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        scored.truncate(match kind.id {
            id if is_scanned(id) => ORDERS,
            "resolution_error" | "dead_zone" | "missed_counts" => STEPPED_STARTS,
            _ => STARTS,
        });
        let starts = scored.into_iter().map(|(_, start)| start).collect();
        Prospect {
            index,
            starts,
            promise,
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
        let simulated: Vec<Option<Columns>> = starts
            .par_iter()
            .with_max_len(1)
            .map(|(hypothesis, p)| self.predictions(hypothesis, p))
            .collect();
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
            judged[k] = (
                anchor.left_over(&r, p) + determinants(&whiteners),
                f64::INFINITY,
            );
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

    /// A grid over the plausible range: four values of the first number, eight of a frequency, two of the others.
    fn grid(&self, parameters: &[EffectParameter]) -> Vec<Vec<f64>> {
        let (setting, motor) = (&self.problem.setting, &self.problem.nominal.parameters);
        let mut points = vec![Vec::new()];
        for (k, parameter) in parameters.iter().enumerate() {
            let (lo, hi) = setting.range(parameter, motor);
            let shares: &[f64] = match (k, parameters.len()) {
                (0, 1) => &[0.03, 0.15, 0.3, 0.5, 0.7, 0.9],
                (0, _) if parameter.unit == "Hz" => &RESONANCES,
                (0, _) => &[0.1, 0.35, 0.6, 0.9],
                _ => &[0.2, 0.7],
            };
            let values: Vec<f64> = match parameter.prior {
                Prior::OneOf(values) => {
                    let stated = self.problem.nominal.parameters.get(parameter.key);
                    let others = values.iter().copied().filter(|v| Some(*v) != stated);
                    others.collect()
                }
                Prior::Phase => [0.0, 0.5, 1.0, 1.5]
                    .map(|x| x * std::f64::consts::PI)
                    .to_vec(),
                _ if hi <= lo => {
                    vec![setting.default(parameter, motor)]
                }
                Prior::LogUniform => shares.iter().map(|s| lo * (hi / lo).powf(*s)).collect(),
                Prior::Uniform => shares.iter().map(|s| lo + (hi - lo) * s).collect(),
            };
            points = points
                .into_iter()
                .flat_map(|point: Vec<f64>| {
                    values.iter().map(move |value| {
                        let mut point = point.clone();
                        point.push(*value);
                        point
                    })
                })
                .collect();
        }
        points
    }

    /// Values at which an effect does next to nothing. Beside edges that are lost above a rate a larger one moves the speed
    /// across that rate, and what is left is no longer what the fit before had found.
    fn next_to_nothing(&self, parameters: &[EffectParameter]) -> Vec<f64> {
        let (setting, motor) = (&self.problem.setting, &self.problem.nominal.parameters);
        let value = |(k, parameter): (usize, &EffectParameter)| {
            let (lo, hi) = setting.range(parameter, motor);
            match parameter.neutral(&setting.measures(motor)) {
                Some((neutral, _)) => neutral,
                None if k == 0 && hi > lo && parameter.prior == Prior::LogUniform => {
                    lo / NEXT_TO_NOTHING
                }
                None if k == 0 => lo,
                None => setting.default(parameter, motor),
            }
        };
        parameters.iter().enumerate().map(value).collect()
    }

    /// A dead zone swallows whole levels of the command: only which ones matters. Tried are the gaps between
    /// levels, in a ramp of many levels every so many; all of them near the value of a fit.
    fn thresholds(&self, near: Option<f64>) -> Vec<Vec<f64>> {
        let (lo, hi) = match near {
            Some(value) => (value / NEARBY, value * NEARBY),
            None => (0.05, 3.0),
        };
        let commands = self.problem.runs.iter().flat_map(|run| &run.command);
        let mut levels: Vec<f64> = commands.map(|u| u.abs()).filter(|u| *u > 0.0).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let between = levels.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let last = levels.last().map(|level| level * 1.05);
        let gaps: Vec<f64> = between
            .chain(last)
            .filter(|v| (lo..=hi).contains(v))
            .collect();
        let every = gaps.len().div_ceil(MOST_THRESHOLDS).max(1);
        gaps.into_iter().step_by(every).map(|v| vec![v]).collect()
    }

    /// Edges that come too fast are lost: then the fastest that were counted tell the limit.
    fn fastest_rates(&self) -> Vec<Vec<f64>> {
        let top = self.problem.runs.iter().map(|run| run.top_speed_counts_s);
        let top = top.fold(0.0, f64::max);
        RATES.iter().map(|share| vec![0.0, share * top]).collect()
    }
}

fn determinants(whiteners: &[Whitener]) -> f64 {
    whiteners.iter().map(|w| w.log_determinant).sum()
}

/// Rate at which a speed error of this motor dies away, 1/s, as its terminals are driven.
pub(super) fn damping_of(motor: &Motor, kind: CommandKind) -> f64 {
    let p = &motor.parameters;
    let coupling = match kind {
        CommandKind::Voltage => {
            p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm
        }
        _ => 0.0,
    };
    (p.viscous_friction_nm_s_per_rad + coupling) / p.inertia_kg_m2
}

/// Largest acceleration that the commands of the runs ask for, in counts/s^2; the recorded one where that is far larger: a
/// shaft that swings or coasts with hardly a command.
pub(super) fn largest_acceleration(motor: &Motor, runs: &[RunData]) -> f64 {
    let p = &motor.parameters;
    let largest = runs.iter().map(|run| {
        let command = run.command.iter().fold(0.0, |m, u| f64::max(m, u.abs()));
        let torque = match run.kind {
            CommandKind::Voltage => command * p.torque_constant_nm_per_a / p.resistance_ohm,
            CommandKind::Current => command * p.torque_constant_nm_per_a,
            CommandKind::Torque => command,
        };
        torque / p.inertia_kg_m2 * run.counts_per_rev / std::f64::consts::TAU
    });
    let asked = largest.fold(1.0, f64::max);
    let recorded = runs.iter().map(RunData::largest_acceleration);
    let recorded = recorded.fold(0.0, f64::max);
    if recorded > FAR_LARGER * asked {
        recorded
    } else {
        asked
    }
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
}
