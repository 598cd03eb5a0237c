//! Machine-independent simulation cost of a diagnosis.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Simulated samples, a derivative counted as many again, and the simulator's estimate of its computing time. Copies
/// share the counts.
#[derive(Debug, Clone, Default)]
pub(crate) struct Work(Arc<Counts>);

#[derive(Debug, Default)]
struct Counts {
    samples: AtomicU64,
    nanoseconds: AtomicU64,
}

impl Work {
    /// Adds a simulation of this many samples with this many derivatives.
    pub fn add(&self, samples: usize, derivatives: usize, nanoseconds: u64) {
        let samples = (samples * (1 + derivatives)) as u64;
        self.0.samples.fetch_add(samples, Ordering::Relaxed);
        self.0.nanoseconds.fetch_add(nanoseconds, Ordering::Relaxed);
    }

    /// Adds that of other segments.
    pub fn add_all(&self, other: &Self) {
        self.add(other.samples() as usize, 0, other.nanoseconds());
    }

    pub fn samples(&self) -> u64 {
        self.0.samples.load(Ordering::Relaxed)
    }

    /// Estimated computing time of one core in ns, the same on every machine.
    pub fn nanoseconds(&self) -> u64 {
        self.0.nanoseconds.load(Ordering::Relaxed)
    }
}
