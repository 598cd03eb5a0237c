//! What the runs are held against, and what is known of it where no motor file is given.

use serde::Serialize;

use crate::least_squares::FirstOrderMotor;
use crate::motor::{CommandKind, Motor};

/// Where the nominal motor's numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NominalSource {
    /// A motor file, or a motor that the caller has.
    #[default]
    Given,
    /// The lab handout's motor, since no motor file is given.
    Handout,
    /// The first-order model's best fit to the runs ([`nominal_fit`](crate::diagnose::nominal_fit)).
    Fit,
}

/// A first-order motor in what voltage in and position out tell: no resistance, and no torque but where a load is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SeenMotor {
    /// Steady speed in rad/s per unit of the command.
    pub steady_rad_s_per_unit: f64,
    /// Time constant in s.
    pub time_constant_s: f64,
    /// Coulomb friction, in units of the command.
    pub friction: f64,
    /// Command for a load of 1 N m, where a load or a disc is known in one of the runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_per_nm: Option<f64>,
    /// Unit of the command: V, A or N m.
    pub command_unit: &'static str,
}

impl SeenMotor {
    /// What is seen of a motor in runs with a known load or disc, or without; none of a motor without any damping.
    pub fn of(motor: &Motor, kind: CommandKind, knows_torque: bool) -> Option<Self> {
        let FirstOrderMotor { gain, shape } = FirstOrderMotor::of(motor, kind)?;
        Some(Self {
            steady_rad_s_per_unit: gain,
            time_constant_s: shape.time_constant_s,
            friction: shape.friction,
            load_per_nm: knows_torque.then(|| kind.per_nm(&motor.parameters)),
            command_unit: match kind {
                CommandKind::Voltage => "V",
                CommandKind::Current => "A",
                CommandKind::Torque => "N m",
            },
        })
    }
}
