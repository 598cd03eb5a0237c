//! Where fits of an effect start.
//!
//! A fit by least squares finds the nearest hollow; these searches find the right one. Every effect is
//! tried over a grid of its plausible range, and the starts that leave least, after the base model has
//! given way linearly, are fitted. For effects that repeat with the angle a grid would miss the order and
//! the phase: there the recorded angle itself is known to a count, so that an acceleration
//! `A sin(N theta) + B cos(N theta)` is linear in `A` and `B`, and every order is tried in one regression.

use nalgebra::{DMatrix, DVector};

use super::data::RunData;
use super::fit::{Fit, Problem};
use super::hypothesis::{BASE, Hypothesis, Member, predict};
use super::noise::{NoiseLevel, response};
use crate::motor::Motor;
use crate::motor::effects::{EffectParameter, Prior, catalogue};
use crate::recording::CommandKind;

/// How many starts of an effect are fitted.
const STARTS: usize = 3;
/// How many orders of an angle-periodic effect are fitted.
const ORDERS: usize = 4;

/// Squares of the prior's standard deviations from which on a base counts as bent.
const STRAINED: f64 = 6.0;

/// Farthest that a regression moves a number of the base before the fit.
const WIDEST_SHIFT: f64 = 0.2;

/// Values of an effect to try: what they leave where that is known, the values, by how much the base moves.
type Try = (Option<f64>, Vec<f64>, [f64; BASE]);

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
}

/// A point around which the base gives way linearly.
struct Anchor {
    hypothesis: Hypothesis,
    p: Vec<f64>,
    /// Whitened residual and base columns there.
    residual: Vec<f64>,
    base: Vec<Vec<f64>>,
}

impl Anchor {
    fn new(problem: &Problem<'_>, fit: &Fit) -> Option<Self> {
        Some(Self {
            hypothesis: fit.hypothesis.clone(),
            p: fit.p.clone(),
            residual: problem.innovations(fit),
            base: problem.base_jacobian(fit)?,
        })
    }
}

impl<'a> Search<'a> {
    /// Looks from `fit` on; `None` where that cannot be simulated.
    pub fn new(problem: &'a Problem<'a>, fit: &Fit) -> Option<Self> {
        // Short horizons: the search must not depend on what happened seconds ago.
        let strongest = problem.levels.get(1).or(problem.levels.first()).copied()?;
        let mut at_level = fit.clone();
        at_level.wander = strongest;
        let mut anchors = vec![Anchor::new(problem, &at_level)?];
        // A base that bent itself far to explain an effect is a bad place to look for it from.
        if fit.hypothesis.members.is_empty() && fit.hypothesis.strain(&fit.p) > STRAINED {
            let start = fit.hypothesis.start();
            let nominal = problem.fit_at(&fit.hypothesis, &start, strongest, 0);
            anchors.extend(nominal.and_then(|fit| Anchor::new(problem, &fit)));
        }
        Some(Self {
            problem,
            members: fit.hypothesis.members.clone(),
            level: problem.noise(&fit.hypothesis, &fit.p, strongest),
            anchors,
        })
    }

    /// The most promising hypotheses with effect `index` added, each with its starting numbers, and what
    /// the best of them leaves (less is better; of use beside other effects' only).
    pub fn starts(&self, index: usize) -> (f64, Vec<Start>) {
        let kind = &catalogue()[index];
        let mut scored: Vec<(f64, Hypothesis, Vec<f64>)> = Vec::new();
        for anchor in &self.anchors {
            let tried: Vec<Try> = match kind.id {
                "cogging" | "torque_ripple" | "gravity_load" | "encoder_eccentricity" => {
                    self.periodic(anchor, index, kind.id)
                }
                "dead_zone" => unrated(self.thresholds()),
                _ => unrated(self.grid(kind.parameters)),
            };
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
                let cost = rating.or_else(|| self.cost(anchor, &hypothesis, &start));
                scored.push((cost.unwrap_or(f64::INFINITY), hypothesis, start));
            }
        }
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        scored.truncate(if is_scanned(kind.id) { ORDERS } else { STARTS });
        let best = scored.first().map_or(f64::INFINITY, |first| first.0);
        (best, scored.into_iter().map(|(_, h, p)| (h, p)).collect())
    }

    /// What is left on short horizons after the base has given way linearly.
    fn cost(&self, anchor: &Anchor, hypothesis: &Hypothesis, start: &[f64]) -> Option<f64> {
        let motor = hypothesis.motor(self.problem.nominal, start);
        let level = NoiseLevel {
            wander: self.level.wander,
            ..self.problem.noise(hypothesis, start, self.level.wander)
        };
        let whiteners = self.problem.whiteners(&level);
        let mut r = Vec::with_capacity(anchor.residual.len());
        let mut determinants = 0.0;
        for (run, whitener) in self.problem.runs.iter().zip(whiteners.iter()) {
            let x = predict(&motor, run)?;
            let mut column: Vec<f64> = run
                .counts
                .iter()
                .zip(&x)
                .map(|(n, x)| n - x - 0.5)
                .collect();
            whitener.whiten(&mut column);
            r.extend(column);
            determinants += whitener.log_determinant;
        }
        Some(left_over(&r, &anchor.base, hypothesis, start) + determinants)
    }

    /// A grid over the plausible range: four values of the first number, two of the others.
    fn grid(&self, parameters: &[EffectParameter]) -> Vec<Vec<f64>> {
        let (setting, motor) = (&self.problem.setting, &self.problem.nominal.parameters);
        let mut points = vec![Vec::new()];
        for (k, parameter) in parameters.iter().enumerate() {
            let (lo, hi) = setting.range(parameter, motor);
            let shares: &[f64] = match (k, parameters.len()) {
                (0, 1) => &[0.03, 0.15, 0.3, 0.5, 0.7, 0.9],
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

    /// A dead zone swallows whole levels of the command: only which ones matters.
    fn thresholds(&self) -> Vec<Vec<f64>> {
        let mut levels: Vec<f64> = self
            .problem
            .runs
            .iter()
            .flat_map(|run| run.command.iter().map(|u| u.abs()))
            .filter(|u| *u > 0.0)
            .collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let most = 24;
        let every = levels.len().div_ceil(most).max(1);
        let chosen: Vec<f64> = levels.iter().copied().step_by(every).collect();
        let (lo, hi) = (0.05, 3.0);
        let between = chosen.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let last = chosen.last().map(|level| level * 1.05);
        between
            .chain(last)
            .filter(|v| (lo..=hi).contains(v))
            .map(|v| vec![v])
            .collect()
    }

    /// Effects that repeat with the angle: order by order, amplitude and phase by regression.
    fn periodic(&self, anchor: &Anchor, index: usize, id: &str) -> Vec<Try> {
        let orders: Vec<f64> = match id {
            "gravity_load" | "encoder_eccentricity" => vec![1.0],
            _ => (8..=120).map(|quarter| f64::from(quarter) * 0.25).collect(),
        };
        let motor = &self.problem.nominal.parameters;
        let whiteners = self.problem.whiteners(&self.level);
        let mut found: Vec<Try> = Vec::new();
        for order in orders {
            let mut columns = [Vec::new(), Vec::new()];
            for (run, whitener) in self.problem.runs.iter().zip(whiteners.iter()) {
                for (column, quarter) in columns.iter_mut().zip([0.0, 0.25]) {
                    let shift = quarter * std::f64::consts::TAU;
                    let mut one = wave(self.problem, run, id, order, shift);
                    whitener.whiten(&mut one);
                    column.extend(one);
                }
            }
            let Some((gain, shift, [a, b])) = regress(&anchor.residual, anchor, &columns) else {
                continue;
            };
            // a sin(x) + b sin(x + pi/2) = c sin(x + phase).
            let (amplitude, phase) = (a.hypot(b), b.atan2(a));
            let values = match id {
                "cogging" => vec![amplitude * motor.inertia_kg_m2, order, phase],
                "torque_ripple" => vec![amplitude.min(0.5), order, phase],
                // Gravity opposes: torque sin(theta + phase) is taken away.
                "gravity_load" => vec![
                    amplitude * motor.inertia_kg_m2,
                    phase + std::f64::consts::PI,
                ],
                _ => vec![amplitude, phase],
            };
            found.push((Some(-gain), values, shift));
        }
        let found = peaks(found, id);
        let parameters = catalogue()[index].parameters;
        found
            .into_iter()
            .map(|(rating, mut values, shift)| {
                for (value, parameter) in values.iter_mut().zip(parameters) {
                    if parameter.prior == Prior::Phase {
                        *value = value.rem_euclid(std::f64::consts::TAU);
                    } else {
                        let (lo, hi) = self.problem.setting.range(parameter, motor);
                        *value = value.clamp(0.5 * lo, 1.5 * hi);
                    }
                }
                (rating, values, shift)
            })
            .collect()
    }
}

/// Whether an effect's order is unknown: beside the right one the objective has many hollows.
pub(super) fn is_scanned(id: &str) -> bool {
    matches!(id, "cogging" | "torque_ripple")
}

/// The best orders that are not neighbours of a better one.
fn peaks(mut found: Vec<Try>, id: &str) -> Vec<Try> {
    found.sort_by(|a, b| f64::total_cmp(&a.0.unwrap_or(0.0), &b.0.unwrap_or(0.0)));
    let mut kept: Vec<Try> = Vec::new();
    for one in found {
        let apart = |other: &Try| !is_scanned(id) || (other.1[1] - one.1[1]).abs() > 0.4;
        if kept.len() < ORDERS && kept.iter().all(apart) {
            kept.push(one);
        }
    }
    kept
}

/// The answer of the position in counts to a unit of an angle-periodic effect of this order and phase.
fn wave(problem: &Problem<'_>, run: &RunData, id: &str, order: f64, shift: f64) -> Vec<f64> {
    let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
    let sine = |k: usize| (order * run.counts[k] / counts_per_rad + shift).sin();
    if id == "encoder_eccentricity" {
        return (0..run.len())
            .map(|k| (sine(k) - sine(0)) * counts_per_rad)
            .collect();
    }
    let p = &problem.nominal.parameters;
    let torque = |k: usize| match (id, run.kind) {
        ("torque_ripple", CommandKind::Voltage) => {
            let speed = run.speed_counts_s[k] / counts_per_rad;
            let (kt, kb, r) = (
                p.torque_constant_nm_per_a,
                p.back_emf_v_s_per_rad,
                p.resistance_ohm,
            );
            kt * (run.command[k] - 2.0 * kb * speed) / (r * p.inertia_kg_m2)
        }
        ("torque_ripple", CommandKind::Current) => {
            p.torque_constant_nm_per_a * run.command[k] / p.inertia_kg_m2
        }
        ("torque_ripple", CommandKind::Torque) => run.command[k] / p.inertia_kg_m2,
        _ => 1.0,
    };
    let acceleration: Vec<f64> = (0..run.len())
        .map(|k| sine(k) * torque(k) * counts_per_rad)
        .collect();
    response(run, problem.damping, &acceleration)
}

/// What is left of `r` in squares after the base has given way linearly, at the price of its prior.
fn left_over(r: &[f64], base: &[Vec<f64>], hypothesis: &Hypothesis, p: &[f64]) -> f64 {
    let d = base.len();
    let mut normal = DMatrix::from_fn(d, d, |i, j| {
        dot(&base[i], &base[j]) + hypothesis.precision(i, j)
    });
    let mut priced = dot(r, r);
    let right = DVector::from_fn(d, |i, _| {
        let pull: f64 = (0..d).map(|j| hypothesis.precision(i, j) * p[j]).sum();
        priced += p[i] * pull;
        dot(&base[i], r) - pull
    });
    for k in 0..d {
        normal[(k, k)] += 1e-9 * normal[(k, k)] + 1e-12;
    }
    match normal.cholesky() {
        Some(cholesky) => priced - cholesky.solve(&right).dot(&right),
        None => priced,
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// By how many squares two more columns help beside the base, the base's coefficients, and theirs.
fn regress(
    r: &[f64],
    anchor: &Anchor,
    columns: &[Vec<f64>; 2],
) -> Option<(f64, [f64; BASE], [f64; 2])> {
    let before = solve(r, &anchor.base, anchor).map_or(0.0, |(gain, _)| gain);
    let all: Vec<Vec<f64>> = anchor.base.iter().chain(columns).cloned().collect();
    let (gain, x) = solve(r, &all, anchor)?;
    let shift = std::array::from_fn(|k| x[k]);
    Some((gain - before, shift, [x[BASE], x[BASE + 1]]))
}

/// Least squares with the base's prior and a little ridge: the squares that the columns explain, and their
/// coefficients, the base's first.
fn solve(r: &[f64], columns: &[Vec<f64>], anchor: &Anchor) -> Option<(f64, DVector<f64>)> {
    let d = columns.len();
    let precision = |i: usize, j: usize| {
        if i < BASE && j < BASE {
            anchor.hypothesis.precision(i, j)
        } else {
            0.0
        }
    };
    let mut normal = DMatrix::from_fn(d, d, |i, j| dot(&columns[i], &columns[j]) + precision(i, j));
    for k in 0..d {
        normal[(k, k)] += 1e-9 * normal[(k, k)] + 1e-12;
    }
    let right = DVector::from_fn(d, |k, _| {
        let pull: f64 = (0..BASE).map(|j| precision(k, j) * anchor.p[j]).sum();
        dot(&columns[k], r) - pull
    });
    let x = normal.cholesky()?.solve(&right);
    Some((x.dot(&right), x))
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

/// Largest acceleration that the commands of the runs ask for, in counts/s^2.
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
    largest.fold(1.0, f64::max)
}
