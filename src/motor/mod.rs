//! The motor: parameters with units, the signal chain, the simulator.

mod active;
mod chain;
mod command;
mod command_kind;
#[cfg(test)]
mod convergence;
mod cruise;
mod curvature;
mod driver;
mod dynamics;
mod effect_parameter;
pub mod effects;
mod electrical;
mod encoders;
mod engine;
mod file;
pub mod fit;
mod guards;
mod inside;
mod ladder;
mod ladders;
mod mechanical;
mod parameter_id;
mod parameters;
mod plant;
mod propagate;
mod read_off;
mod reading;
pub mod scalar;
mod schedule;
mod sensor;
mod simulate;
mod sine;
mod timing;
mod transitions;
mod transmission;
mod workspace;

pub use command_kind::CommandKind;
pub use effects::{ActiveEffect, Effects};
pub use file::{Motor, MotorFileError, read_motor};
pub use parameters::Parameters;
pub use plant::Plant;
pub use simulate::{Drive, SimulationError, SimulationOptions, Trajectory, simulate};

/// Which of the handout's models: without or with the inductance of the motor file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// L = 0: the current follows the voltage at once. (The effect `inductance` still brings its own.)
    FirstOrder,
    /// With the winding's inductance.
    #[default]
    SecondOrder,
}
