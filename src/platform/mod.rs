//! Disk, clock and timers of an operating system, or their equivalents in a browser.
//!
//! Elsewhere the code is the same on both. On an operating system everything here is the standard library's or tokio's own.

pub(crate) mod files;
#[cfg(any(test, target_family = "wasm"))]
pub mod memory;
#[cfg(target_family = "wasm")]
mod page;
pub mod time;
