//! Decides whether a logged speed is instantaneous, or the mean since the previous row.
//!
//! A first-order motor `T w' + w = K (u - F sgn w)` with a command that is held between rows has the logged speed `w`
//! in the first case and `(w_e + (w - w_e) (1 - a) T / h)` in the second, with the time `h` between rows, `a =
//! exp(-h/T)` and the final speed `w_e`. Each is fitted to the speeds by least squares in `K`, `K F` and the initial
//! speed, which are linear, for every `T` of a grid and some whole delays of the command; the one with the smaller
//! residual is used. (Ogata, Modern Control Engineering: first-order systems, zero-order hold.)

use nalgebra::{Matrix3, Vector3};

use super::Integration;
use crate::plain::{rounded_to, short};

/// Number of time constants of the grid, from a fifth of the sample time...
const GRID: usize = 24;
const LEAST_TIME_CONSTANT: f64 = 0.2;
/// ...to this share of the recording: a slower motor does not settle in it.
const MOST_TIME_CONSTANT: f64 = 0.5;
/// Bisections of the grid's step around its best.
const REFINEMENTS: usize = 10;
/// Delays of the motor relative to the command column in rows; -1 is a late column.
const DELAYS: [i32; 4] = [-1, 0, 1, 2];
/// Fewest rows.
const LEAST_ROWS: usize = 20;
/// Least coefficient of determination of a first-order motor as evidence.
const LEAST_EXPLAINED: f64 = 0.9;
/// Least ratio of the residual sums of squares: less may be noise.
const DECISIVE: f64 = 1.2;
/// Relative rounding error of sums of squares.
const ROUNDING: f64 = 1e-13;

/// Kind of a logged speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SpeedOf {
    /// The instantaneous speed of the row.
    Instant,
    /// The mean since the previous row.
    Mean,
}

/// One row of the log.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub t_s: f64,
    pub command: f64,
    pub speed: f64,
}

/// Result of the fit of a first-order motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rule {
    pub speed_of: SpeedOf,
    pub time_constant_s: f64,
    /// Residual RMS of the speed, and that of the other rule.
    pub left: f64,
    pub left_other: f64,
}

/// For messages.
pub(crate) const INSTANT: &str = "the speed at the instant of the row";
pub(crate) const MEAN: &str = "the mean since the row before";

impl Rule {
    pub(crate) fn integration(&self) -> Integration {
        match self.speed_of {
            SpeedOf::Instant => Integration::Trapezoid,
            SpeedOf::Mean => Integration::Backward,
        }
    }

    /// The time constant in s with which the speed goes from row to row, not in a straight line.
    pub(crate) fn curve_s(&self) -> Option<f64> {
        (self.speed_of == SpeedOf::Instant).then(|| rounded_to(self.time_constant_s, 4))
    }

    /// What it is, why, and the flag for the other one.
    pub(crate) fn words(&self, unit: &str) -> String {
        let (this, other, flag) = match self.speed_of {
            SpeedOf::Instant => (INSTANT, MEAN, Integration::Backward),
            SpeedOf::Mean => (MEAN, INSTANT, Integration::Trapezoid),
        };
        let said = |left: f64| format!("{} {unit}", short(rounded_to(left, 2)));
        format!(
            "it is {this}: a first-order motor leaves {} RMS, as {other} {} (--integrate {} says that one)",
            said(self.left),
            said(self.left_other),
            flag.name()
        )
    }
}

/// The rule with the smaller residual for a first-order motor, if one is significantly better.
pub(crate) fn rule(rows: &[Row]) -> Option<Rule> {
    let blocks: Vec<&[Row]> = rows
        .chunk_by(|before, after| after.t_s > before.t_s)
        .filter(|block| block.len() > 2)
        .collect();
    let count: usize = blocks.iter().map(|block| block.len()).sum();
    let mean = rows.iter().map(|row| row.speed).sum::<f64>() / rows.len() as f64;
    let variance = rows
        .iter()
        .map(|row| (row.speed - mean).powi(2))
        .sum::<f64>();
    if count < LEAST_ROWS || variance == 0.0 {
        return None;
    }
    let best = |speed_of| {
        let motor = |delay: &i32| Motor::on_grid(&blocks, speed_of, *delay).refined(&blocks);
        let found = DELAYS.iter().map(motor);
        found.min_by(|a, b| a.left.total_cmp(&b.left))
    };
    let (instant, mean) = (best(SpeedOf::Instant)?, best(SpeedOf::Mean)?);
    let (speed_of, better, other) = match instant.left <= mean.left {
        true => (SpeedOf::Instant, instant, mean),
        false => (SpeedOf::Mean, mean, instant),
    };
    let is_decided =
        better.left <= (1.0 - LEAST_EXPLAINED) * variance && other.left > DECISIVE * better.left;
    is_decided.then(|| Rule {
        speed_of,
        time_constant_s: better.of_log.exp(),
        left: (better.left / count as f64).sqrt(),
        left_other: (other.left / count as f64).sqrt(),
    })
}

/// A motor of the grid.
#[derive(Debug, Clone, Copy)]
struct Motor {
    speed_of: SpeedOf,
    delay: i32,
    /// Logarithm of the time constant in s, and the step of the grid there.
    of_log: f64,
    step: f64,
    /// Residual sum of squares.
    left: f64,
}

impl Motor {
    /// The best one of the grid.
    fn on_grid(blocks: &[&[Row]], speed_of: SpeedOf, delay: i32) -> Self {
        let longest = blocks
            .iter()
            .map(|block| block[block.len() - 1].t_s - block[0].t_s);
        let spans = longest.clone().sum::<f64>();
        let steps = blocks.iter().map(|block| block.len() - 1).sum::<usize>();
        let least = (LEAST_TIME_CONSTANT * spans / steps as f64).ln();
        let most = (MOST_TIME_CONSTANT * longest.fold(0.0, f64::max))
            .ln()
            .max(least + 1.0);
        let step = (most - least) / (GRID - 1) as f64;
        let at = |k: usize| {
            let of_log = least + step * k as f64;
            Self {
                speed_of,
                delay,
                of_log,
                step,
                left: left(blocks, speed_of, delay, of_log.exp()),
            }
        };
        let first = at(0);
        (1..GRID).map(at).fold(
            first,
            |best, one| if one.left < best.left { one } else { best },
        )
    }

    /// The best around it, by bisection of the grid's step.
    fn refined(self, blocks: &[&[Row]]) -> Self {
        let mut best = self;
        for _ in 0..REFINEMENTS {
            best.step /= 2.0;
            for of_log in [best.of_log - best.step, best.of_log + best.step] {
                let left = left(blocks, self.speed_of, self.delay, of_log.exp());
                if left < best.left {
                    best = Self {
                        of_log,
                        left,
                        ..best
                    };
                }
            }
        }
        best
    }
}

/// Residual sum of squares for this time constant.
fn left(blocks: &[&[Row]], speed_of: SpeedOf, delay: i32, time_constant_s: f64) -> f64 {
    let (mut gram, mut products, mut squares) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for block in blocks {
        // Speeds for a unit command, a unit friction and a unit initial speed.
        let mut state = Vector3::new(0.0, 0.0, 1.0);
        for (k, pair) in block.windows(2).enumerate() {
            let h = (pair[1].t_s - pair[0].t_s) / time_constant_s;
            let settled = -(-h).exp_m1();
            let at = (k as i64 - i64::from(delay)).clamp(0, block.len() as i64 - 1) as usize;
            // At rest, static friction balances the command.
            let moves = pair[0].speed != 0.0 || pair[1].speed != 0.0;
            let way = if pair[1].speed == 0.0 {
                pair[0].speed
            } else {
                pair[1].speed
            };
            let end = match moves {
                true => Vector3::new(block[at].command, -way.signum(), 0.0),
                false => Vector3::zeros(),
            };
            let off = state - end;
            state = end + off * (1.0 - settled);
            let shown = match speed_of {
                SpeedOf::Instant => state,
                SpeedOf::Mean => end + off * (settled / h),
            };
            gram += shown * shown.transpose();
            products += shown * pair[1].speed;
            squares += pair[1].speed.powi(2);
        }
    }
    // Friction and command are one column if the command has one level.
    let solved = gram.svd(true, true).solve(&products, 1e-12 * gram.norm());
    let explained = solved.map_or(0.0, |by| by.dot(&products));
    // Rounding of the sums is no residual.
    (squares - explained).max(ROUNDING * squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIME_CONSTANT_S: f64 = 0.08;

    /// A first-order motor under levels held between rows, its speed rounded as in a log.
    fn rows(h: f64, speed_of: SpeedOf, delay: usize) -> Vec<Row> {
        let level = |k: usize| match (k as f64 * h / 0.9) as usize % 4 {
            0 => 0.0,
            1 => 6.0,
            2 => -4.0,
            _ => 2.0,
        };
        let settled = -(-h / TIME_CONSTANT_S).exp_m1();
        let (mut speed, mut shown) = (0.0, 0.0);
        (0..(8.0 / h) as usize)
            .map(|k| {
                let row = Row {
                    t_s: k as f64 * h,
                    command: level(k),
                    speed: (1000.0_f64 * shown).round() / 1000.0,
                };
                let end = 1.7 * level(k.saturating_sub(delay));
                let off = speed - end;
                speed = end + off * (1.0 - settled);
                shown = match speed_of {
                    SpeedOf::Instant => speed,
                    SpeedOf::Mean => end + off * settled * TIME_CONSTANT_S / h,
                };
                row
            })
            .collect()
    }

    #[test]
    fn the_rule_of_a_perfect_motor_is_found_from_5_to_50_ms() {
        for h in [0.005, 0.01, 0.02, 0.05] {
            for speed_of in [SpeedOf::Instant, SpeedOf::Mean] {
                for delay in [0, 1] {
                    let found = rule(&rows(h, speed_of, delay)).expect("a rule");
                    assert_eq!(found.speed_of, speed_of, "{h} {delay}: {found:?}");
                    let off = found.time_constant_s / TIME_CONSTANT_S - 1.0;
                    assert!(off.abs() < 0.01, "{h} {speed_of:?}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn data_of_no_motor_decide_no_rule() {
        let noise = |k: usize| ((k * k * 7919) % 101) as f64 - 50.0;
        let rows: Vec<Row> = (0..300)
            .map(|k| Row {
                t_s: 0.01 * k as f64,
                command: if k < 50 { 0.0 } else { 6.0 },
                speed: noise(k),
            })
            .collect();
        assert_eq!(rule(&rows), None);
        assert_eq!(rule(&rows[..3]), None);
    }
}
