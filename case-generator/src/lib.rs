//! Generator of simulated recordings with known hidden effects, independent of the simulator that diagnoses them: no
//! shared code, an integrator with steps of 10 us, dry friction as a bristle model, contacts as springs with dampers,
//! random torques of load and friction, late ticks, and effects outside the catalogue.
//!
//! ```
//! let case = case_generator::generate(1, &"stribeck".parse().unwrap());
//! assert_eq!(case.runs.len(), 3);
//! assert_eq!(case.label.effects[0].id, "stribeck");
//! assert!(case.runs[0].to_csv().starts_with("# format = \"motorlab-run/1\""));
//! ```
//!
//! Data flow: [`Motor`] and effects are drawn from the seed -> profiles -> the plant, stepped -> the board's samples
//! ([`CaseRun`]) -> [`Case`] with its [`Label`].

mod body;
pub mod breadth;
mod case;
mod chosen;
#[cfg(test)]
mod closed_forms;
mod effect;
mod freewheel;
mod friction;
mod kind;
mod loads;
mod motor;
mod plant;
mod profile;
mod random_torque;
mod record;
mod strength;
mod transmission;
mod true_motor;
mod unmodelled;

pub use case::{Case, Label, Options, generate, generate_with};
pub use chosen::{Chosen, ChosenRun, record_chosen};
pub use effect::{CATALOGUE, Effect, LATER};
pub use kind::{Kind, Mix, UnknownKind, plan};
pub use motor::{Motor, NOMINAL_SIGMA};
pub use plant::STEP_S;
pub use profile::Profile;
pub use record::CaseRun;
pub use unmodelled::OUTSIDE;
