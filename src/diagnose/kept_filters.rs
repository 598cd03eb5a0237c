//! Filters of a problem's runs, kept for as long as its noise is what it is: making one costs as much as a simulation.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::noise::{NoiseLevel, Whitener};

/// How many filters with noise of an effect's own are kept.
const KEPT_OWN: usize = 8;

/// The filters of all runs.
pub(super) type Filters = Arc<Vec<Whitener>>;

/// Filters that were made.
#[derive(Debug, Default)]
pub(super) struct KeptFilters {
    /// Of the levels of the wander without noise of an effect's own.
    shared: Mutex<Vec<(f64, Filters)>>,
    /// The last of others: a level with lost edges or late samples is often asked for again at once.
    own: Mutex<VecDeque<(NoiseLevel, Filters)>>,
}

impl KeptFilters {
    /// Those of a level, made where they are not there. Who asks for a shared level while it is being made waits for it, so
    /// that `make` must not wait for others.
    pub fn of(&self, level: &NoiseLevel, make: impl Fn() -> Vec<Whitener>) -> Filters {
        if !level.is_shared() {
            let known = locked(&self.own)
                .iter()
                .rev()
                .find(|(of, _)| of == level)
                .cloned();
            if let Some((_, filters)) = known {
                return filters;
            }
            let filters = Arc::new(make());
            let mut own = locked(&self.own);
            if own.len() == KEPT_OWN {
                own.pop_front();
            }
            own.push_back((*level, filters.clone()));
            return filters;
        }
        let mut shared = locked(&self.shared);
        if let Some((_, filters)) = shared.iter().find(|(wander, _)| *wander == level.wander) {
            return filters.clone();
        }
        let filters = Arc::new(make());
        shared.push((level.wander, filters.clone()));
        filters
    }
}

fn locked<T>(kept: &Mutex<T>) -> MutexGuard<'_, T> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}
