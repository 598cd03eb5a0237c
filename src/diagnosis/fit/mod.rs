//! Models with free numbers, their priors, and the Levenberg-Marquardt fit.

mod levenberg;
mod model;
mod simulated;

pub(crate) use levenberg::{Fit, dot, finished, fit};
pub(crate) use model::{BASE, Base, Member, Model, frees, range_of};
pub(crate) use simulated::{response, sensitivities};
