//! A nominal motor where nothing is known: the handout's first-order model, fitted.
//!
//! What is fitted is what is shown: the position error in counts over pieces, each from its own measured start. It begins from the plain
//! least squares of whole runs in open loop and of the pieces ([`least_squares`]): over minutes in open loop a speed that creeps hides
//! everything else. It is never worse than the motor that is given. What cannot be seen from outside (`R`, `Kt`, and of a
//! voltage-driven motor `b`) begins as given.
//!
//! [`least_squares`]: crate::least_squares

use super::error::{DiagnoseError, usable};
use super::fit::{Base, Left, Model, unweighted};
use super::pieces::{Pieces, Thinned};
use super::screening::{own_part, shares};
use super::settings::FITTED_TOLERANCE;
use super::{made_ready, read_right};
use crate::least_squares::{FirstOrderMotor, columns, plain_fit, records};
use crate::motor::Motor;
use crate::recording::Run;

/// Most times that runs are cut anew: a time constant that is found in pieces cuts others.
const CUTS: usize = 4;

/// A motor that was fitted to runs, and what it leaves of them.
#[derive(Debug, Clone)]
pub struct NominalFit {
    /// The motor.
    pub motor: Motor,
    /// Position error in counts RMS over pieces, each from its own measured start.
    pub left_counts: f64,
    /// What the motor that was given leaves; none where it cannot be simulated.
    pub given_left_counts: Option<f64>,
    /// What a shaft that never turns leaves: how far these runs go.
    pub at_rest_counts: f64,
    /// Whether a load or a disc is known in one of the runs, so that they tell `Kt/R` too.
    pub knows_torque: bool,
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
    let runs = &read_right(runs)[..];
    let kind = usable(runs)?;
    let mut given = given.clone();
    given.parameters.counts_per_rev = runs[0].counts_per_rev;
    given.parameters.supply_v = runs[0].supply_v.unwrap_or(given.parameters.supply_v);
    let starts: Vec<_> = FirstOrderMotor::of(&given, kind).into_iter().collect();
    let columns = columns(runs);
    let whole = plain_fit(&records(runs, &columns), &starts).ok_or(DiagnoseError::NoFit)?;
    // The pieces are as long as the motor that is found in them asks for.
    let mut found = vec![whole.motor];
    let (mut all, mut base) = made_ready(runs, &whole.motor.in_place_of(&given, kind))?;
    for _ in 0..CUTS {
        let counts: Vec<f64> = all.counts.iter().map(|n| n + 0.5).collect();
        let Some(fit) = plain_fit(&all.records(&counts), &found[found.len() - 1..]) else {
            break;
        };
        found.push(fit.motor);
        let (again, its_base) = made_ready(runs, &fit.motor.in_place_of(&given, kind))?;
        let stands_still = again.pieces.len() == all.pieces.len();
        (all, base) = (again, its_base);
        if stands_still {
            break;
        }
    }
    let thinned = Thinned::new(&all, runs)?;
    let pieces = thinned.as_ref().map_or(&all, |thinned| &thinned.pieces);
    let at_rest_counts = rms(&all.counts);
    let given_left_counts = left_by(&given, &all, &base);
    let mut starts: Vec<Motor> = (found.iter())
        .map(|motor| motor.in_place_of(&given, kind))
        .collect();
    // A plain motor knows of no load. The inverse form has it without a start.
    if base.knows_torque {
        let model = Model::new(&base, Vec::new());
        let own = own_part(pieces);
        starts.extend(own.map(|own| model.motor(&model.start_with(shares(&base, own)))));
    }
    let fitted = starts.into_iter().filter_map(|mut motor| {
        for key in base.told() {
            motor.tolerance.insert((*key).to_owned(), FITTED_TOLERANCE);
        }
        let base = Base {
            motor,
            ..base.clone()
        };
        let model = Model::new(&base, Vec::new());
        let fit = unweighted(pieces, &model, kind, &[model.start()])?;
        let left_counts = left_by(&fit.left.motor, &all, &base)?;
        Some((fit.left.motor, left_counts))
    });
    let best = fitted.min_by(|a, b| a.1.total_cmp(&b.1));
    let (motor, left_counts) = best.ok_or(DiagnoseError::NoFit)?;
    if left_counts >= at_rest_counts {
        return Err(DiagnoseError::FitFailed {
            left_counts,
            at_rest_counts,
        });
    }
    let is_given = given_left_counts.is_some_and(|left| left < left_counts);
    Ok(NominalFit {
        motor: if is_given { given } else { motor },
        left_counts: given_left_counts.map_or(left_counts, |left| left.min(left_counts)),
        given_left_counts,
        at_rest_counts,
        knows_torque: base.knows_torque,
        is_given,
    })
}

/// Position error of a motor in counts RMS over pieces; none where it cannot be simulated.
fn left_by(motor: &Motor, pieces: &Pieces, base: &Base) -> Option<f64> {
    let base = Base {
        motor: motor.clone(),
        ..base.clone()
    };
    let model = Model::new(&base, Vec::new());
    let left = Left::new(pieces, &model, base.kind, &model.start())?;
    Some(rms(&left.shown))
}

fn rms(values: &[f64]) -> f64 {
    let squares = values.iter().map(|value| value * value).sum::<f64>();
    (squares / values.len().max(1) as f64).sqrt()
}
