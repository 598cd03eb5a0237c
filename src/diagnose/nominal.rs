//! A nominal motor where nothing is known: least squares of the model without effects.
//!
//! It starts from the plain fit of whole runs in open loop ([`least_squares`](crate::least_squares)), from the equation-error regression and
//! from the given motor, and never leaves more than the given motor. What voltage and counts do not determine (`R`, `Kt`) stays as given.

use super::error::{DiagnoseError, usable};
use super::fit::Fit;
use super::inverse::{own_part, shares};
use super::model::Model;
use super::nested::least_squares;
use super::pipeline::Prepared;
use super::settings::Settings;
use super::without_named_samples;
use crate::least_squares::{FirstOrderMotor, columns, plain_fit, records};
use crate::motor::Motor;
use crate::recording::Run;

/// Most times that runs are cut anew: the fitted time constant sets the length of segments.
const CUTS: usize = 3;

/// A motor that was fitted to runs.
#[derive(Debug, Clone)]
pub struct NominalFit {
    /// The motor.
    pub motor: Motor,
    /// Residual RMS in counts over segments.
    pub left_counts: f64,
    /// The same of the given motor; none where it cannot be simulated.
    pub given_left_counts: Option<f64>,
    /// The same of a shaft that never turns: how far these runs go.
    pub at_rest_counts: f64,
    /// Whether torques are identifiable in N m: a load or a disc is known in one of the runs.
    pub knows_torque: bool,
    /// Whether the motor is the given one, since no other leaves less.
    pub is_given: bool,
}

/// The model without effects fitted to the runs, on top of `given` for what they do not determine.
///
/// # Errors
/// Runs that are too short or of different axes, in which nothing moves, or that no first-order motor follows better than a shaft at rest.
///
/// ```
/// use motorlab::diagnose::nominal_fit;
/// use motorlab::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};
/// use motorlab::recording::Run;
///
/// let mut heavy = Motor::default();
/// heavy.parameters.inertia_kg_m2 *= 3.0;
/// let t_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.01).collect();
/// let command = vec![4.5; 400];
/// let drive = Drive { t_s: &t_s, command: &command, kind: CommandKind::Voltage };
/// let counts = simulate(&heavy, &drive, &SimulationOptions::default())?.counts;
/// let run = Run { sample_time_s: 0.01, counts_per_rev: 720.0, t_s, command, counts, ..Run::default() };
/// let found = nominal_fit(&[run], &Motor::default())?;
/// assert!(found.left_counts < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn nominal_fit(runs: &[Run], given: &Motor) -> Result<NominalFit, DiagnoseError> {
    let settings = Settings::default();
    let runs = &without_named_samples(runs)[..];
    let kind = usable(runs)?;
    let mut given = given.clone();
    given.parameters.counts_per_rev = runs[0].counts_per_rev;
    given.parameters.supply_v = runs[0].supply_v.unwrap_or(given.parameters.supply_v);
    let starts: Vec<_> = FirstOrderMotor::of(&given, kind).into_iter().collect();
    let of_runs = columns(runs);
    let whole = plain_fit(&records(runs, &of_runs), &starts).ok_or(DiagnoseError::NoFit)?;
    let mut motor = whole.motor.in_place_of(&given, kind);
    let mut best: Option<(Motor, f64, Prepared)> = None;
    for _ in 0..CUTS {
        let tolerant = with_wide_tolerances(&motor, &settings);
        let prepared = Prepared::new(runs, &tolerant, &settings)?;
        let segments = prepared.searched();
        let model = Model::new(&prepared.base, Vec::new());
        let mut starts = vec![model.start()];
        let own = own_part(segments).map(|own| shares(&prepared.base, own));
        starts.extend(own.map(|own| model.start_with(own)));
        let found = least_squares(segments, &model, &starts).ok_or(DiagnoseError::NoFit)?;
        let is_settled = best
            .as_ref()
            .is_some_and(|(.., last)| last.all.segments.len() == prepared.all.segments.len());
        motor = found.model.motor(&found.x);
        motor.tolerance.clone_from(&tolerant.tolerance);
        let rms = left_by(&motor, &prepared).ok_or(DiagnoseError::NoFit)?;
        best = Some((motor.clone(), rms, prepared));
        if is_settled {
            break;
        }
    }
    let (motor, left_counts, prepared) = best.ok_or(DiagnoseError::NoFit)?;
    let counts = &prepared.all.counts;
    let at_rest_counts =
        (counts.iter().map(|n| n * n).sum::<f64>() / counts.len().max(1) as f64).sqrt();
    if left_counts >= at_rest_counts {
        return Err(DiagnoseError::FitFailed {
            left_counts,
            at_rest_counts,
        });
    }
    let given_left_counts = left_by(&given, &prepared);
    let is_given = given_left_counts.is_some_and(|left| left < left_counts);
    Ok(NominalFit {
        motor: if is_given { given } else { motor },
        left_counts: given_left_counts.map_or(left_counts, |left| left.min(left_counts)),
        given_left_counts,
        at_rest_counts,
        knows_torque: prepared.base.torque_identifiable,
        is_given,
    })
}

/// A motor whose parameters are known no better than the runs tell.
fn with_wide_tolerances(motor: &Motor, settings: &Settings) -> Motor {
    let mut motor = motor.clone();
    for key in super::model::BASE {
        let tolerance = settings.fitted_tolerance;
        motor.tolerance.insert(key.to_owned(), tolerance);
    }
    motor
}

/// Residual RMS of a motor in counts; `None` where it cannot be simulated.
fn left_by(motor: &Motor, prepared: &Prepared) -> Option<f64> {
    let mut base = prepared.base.clone();
    base.motor = motor.clone();
    let model = Model::new(&base, Vec::new());
    Some(Fit::at(&prepared.all, &model, model.start())?.rms())
}
