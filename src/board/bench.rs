//! The bench of a virtual board: volts in, encoder counts out.
//!
//! The motor simulation implements [`Bench`]; tests use benches of a few lines.

use crate::motor::Plant;

/// The mechanics behind a virtual board, stepped in true time.
pub trait Bench: Send {
    /// Advances the bench to `until_s` with a constant `command` (V, A or N m).
    fn hold(&mut self, command: f64, until_s: f64);

    /// Encoder counts now, x4 decoded, not wrapped.
    fn counts(&mut self) -> i64;

    /// Driver supply in V: the largest command.
    fn supply_v(&self) -> f64;

    /// Encoder counts per revolution.
    fn counts_per_rev(&self) -> f64;

    /// Delay of the logged command relative to the applied one, in s.
    fn notes_late_s(&self) -> f64 {
        0.0
    }
}

impl<B: Bench + ?Sized> Bench for Box<B> {
    fn hold(&mut self, command: f64, until_s: f64) {
        (**self).hold(command, until_s);
    }

    fn counts(&mut self) -> i64 {
        (**self).counts()
    }

    fn supply_v(&self) -> f64 {
        (**self).supply_v()
    }

    fn counts_per_rev(&self) -> f64 {
        (**self).counts_per_rev()
    }

    fn notes_late_s(&self) -> f64 {
        (**self).notes_late_s()
    }
}

impl Bench for Plant {
    fn hold(&mut self, command: f64, until_s: f64) {
        Self::hold(self, command, until_s);
    }

    fn counts(&mut self) -> i64 {
        Self::counts(self)
    }

    fn supply_v(&self) -> f64 {
        Self::supply_v(self)
    }

    fn counts_per_rev(&self) -> f64 {
        Self::counts_per_rev(self)
    }

    fn notes_late_s(&self) -> f64 {
        Self::notes_late_s(self)
    }
}

/// A motor without inertia or friction: its speed follows the command immediately. For tests and benchmarks with
/// exactly known counts.
#[derive(Debug, Clone)]
pub struct IdealBench {
    /// Speed per volt in counts/s.
    pub counts_per_s_per_v: f64,
    /// Driver supply in V.
    pub supply_v: f64,
    /// Encoder counts per revolution.
    pub counts_per_rev: f64,
    angle_counts: f64,
    now_s: f64,
}

impl IdealBench {
    /// At rest at count 0, with 720 counts per revolution and a supply of 4.5 V.
    pub fn new(counts_per_s_per_v: f64) -> Self {
        Self {
            counts_per_s_per_v,
            supply_v: 4.5,
            counts_per_rev: 720.0,
            angle_counts: 0.0,
            now_s: 0.0,
        }
    }
}

impl Bench for IdealBench {
    fn hold(&mut self, command: f64, until_s: f64) {
        self.angle_counts += self.counts_per_s_per_v * command * (until_s - self.now_s);
        self.now_s = until_s;
    }

    fn counts(&mut self) -> i64 {
        self.angle_counts.floor() as i64
    }

    fn supply_v(&self) -> f64 {
        self.supply_v
    }

    fn counts_per_rev(&self) -> f64 {
        self.counts_per_rev
    }
}
