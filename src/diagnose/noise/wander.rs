//! How strongly, and how fast, a load wanders, and how far logged speeds scatter: by likelihood, on a grid.

use super::{Surroundings, Whitener};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{
    SPEED_SCATTER_LEAST, SPEED_SCATTER_LEVELS, USUAL_WANDER, WANDER_LEAST, WANDER_LEVELS,
    WANDER_TIMES_S,
};

/// A load that wanders, and speeds that scatter where a log has no position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// One sigma as a share of the stall torque.
    pub strength: f64,
    /// Correlation time in s.
    pub time_s: f64,
    /// One sigma of each logged speed, in counts/s, of runs whose position is integrated from them: their errors add up (a random walk).
    pub speed_counts_s: f64,
}

impl Noise {
    /// Rounding alone.
    pub const NONE: Self = Self {
        strength: 0.0,
        time_s: 0.2,
        speed_counts_s: 0.0,
    };

    /// What is implausible about it, in nats: half a square, in what benches shake by.
    pub fn prior(&self) -> f64 {
        0.5 * (self.strength / USUAL_WANDER).powi(2)
    }
}

/// The noise under which a residual is likeliest, and that is plausible itself: a search over strengths by fours, then times, then
/// strengths by twos. Where a position is integrated from speeds their scatter is found first, and once more beside the load.
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
    let top = pieces.runs.iter().filter(|run| run.is_integrated);
    let top = top.fold(0.0, |most, run| f64::max(most, run.top));
    let scatters: Vec<f64> = (0..SPEED_SCATTER_LEVELS)
        .map(|level| top * SPEED_SCATTER_LEAST * 2f64.powi(level as i32))
        .collect();
    let scatter = |best: &mut (f64, Noise)| {
        let found = best.1;
        for speed_counts_s in scatters.iter().copied().filter(|_| top > 0.0) {
            let noise = Noise {
                speed_counts_s,
                ..found
            };
            look(noise, best);
        }
    };
    scatter(&mut best);
    let begun = best.1;
    for level in (0..WANDER_LEVELS).step_by(2) {
        let noise = Noise {
            strength: WANDER_LEAST * 2f64.powi(level as i32),
            time_s: WANDER_TIMES_S[1],
            ..begun
        };
        look(noise, &mut best);
    }
    if best.1.strength == 0.0 {
        return best.1;
    }
    let begun = best.1;
    for time_s in WANDER_TIMES_S {
        look(Noise { time_s, ..begun }, &mut best);
    }
    scatter(&mut best);
    let found = best.1;
    for factor in [0.5, 2.0] {
        let strength = found.strength * factor;
        look(Noise { strength, ..found }, &mut best);
    }
    best.1
}
