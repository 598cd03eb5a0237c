//! Recordings from boards, ports and raw logs, and their run files.

#[path = "../support/mod.rs"]
mod support;

mod board_fixtures;
mod capture;
mod cases;
mod death;
mod faults;
mod first_use;
mod fixtures;
mod flash;
mod live;
mod long_runs;
mod odd_lines;
mod one_velocity_rule;
mod ports;
mod replay;
mod run_file;
mod text_boards;
