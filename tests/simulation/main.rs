//! The simulator against closed forms, conserved quantities and independent programs.

#[path = "../support/mod.rs"]
mod support;

mod closed_form;
mod generator_laws;
mod laws_of_motion;
mod reference;
mod sensitivities;
mod stiffness;
