//! Machine-independent simulation cost of a diagnosis.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Simulated samples, a derivative counted as many again. Copies share the count.
#[derive(Debug, Clone, Default)]
pub(crate) struct Work(Arc<AtomicU64>);

impl Work {
    /// Adds a simulation of this many samples with this many derivatives.
    pub fn add(&self, samples: usize, derivatives: usize) {
        (self.0).fetch_add((samples * (1 + derivatives)) as u64, Ordering::Relaxed);
    }

    pub fn samples(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}
