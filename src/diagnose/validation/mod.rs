//! Whether an effect is there, which of several it is, and whether something unknown is beside it.

mod flexible;
mod nulls;
mod which;

pub(crate) use flexible::{Unknown, unknown};
#[cfg(test)]
pub(crate) use nulls::residual_by_chance;
pub(crate) use nulls::{Presence, left_by_chance, presence};
pub(crate) use which::{Tie, standing};
