//! `motorlab lab`: the handout's report.

#[path = "../support/mod.rs"]
mod support;

mod class;
mod first_try;
mod handout;
mod steps_show;
