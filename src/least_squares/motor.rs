//! Conversion between the first-order motor and a motor file.
//!
//! With `k` the torque per unit of the command (`Kt/R` for a voltage-driven axis) and `Kb` for a voltage command
//! only: `K = 1 / (Kb + b/k)`, `T = K J / k`, `F = Tf / k`.

use super::FirstOrder;
use crate::motor::{CommandKind, Motor};

/// A first-order motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstOrderMotor {
    /// Gain in rad/s per unit of the command.
    pub gain: f64,
    /// Time constant and friction.
    pub shape: FirstOrder,
}

impl FirstOrderMotor {
    /// The motor of a motor file without inductance; `None` without damping.
    pub fn of(motor: &Motor, kind: CommandKind) -> Option<Self> {
        let p = &motor.parameters;
        let torque = torque_per_command(motor, kind);
        let back_emf = match kind {
            CommandKind::Voltage => p.back_emf_v_s_per_rad,
            CommandKind::Current | CommandKind::Torque => 0.0,
        };
        let gain = 1.0 / (back_emf + p.viscous_friction_nm_s_per_rad / torque);
        let shape = FirstOrder {
            time_constant_s: gain * p.inertia_kg_m2 / torque,
            friction: p.coulomb_friction_nm / torque,
        };
        let is_number = gain.is_finite() && shape.time_constant_s > 0.0 && shape.friction >= 0.0;
        is_number.then_some(Self { gain, shape })
    }

    /// The given motor with this gain, time constant and friction, and without inductance. Unidentifiable parameters
    /// (`R`, `Kt`, and `b` of a voltage-driven motor) are kept.
    pub fn in_place_of(&self, given: &Motor, kind: CommandKind) -> Motor {
        let Self { gain, shape } = *self;
        let torque = torque_per_command(given, kind);
        let mut motor = given.clone();
        let p = &mut motor.parameters;
        p.inertia_kg_m2 = shape.time_constant_s / gain * torque;
        p.coulomb_friction_nm = shape.friction * torque;
        if kind == CommandKind::Voltage {
            // At most half of the damping is friction.
            let viscous = (p.viscous_friction_nm_s_per_rad / torque).min(0.5 / gain);
            p.viscous_friction_nm_s_per_rad = viscous * torque;
            p.back_emf_v_s_per_rad = 1.0 / gain - viscous;
        } else {
            p.viscous_friction_nm_s_per_rad = torque / gain;
        }
        p.inductance_h = 0.0;
        motor
    }
}

/// Torque per unit of the command in N m.
fn torque_per_command(motor: &Motor, kind: CommandKind) -> f64 {
    let p = &motor.parameters;
    match kind {
        CommandKind::Voltage => p.torque_constant_nm_per_a / p.resistance_ohm,
        CommandKind::Current => p.torque_constant_nm_per_a,
        CommandKind::Torque => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fitted_parameters_are_written_to_the_motor() {
        for kind in [
            CommandKind::Voltage,
            CommandKind::Current,
            CommandKind::Torque,
        ] {
            let numbers = FirstOrderMotor {
                gain: 3.0,
                shape: FirstOrder {
                    time_constant_s: 0.07,
                    friction: 0.4,
                },
            };
            let motor = numbers.in_place_of(&Motor::default(), kind);
            let back = FirstOrderMotor::of(&motor, kind).expect("a damped motor");
            assert!((back.gain - 3.0).abs() < 1e-12, "{back:?}");
            assert!(
                (back.shape.time_constant_s - 0.07).abs() < 1e-12,
                "{back:?}"
            );
            assert!((back.shape.friction - 0.4).abs() < 1e-12, "{back:?}");
        }
    }
}
