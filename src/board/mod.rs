//! The board room: everything between a serial device and validated samples.

mod bench;
mod clock;
pub mod faults;
mod profile;
pub mod rawlog;
pub mod text_lines;

pub use bench::{Bench, IdealBench};
pub use clock::{ClockFit, ClockFitter, MicrosUnwrapper};
pub use profile::{BUILT_IN, Profile, ProfileError, STEP_REST_S, Segment};
