//! Encoder and timing at the shaft: counts edge by edge, their mean, and the lateness of samples.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::integrator::dynamics::{ONE_BODY, TH1};
use crate::memory::Memory;
use crate::scalar::Scalar;
use crate::stages::sensor::Sensor;

/// Index in the state of the encoder's angle; its speed is the next.
#[inline(always)]
pub(crate) fn encoder_shaft<const N: usize>(is_on_load: bool) -> usize {
    if N > ONE_BODY && is_on_load {
        N - 2
    } else {
        TH1
    }
}

/// Most groups in which the edges of one sample are lost or counted; up to this number each edge is a group. At 3 ms
/// that is a million edges a second, ten times the rate of a board without a hardware decoder.
const MOST_GROUPS: u64 = 4096;

fn uniform(random: &mut Pcg64Mcg) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Random lateness of samples.
#[derive(Debug, Clone)]
pub(crate) struct Lateness {
    spread_s: f64,
    random: Pcg64Mcg,
}

impl Lateness {
    pub(crate) fn new(spread_s: f64, seed: u64) -> Self {
        Self {
            spread_s,
            random: Pcg64Mcg::seed_from_u64(seed ^ 0x6a69_7474_6572),
        }
    }

    /// Lateness of the next sample.
    pub(crate) fn next_s(&mut self) -> f64 {
        self.spread_s * uniform(&mut self.random)
    }
}

/// The encoder's integer counts, edge by edge.
#[derive(Debug, Clone)]
pub(crate) struct Encoder {
    sensor: Sensor<f64>,
    start_fraction: f64,
    edge: i64,
    counts: i64,
    speed_rad_s: f64,
    memory: Memory<f64>,
    random: Pcg64Mcg,
}

impl Encoder {
    pub(crate) fn new(sensor: Sensor<f64>, start_fraction: f64, seed: u64) -> Self {
        let edge = (sensor.unrounded(0.0) + start_fraction).floor() as i64;
        Self {
            sensor,
            start_fraction,
            edge,
            counts: edge,
            speed_rad_s: 0.0,
            memory: Memory::new(&sensor, 0.0, 0.0),
            random: Pcg64Mcg::seed_from_u64(seed),
        }
    }

    /// Counts at this angle and speed of the shaft at this (real) time.
    pub(crate) fn read(&mut self, angle_rad: f64, speed_rad_s: f64, at_s: f64) -> i64 {
        let unrounded = if self.sensor.remembers() {
            (self.memory).read(&self.sensor, (angle_rad, speed_rad_s), at_s)
        } else {
            self.sensor.unrounded(angle_rad)
        };
        let edge = (unrounded + self.start_fraction).floor() as i64;
        let steps = edge.saturating_sub(self.edge);
        if self.sensor.faithful() {
            self.counts = self.counts.saturating_add(steps);
        } else {
            let before = self.speed_rad_s;
            let passed = steps.unsigned_abs();
            let group = passed.div_ceil(MOST_GROUPS).max(1);
            let mut from = 0;
            while from < passed {
                let edges = group.min(passed - from);
                let share = (from as f64 + 0.5 * edges as f64) / passed as f64;
                let speed = before + share * (speed_rad_s - before);
                let too_fast = self.sensor.too_fast(speed);
                let lost = self.sensor.loss > 0.0 && uniform(&mut self.random) < self.sensor.loss;
                if !too_fast && !lost {
                    let counted = steps.signum().saturating_mul(edges as i64);
                    self.counts = self.counts.saturating_add(counted);
                }
                from += edges;
            }
        }
        (self.edge, self.speed_rad_s) = (edge, speed_rad_s);
        self.counts
    }
}

/// The encoder's counts before quantization; their mean if edges are lost.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeanCounts<S> {
    sensor: Sensor<S>,
    unrounded: S,
    speed_rad_s: S,
    mean: S,
    memory: Memory<S>,
}

impl<S: Scalar> MeanCounts<S> {
    /// Starts at this angle and speed.
    pub(crate) fn new(sensor: Sensor<S>, angle_rad: S, speed_rad_s: S) -> Self {
        let unrounded = sensor.unrounded(angle_rad);
        Self {
            sensor,
            unrounded,
            speed_rad_s,
            mean: unrounded,
            memory: Memory::new(&sensor, angle_rad, speed_rad_s),
        }
    }

    /// Restarts at this angle and speed, at this (real) time.
    pub(crate) fn restart(&mut self, angle_rad: S, speed_rad_s: S, at_s: S) {
        *self = Self::new(self.sensor, angle_rad, speed_rad_s);
        self.memory.begin_at(at_s);
    }

    /// Mean counts at this angle, speed and (real) time; the last two are not used by an encoder without loss of
    /// edges.
    #[inline(always)]
    pub(crate) fn read(
        &mut self,
        angle_rad: S,
        speed_rad_s: impl FnOnce() -> S,
        at_s: impl FnOnce() -> S,
    ) -> S {
        if self.sensor.remembers() {
            return self.recall(angle_rad, speed_rad_s(), at_s());
        }
        let unrounded = self.sensor.unrounded(angle_rad);
        if self.sensor.faithful() {
            return unrounded;
        }
        self.keep(unrounded, speed_rad_s())
    }

    /// The same for an encoder with memory.
    #[inline(never)]
    fn recall(&mut self, angle_rad: S, speed_rad_s: S, at_s: S) -> S {
        let unrounded = (self.memory).read(&self.sensor, (angle_rad, speed_rad_s), at_s);
        if self.sensor.faithful() {
            return unrounded;
        }
        self.keep(unrounded, speed_rad_s)
    }

    /// Mean counts with loss of edges.
    #[inline(never)]
    fn keep(&mut self, unrounded: S, speed_rad_s: S) -> S {
        let kept = self.sensor.kept_share(self.speed_rad_s, speed_rad_s);
        self.mean += (unrounded - self.unrounded) * kept;
        (self.unrounded, self.speed_rad_s) = (unrounded, speed_rad_s);
        self.mean
    }
}
