//! The sketch of motorlab on an emulated Arduino that turns a simulated motor.
//!
//! ```text
//!              +--------- Board ----------+
//! Host / pty --| UART   Mcu (simavr)  PWM |--> driver --> Shaft (motorlab's motor model)
//!              |        the sketch  pins 2, 3 <------------ encoder edges, to the cycle
//!              +--------------------------+
//!                 Truth: when each sample was taken, and what the wheel's angle then was
//! ```

pub mod bench;
pub mod board;
pub mod host;
pub mod line;
pub mod mcu;
pub mod truth;
pub mod wiring;
