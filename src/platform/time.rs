//! Clock and timers: those of the standard library and of tokio, or those of a page.

#[cfg(not(target_family = "wasm"))]
pub use std::time::Instant;
#[cfg(not(target_family = "wasm"))]
pub use tokio::spawn;
#[cfg(not(target_family = "wasm"))]
pub use tokio::task::JoinHandle;
#[cfg(not(target_family = "wasm"))]
pub use tokio::time::{MissedTickBehavior, interval, sleep, sleep_until, timeout};

#[cfg(target_family = "wasm")]
pub use super::page::{
    JoinHandle, MissedTickBehavior, interval, sleep, sleep_until, spawn, timeout,
};
#[cfg(target_family = "wasm")]
pub use web_time::Instant;
