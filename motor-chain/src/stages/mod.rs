//! The stages of the chain, one file each: what happens to the signal there, and which effects it knows.

pub(crate) mod command;
pub(crate) mod driver;
pub(crate) mod electrical;
pub(crate) mod mechanical;
pub(crate) mod sensor;
pub(crate) mod timing;
pub(crate) mod transmission;
