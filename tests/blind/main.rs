//! Sealed cases and their score.

#[path = "../support/mod.rs"]
mod support;

mod command;
mod score;
mod sealed;
mod shapes;
