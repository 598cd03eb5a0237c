//! Importing logs of other programs.

#[path = "../support/mod.rs"]
mod support;

mod clocks;
mod direct;
mod exports;
mod formats;
mod forms;
mod inferred;
mod instruments;
mod lines;
mod mapped;
mod options;
mod public_forms;
mod real_mapped;
mod real_unmapped;
mod signs;
mod speeds;
mod ticks;
mod units;
mod unmapped;
