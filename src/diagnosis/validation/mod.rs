//! Whether it is there, and which of several.

mod flexible;
mod nulls;
mod which;

pub(crate) use flexible::unknown;
#[cfg(test)]
pub(crate) use nulls::residual_by_chance;
pub(crate) use nulls::{Presence, presence};
pub(crate) use which::standing;
