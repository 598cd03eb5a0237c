//! The catalogue of effects: its table, its commands, and effects in other commands.

#[path = "../support/mod.rs"]
mod support;

mod command;
mod explain;
mod in_commands;
mod shown;
mod table;
