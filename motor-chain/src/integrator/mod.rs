//! The equations of motion through time: exact exponential steps within a mode, events between modes, and the
//! state inside a step where a sample lies.

#[cfg(test)]
mod convergence;
mod cruise;
mod curvature;
pub(crate) mod dynamics;
pub(crate) mod engine;
mod guards;
pub(crate) mod inside;
mod ladder;
mod ladders;
mod propagate;
mod read_off;
pub(crate) mod schedule;
mod transitions;
