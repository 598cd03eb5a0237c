//! A nominal motor where nothing is known: the handout's first-order model, fitted.
//!
//! Between two samples `a` and `b` the equation of motion has the integral
//!
//! `int u dt = (J R/Kt) (w_b - w_a) + (Kb + b R/Kt) (theta_b - theta_a) + (Tf R/Kt) int sgn(w) dt`
//!
//! and least squares over stretches of a quarter second gives its three numbers without a derivative. Of a current- or
//! torque-driven axis `Kb` has no part, and `b` takes the middle term. What cannot be seen from outside (`R`, `Kt`, and
//! of a voltage-driven motor `b`) is taken as given.

use nalgebra::{Matrix3, Vector3};

use super::data::RunData;
use super::{DiagnoseError, ready};
use crate::motor::Motor;
use crate::recording::{CommandKind, Run};

/// Length of a stretch in s.
const STRETCH_S: f64 = 0.25;
/// Least number of samples of a stretch.
const SAMPLES: usize = 4;
/// Smallest plausible share of each of the three in the largest command.
const LEAST_SHARE: f64 = 1e-3;
/// Relative tolerance of what was fitted.
const TOLERANCE: f64 = 0.5;

/// The first-order model's best fit to the runs, on top of `given` for all that they do not tell.
///
/// # Errors
/// Runs that are too short or of different axes, or in which nothing moves.
pub fn fitted_nominal(runs: &[Run], given: &Motor) -> Result<Motor, DiagnoseError> {
    let first = runs.first().ok_or(DiagnoseError::NoRuns)?;
    let kind = first.command_kind;
    let (_, data) = ready(runs, kind, &mut Vec::new())?;
    let mut normal = Matrix3::<f64>::zeros();
    let mut right = Vector3::<f64>::zeros();
    let mut largest = Vector3::<f64>::zeros();
    let mut largest_command = 0.0_f64;
    for run in &data {
        for (row, impulse, span_s) in stretches(run) {
            normal += row * row.transpose();
            right += row * impulse;
            largest = largest.sup(&(row.abs() / span_s));
            largest_command = largest_command.max((impulse / span_s).abs());
        }
    }
    for k in 0..3 {
        normal[(k, k)] *= 1.0 + 1e-9;
    }
    let fitted = normal
        .try_inverse()
        .map(|inverse| inverse * right)
        .filter(|x| x.iter().all(|x| x.is_finite()) && largest.min() > 0.0)
        .ok_or(DiagnoseError::NoFit)?;
    // A number that came out at or below nought is small, not absent.
    let number = |k: usize| fitted[k].max(LEAST_SHARE * largest_command / largest[k]);
    let mut motor = given.clone();
    let p = &mut motor.parameters;
    // From what is commanded to a torque.
    let torque = match kind {
        CommandKind::Voltage => p.torque_constant_nm_per_a / p.resistance_ohm,
        CommandKind::Current => p.torque_constant_nm_per_a,
        CommandKind::Torque => 1.0,
    };
    p.inertia_kg_m2 = number(0) * torque;
    p.coulomb_friction_nm = number(2) * torque;
    if kind == CommandKind::Voltage {
        let viscous = (p.viscous_friction_nm_s_per_rad / torque).min(0.5 * number(1));
        p.viscous_friction_nm_s_per_rad = viscous * torque;
        p.back_emf_v_s_per_rad = number(1) - viscous;
    } else {
        p.viscous_friction_nm_s_per_rad = number(1) * torque;
    }
    p.inductance_h = 0.0;
    p.counts_per_rev = first.counts_per_rev;
    p.supply_v = first.supply_v.unwrap_or(p.supply_v);
    for key in [
        "inertia_kg_m2",
        "coulomb_friction_nm",
        "back_emf_v_s_per_rad",
        "viscous_friction_nm_s_per_rad",
    ] {
        motor.tolerance.insert(key.to_owned(), TOLERANCE);
    }
    Ok(motor)
}

/// Of each stretch in which the shaft turns: the three integrals, that of the command, and its length in s.
fn stretches(run: &RunData) -> Vec<(Vector3<f64>, f64, f64)> {
    let rad = std::f64::consts::TAU / run.counts_per_rev;
    let length = ((STRETCH_S / run.sample_time_s).round() as usize).max(SAMPLES);
    let mut found = Vec::new();
    for from in (0..run.len().saturating_sub(length)).step_by((length / 2).max(1)) {
        let to = from + length;
        if !run.moving[from..=to].iter().any(|moving| *moving) {
            continue;
        }
        let (mut sliding_s, mut impulse) = (0.0, 0.0);
        for k in from..to {
            // Friction at rest takes up what is commanded, and says nothing.
            if run.moving[k] {
                let dt_s = run.t_s[k + 1] - run.t_s[k];
                sliding_s += run.speed_counts_s[k].signum() * dt_s;
                impulse += run.command[k] * dt_s;
            }
        }
        let speed = (run.speed_counts_s[to] - run.speed_counts_s[from]) * rad;
        let angle = (run.counts[to] - run.counts[from]) * rad;
        let row = Vector3::new(speed, angle, sliding_s);
        found.push((row, impulse, run.t_s[to] - run.t_s[from]));
    }
    found
}
