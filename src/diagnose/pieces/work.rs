//! How much is simulated for a diagnosis: a count that says what it costs, on whatever machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Samples simulated for some pieces and their copies, a derivative by a number as many again.
#[derive(Debug, Clone, Default)]
pub(crate) struct Work(Arc<AtomicU64>);

impl Work {
    /// So many samples more, with so many derivatives.
    pub fn add(&self, samples: usize, derivatives: usize) {
        (self.0).fetch_add((samples * (1 + derivatives)) as u64, Ordering::Relaxed);
    }

    pub fn samples(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}
