//! Models with free numbers, their priors, and the Levenberg-Marquardt fit.

mod base;
mod fitted;
mod folds;
mod levenberg;
mod member;
mod model;
mod prior;
#[cfg(test)]
mod right_model;
mod rounding;
mod simulated;
mod starts;
mod then;
mod tolerances;
mod unweighted;

pub(crate) use base::{BASE, Base, range_of};
pub(crate) use fitted::{Fit, dot, error_of_sum, jitter_s, loss, residual, surroundings};
pub(crate) use folds::{finished, score_at};
pub(crate) use levenberg::{Most, fit};
pub(crate) use member::Member;
pub(crate) use model::Model;
pub(crate) use rounding::rounding;
pub(crate) use simulated::{response, sensitivities};
pub(crate) use starts::{Starts, less_start};
pub(crate) use then::Then;
pub(crate) use unweighted::{Left, Unweighted, as_weighed, unweighted};
