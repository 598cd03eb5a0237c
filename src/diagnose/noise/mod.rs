//! Random errors: quantization, a random load torque, scatter of logged speeds.

mod random_load;
mod simulated;
mod transition;
mod whitener;

pub(crate) use random_load::{Noise, likeliest};
pub(crate) use simulated::expected_mean_square;
pub(crate) use whitener::{LinearPlant, Whitener};
