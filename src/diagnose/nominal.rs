//! A nominal motor where nothing is known: the handout's first-order model, fitted.
//!
//! What is fitted is what is shown: the position error in counts, in open loop from the start of each run
//! (`least_squares`). It begins from a regression, from the motor that is given, and from a grid of its own, and is never
//! worse than any of these. Between two samples `a` and `b` the equation of motion has the integral
//!
//! `int u dt = (J R/Kt) (w_b - w_a) + (Kb + b R/Kt) (theta_b - theta_a) + (Tf R/Kt) int sgn(w) dt`
//!
//! and least squares over stretches of a quarter second gives its three numbers without a derivative: time constant over
//! gain, one over gain, and friction. Of a current- or torque-driven axis `Kb` has no part, and `b` takes the middle term. What
//! cannot be seen from outside (`R`, `Kt`, and of a voltage-driven motor `b`) is taken as given. Of an axis that its
//! controller holds the regression stands: there no open loop goes where the recording went.

use nalgebra::{Matrix3, Vector3};

use super::data::RunData;
use super::effort::Effort;
use super::held::is_held;
use super::predict::predict;
use super::{DiagnoseError, ready};
use crate::least_squares::{FirstOrder, FirstOrderMotor, Record, left_at_rest, plain_fit};
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

/// A motor that was fitted to runs, and what it leaves of them.
#[derive(Debug, Clone)]
pub struct NominalFit {
    /// The motor.
    pub motor: Motor,
    /// Position error in counts RMS over all samples, in open loop from the start of each run.
    pub left_counts: f64,
    /// What the motor that was given leaves; none where it cannot be simulated.
    pub given_left_counts: Option<f64>,
    /// What a shaft that never turns leaves: how far these runs go.
    pub at_rest_counts: f64,
    /// Whether the motor is the one that was given, since no first-order motor leaves less.
    pub is_given: bool,
}

/// The first-order model's best fit to the runs, on top of `given` for all that they do not tell.
///
/// # Errors
/// As [`nominal_fit`].
pub fn fitted_nominal(runs: &[Run], given: &Motor) -> Result<Motor, DiagnoseError> {
    nominal_fit(runs, given).map(|fit| fit.motor)
}

/// The same with what it leaves of the runs.
///
/// # Errors
/// Runs that are too short or of different axes, in which nothing moves, or that no first-order motor follows better than a
/// shaft that stands still.
pub fn nominal_fit(runs: &[Run], given: &Motor) -> Result<NominalFit, DiagnoseError> {
    let first = runs.first().ok_or(DiagnoseError::NoRuns)?;
    let kind = first.command_kind;
    let (_, data) = ready(runs, kind, &mut Vec::new())?;
    let mut given = given.clone();
    given.parameters.counts_per_rev = first.counts_per_rev;
    given.parameters.supply_v = first.supply_v.unwrap_or(given.parameters.supply_v);
    let records: Vec<Record<'_>> = data.iter().map(record).collect();
    let at_rest_counts = left_at_rest(&records);
    let given_left_counts = left_by(&given, &data);
    let regressed = regression(&data);
    if is_held(&data) {
        let fitted = regressed.ok_or(DiagnoseError::NoFit)?;
        let motor = with_numbers(&given, kind, fitted);
        let left_counts = left_by(&motor, &data).ok_or(DiagnoseError::NoFit)?;
        return Ok(NominalFit {
            motor,
            left_counts,
            given_left_counts,
            at_rest_counts,
            is_given: false,
        });
    }
    let starts: Vec<_> = (regressed.into_iter())
        .chain(FirstOrderMotor::of(&given, kind))
        .collect();
    let found = plain_fit(&records, &starts).ok_or(DiagnoseError::NoFit)?;
    if found.left_counts >= at_rest_counts {
        return Err(DiagnoseError::FitFailed {
            left_counts: found.left_counts,
            at_rest_counts,
        });
    }
    let motor = with_numbers(&given, kind, found.motor);
    let left_counts = left_by(&motor, &data).ok_or(DiagnoseError::NoFit)?;
    let is_given = given_left_counts.is_some_and(|left| left < left_counts);
    Ok(NominalFit {
        motor: if is_given { given } else { motor },
        left_counts: given_left_counts.map_or(left_counts, |left| left.min(left_counts)),
        given_left_counts,
        at_rest_counts,
        is_given,
    })
}

/// The run as the plain fit needs it.
fn record(run: &RunData) -> Record<'_> {
    Record::from_rest(&run.t_s, &run.command, &run.counts, run.counts_per_rev)
        .starting(run.start_speed_counts_s)
}

/// Position error of a motor in counts RMS over all samples, in open loop from the start of each run; where inside a count it
/// started is the run's own.
fn left_by(motor: &Motor, data: &[RunData]) -> Option<f64> {
    let (mut squares, mut samples) = (0.0, 0);
    for run in data {
        let x = predict(motor, run, &Effort::default())?;
        let raw = || run.counts.iter().zip(&x).map(|(n, x)| n - x);
        let start = (raw().sum::<f64>() / run.len() as f64).clamp(0.0, 1.0);
        squares += raw().map(|r| (r - start).powi(2)).sum::<f64>();
        samples += run.len();
    }
    let left = (squares / samples as f64).sqrt();
    left.is_finite().then_some(left)
}

/// The first-order motor with its numbers' tolerances.
fn with_numbers(given: &Motor, kind: CommandKind, fitted: FirstOrderMotor) -> Motor {
    let mut motor = fitted.in_place_of(given, kind);
    for key in [
        "inertia_kg_m2",
        "coulomb_friction_nm",
        "back_emf_v_s_per_rad",
        "viscous_friction_nm_s_per_rad",
    ] {
        motor.tolerance.insert(key.to_owned(), TOLERANCE);
    }
    motor
}

/// Gain, time constant and friction by least squares over stretches; `None` where they cannot be told.
fn regression(data: &[RunData]) -> Option<FirstOrderMotor> {
    let mut normal = Matrix3::<f64>::zeros();
    let mut right = Vector3::<f64>::zeros();
    let mut largest = Vector3::<f64>::zeros();
    let mut largest_command = 0.0_f64;
    for run in data {
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
        .filter(|x| x.iter().all(|x| x.is_finite()) && largest.min() > 0.0)?;
    // A number that came out at or below nought is small, not absent.
    let number = |k: usize| fitted[k].max(LEAST_SHARE * largest_command / largest[k]);
    let gain = 1.0 / number(1);
    let shape = FirstOrder {
        time_constant_s: gain * number(0),
        friction: number(2),
    };
    Some(FirstOrderMotor { gain, shape })
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
