//! What no model foresees: rounding, and a load that wanders.

mod passing;
mod wander;
mod whitener;

pub(crate) use passing::Passing;
pub(crate) use wander::{Noise, likeliest};
pub(crate) use whitener::{Surroundings, Whitener};
