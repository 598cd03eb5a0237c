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
    Some(in_counts(&angles, run).collect())
}

/// The same with its derivatives by the first `numbers` of the hypothesis, a column a number.
pub(super) fn predict_with_derivatives(
    hypothesis: &Hypothesis,
    nominal: &Motor,
    p: &[f64],
    numbers: usize,
    run: &RunData,
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let motor = on_run(&hypothesis.motor(nominal, p), run);
    let mut ids = hypothesis.parameter_ids();
    ids.truncate(numbers);
    let mut angles = vec![0.0; run.len()];
    let mut columns = vec![0.0; run.len() * ids.len()];
    WORKSPACE
        .with_borrow_mut(|workspace| {
            run.simulator
                .sensitivities(&motor, &ids, workspace, &mut angles, &mut columns)
        })
        .ok()?;
    let derivatives = columns
        .chunks_exact(run.len().max(1))
        .enumerate()
        .map(|(k, column)| {
            let factor = if !hypothesis.movable(k) {
                0.0
            } else if hypothesis.is_logarithmic(k) {
                ids[k].get(&motor).unwrap_or(0.0)
            } else {
                1.0
            };
            let by_number = |value: f64| {
                if value.is_finite() {
                    value * factor
                } else {
                    0.0
                }
            };
            in_counts(column, run).map(by_number).collect()
        });
    let derivatives = derivatives.collect();
    Some((in_counts(&angles, run).collect(), derivatives))
}

/// Angles in rad to counts from the first sample.
fn in_counts(angles: &[f64], run: &RunData) -> impl Iterator<Item = f64> {
    let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
    let first = angles.first().copied().unwrap_or(0.0);
    angles
        .iter()
        .map(move |angle| (angle - first) * counts_per_rad)
}
