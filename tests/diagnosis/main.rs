//! The diagnosis.

#[path = "../support/mod.rs"]
mod support;

mod assumed_torque;
mod cases;
mod delays;
mod document;
mod fast_turning;
mod figures;
mod hold_out;
mod more_data;
mod musts;
mod off_under_command;
mod perfect_motors;
mod plain_fit;
mod quick;
mod random_effects;
mod real_motors;
mod recorded;
mod reference_runs;
mod report;
mod right_model;
mod second_generator;
mod speed_logs;
mod thresholds;
mod verdicts;
mod work;
