//! Cache of step tables over modes and machines.
//!
//! A [`StepTable`] depends on a matrix, on whether the equations are affine, and on the longest step. Within one
//! machine the mode's [`Key`] identifies it. The modes of the next machine have the same matrices if it differs only
//! in other terms, as between the segments of a cut recording.

use crate::integrator::mode::Flow;
use crate::integrator::step_table::{Matrix, StepTable};
use crate::scalar::Scalar;

/// Most step tables kept; the oldest are dropped.
const MOST: usize = 24;

/// The parts of a mode on which the matrices of one machine depend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Key {
    pub flow: Flow,
    pub touching: bool,
    pub sticks: [bool; 2],
    /// Sign of the torque and both directions of slip, if a matrix depends on them.
    pub directions: [f64; 3],
    pub added_resistance: f64,
}

/// A step table with its key in the current machine.
#[derive(Debug, Clone)]
struct Known<S, const N: usize> {
    key: Option<Key>,
    step_table: StepTable<S, N>,
}

/// Step tables for one longest step, and the current one.
#[derive(Debug, Clone)]
pub(crate) struct StepTables<S, const N: usize> {
    longest_s: f64,
    /// The most recently used is last; tables of earlier machines have no key.
    known: Vec<Known<S, N>>,
    at: usize,
    /// Tables computed for the current machine.
    pub computed: u64,
}

impl<S: Scalar, const N: usize> StepTables<S, N> {
    /// An empty cache for this longest step.
    pub fn new(longest_s: f64) -> Self {
        Self {
            longest_s,
            known: Vec::with_capacity(MOST),
            at: 0,
            computed: 0,
        }
    }

    /// Keeps the tables for another machine.
    pub fn restart(&mut self, longest_s: f64) {
        if self.longest_s != longest_s {
            self.known.clear();
            self.longest_s = longest_s;
        }
        for known in &mut self.known {
            known.key = None;
        }
        self.computed = 0;
    }

    /// Selects the step table of this key, for affine equations or not; `matrix` is called if the machine has not
    /// used it.
    pub fn select(&mut self, key: Key, is_affine: bool, matrix: impl FnOnce() -> Matrix<S, N>) {
        if let Some(at) = self.known.iter().position(|known| known.key == Some(key)) {
            self.at = at;
            return;
        }
        let a = matrix();
        let serves = |known: &Known<S, N>| {
            known.key.is_none()
                && known.step_table.is_affine == is_affine
                && known.step_table.a == a
        };
        let step_table = match self.known.iter().position(serves) {
            Some(place) => self.known.remove(place).step_table,
            None => {
                self.computed += 1;
                StepTable::new(&a, self.longest_s, is_affine)
            }
        };
        if self.known.len() == MOST {
            self.known.remove(0);
        }
        let key = Some(key);
        self.known.push(Known { key, step_table });
        self.at = self.known.len() - 1;
    }

    /// The one in force.
    #[inline(always)]
    pub fn in_force(&self) -> &StepTable<S, N> {
        &self.known[self.at].step_table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(added_resistance: f64) -> Key {
        Key {
            flow: Flow::Free,
            touching: true,
            sticks: [false; 2],
            directions: [0.0; 3],
            added_resistance,
        }
    }

    #[test]
    fn step_tables_are_reused_only_for_the_same_matrices_and_steps() {
        let mut step_tables = StepTables::<f64, 1>::new(0.003);
        let mut made = Vec::new();
        let mut select =
            |step_tables: &mut StepTables<f64, 1>, r: f64, rate: f64, is_affine: bool| {
                step_tables.select(key(r), is_affine, || [[-rate]]);
                let step_table = step_tables.in_force();
                assert_eq!(step_table.a, [[-rate]]);
                let place: *const _ = step_table.matrices(0);
                let is_new = !made.contains(&place);
                made.push(place);
                is_new
            };
        assert!(select(&mut step_tables, 0.0, 5.0, true));
        assert!(select(&mut step_tables, 1.0, 7.0, true));
        assert!(!select(&mut step_tables, 0.0, 5.0, true));
        // The same matrices under other keys.
        step_tables.restart(0.003);
        assert!(!select(&mut step_tables, 0.5, 7.0, true));
        assert!(!select(&mut step_tables, 0.0, 5.0, true));
        assert!(select(&mut step_tables, 2.0, 5.0, false));
        assert_eq!(step_tables.known.len(), 3);
        // The same key with different matrices and steps.
        step_tables.restart(0.003);
        assert!(select(&mut step_tables, 0.0, 6.0, true));
        step_tables.restart(0.03);
        assert!(step_tables.known.is_empty());
        step_tables.select(key(0.0), true, || [[-6.0]]);
        let e = step_tables.in_force().matrices(0).e[0][0];
        assert!((e - (-0.18_f64).exp()).abs() < 1e-12, "{e}");
    }

    #[test]
    fn the_oldest_tables_are_evicted_first() {
        let mut step_tables = StepTables::<f64, 1>::new(0.003);
        for k in 0..=MOST {
            step_tables.select(key(k as f64), true, || [[-1.0 - k as f64]]);
        }
        assert_eq!(step_tables.known.len(), MOST);
        assert!(
            step_tables
                .known
                .iter()
                .all(|known| known.step_table.a != [[-1.0]])
        );
        assert_eq!(step_tables.in_force().a, [[-1.0 - MOST as f64]]);
    }
}
