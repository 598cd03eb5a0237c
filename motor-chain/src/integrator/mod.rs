//! Time integration of the equations of motion: exact exponential steps within a mode, events between modes, dense
//! output at samples.

#[cfg(test)]
mod convergence;
mod curvature;
pub(crate) mod dense_output;
pub(crate) mod dynamics;
pub(crate) mod engine;
mod event_functions;
pub(crate) mod mode;
mod propagate;
mod read_off;
pub(crate) mod schedule;
mod steady_steps;
mod step_table;
mod step_tables;
mod transitions;
