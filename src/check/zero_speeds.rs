//! Logged speeds that are 0 between rare edges, from the log's own values before they are rounded to counts.
//!
//! Differences of counts are 0 in most rows as well where edges are rare, and their sum is right. They are whole
//! multiples of one count; a speed that is computed at each edge takes any value while the shaft accelerates or
//! coasts.

/// Header key under which the import states it.
pub(crate) const SPEED_ZERO: &str = "speed_zero";

/// Rows on each side over which the speed is averaged: the fewest, the fewest with an edge, the most.
const LEAST_AROUND: usize = 12;
const EDGES_AROUND: f64 = 4.0;
const MOST_AROUND: usize = 100;
/// Least speed on each side of a row as a share of the average.
const BOTH_SIDES: f64 = 0.6;
/// A row is 0 below this share of the average.
const ZERO: f64 = 0.1;
/// Least share of the rows of a turning shaft that are 0, and fewest rows of a turning shaft.
const LEAST_SHARE: f64 = 0.2;
const LEAST_ROWS: usize = 30;
/// A difference of counts over the measured time is a multiple of one count within this share.
const MULTIPLE: f64 = 0.05;
/// Largest share of rows that are no multiples: rows after a pause.
const OFF: f64 = 0.01;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ZeroSpeeds {
    /// Share of the rows of a turning shaft that are 0.
    pub share: f64,
    pub turning: usize,
    /// The mean of the other rows.
    pub at_edges: f64,
}

impl ZeroSpeeds {
    pub(crate) fn of(speeds: &[f64]) -> Option<Self> {
        let moving = speeds.iter().filter(|speed| **speed != 0.0).count();
        let around = (EDGES_AROUND * speeds.len() as f64 / moving.max(1) as f64) as usize;
        let around = around.clamp(LEAST_AROUND, MOST_AROUND);
        let (mut turning, mut at_zero, mut together) = (0_usize, 0_usize, 0_usize);
        let mut edges: Vec<f64> = Vec::new();
        for k in around..speeds.len().saturating_sub(around) {
            let rows = &speeds[k - around..=k + around];
            let mean = rows.iter().sum::<f64>() / rows.len() as f64;
            // The shaft turns on both sides: rows before a start and after a stop are at rest.
            let half = |rows: &[f64]| rows.iter().sum::<f64>() / around as f64;
            let (before, after) = (half(&rows[..around]), half(&rows[around + 1..]));
            let least = (before * mean.signum()).min(after * mean.signum());
            if mean == 0.0 || !mean.is_finite() || least < BOTH_SIDES * mean.abs() {
                together = 0;
                continue;
            }
            turning += 1;
            if speeds[k].abs() >= ZERO * mean.abs() {
                together = 0;
                edges.push(speeds[k].abs());
                continue;
            }
            together += 1;
            if together > around {
                return None;
            }
            at_zero += 1;
        }
        let share = at_zero as f64 / turning.max(1) as f64;
        let is_found = turning >= LEAST_ROWS && share >= LEAST_SHARE && !edges.is_empty();
        (is_found && !are_counts(speeds, &edges)).then(|| Self {
            share,
            turning,
            at_edges: edges.iter().sum::<f64>() / edges.len() as f64,
        })
    }
}

/// Whether the speeds are differences of counts: multiples of the smallest one in steady turning.
fn are_counts(speeds: &[f64], edges: &[f64]) -> bool {
    let count = edges.iter().copied().fold(f64::INFINITY, f64::min);
    let (mut moving, mut off) = (0_usize, 0_usize);
    for speed in speeds.iter().map(|speed| speed.abs()).filter(|x| *x > 0.0) {
        let times = (speed / count).round();
        moving += 1;
        off += usize::from((speed - times * count).abs() > MULTIPLE * speed);
    }
    off as f64 <= OFF * moving as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first-order motor that is switched on and off, in counts a row.
    fn speeds(top: f64) -> Vec<f64> {
        let mut speed = 0.0;
        let step = |k: u32| {
            let end = if (50..700).contains(&k) { top } else { 0.0 };
            speed += 0.12 * (end - speed);
            speed
        };
        (0..900).map(step).collect()
    }

    #[test]
    fn speeds_of_0_between_rare_edges_are_found_however_slow() {
        for top in [0.05, 0.6, 12.0] {
            for every in [2, 5, 12, 20] {
                let mut log = speeds(top);
                for (k, speed) in log.iter_mut().enumerate() {
                    *speed *= f64::from(u8::from(k % every == 0));
                }
                let found = ZeroSpeeds::of(&log).expect("speeds of 0");
                let share = 1.0 - 1.0 / every as f64;
                assert!(
                    (found.share - share).abs() < 0.05,
                    "{top} {every}: {found:?}"
                );
                assert!((found.at_edges / top - 1.0).abs() < 0.1, "{found:?}");
            }
            assert_eq!(ZeroSpeeds::of(&speeds(top)), None);
        }
    }

    #[test]
    fn differences_of_counts_are_no_zero_speeds() {
        for top in [0.05, 0.3, 0.9, 2.4] {
            for jitter in [0.0, 0.02] {
                let mut position = 0.3;
                let log: Vec<f64> = (speeds(top).iter().enumerate())
                    .map(|(k, speed)| {
                        let before = f64::floor(position);
                        position += speed;
                        let step_s = 0.01 * (1.0 + jitter * (k as f64 * 1.7).sin());
                        (position.floor() - before) / step_s
                    })
                    .collect();
                assert_eq!(ZeroSpeeds::of(&log), None, "{top} {jitter}");
            }
        }
    }
}
