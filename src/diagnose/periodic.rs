//! Where fits of effects that repeat with the angle start: orders, amplitudes and phases by regression.
//!
//! The recorded angle is known to a count, so that an acceleration `A sin(N theta) + B cos(N theta)` is linear in
//! `A` and `B`, and every order `N` is tried in one regression beside the base.

use nalgebra::{DMatrix, DVector};

use super::data::RunData;
use super::fit::Problem;
use super::hypothesis::BASE;
use super::noise::{NoiseLevel, response};
use super::search::{Anchor, ORDERS, Try, dot};
use crate::motor::effects::{Prior, catalogue};
use crate::recording::CommandKind;

/// The best of all orders gains this in squares where there is none.
const LEAST_GAIN: f64 = 10.0;

/// Effects that repeat with the angle: order by order, amplitude and phase by regression.
pub(super) fn periodic(
    problem: &Problem<'_>,
    level: &NoiseLevel,
    anchor: &Anchor,
    index: usize,
    id: &str,
) -> Vec<Try> {
    let orders: Vec<f64> = match id {
        "gravity_load" | "encoder_eccentricity" => vec![1.0],
        _ => (8..=120).map(|quarter| f64::from(quarter) * 0.25).collect(),
    };
    let motor = &problem.nominal.parameters;
    let whiteners = problem.whiteners(level);
    let mut found: Vec<Try> = Vec::new();
    for order in orders {
        let mut columns = [Vec::new(), Vec::new()];
        for (run, whitener) in problem.runs.iter().zip(whiteners.iter()) {
            for (column, quarter) in columns.iter_mut().zip([0.0, 0.25]) {
                let shift = quarter * std::f64::consts::TAU;
                let mut one = wave(problem, run, id, order, shift);
                whitener.whiten(&mut one);
                column.extend(one);
            }
        }
        let Some((gain, shift, [a, b])) = regress(&anchor.residual, anchor, &columns) else {
            continue;
        };
        if is_scanned(id) && gain < LEAST_GAIN {
            continue;
        }
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
        found.push((Some(anchor.left - gain), values, shift));
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
                    let (lo, hi) = problem.setting.range(parameter, motor);
                    *value = value.clamp(0.5 * lo, 1.5 * hi);
                }
            }
            (rating, values, shift)
        })
        .collect()
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
    let angle = |k: usize| (run.first_counts + run.counts[k]) / counts_per_rad;
    let sine = |k: usize| (order * angle(k) + shift).sin();
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
