//! The diagnosis.

#[path = "../support/mod.rs"]
mod support;

mod cases;
mod hold_out;
mod musts;
mod perfect_motors;
mod plain_fit;
mod real_motors;
mod reference_runs;
mod report;
mod right_model;
mod second_generator;
mod speed_logs;
mod verdicts;
mod work;
