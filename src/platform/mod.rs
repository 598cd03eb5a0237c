//! Disk, clock and timers of an operating system, or their equivalents in a browser.
//!
//! Callers are the same on both. On an operating system everything here is from the standard library or tokio.

pub(crate) mod files;
#[cfg(any(test, target_family = "wasm"))]
pub mod memory;
#[cfg(target_family = "wasm")]
mod page;
pub mod time;
