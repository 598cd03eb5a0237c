//! motorlab records a DC motor over a serial line, simulates it, compares the two and says which
//! effect causes the sim-to-real error.
//!
//! The rooms follow the data:
//!
//! | room | what happens there |
//! | --- | --- |
//! | [`board`] | serial ports, the reader thread, the board's clock, the virtual board |
//! | [`recording`] | a run: its file, the crash-safe writer, the velocity estimate |
//! | [`import`] | other programs' logs as run files, by column names or a mapping file |
//! | [`motor`] | parameters, the signal chain, the simulator |
//! | [`data_sheet`] | model parameters from a motor's data sheet |
//! | [`effects`] | the catalogue for readers, and the experiment that shows each effect |
//! | [`check`] | faults of a recording, found before any diagnosis |
//! | [`compare`] | recorded runs against their simulation |
//! | [`least_squares`] | the fit of a first-order motor to recordings |
//! | [`diagnose`] | error budget, identified effects, held-out error |
//! | [`lab`] | the lab handout: its parts computed, its questions answered |
//! | [`blind`] | verdicts on sealed cases: commitments, the ledger, the score |
//! | [`fleet`] | many diagnoses as tables, and each unit compared with the population |
//! | [`export`] | a motor or a run in other programs' formats |
//! | [`report`] | plots, HTML, the terminal |
//! | [`hint`] | errors with hints |
//! | [`plain`] | text from files and devices without control characters |
//! | [`platform`] | files and clocks of an operating system or a browser |
//! | [`cli`] | one file per subcommand: arguments and printing only |
//!
//! Dependencies point one way: `cli` uses `report`, `diagnose` and `compare`; those use `check`, `least_squares`,
//! `motor` and `recording`; those use `board` and the `firmware_protocol` crate. `motor` is the crate `motor-chain`,
//! separate so that it is compiled once. Numbers between modules are in SI units.

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
