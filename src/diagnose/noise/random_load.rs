//! Strength and correlation time of a random load torque, and the scatter of logged speeds: maximum likelihood on a grid.

use super::{LinearPlant, Whitener};
use crate::diagnose::segments::Segments;

use crate::diagnose::settings::Settings;
use crate::diagnose::settings::solver::{
    LEAST_LOAD, LOAD_FACTORS, LOAD_LEVELS, LOAD_TIMES_S, SCATTER_LEVELS,
};

/// A random load torque (Ornstein-Uhlenbeck process), and scatter of speeds where a log has no position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// One sigma as a share of the stall torque.
    pub strength: f64,
    /// Correlation time in s.
    pub time_s: f64,
    /// One sigma of each logged speed in counts/s, where the position is integrated from them: their errors are a random walk.
    pub speed_counts_s: f64,
}

impl Noise {
    /// Quantization alone.
    pub const NONE: Self = Self {
        strength: 0.0,
        time_s: LOAD_TIMES_S[1],
        speed_counts_s: 0.0,
    };

    /// The load that is assumed of a bench without a recording: an immaterial share of the usual one.
    pub fn of_a_clean_bench(settings: &Settings) -> Self {
        Self {
            strength: settings.unexplained_share * settings.usual_load,
            ..Self::NONE
        }
    }

    /// Negative log prior density of its strength, half-normal with the usual load as scale.
    pub fn prior(&self, usual_load: f64) -> f64 {
        0.5 * (self.strength / usual_load).powi(2)
    }
}

/// The noise with the largest posterior density given a residual in counts.
pub(crate) fn likeliest(
    segments: &Segments,
    plant: &LinearPlant,
    usual_load: f64,
    residual: &[f64],
) -> Noise {
    let cost = |noise: Noise| -> f64 {
        Whitener::cost_of(segments, plant, noise, residual) + noise.prior(usual_load)
    };
    let mut best = (cost(Noise::NONE), Noise::NONE);
    let look = |noise: Noise, best: &mut (f64, Noise)| {
        let cost = cost(noise);
        if cost < best.0 {
            *best = (cost, noise);
        }
    };
    let integrated = segments.runs.iter().filter(|run| run.is_integrated);
    let top = integrated.fold(0.0, |most, run| f64::max(most, run.top));
    let scatter = |best: &mut (f64, Noise)| {
        let found = best.1;
        for level in SCATTER_LEVELS {
            if top > 0.0 {
                let speed_counts_s = top / f64::from(1 << level);
                look(
                    Noise {
                        speed_counts_s,
                        ..found
                    },
                    best,
                );
            }
        }
    };
    scatter(&mut best);
    let begun = best.1;
    for level in (0..LOAD_LEVELS).step_by(2) {
        let strength = LEAST_LOAD * usual_load * 2f64.powi(level);
        look(Noise { strength, ..begun }, &mut best);
    }
    if best.1.strength == 0.0 {
        return best.1;
    }
    let begun = best.1;
    for time_s in LOAD_TIMES_S {
        look(Noise { time_s, ..begun }, &mut best);
    }
    scatter(&mut best);
    let found = best.1;
    for factor in LOAD_FACTORS {
        let strength = found.strength * factor;
        look(Noise { strength, ..found }, &mut best);
    }
    best.1
}
