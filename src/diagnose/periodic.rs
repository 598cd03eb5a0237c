//! Where fits of effects that repeat with the angle start: orders, amplitudes and phases by regression.
//!
//! The recorded angle is known to a count, so that an acceleration `A sin(N theta) + B cos(N theta)` is linear in
//! `A` and `B`, and every order `N` is tried in one regression beside the base.

use std::sync::Arc;

use rayon::prelude::*;

use super::anchor::Anchor;
use super::data::RunData;
use super::hypothesis::BASE;
use super::kept::Kept;
use super::kept_filters::Filters;
use super::noise::{Carried, NoiseLevel};
use super::problem::Problem;
use super::response::Response;
use super::rivals::catalogue;
use super::search::{ORDERS, Try};
use super::sums::{dot, gram};
use crate::motor::catalogue::Prior;
use crate::recording::CommandKind;

/// The best of all orders gains this in squares where there is none.
const LEAST_GAIN: f64 = 10.0;

/// A wave's sine and cosine.
type Pair = [Vec<f64>; 2];

/// Waves that were made.
#[derive(Debug, Default)]
pub(super) struct KeptWaves {
    /// Whitened, by the wander's level, the effect and the order.
    whitened: Kept<(u64, &'static str, u64), Pair>,
    /// Sine and cosine of the recorded angle in counts, by the order.
    plain: Kept<u64, Pair>,
}

/// The answers of the runs to angle-periodic torques, whitened.
pub(super) struct Waves<'a> {
    problem: &'a Problem<'a>,
    whiteners: Filters,
    /// Whether the runs are short enough to keep their waves.
    is_short: bool,
    /// The level of the wander, where they are and there is no other noise.
    kept_at: Option<f64>,
}

impl<'a> Waves<'a> {
    /// On this level of the noise.
    pub fn new(problem: &'a Problem<'a>, level: &NoiseLevel) -> Self {
        let is_short = problem.keeps_columns();
        Self {
            problem,
            whiteners: problem.whiteners(level),
            is_short,
            kept_at: (is_short && level.is_shared()).then_some(level.wander),
        }
    }

    /// Sine and cosine of an order of this effect, all runs end to end.
    pub fn columns(&self, id: &'static str, order: f64) -> Arc<Pair> {
        let Some(level) = self.kept_at else {
            return Arc::new(self.made(id, order));
        };
        let key = (level.to_bits(), id, order.to_bits());
        self.problem.waves.whitened.of(key, || self.made(id, order))
    }

    fn made(&self, id: &str, order: f64) -> Pair {
        let mut columns = [Vec::new(), Vec::new()];
        let mut carried = [Carried::default(); 2];
        let turning = || turning(self.problem.runs, order);
        let turning = if self.is_short {
            self.problem.waves.plain.of(order.to_bits(), turning)
        } else {
            Arc::new(turning())
        };
        let runs = self.problem.runs.iter();
        let mut from = 0;
        for ((run, response), whitener) in runs
            .zip(self.problem.responses.iter())
            .zip(self.whiteners.iter())
        {
            let of_run = turning.each_ref().map(|wave| &wave[from..from + run.len()]);
            from += run.len();
            let mut waves = waves(self.problem, run, response, id, of_run);
            whitener.whiten_all_on(&mut carried, &mut waves);
            for (column, wave) in columns.iter_mut().zip(waves) {
                column.extend(wave);
            }
        }
        columns
    }

    /// Values of effect `index` whose wave of this order has these coefficients of sine and cosine.
    pub fn values(&self, index: usize, order: f64, [a, b]: [f64; 2]) -> Vec<f64> {
        let kind = &catalogue()[index];
        let motor = &self.problem.nominal.parameters;
        // a sin(x) + b sin(x + pi/2) = c sin(x + phase).
        let (amplitude, phase) = (a.hypot(b), b.atan2(a));
        let mut values = match kind.id {
            "cogging" => vec![amplitude * motor.inertia_kg_m2, order, phase],
            "torque_ripple" => vec![amplitude.min(0.5), order, phase],
            // Gravity opposes: torque sin(theta + phase) is taken away.
            "gravity_load" => vec![
                amplitude * motor.inertia_kg_m2,
                phase + std::f64::consts::PI,
            ],
            _ => vec![amplitude, phase],
        };
        for (value, parameter) in values.iter_mut().zip(kind.parameters) {
            if parameter.prior == Prior::Phase {
                *value = value.rem_euclid(std::f64::consts::TAU);
            } else {
                let (lo, hi) = self.problem.setting.range(parameter, motor);
                *value = value.clamp(0.5 * lo, 1.5 * hi);
            }
        }
        values
    }
}

/// The orders to try of an effect that repeats with the angle; none of another.
pub(super) fn orders(id: &str) -> Vec<f64> {
    match id {
        "gravity_load" | "encoder_eccentricity" => vec![1.0],
        _ if is_scanned(id) => (8..=120).map(|quarter| f64::from(quarter) * 0.25).collect(),
        _ => Vec::new(),
    }
}

/// Whether an effect repeats with the angle.
pub(super) fn repeats(id: &str) -> bool {
    !orders(id).is_empty()
}

/// Effects that repeat with the angle: order by order, amplitude and phase by regression.
pub(super) fn periodic(
    problem: &Problem<'_>,
    level: &NoiseLevel,
    anchor: &Anchor,
    index: usize,
    id: &'static str,
) -> Vec<Try> {
    let waves = Waves::new(problem, level);
    let regression = Regression::new(anchor);
    let found = orders(id).into_par_iter().filter_map(|order| {
        let columns = waves.columns(id, order);
        let (gain, shift, coefficients) = regression.with(&columns)?;
        if is_scanned(id) && gain < LEAST_GAIN {
            return None;
        }
        let values = waves.values(index, order, coefficients);
        Some((anchor.left - gain, values, shift))
    });
    let found: Vec<Try> = found.collect();
    peaks(found, id)
}

/// Whether an effect's order is unknown: beside the right one the objective has many hollows.
pub(super) fn is_scanned(id: &str) -> bool {
    matches!(id, "cogging" | "torque_ripple")
}

/// Whether an effect is a torque that repeats with the angle: a simulated angle that is off by a part of a period there is driven
/// farther off, so that long runs have many hollows.
pub(super) fn parts(id: &str) -> bool {
    is_scanned(id) || id == "gravity_load"
}

/// The best orders that are not neighbours of a better one.
fn peaks(mut found: Vec<Try>, id: &str) -> Vec<Try> {
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<Try> = Vec::new();
    for one in found {
        let apart = |other: &Try| !is_scanned(id) || (other.1[1] - one.1[1]).abs() > 0.4;
        if kept.len() < ORDERS && kept.iter().all(apart) {
            kept.push(one);
        }
    }
    kept
}

/// Sine and cosine of the recorded angle times an order, in counts, all runs end to end.
fn turning(runs: &[RunData], order: f64) -> Pair {
    let waves = runs.iter().flat_map(|run| {
        let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
        run.counts.iter().map(move |counts| {
            let (sine, cosine) = (order * (run.first_counts + counts) / counts_per_rad).sin_cos();
            (sine * counts_per_rad, cosine * counts_per_rad)
        })
    });
    waves.unzip::<f64, f64, Vec<f64>, Vec<f64>>().into()
}

/// The answers of the position in counts to a unit of an angle-periodic effect, from the sine and cosine of its order.
fn waves(
    problem: &Problem<'_>,
    run: &RunData,
    response: &Response,
    id: &str,
    turning: [&[f64]; 2],
) -> Pair {
    if id == "encoder_eccentricity" {
        return turning.map(|wave| {
            let first = wave.first().copied().unwrap_or(0.0);
            wave.iter().map(|x| x - first).collect()
        });
    }
    let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
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
    turning.map(|wave| {
        let torques = wave.iter().enumerate().map(|(k, value)| value * torque(k));
        response.to(&torques.collect::<Vec<f64>>())
    })
}

/// Least squares of the residual by the base, with its prior and a little ridge, and by two more columns.
struct Regression<'a> {
    anchor: &'a Anchor,
    /// Squares that the base alone explains.
    gain: f64,
}

impl<'a> Regression<'a> {
    fn new(anchor: &'a Anchor) -> Self {
        let solved = anchor.factor.as_ref().map(|c| c.solve(&anchor.right));
        Self {
            gain: solved.map_or(0.0, |x| x.dot(&anchor.right)),
            anchor,
        }
    }

    /// By how many squares the columns help beside the base, the base's coefficients, and theirs.
    fn with(&self, columns: &[Vec<f64>; 2]) -> Option<(f64, [f64; BASE], [f64; 2])> {
        let d = self.anchor.base.len();
        let mut normal = self.anchor.normal.clone().resize(d + 2, d + 2, 0.0);
        let right = self.anchor.right.clone();
        let mut right = right.resize_vertically(d + 2, 0.0);
        for (m, column) in columns.iter().enumerate() {
            for (k, base) in self.anchor.base.iter().enumerate() {
                let sum = dot(base, column);
                (normal[(k, d + m)], normal[(d + m, k)]) = (sum, sum);
            }
            right[d + m] = dot(column, &self.anchor.residual);
        }
        normal
            .view_mut((d, d), (2, 2))
            .copy_from(&gram(columns, |_, _| 0.0));
        for k in d..d + 2 {
            normal[(k, k)] += 1e-9 * normal[(k, k)] + 1e-12;
        }
        let x = normal.cholesky()?.solve(&right);
        let shift = std::array::from_fn(|k| x[k]);
        Some((x.dot(&right) - self.gain, shift, [x[d], x[d + 1]]))
    }
}
