//! motorlab records a DC motor over a serial line, simulates it, compares the two and says which
//! effect causes the sim-to-real error.
//!
//! The rooms follow the data:
//!
//! | room | what happens there |
//! | --- | --- |
//! | [`board`] | serial ports, the reader thread, the board's clock, the virtual board |
//! | [`recording`] | a run: its file, the crash-safe writer, the one velocity rule |
//! | [`import`] | other programs' logs into run files, by their names or a mapping file |
//! | [`motor`] | parameters, the signal chain, the simulator |
//! | [`data_sheet`] | the numbers of a motor's data sheet as parameters |
//! | [`effects`] | the catalogue as people read it, and the experiment that shows each effect |
//! | [`check`] | faults of a recording itself, before anything is concluded from it |
//! | [`compare`] | recorded against simulated |
//! | [`least_squares`] | the plain fit of a first-order motor to recordings |
//! | [`diagnose`] | error budget, identified effects, held-out error |
//! | [`lab`] | the lab handout: its parts computed, its questions answered |
//! | [`blind`] | verdicts on sealed cases: commitments, the ledger, the score |
//! | [`fleet`] | many diagnoses as tables, and each unit against the population |
//! | [`export`] | a motor or a run in other programs' formats |
//! | [`report`] | plots, HTML, the terminal |
//! | [`hint`] | errors with what to do about them |
//! | [`plain`] | text from files and devices made harmless for its readers |
//! | [`platform`] | files and clocks where there is an operating system, and where there is none |
//! | [`cli`] | one file a subcommand: arguments and printing only |
//!
//! Arrows point one way: `cli` uses `report`, `diagnose` and `compare`; those use `check`, `least_squares`, `motor` and
//! `recording`; those use `board` and the `firmware_protocol` crate. `motor` is the crate
//! `motor-chain`, beneath all of them, so that it is compiled once. Numbers cross rooms in SI.

#[cfg(not(target_family = "wasm"))]
pub mod blind;
pub mod board;
pub mod check;
#[cfg(not(target_family = "wasm"))]
pub mod cli;
pub mod compare;
pub mod data_sheet;
pub mod diagnose;
pub mod effects;
pub mod export;
pub mod fleet;
pub mod hint;
pub mod import;
pub mod lab;
pub mod least_squares;
pub mod plain;
pub mod platform;
pub mod recording;
pub mod report;
pub mod units;

pub use motor_chain as motor;
