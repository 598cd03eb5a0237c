//! Memory of the simulator in fits, and its work.

use crate::integrator::dynamics::ONE_BODY;
use crate::integrator::engine::Engine;
use crate::scalar::{Dual, Scalar};

/// Memory that the simulations of one thread reuse.
#[derive(Debug, Default)]
pub struct Workspace {
    pub(crate) plain: Engines<f64>,
    pub(crate) four: Engines<Dual<4>>,
    pub(crate) eight: Engines<Dual<8>>,
}

impl Workspace {
    /// Work since the last call: about a nanosecond of one core per unit, independent of the machine.
    pub fn take_work(&mut self) -> u64 {
        let works = [
            &mut self.plain.work,
            &mut self.four.work,
            &mut self.eight.work,
        ];
        works.into_iter().map(std::mem::take).sum()
    }
}

/// Engines with one scalar type, and their work.
#[derive(Debug)]
pub(crate) struct Engines<S> {
    pub rigid: Option<Box<Engine<S, 3>>>,
    pub rigid_warm: Option<Box<Engine<S, 4>>>,
    pub two: Option<Box<Engine<S, 5>>>,
    pub two_warm: Option<Box<Engine<S, 6>>>,
    pub work: u64,
}

impl<S> Default for Engines<S> {
    fn default() -> Self {
        Self {
            rigid: None,
            rigid_warm: None,
            two: None,
            two_warm: None,
            work: 0,
        }
    }
}

/// Counts of a simulation.
pub(crate) struct Done {
    pub samples: usize,
    /// Changes of the command.
    pub changes: usize,
    pub steps: u64,
    pub curved_steps: u64,
    /// Step tables computed.
    pub tables: u64,
}

/// Estimated nanoseconds of a simulation. Start, samples and steps: least squares over 41 thousand simulations of four
/// diagnoses, with a scatter of a factor of 1.3 (one sigma). Changes and tables: a command that changes at every
/// sample, without and with a supply that sags, so that every sample has its own matrices.
pub(crate) fn work_of<S: Scalar, const N: usize>(done: &Done) -> u64 {
    let derivatives = S::DERIVATIVES as u64;
    let has_two_bodies = N > ONE_BODY + 1;
    let (start, straight, curved) = if has_two_bodies {
        (
            1700 + 1600 * derivatives,
            24 + 25 * derivatives,
            240 + 97 * derivatives,
        )
    } else {
        (
            700 * derivatives,
            11 + 8 * derivatives,
            205 + 32 * derivatives,
        )
    };
    let sample = 17 + 5 * derivatives;
    let change = 115 + 15 * derivatives;
    let table = 40 * (1 + derivatives) * (N * N * N) as u64;
    start
        + done.samples as u64 * sample
        + done.changes as u64 * change
        + (done.steps - done.curved_steps) * straight
        + done.curved_steps * curved
        + done.tables * table
}
