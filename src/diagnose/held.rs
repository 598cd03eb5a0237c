//! An axis that its controller holds in place: the command answers to the motion, not the motion to the command.
//!
//! Then what is commanded goes neither into acceleration nor into friction; it stands against another torque. The
//! disturbance and the command are then nearly the same number, and whatever makes the motor answer less to the command (an
//! inertia that is larger, a friction that grows with the torque, a spring in between) makes such a recording likelier,
//! whether it is there or not. So the inertia stays where the motor file has it, and in play are effects that are a torque
//! at the recorded motion alone, which the command must stand against.

use nalgebra::{Matrix4, Vector4};

use super::data::RunData;
use super::verdict::DataProblem;
use crate::recording::CommandKind;

/// Share of the command's squares from which on it is neither acceleration nor friction that it stands against.
const HELD: f64 = 0.5;
/// Ridge of the regression, as a share.
const RIDGE: f64 = 1e-9;
/// Time in s over which an acceleration is measured, to either side.
const SPAN_S: f64 = 0.045;
/// Effects that are a torque at an angle and a speed.
const TORQUES: [&str; 7] = [
    "coulomb_friction",
    "viscous_friction",
    "stribeck",
    "asymmetric_friction",
    "quadratic_drag",
    "gravity_load",
    "cogging",
];

/// Whether an effect can be told on an axis that is held.
pub(super) fn tells_of(id: &str) -> bool {
    TORQUES.contains(&id)
}

/// What that means, for the list of what is the matter with the recordings.
pub(super) fn note() -> DataProblem {
    DataProblem {
        run: "all runs".to_owned(),
        problem: "held".to_owned(),
        detail: format!(
            "acceleration and friction explain less than half of the command: the axis is held by its controller, so \
             that only torques at an angle or a speed can be told ({}), and nothing that makes it answer less to the command",
            TORQUES.join(", ").replace('_', " ")
        ),
    }
}

/// Whether the axis of these runs is held: acceleration and friction leave most of the command unexplained. A motor
/// under voltage is not asked: there the back EMF stands against the command.
pub(super) fn is_held(runs: &[RunData]) -> bool {
    let is_torque = |run: &RunData| run.kind != CommandKind::Voltage;
    let (mut normal, mut right, mut squares) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
    for run in runs.iter().filter(|run| is_torque(run)) {
        let half = ((SPAN_S / run.sample_time_s).round() as usize).max(1);
        for k in half..run.len().saturating_sub(half) {
            let (from, to) = (k - half, k + half);
            let speed = run.speed_counts_s[k];
            let change = run.speed_counts_s[to] - run.speed_counts_s[from];
            let direction = if run.moving[k] { speed.signum() } else { 0.0 };
            let row = Vector4::new(
                SPAN_S * change / (run.t_s[to] - run.t_s[from]) / run.top_speed_counts_s,
                speed / run.top_speed_counts_s,
                direction,
                1.0,
            );
            let command = run.command[from..=to].iter().sum::<f64>() / (2 * half + 1) as f64;
            normal += row * row.transpose();
            right += row * command;
            squares += command * command;
        }
    }
    let ridge = Matrix4::identity() * (RIDGE * normal.trace());
    let Some(fitted) = (normal + ridge)
        .try_inverse()
        .map(|inverse| inverse * right)
    else {
        return false;
    };
    let explained = 2.0 * fitted.dot(&right) - fitted.dot(&(normal * fitted));
    squares - explained > HELD * squares
}
