//! `motorlab compare`: simulated against recorded.

#[path = "../support/mod.rs"]
mod support;

mod handout;
mod known_differences;
