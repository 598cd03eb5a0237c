//! The motor: parameters with units, the signal chain, the simulator.

mod parameters;

pub use parameters::Parameters;
