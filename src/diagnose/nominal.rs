//! Fit of a nominal motor: least squares of the model without effects.
//!
//! It starts from plain fits of whole runs and of parts in open loop ([`least_squares`](crate::least_squares)), from
//! the equation-error regression and from the given motor, and its error is never larger than the given motor's.
//! Parameters that voltage and counts do not determine (`R`, `Kt`) keep their given values.

use std::ops::Range;

use super::error::{DiagnoseError, usable};
use super::fit::Fit;
use super::inverse::{own_part, shares};
use super::model::{Base, Model, corrected_residual, mean_square};
use super::nested::least_squares;
use super::pipeline::Prepared;
use super::relevance::{exceeds, noise_floor};
use super::score::effective_observations;
use super::segments::{Segments, driven, time_constant_s};
use super::settings::Settings;
use super::settings::solver::{CUTS, WINDINGS};
use super::without_named_samples;
use crate::check::off_under_command;
use crate::least_squares::{FirstOrderMotor, Record, columns, plain_fit, start_of};
use crate::motor::{CommandKind, Motor};
use crate::recording::Run;

/// A fitted motor.
#[derive(Debug, Clone)]
pub struct NominalFit {
    /// The motor.
    pub motor: Motor,
    /// Residual RMS in counts over segments.
    pub left_counts: f64,
    /// The same for the given motor; `None` if it cannot be simulated.
    pub given_left_counts: Option<f64>,
    /// The same for a shaft at rest: the extent of the motion.
    pub at_rest_counts: f64,
    /// Whether torques are identifiable in N m: a load or a disc is known in one of the runs.
    pub knows_torque: bool,
    /// Whether the motor is the given one, because no other has a smaller error.
    pub is_given: bool,
}

/// The model without effects fitted to the runs, with the values of `given` for parameters that they do not
/// determine.
///
/// # Errors
/// Runs that are too short or of different axes, without motion, or for which no first-order motor is better than a
/// shaft at rest.
///
/// ```
/// use motorlab::diagnose::{Settings, nominal_fit};
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
/// let found = nominal_fit(&[run], &Motor::default(), &Settings::default())?;
/// assert!(found.left_counts < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn nominal_fit(
    runs: &[Run],
    given: &Motor,
    settings: &Settings,
) -> Result<NominalFit, DiagnoseError> {
    let runs = &without_named_samples(runs)[..];
    let kind = usable(runs)?;
    let mut given = given.clone();
    given.parameters.counts_per_rev = runs[0].counts_per_rev;
    given.parameters.supply_v = runs[0].supply_v.unwrap_or(given.parameters.supply_v);
    let mut motor = start(runs, &given, kind, settings)?;
    let mut best: Option<(Motor, f64, Prepared)> = None;
    for _ in 0..CUTS {
        let tolerant = with_tolerances(&motor, super::model::BASE, settings.largest_factor);
        let prepared = Prepared::new(runs, &tolerant, settings, false)?;
        let (segments, _) = prepared.searched();
        let model = Model::new(&prepared.base, Vec::new());
        let mut starts = vec![model.start()];
        let own = own_part(segments).map(|own| shares(&prepared.base, own));
        let own = own.map(|own| model.start_with(own));
        let is_closed_loop = segments.runs.iter().any(|run| run.is_closed_loop);
        let found = match own.as_ref().filter(|_| is_closed_loop) {
            // In closed loop the equation error is the better criterion.
            Some(own) => Fit::at(segments, &model, own.clone()),
            None => {
                starts.extend(own);
                least_squares(segments, &model, &starts)
            }
        };
        let found = found.ok_or(DiagnoseError::NoFit)?;
        let found = match is_closed_loop {
            true => found,
            false => with_winding(segments, &prepared.base, found),
        };
        let is_settled = best
            .as_ref()
            .is_some_and(|(.., last)| last.all.segments.len() == prepared.all.segments.len());
        motor = found.model.motor(&found.x);
        motor.tolerance.clone_from(&given.tolerance);
        let fitted = (found.model.parameters.iter()).map(|parameter| parameter.id.key());
        motor = with_tolerances(&motor, fitted, settings.fitted_tolerance);
        let rms = residual_rms(&motor, &prepared).ok_or(DiagnoseError::NoFit)?;
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
    let given_left_counts = residual_rms(&given, &prepared);
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

/// The fit with a winding (L/R free) in place of the first-order one, if the latter's error is above the noise floor
/// and materially larger.
fn with_winding(segments: &Segments, base: &Base, first_order: Fit) -> Fit {
    let motor = first_order.model.motor(&first_order.x);
    let has_winding = motor.parameters.inductance_h > 0.0;
    let n_eff = effective_observations(segments, &first_order.corrected);
    let leaves_more = |than: f64| exceeds(first_order.mean_square(), than, n_eff, &base.settings);
    let is_described = noise_floor(segments, &first_order).is_none_or(|floor| !leaves_more(floor));
    // A logged speed may be filtered, which is similar to a winding.
    let is_of_speeds = segments.runs.iter().any(|run| run.is_integrated);
    if base.kind != CommandKind::Voltage || has_winding || is_of_speeds || is_described {
        return first_order;
    }
    let fits = WINDINGS.iter().filter_map(|share| {
        let mut base = base.clone();
        base.motor = motor.clone();
        base.motor.parameters.inductance_h =
            share * time_constant_s(&motor) * motor.parameters.resistance_ohm;
        let model = Model::new(&base, Vec::new());
        least_squares(segments, &model, &[model.start()])
    });
    fits.min_by(|a, b| a.square_sum().total_cmp(&b.square_sum()))
        .filter(|fit| leaves_more(fit.mean_square()))
        .unwrap_or(first_order)
}

/// Start of the fit: the given motor or a plain fit to whole runs or to parts as long as segments, whichever has the
/// smallest error over segments.
fn start(
    runs: &[Run],
    given: &Motor,
    kind: CommandKind,
    settings: &Settings,
) -> Result<Motor, DiagnoseError> {
    let begun: Vec<_> = FirstOrderMotor::of(given, kind).into_iter().collect();
    let longest_s = settings.segment_time_constants * settings.segment_s;
    let of_runs = columns(runs);
    let mut candidates = vec![given.clone()];
    for length_s in [settings.segment_s, longest_s, f64::INFINITY] {
        let counts: Vec<(usize, Range<usize>, Vec<f64>)> = (runs.iter().enumerate())
            .flat_map(|(k, run)| {
                cut(run, length_s, settings.segment_samples).map(move |range| (k, range))
            })
            .map(|(k, range)| {
                let counts = &of_runs[k].1[range.clone()];
                let from_first = counts.iter().map(|n| n - counts[0] + 0.5).collect();
                (k, range, from_first)
            })
            .collect();
        let parts: Vec<Record<'_>> = (counts.iter())
            .map(|(k, range, counts)| {
                let (t_s, command) = (&runs[*k].t_s[range.clone()], &of_runs[*k].0[range.clone()]);
                let record = Record::from_rest(t_s, command, counts, runs[*k].counts_per_rev);
                record.starting(start_of(&record).speed_counts_s)
            })
            .collect();
        let plain = plain_fit(&parts, &begun);
        candidates.extend(plain.map(|fit| fit.motor.in_place_of(given, kind)));
    }
    let slowest = (candidates[1..].iter())
        .max_by(|a, b| time_constant_s(a).total_cmp(&time_constant_s(b)))
        .ok_or(DiagnoseError::NoFit)?;
    let prepared = Prepared::new(runs, slowest, settings, false)?;
    let left = candidates
        .iter()
        .filter_map(|motor| Some((residual_rms(motor, &prepared)?, motor)));
    let best = left.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, motor)| motor.clone())
        .ok_or(DiagnoseError::NoFit)
}

/// Parts of a run of about this length in s with at least this number of samples, without those in which the drive
/// was off.
fn cut(run: &Run, length_s: f64, least: usize) -> impl Iterator<Item = Range<usize>> + use<> {
    let sample_time_s = run.sample_time_s;
    let parts = driven(run.t_s.len(), &off_under_command(run), least);
    parts.into_iter().flat_map(move |part| {
        let n = part.len();
        let count = ((n as f64 * sample_time_s / length_s) as usize).clamp(1, (n / least).max(1));
        (0..count).map(move |k| part.start + k * n / count..part.start + (k + 1) * n / count)
    })
}

/// A motor with this relative tolerance of some parameters.
fn with_tolerances(
    motor: &Motor,
    keys: impl IntoIterator<Item = &'static str>,
    tolerance: f64,
) -> Motor {
    let mut motor = motor.clone();
    (motor.tolerance).extend(keys.into_iter().map(|key| (key.to_owned(), tolerance)));
    motor
}

/// Residual RMS of a motor in counts; `None` if it cannot be simulated.
fn residual_rms(motor: &Motor, prepared: &Prepared) -> Option<f64> {
    Some(mean_square(&corrected_residual(&prepared.all, motor)?).sqrt())
}
