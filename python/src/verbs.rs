//! Simulate, compare, check: one function a verb.

use motorlab::cli::Failure;
use motorlab::compare as comparing;
use motorlab::hint::{Hinted, In};
use motorlab::motor::fit::Simulator;
use motorlab::motor::{self, CommandKind, Drive, SimulationError, SimulationOptions, Trajectory};
use motorlab::recording::difference_velocities;
use numpy::ndarray::{Array2, ArrayView1};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::apart::apart;
use crate::failure::{raised, refused, refused_of};
use crate::motor::{Motor, model_of, set, set_effect};
use crate::run::Run;

/// Commands and simulation settings.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Driven<'py> {
    t_s: PyReadonlyArray1<'py, f64>,
    command: PyReadonlyArray1<'py, f64>,
    /// `command_v`, `command_a` or `command_nm`.
    command_column: String,
    model: String,
    seed: u64,
}

/// Motors that are simulated between two looks whether the work has been given up.
const MOTORS_AT_ONCE: usize = 64;

/// Simulates every motor: `base` with a row of `values` under the `keys`, `EFFECT.KEY` for those of effects. A row of the result a motor.
#[pyfunction]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    base: &Motor,
    keys: Vec<String>,
    values: PyReadonlyArray2<'py, f64>,
    driven: Driven<'py>,
    output: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let motors = motors(&base.inner, &keys, &values).map_err(|error| refused_of(py, error))?;
    let t_s = driven.t_s.as_array().to_vec();
    let command = driven.command.as_array().to_vec();
    let kind = kind_of(py, &driven.command_column)?;
    let options = SimulationOptions {
        model: model_of(py, &driven.model)?,
        seed: driven.seed,
        ..SimulationOptions::default()
    };
    let shape = (motors.len(), t_s.len());
    if output == "measured_angle_rad" {
        let angles = apart(py, move |given| {
            let drive = Drive {
                t_s: &t_s,
                command: &command,
                kind,
            };
            let simulator = Simulator::new(&drive, options.model)?;
            let mut angles = vec![0.0; motors.len() * t_s.len()];
            let rows = angles.chunks_mut(MOTORS_AT_ONCE * t_s.len().max(1));
            for (motors, rows) in motors.chunks(MOTORS_AT_ONCE).zip(rows) {
                given.go_on();
                simulator.batch(motors, rows)?;
            }
            Ok::<_, SimulationError>(angles)
        })?;
        return array(py, shape, angles.map_err(|error| refused(py, error))?);
    }
    type Of<T> = fn(Trajectory) -> Vec<T>;
    let of: Of<f64> = match output {
        "counts" | "velocity_rad_s" => |_| Vec::new(),
        "angle_rad" => |trajectory| trajectory.angle_rad,
        "speed_rad_s" => |trajectory| trajectory.speed_rad_s,
        "current_a" => |trajectory| trajectory.current_a,
        other => {
            return Err(refused(
                py,
                Hinted::new(
                    format!("output is '{other}'"),
                    "it is one of measured_angle_rad, angle_rad, speed_rad_s, current_a, counts, velocity_rad_s",
                ),
            ));
        }
    };
    let is_counts = output == "counts";
    let is_velocity = output == "velocity_rad_s";
    let sample_time_s = median_step_s(&t_s);
    let rows = apart(py, move |given| {
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind,
        };
        let row = |motor: &motor::Motor| {
            given.go_on();
            let trajectory = motor::simulate(motor, &drive, &options)?;
            let counts_per_rev = motor.parameters.counts_per_rev;
            Ok(if is_counts {
                Row::Counts(trajectory.counts)
            } else if is_velocity {
                let counts = &trajectory.counts;
                let speeds = difference_velocities(counts, None, counts_per_rev, sample_time_s);
                let speeds = speeds.into_iter();
                Row::Floats(speeds.map(|speed| speed.unwrap_or(f64::NAN)).collect())
            } else {
                Row::Floats(of(trajectory))
            })
        };
        let rows = motors.par_iter().map(row);
        rows.collect::<Result<Vec<Row>, SimulationError>>()
    })?;
    let rows = rows.map_err(|error| refused(py, error))?;
    let (mut floats, mut counts) = (Vec::new(), Vec::new());
    for row in rows {
        match row {
            Row::Floats(row) => floats.extend(row),
            Row::Counts(row) => counts.extend(row),
        }
    }
    match is_counts {
        true => array(py, shape, counts),
        false => array(py, shape, floats),
    }
}

enum Row {
    Floats(Vec<f64>),
    Counts(Vec<i64>),
}

fn array<T: numpy::Element>(
    py: Python<'_>,
    shape: (usize, usize),
    values: Vec<T>,
) -> PyResult<Bound<'_, PyAny>> {
    let array = Array2::from_shape_vec(shape, values).map_err(|error| refused(py, error))?;
    Ok(array.into_pyarray(py).into_any())
}

/// The median of the steps of time: the sample time.
fn median_step_s(t_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN)
}

fn kind_of(py: Python<'_>, column: &str) -> PyResult<CommandKind> {
    let kinds = [
        CommandKind::Voltage,
        CommandKind::Current,
        CommandKind::Torque,
    ];
    let found = kinds.into_iter().find(|kind| kind.column() == column);
    found.ok_or_else(|| {
        refused(
            py,
            Hinted::new(
                format!("the command is '{column}'"),
                "it is one of command_v, command_a and command_nm",
            ),
        )
    })
}

/// The motors of a table.
fn motors(
    base: &motor::Motor,
    keys: &[String],
    values: &PyReadonlyArray2<'_, f64>,
) -> Result<Vec<motor::Motor>, Box<dyn std::error::Error + Send + Sync>> {
    let motor = |(row, values): (usize, ArrayView1<'_, f64>)| {
        let place = format!("row {row} of the motors");
        let mut motor = base.clone();
        for (key, value) in keys.iter().zip(&values) {
            match key.rsplit_once('.') {
                None => set(&mut motor, key, *value).map_err(|error| In::new(&*place, error))?,
                Some((id, key)) => {
                    let mut parameters = match motor.effects.get(id) {
                        Some(effect) => (effect.parameters())
                            .map(|(number, value)| (number.key.to_owned(), value))
                            .collect(),
                        None => std::collections::BTreeMap::new(),
                    };
                    parameters.insert(key.to_owned(), *value);
                    set_effect(&mut motor, id, &parameters)
                        .map_err(|error| In::new(&*place, error))?;
                }
            }
        }
        Ok(motor)
    };
    let rows = values.as_array();
    rows.outer_iter().enumerate().map(motor).collect()
}

/// Lays a run over its simulation: the figures as JSON, and the columns.
#[pyfunction]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    run: &Run,
    motor: &Motor,
    model: &str,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let model = model_of(py, model)?;
    let (recorded, motor) = (run.inner.clone(), motor.inner.clone());
    let name = recorded
        .path
        .as_ref()
        .map(|path| path.display().to_string());
    let overlay = apart(py, move |_| comparing::compare(&recorded, &motor, model))?;
    let mut overlay = overlay.map_err(|error| {
        raised(
            py,
            &match name {
                Some(name) => Failure::input(In::new(name, error)),
                None => Failure::input(error),
            },
        )
    })?;
    overlay.figures.notes = run.notes();
    let figures = serde_json::to_string(&overlay.figures).map_err(|error| refused(py, error))?;
    let open = |speeds: Vec<Option<f64>>| {
        speeds
            .into_iter()
            .map(|speed| speed.unwrap_or(f64::NAN))
            .collect()
    };
    let columns = PyDict::new(py);
    for (name, column) in [
        ("recorded_speed_rad_s", open(overlay.recorded_speed_rad_s)),
        ("simulated_speed_rad_s", open(overlay.simulated_speed_rad_s)),
        (
            "simulated_position_counts",
            overlay.simulated_position_counts,
        ),
        ("residual_counts", overlay.residual_counts),
        ("true_speed_rad_s", overlay.true_speed_rad_s),
    ] {
        columns.set_item(name, PyArray1::from_vec(py, column))?;
    }
    Ok((figures, columns))
}

/// Findings about recordings, as JSON.
#[pyfunction]
#[pyo3(signature = (runs, motor=None))]
pub(crate) fn check(
    py: Python<'_>,
    runs: Vec<PyRef<'_, Run>>,
    motor: Option<&Motor>,
) -> PyResult<String> {
    let runs: Vec<_> = runs.iter().map(|run| (*run.inner).clone()).collect();
    let motor = motor.map(|motor| motor.inner.clone());
    let findings = apart(py, move |_| motorlab::check::check(&runs, motor.as_ref()))?;
    serde_json::to_string(&findings).map_err(|error| refused(py, error))
}
