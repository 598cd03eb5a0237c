//! The motor: parameters with units, the signal chain, the simulator.

mod chain;
mod command;
mod driver;
pub mod effects;
mod electrical;
mod file;
mod mechanical;
mod parameters;
pub mod scalar;
mod sensor;
mod timing;
mod transmission;

pub use effects::{ActiveEffect, Effects};
pub use file::{Motor, MotorFileError, read_motor};
pub use parameters::Parameters;

/// Which of the handout's models: without or with the inductance of the motor file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// L = 0: the current follows the voltage at once. (The effect `inductance` still brings its own.)
    FirstOrder,
    /// With the winding's inductance.
    #[default]
    SecondOrder,
}
