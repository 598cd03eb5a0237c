//! What a motor and its runs are measured in: how fast an error of the speed dies away, and the largest acceleration.

use super::data::RunData;
use crate::motor::Motor;
use crate::recording::CommandKind;

/// Reversing brakes with up to twice of what the command asks for; this many times it is none of the command's doing.
const FAR_LARGER: f64 = 4.0;

/// Rate at which a speed error of this motor dies away, 1/s, as its terminals are driven.
pub(super) fn damping_of(motor: &Motor, kind: CommandKind) -> f64 {
    let p = &motor.parameters;
    let coupling = match kind {
        CommandKind::Voltage => {
            p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm
        }
        _ => 0.0,
    };
    (p.viscous_friction_nm_s_per_rad + coupling) / p.inertia_kg_m2
}

/// Largest acceleration that the commands of the runs ask for, in counts/s^2; the recorded one where that is far larger: a
/// shaft that swings or coasts with hardly a command.
pub(super) fn largest_acceleration(motor: &Motor, runs: &[RunData]) -> f64 {
    let p = &motor.parameters;
    let largest = runs.iter().map(|run| {
        let command = run.command.iter().fold(0.0, |m, u| f64::max(m, u.abs()));
        let torque = match run.kind {
            CommandKind::Voltage => command * p.torque_constant_nm_per_a / p.resistance_ohm,
            CommandKind::Current => command * p.torque_constant_nm_per_a,
            CommandKind::Torque => command,
        };
        torque / p.inertia_kg_m2 * run.counts_per_rev / std::f64::consts::TAU
    });
    let asked = largest.fold(1.0, f64::max);
    let recorded = runs.iter().map(RunData::largest_acceleration);
    let recorded = recorded.fold(0.0, f64::max);
    if recorded > FAR_LARGER * asked {
        recorded
    } else {
        asked
    }
}
