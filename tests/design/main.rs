//! Planning the next recording, and recording it.

#[path = "../support/mod.rs"]
mod support;

mod command;
mod experiments;
mod known_change;
mod until_known;
