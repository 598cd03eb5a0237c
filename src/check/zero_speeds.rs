//! Speeds that are 0 between rare edges, as the log has them: rounded to counts, slow ones would be 0 anyway.
//!
//! Differences of counts are 0 in most rows too where edges are rare, and their sum is right. They are whole multiples of one count,
//! and never less; a speed that is written where an edge comes takes any value while the shaft speeds up and runs out.

/// Key of the header under which the import says it.
pub(crate) const SPEED_ZERO: &str = "speed_zero";

/// Rows before and after a row whose mean is the speed there: at least so many, and so many with an edge, up to a most.
const LEAST_AROUND: usize = 12;
const EDGES_AROUND: f64 = 4.0;
const MOST_AROUND: usize = 100;
/// Before and after a row the shaft turns at this share of the speed there, at least.
const BOTH_SIDES: f64 = 0.6;
/// A row is at 0 below this share of the speed there.
const ZERO: f64 = 0.1;
/// So large a share of the rows of a turning shaft are at 0, and so many rows turn at least.
const LEAST_SHARE: f64 = 0.2;
const LEAST_ROWS: usize = 30;
/// A difference of counts over the time that really passed is a multiple of one count within this share.
const MULTIPLE: f64 = 0.05;
/// Of differences of counts at most this share are none: rows after a pause.
const OFF: f64 = 0.01;

/// A speed that jumps between 0 and its value while the shaft turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ZeroSpeeds {
    /// Of the rows of a turning shaft those at 0.
    pub share: f64,
    pub turning: usize,
    /// The mean of the other rows.
    pub at_edges: f64,
}

impl ZeroSpeeds {
    /// Of the speeds of a log, row for row.
    pub(crate) fn of(speeds: &[f64]) -> Option<Self> {
        let moving = speeds.iter().filter(|speed| **speed != 0.0).count();
        let around = (EDGES_AROUND * speeds.len() as f64 / moving.max(1) as f64) as usize;
        let around = around.clamp(LEAST_AROUND, MOST_AROUND);
        let (mut turning, mut at_zero, mut together) = (0_usize, 0_usize, 0_usize);
        let mut edges: Vec<f64> = Vec::new();
        for k in around..speeds.len().saturating_sub(around) {
            let rows = &speeds[k - around..=k + around];
            let mean = rows.iter().sum::<f64>() / rows.len() as f64;
            // The shaft turns on both sides of the row: before a start and after a stop there are rows at rest.
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

/// Whether the speeds are differences of counts: whole multiples of the smallest in steady turning.
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
    fn differences_of_counts_are_none_of_these() {
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
