//! The sketch of motorlab on an emulated Arduino with a simulated motor.
//!
//! ```text

pub mod bench;
pub mod board;
pub mod host;
pub mod line;
pub mod mcu;
pub mod truth;
pub mod wiring;
