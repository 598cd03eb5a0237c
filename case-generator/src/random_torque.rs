//! Random torque of load and friction, a process noise that no deterministic model predicts: an Ornstein-Uhlenbeck
//! process, stepped exactly (Gillespie 1996).

use rand::Rng;

use crate::motor::normal;

/// A stationary Gaussian process with autocorrelation exp(-t / time_s).
#[derive(Debug, Clone, Copy)]
pub(crate) struct OrnsteinUhlenbeck {
    sigma: f64,
    time_s: f64,
    value: f64,
}

impl OrnsteinUhlenbeck {
    /// Starts at a value of the stationary distribution.
    pub(crate) fn new(sigma: f64, time_s: f64, rng: &mut impl Rng) -> Self {
        Self {
            sigma,
            time_s,
            value: sigma * normal(rng),
        }
    }

    /// The value `dt` seconds later; exact for any step.
    pub(crate) fn step(&mut self, dt: f64, rng: &mut impl Rng) -> f64 {
        let kept = (-dt / self.time_s).exp();
        self.value = kept * self.value + self.sigma * (1.0 - kept * kept).sqrt() * normal(rng);
        self.value
    }
}

/// Random torque of load and of friction in a run (Ornstein-Uhlenbeck): sigma relative to Tf, and correlation time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RandomTorque {
    pub(crate) sigma: f64,
    pub(crate) time_s: f64,
}
