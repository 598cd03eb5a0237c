//! Runs, motors and diagnoses as files for other programs.

#[path = "../support/mod.rs"]
mod support;

mod actuator;
mod actuator_cases;
mod actuator_programs;
mod command;
mod formats;
mod pictures;
mod resistance;
mod tabulate;
