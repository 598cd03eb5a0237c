//! Models with free numbers, their priors, and the Levenberg-Marquardt fit.

mod levenberg;
mod model;
mod simulated;
mod start_error;
mod unweighted;

pub(crate) use levenberg::{
    Fit, dot, finished, fit, jitter_s, loss, residual, score_at, surroundings,
};
pub(crate) use model::{BASE, Base, Member, Model, range_of};
pub(crate) use simulated::{response, sensitivities};
pub(crate) use start_error::less_start;
pub(crate) use unweighted::{Left, Unweighted, unweighted};
