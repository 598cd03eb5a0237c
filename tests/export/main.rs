//! Runs, motors and diagnoses as files for other programs.

#[path = "../support/mod.rs"]
mod support;

mod command;
mod formats;
mod pictures;
mod tabulate;
