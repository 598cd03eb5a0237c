//! The diagnosis.

#[path = "../support/mod.rs"]
mod support;

mod cases;
mod diagnose;
mod hold_out;
mod perfect_motors;
mod plain_fit;
mod real_motors;
mod reference;
mod reference_runs;
mod report;
mod speed_logs;
mod work;
