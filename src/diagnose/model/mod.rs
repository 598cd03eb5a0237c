//! A motor with effects: its free parameters, their priors, its predictions with derivatives.

mod base;
mod member;
mod parameters;
mod prior;
mod reference;
mod simulate;
mod tolerances;

pub(crate) use base::{BASE, Base, is_parameter_change, range_of};
pub(crate) use member::{Member, Parameter};
pub(crate) use parameters::Model;
pub(crate) use prior::freed_width;
pub(crate) use reference::ReferencePosterior;
pub(crate) use simulate::{
    corrected_residual, dot, less, mean_square, predict, sensitivities, simulated_counts,
};
