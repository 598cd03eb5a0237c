//! Probing profiles, which excite effects that a step from rest does not.
//!
//! Levels are shares of the supply of equal duration; at most 64, so that they fit boards with little memory.

use super::Segment;
use super::profile::held;

/// Reversals of a chirp.
const REVERSALS: i32 = 48;
/// Ratio of the durations of its first and last half wave.
const SPEED_UP: f64 = 16.0;

pub(super) fn probing_levels(name: &str) -> Option<Vec<f64>> {
    Some(match name {
        "threshold" => {
            let up = (0..=12).map(|k| f64::from(k) / 12.0);
            let down = (0..12).rev().map(|k| f64::from(k) / 12.0);
            let there: Vec<f64> = up.chain(down).collect();
            let back: Vec<f64> = there[1..].iter().map(|level| -level).collect();
            [there, back].concat()
        }
        "crawl" => vec![0.0, 1.0, 0.0, -1.0, 0.0, 0.7, 0.85, -0.7, -0.85, 0.0],
        "coasts" => vec![
            0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.6, 0.0, -0.6, 0.0, 0.3, 0.0, -0.3, 0.0,
        ],
        "jog" => [1.0, 0.7, 0.4]
            .iter()
            .flat_map(|size| (0..16).map(move |k| if k % 2 == 0 { *size } else { -size }))
            .chain([0.0])
            .collect(),
        "brakes" => vec![
            0.0, 1.0, 0.3, 0.8, 0.2, 1.0, 0.5, -1.0, -0.3, -0.8, -0.2, -1.0, -0.5, 0.0,
        ],
        _ => return None,
    })
}

/// Half waves of plus and minus `level` with durations in geometric progression.
pub(super) fn chirp(level: f64, duration_s: f64) -> Vec<Segment> {
    let factor = SPEED_UP.powf(-1.0 / f64::from(REVERSALS - 1));
    let length = |k: i32| factor.powi(k);
    let total: f64 = (0..REVERSALS).map(length).sum();
    let wave = |k: i32| {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        held(duration_s * length(k) / total, sign * level)
    };
    (0..REVERSALS).map(wave).collect()
}
