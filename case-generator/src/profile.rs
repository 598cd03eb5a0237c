//! Command profiles: steps, and multi-level reversing sequences.

use rand::{Rng, RngExt};

/// A command sequence, held over each sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Name in the header of the run.
    pub name: &'static str,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Command of each sample in V, whole millivolts.
    pub command_v: Vec<f64>,
}

/// Integral millivolts, as a recorder sends them.
pub(crate) fn millivolts(volts: f64) -> f64 {
    (volts * 1000.0).round() / 1000.0
}

impl Profile {
    /// At rest for 0.3 s, then the full supply until `duration_s`.
    pub(crate) fn step(sample_time_s: f64, duration_s: f64, supply_v: f64) -> Self {
        let samples = (duration_s / sample_time_s).round() as usize;
        let rest = (0.3 / sample_time_s).round() as usize;
        let command_v = (0..samples)
            .map(|k| if k < rest { 0.0 } else { millivolts(supply_v) })
            .collect();
        Self {
            name: "step",
            sample_time_s,
            command_v,
        }
    }

    /// Levels of both signs, held for 0.12 to 0.9 s: a quarter near `breakaway_v` (0.7 to 3 times), a fifth zero (the
    /// motor brakes), the rest up to the supply.
    pub(crate) fn multi_level(
        sample_time_s: f64,
        duration_s: f64,
        supply_v: f64,
        breakaway_v: f64,
        rng: &mut impl Rng,
    ) -> Self {
        let samples = (duration_s / sample_time_s).round() as usize;
        let rest = (0.15 / sample_time_s).round() as usize;
        let mut command_v = vec![0.0; rest];
        while command_v.len() < samples {
            let held = (rng.random_range(0.12..0.9) / sample_time_s).round() as usize;
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            let level = match rng.random_range(0.0..1.0) {
                u if u < 0.2 => 0.0,
                u if u < 0.45 => (breakaway_v * rng.random_range(0.7..3.0)).min(supply_v),
                _ => supply_v * rng.random_range(0.25..1.0),
            };
            command_v.extend(std::iter::repeat_n(millivolts(sign * level), held));
        }
        command_v.truncate(samples);
        Self {
            name: "multi-level",
            sample_time_s,
            command_v,
        }
    }
}
