//! Importing logs of other programs.

#[path = "../support/mod.rs"]
mod support;

mod formats;
mod inferred;
mod lines;
mod mapped;
mod options;
mod real_mapped;
mod real_unmapped;
mod unmapped;
