//! What might be missing: each effect's shape against what the fitted model leaves, before anything is fitted.

mod candidates;
mod inverse;
mod periodic;
mod score;

pub(crate) use candidates::{Candidate, Shape, candidates};
pub(crate) use inverse::{Pick, own_part, picks, shares};
pub(crate) use periodic::filter;
pub(crate) use score::{Gain, Screen};
