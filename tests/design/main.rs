//! Planning the next recording, and recording it.

#[path = "../support/mod.rs"]
mod support;

mod command;
mod design_loop;
mod known_change;
mod next_experiment;
mod until_known;
