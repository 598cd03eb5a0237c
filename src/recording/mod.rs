//! A run: what was commanded and what the encoder counted, with its file and the velocity rule.

mod run;
mod velocity;

pub use run::{CommandKind, Flags, Run, UnknownFlag};
pub use velocity::{difference_velocities, velocity_rad_s};
