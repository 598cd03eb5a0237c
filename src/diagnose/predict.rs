//! What a motor, or a hypothesis with its numbers, makes the encoder of a run show, in counts from the first sample.

use std::cell::RefCell;

use super::data::RunData;
use super::effort::Effort;
use super::hypothesis::Hypothesis;
use crate::motor::Motor;
use crate::motor::fit::{ParameterId, Workspace, carried_together};

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
pub(super) fn predict(motor: &Motor, run: &RunData, effort: &Effort) -> Option<Vec<f64>> {
    let motor = on_run(motor, run);
    let mut angles = vec![0.0; run.len()];
    WORKSPACE
        .with_borrow_mut(|workspace| {
            let done = run.simulator.angles(&motor, workspace, &mut angles);
            effort.spend(workspace.take_work());
            done
        })
        .ok()?;
    Some(in_counts(&angles, run).collect())
}

/// The same of motors that move alike, from one simulation: theirs one after the other.
pub(super) fn predict_alike(
    motors: &[Motor],
    run: &RunData,
    effort: &Effort,
) -> Option<Vec<Vec<f64>>> {
    let motors: Vec<Motor> = motors.iter().map(|motor| on_run(motor, run)).collect();
    let mut angles = vec![0.0; run.len() * motors.len()];
    WORKSPACE
        .with_borrow_mut(|workspace| {
            let simulator = &run.simulator;
            let done = simulator.angles_by_encoder(&motors, workspace, &mut angles);
            effort.spend(workspace.take_work());
            done
        })
        .ok()?;
    let rows = angles.chunks_exact(run.len().max(1));
    Some(rows.map(|row| in_counts(row, run).collect()).collect())
}

/// The same with its derivatives by the first `numbers` of the hypothesis, a column a number.
pub(super) fn predict_with_derivatives(
    hypothesis: &Hypothesis,
    nominal: &Motor,
    p: &[f64],
    numbers: usize,
    run: &RunData,
    effort: &Effort,
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let motor = on_run(&hypothesis.motor(nominal, p), run);
    let mut ids = hypothesis.parameter_ids();
    ids.truncate(numbers);
    let mut angles = vec![0.0; run.len()];
    let mut columns = vec![0.0; run.len() * ids.len()];
    sensitivities(&motor, &ids, run, [&mut angles, &mut columns], effort)?;
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

/// The simulator's angles and derivatives. Those that do not fit one simulation are simulated side by side.
fn sensitivities(
    motor: &Motor,
    ids: &[ParameterId],
    run: &RunData,
    [angles, columns]: [&mut [f64]; 2],
    effort: &Effort,
) -> Option<()> {
    let simulated = |ids: &[ParameterId], angles: &mut [f64], columns: &mut [f64]| {
        WORKSPACE
            .with_borrow_mut(|workspace| {
                let done = (run.simulator).sensitivities(motor, ids, workspace, angles, columns);
                effort.spend(workspace.take_work());
                done
            })
            .ok()
    };
    let (first, others) = ids.split_at(carried_together(ids.len()));
    if others.is_empty() {
        return simulated(ids, angles, columns);
    }
    let (of_first, of_others) = columns.split_at_mut(first.len() * angles.len());
    let mut same_angles = vec![0.0; angles.len()];
    let (a, b) = rayon::join(
        || simulated(first, angles, of_first),
        || sensitivities(motor, others, run, [&mut same_angles, of_others], effort),
    );
    a.and(b)
}

/// Angles in rad to counts from the first sample.
fn in_counts(angles: &[f64], run: &RunData) -> impl Iterator<Item = f64> {
    let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
    let first = angles.first().copied().unwrap_or(0.0);
    angles
        .iter()
        .map(move |angle| (angle - first) * counts_per_rad)
}

#[cfg(test)]
mod tests {
    use super::super::hypothesis::Member;
    use super::super::samples::{index, motor_with, problem, ready, recording};
    use super::*;

    /// Ten numbers are more than one simulation carries; one after the other they come out the same.
    #[test]
    fn derivatives_side_by_side_are_those_one_after_the_other() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let member = |id: &str, values: &[f64]| Member {
            index: index(id),
            values: values.to_vec(),
        };
        let members = vec![
            member("cogging", &[0.01, 12.0, 1.0]),
            member("stribeck", &[0.03, 0.5]),
            member("inductance", &[2e-3]),
        ];
        let hypothesis = Hypothesis::new(&nominal, members, &problem.setting);
        let ids = hypothesis.parameter_ids();
        assert!(carried_together(ids.len()) < ids.len());
        let motor = hypothesis.motor(&nominal, &hypothesis.start());
        let run = &runs[0];
        let (mut angles, mut columns) = (vec![0.0; run.len()], vec![0.0; run.len() * ids.len()]);
        let effort = Effort::default();
        sensitivities(&motor, &ids, run, [&mut angles, &mut columns], &effort).expect("a motor");
        let mut same_angles = vec![f64::NAN; angles.len()];
        let mut one_by_one = vec![f64::NAN; columns.len()];
        let mut workspace = Workspace::default();
        (run.simulator)
            .sensitivities(
                &motor,
                &ids,
                &mut workspace,
                &mut same_angles,
                &mut one_by_one,
            )
            .expect("a motor");
        assert_eq!(angles, same_angles);
        assert_eq!(columns, one_by_one);
        let moves = |column: &[f64]| column.iter().any(|x| *x != 0.0);
        assert!(columns.chunks(run.len()).all(moves));
    }
}
