//! `motorlab check`: what it finds, and what it leaves alone.

#[path = "../support/mod.rs"]
mod support;

mod any_recording;
mod findings;
mod fires;
mod kinds;
mod real;
mod time;
