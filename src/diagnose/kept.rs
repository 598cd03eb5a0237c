//! What is made once and asked for again.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

/// Things that were made, by what they were made for.
#[derive(Debug)]
pub(super) struct Kept<K, V>(Mutex<HashMap<K, Arc<V>>>);

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Eq + Hash, V> Kept<K, V> {
    /// What is kept under `key`, made where it is not there. Two who ask at once may both make it: both are the same.
    pub fn of(&self, key: K, make: impl FnOnce() -> V) -> Arc<V> {
        let locked = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = locked().get(&key) {
            return known.clone();
        }
        let made = Arc::new(make());
        locked().insert(key, made.clone());
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_made_is_not_made_again() {
        let kept = Kept::<u64, Vec<f64>>::default();
        let first = kept.of(3, || vec![1.0]);
        let again = kept.of(3, || vec![2.0]);
        assert!(Arc::ptr_eq(&first, &again));
        assert_eq!(*kept.of(4, || vec![2.0]), [2.0]);
    }
}
