//! How strongly, and how fast, a load wanders: by likelihood, on a grid.

use super::{Surroundings, Whitener};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{USUAL_WANDER, WANDER_LEAST, WANDER_LEVELS, WANDER_TIMES_S};

/// A load that wanders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// One sigma as a share of the stall torque.
    pub strength: f64,
    /// Correlation time in s.
    pub time_s: f64,
}

impl Noise {
    /// Rounding alone.
    pub const NONE: Self = Self {
        strength: 0.0,
        time_s: 0.2,
    };

    /// What is implausible about it, in nats: half a square, in what benches shake by.
    pub fn prior(&self) -> f64 {
        0.5 * (self.strength / USUAL_WANDER).powi(2)
    }
}

/// The noise under which a residual is likeliest, and that is plausible itself: a search over strengths by fours, then times, then strengths by twos.
pub(crate) fn likeliest(pieces: &Pieces, around: &Surroundings, residual: &[f64]) -> Noise {
    let cost = |noise: Noise| -> f64 {
        let whitener = Whitener::new(pieces, around, noise);
        let e = whitener.whiten(residual);
        let squares = e.iter().map(|e| e * e).sum::<f64>();
        squares + whitener.log_det.iter().sum::<f64>() + 2.0 * noise.prior()
    };
    let mut best = (cost(Noise::NONE), Noise::NONE);
    let look = |noise: Noise, best: &mut (f64, Noise)| {
        let cost = cost(noise);
        if cost < best.0 {
            *best = (cost, noise);
        }
    };
    let at = |level: usize, time_s: f64| Noise {
        strength: WANDER_LEAST * 2f64.powi(level as i32),
        time_s,
    };
    for level in (0..WANDER_LEVELS).step_by(2) {
        look(at(level, WANDER_TIMES_S[1]), &mut best);
    }
    if best.1.strength == 0.0 {
        return best.1;
    }
    for time_s in WANDER_TIMES_S {
        let strength = best.1.strength;
        look(Noise { strength, time_s }, &mut best);
    }
    let found = best.1;
    for factor in [0.5, 2.0] {
        let strength = found.strength * factor;
        look(Noise { strength, ..found }, &mut best);
    }
    best.1
}
