//! The motor: parameters with units, the signal chain, the simulator.

mod active;
pub mod catalogue;
mod chain;
mod command_kind;
mod effect_parameter;
mod encoders;
mod file;
pub mod fit;
mod integrator;
mod known;
mod memory;
mod parameter_id;
mod parameters;
mod plant;
pub mod plausible;
mod reading;
mod resistance;
pub mod scalar;
mod simulate;
mod sine;
mod stages;
mod synonyms;
mod workspace;

pub use catalogue::{ActiveEffect, Effects};
pub use command_kind::CommandKind;
pub use file::{Motor, MotorFileError, read_motor, read_motor_and_lacking};
pub use known::{KnownDifferences, KnownError};
pub use parameter_id::ParameterId;
pub use parameters::Parameters;
pub use plant::Plant;
pub use simulate::{
    Drive, SimulationError, SimulationOptions, Trajectory, simulate, simulate_reporting,
};
pub use synonyms::{is_alike, nearest_name};

/// The handout's model order: without or with the inductance of the motor file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// L = 0: the current is algebraic. (The effect `inductance` has its own.)
    FirstOrder,
    /// With the winding's inductance.
    #[default]
    SecondOrder,
}
