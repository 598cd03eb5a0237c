//! Initial speed of a recording: at rest or in motion.
//!
//! A parabola through the first samples gives the speed at the first of them. A motor with a short time constant has
//! a short first interval and equal ones after it, which the parabola takes for initial motion. If the parabola shows
//! motion, the step response of a first-order motor from rest is therefore fitted to the same samples,
//!
//! `n(t) = o + v (t - T (1 - exp(-t/T)))`,
//!
//! and rest is accepted if its residual is clearly smaller, with as many coefficients. Steady motion from the first
//! sample on has no lag, and was motion before it.

use nalgebra::{Matrix3, Vector3};

use super::Record;
use crate::units::ROUNDING_VARIANCE as ROUNDING;

/// Samples from which the initial speed is estimated.
const START_SAMPLES: usize = 6;
/// Least initial speed of a shaft in motion, as a share of the mean speed of these samples.
const TURNING: f64 = 0.3;
/// Relative uncertainty of that speed in addition to quantization.
const START_SHARE: f64 = 0.05;
/// Samples that distinguish a step response from a parabola: a lag within the first six is gone in the second six.
const BENT_SAMPLES: usize = 12;
/// Least reduction of the residual by rest, in variances of a sample: three standard deviations.
const CLEARLY: f64 = 9.0;
/// Grid of time constants in mean sample times: shorter ones settle before the second sample, and for longer ones the
/// parabola is right. Neighbours differ by a tenth.
const TIME_CONSTANTS: (f64, f64, usize) = (0.1, 10.0, 48);

/// Initial state of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Start {
    /// Initial speed in counts/s; 0 from rest.
    pub speed_counts_s: f64,
    /// Its variance in (counts/s)^2; 0 from rest.
    pub variance: f64,
}

/// Initial state of a recording: rest, if it is consistent.
pub fn start_of(record: &Record<'_>) -> Start {
    let n = START_SAMPLES.min(record.counts.len());
    let (moving, _) = by_parabola(&record.t_s[..n], &record.counts[..n]);
    if moving.speed_counts_s == 0.0 {
        return moving;
    }
    let n = BENT_SAMPLES.min(record.counts.len());
    let (t_s, counts) = (&record.t_s[..n], &record.counts[..n]);
    // A step has a constant command.
    let steps = record.command[..n]
        .windows(2)
        .all(|pair| pair[0] == pair[1]);
    let (_, bent) = by_parabola(t_s, counts);
    let clearly = |rest: &f64| {
        let variance = (rest / (n - 3) as f64).max(ROUNDING);
        bent - rest > CLEARLY * variance
    };
    match step_residual(t_s, counts).filter(clearly) {
        Some(_) if steps => Start::default(),
        _ => moving,
    }
}

/// Residual sum of squares of the step response of a first-order motor from rest.
fn step_residual(t_s: &[f64], counts: &[f64]) -> Option<f64> {
    let n = counts.len();
    let step_s = (t_s[n - 1] - t_s[0]) / (n - 1) as f64;
    let (shortest, longest, tried) = TIME_CONSTANTS;
    let ratio = (longest / shortest).ln() / (tried - 1) as f64;
    let residuals = (0..tried).map(|k| {
        let time_constant_s = step_s * shortest * (ratio * k as f64).exp();
        let turned = t_s.iter().map(|t| {
            let passed_s = t - t_s[0];
            passed_s + time_constant_s * (-passed_s / time_constant_s).exp_m1()
        });
        line_residual(&turned.collect::<Vec<f64>>(), counts)
    });
    residuals
        .filter(|residuals| residuals.is_finite())
        .min_by(f64::total_cmp)
}

/// Residual sum of squares of the regression line in `x`.
fn line_residual(x: &[f64], counts: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (x_mean, n_mean) = (mean(x), mean(counts));
    let pairs = || x.iter().zip(counts).map(|(x, n)| (x - x_mean, n - n_mean));
    let slope = pairs().map(|(x, n)| x * n).sum::<f64>() / pairs().map(|(x, _)| x * x).sum::<f64>();
    pairs().map(|(x, n)| (n - slope * x).powi(2)).sum()
}

/// The parabola through these samples and its residual sum of squares; rest if it is consistent.
fn by_parabola(t_s: &[f64], counts: &[f64]) -> (Start, f64) {
    let rest = (Start::default(), 0.0);
    let n = counts.len();
    if n < 4 {
        return rest;
    }
    let span_s = t_s[n - 1] - t_s[0];
    if span_s <= 0.0 {
        return rest;
    }
    let rows: Vec<Vector3<f64>> = t_s[..n]
        .iter()
        .map(|t| (t - t_s[0]) / span_s)
        .map(|x| Vector3::new(1.0, x, x * x))
        .collect();
    let normal: Matrix3<f64> = rows.iter().map(|row| row * row.transpose()).sum();
    let right: Vector3<f64> = rows.iter().zip(counts).map(|(row, n)| row * *n).sum();
    let Some(inverse) = normal.try_inverse() else {
        return rest;
    };
    let fitted = inverse * right;
    let squares: f64 = rows
        .iter()
        .zip(counts)
        .map(|(row, n)| (n - row.dot(&fitted)).powi(2))
        .sum();
    let rounding = (squares / (n - 3) as f64).max(ROUNDING);
    let deviation = (rounding * inverse[(1, 1)]).sqrt();
    let mean = counts[n - 1] - counts[0];
    if fitted[1].abs() < 5.0 * deviation || fitted[1] / mean < TURNING {
        return rest;
    }
    let speed_counts_s = fitted[1] / span_s;
    let deviation = (deviation / span_s).hypot(START_SHARE * speed_counts_s);
    let start = Start {
        speed_counts_s,
        variance: deviation * deviation,
    };
    (start, squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_TIME_S: f64 = 0.01;

    /// Counts of a motor with a steady speed of 2,000 counts/s and an initial speed of `share` of it.
    fn counts(time_constant_s: f64, share: f64) -> (Vec<f64>, Vec<f64>) {
        let t_s: Vec<f64> = (0..300).map(|k| f64::from(k) * SAMPLE_TIME_S).collect();
        let turned = |t: &f64| {
            let settled = -time_constant_s * (-t / time_constant_s).exp_m1();
            (2000.0 * (t - (1.0 - share) * settled) + 0.4).floor() + 0.5
        };
        let counts = t_s.iter().map(turned).collect();
        (t_s, counts)
    }

    fn start(time_constant_s: f64, share: f64) -> f64 {
        let (t_s, counts) = counts(time_constant_s, share);
        let command = vec![1.0; t_s.len()];
        start_of(&Record::from_rest(&t_s, &command, &counts, 1000.0)).speed_counts_s
    }

    #[test]
    fn a_step_of_a_fast_motor_starts_at_rest() {
        for time_constant_s in [0.005, 0.008, 0.01, 0.02, 0.2] {
            assert_eq!(start(time_constant_s, 0.0), 0.0, "{time_constant_s} s");
        }
    }

    #[test]
    fn a_shaft_that_turns_at_the_first_sample_starts_in_motion() {
        for (time_constant_s, share) in [(0.05, 1.0), (0.2, 1.0), (0.2, 0.6), (0.05, 1.5)] {
            let speed = start(time_constant_s, share);
            assert!(
                (speed / (2000.0 * share) - 1.0).abs() < 0.1,
                "{speed}, {share}"
            );
        }
    }
}
