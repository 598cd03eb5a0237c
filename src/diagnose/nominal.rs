//! A nominal motor where nothing is known: the handout's first-order model, fitted.
//!
//! What is fitted is what is shown: the position error in counts, in open loop from the start of each run ([`least_squares`]). It is
//! never worse than the motor that is given. What cannot be seen from outside (`R`, `Kt`, and of a voltage-driven motor `b`) is taken
//! as given.
//!
//! [`least_squares`]: crate::least_squares

use super::error::{DiagnoseError, name_of, usable};
use super::fit::BASE;
use super::settings::FITTED_TOLERANCE;
use crate::least_squares::{FirstOrderMotor, Record, columns, left_at_rest, plain_fit, records};
use crate::motor::fit::{Simulator, Workspace};
use crate::motor::{Drive, Model, Motor};
use crate::recording::Run;

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
/// Runs that are too short or of different axes, in which nothing moves, or that no first-order motor follows better than a
/// shaft that stands still.
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
    let kind = usable(runs)?;
    let mut given = given.clone();
    given.parameters.counts_per_rev = runs[0].counts_per_rev;
    given.parameters.supply_v = runs[0].supply_v.unwrap_or(given.parameters.supply_v);
    let columns = columns(runs);
    let records = records(runs, &columns);
    let at_rest_counts = left_at_rest(&records);
    let given_left_counts = left_by(&given, runs, &records).ok();
    let starts: Vec<_> = FirstOrderMotor::of(&given, kind).into_iter().collect();
    let found = plain_fit(&records, &starts).ok_or(DiagnoseError::NoFit)?;
    if found.left_counts >= at_rest_counts {
        return Err(DiagnoseError::FitFailed {
            left_counts: found.left_counts,
            at_rest_counts,
        });
    }
    let mut motor = found.motor.in_place_of(&given, kind);
    for key in BASE {
        motor.tolerance.insert(key.to_owned(), FITTED_TOLERANCE);
    }
    let left_counts = left_by(&motor, runs, &records)?;
    let is_given = given_left_counts.is_some_and(|left| left < left_counts);
    Ok(NominalFit {
        motor: if is_given { given } else { motor },
        left_counts: given_left_counts.map_or(left_counts, |left| left.min(left_counts)),
        given_left_counts,
        at_rest_counts,
        is_given,
    })
}

/// Position error of a motor in counts RMS over all samples, in open loop from the start of each run; where inside a count it
/// started is the run's own.
fn left_by(motor: &Motor, runs: &[Run], records: &[Record<'_>]) -> Result<f64, DiagnoseError> {
    let (mut squares, mut samples) = (0.0, 0);
    for (k, (run, record)) in runs.iter().zip(records).enumerate() {
        let drive = Drive {
            t_s: record.t_s,
            command: record.command,
            kind: run.command_kind,
        };
        let first_rad = run.counts[0] as f64 / record.counts_per_rad;
        let simulated = Simulator::new(&drive, Model::SecondOrder).and_then(|simulator| {
            let simulator =
                (simulator.knowing(run.known.clone())).starting(first_rad, record.start_rad_s);
            let mut angles = vec![0.0; run.len()];
            simulator.angles(motor, &mut Workspace::default(), &mut angles)?;
            Ok(angles)
        });
        let angles = simulated.map_err(|source| DiagnoseError::Simulation {
            run: name_of(k, run),
            source,
        })?;
        let raw = || {
            let pairs = record.counts.iter().zip(&angles);
            pairs.map(|(n, angle)| n - (angle - first_rad) * record.counts_per_rad)
        };
        let start = (raw().sum::<f64>() / run.len() as f64).clamp(0.0, 1.0);
        squares += raw().map(|r| (r - start).powi(2)).sum::<f64>();
        samples += run.len();
    }
    Ok((squares / samples as f64).sqrt())
}
