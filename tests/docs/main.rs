//! The documentation holds together.

#[path = "../support/mod.rs"]
mod support;

mod pages;
mod promises;
