//! What a motor, or a hypothesis with its numbers, makes the encoder of a run show, in counts from the first sample.

use std::cell::RefCell;

use super::data::RunData;
use super::hypothesis::Hypothesis;
use crate::motor::Motor;
use crate::motor::fit::Workspace;

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::default();
}

/// The motor as this run's file has it: its encoder and its supply.
fn on_run(motor: &Motor, run: &RunData) -> Motor {
    let mut motor = motor.clone();
    motor.parameters.counts_per_rev = run.counts_per_rev;
    if let Some(supply_v) = run.supply_v {
        motor.parameters.supply_v = supply_v;
    }
    motor
}

/// The encoder's expected position in counts, not rounded, from the first sample; `None` where the
/// numbers make no motion that can be simulated.
pub(super) fn predict(motor: &Motor, run: &RunData) -> Option<Vec<f64>> {
    let motor = on_run(motor, run);
    let mut angles = vec![0.0; run.len()];
    WORKSPACE
        .with_borrow_mut(|workspace| run.simulator.angles(&motor, workspace, &mut angles))
        .ok()?;
    to_counts(&mut angles, run);
    Some(angles)
}

/// The same with its derivatives by every number of the hypothesis, a column a number.
pub(super) fn predict_with_derivatives(
    hypothesis: &Hypothesis,
    nominal: &Motor,
    p: &[f64],
    run: &RunData,
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let motor = on_run(&hypothesis.motor(nominal, p), run);
    let ids = hypothesis.parameter_ids();
    let mut angles = vec![0.0; run.len()];
    let mut columns = vec![0.0; run.len() * ids.len()];
    WORKSPACE
        .with_borrow_mut(|workspace| {
            run.simulator
                .sensitivities(&motor, &ids, workspace, &mut angles, &mut columns)
        })
        .ok()?;
    to_counts(&mut angles, run);
    let derivatives = columns
        .chunks_exact(run.len().max(1))
        .enumerate()
        .map(|(k, column)| {
            let mut column = column.to_vec();
            to_counts(&mut column, run);
            let factor = if !hypothesis.movable(k) {
                0.0
            } else if hypothesis.is_logarithmic(k) {
                ids[k].get(&motor).unwrap_or(0.0)
            } else {
                1.0
            };
            for value in &mut column {
                *value = if value.is_finite() {
                    *value * factor
                } else {
                    0.0
                };
            }
            column
        });
    Some((angles, derivatives.collect()))
}

/// Angles in rad to counts from the first sample.
fn to_counts(angles: &mut [f64], run: &RunData) {
    let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
    let first = angles.first().copied().unwrap_or(0.0);
    for angle in angles {
        *angle = (*angle - first) * counts_per_rad;
    }
}
