//! The stages of the chain, one file each, with their effects.

pub(crate) mod command;
pub(crate) mod driver;
pub(crate) mod electrical;
pub(crate) mod mechanical;
pub(crate) mod sensor;
pub(crate) mod timing;
pub(crate) mod transmission;
