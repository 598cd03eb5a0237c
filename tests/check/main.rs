//! `motorlab check`: findings, and none on valid recordings.

#[path = "../support/mod.rs"]
mod support;

mod any_recording;
mod findings;
mod fires;
mod kinds;
mod real;
mod time;
