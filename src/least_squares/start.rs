//! Whether a recording begins at rest or in motion, and how fast.
//!
//! A parabola through the first samples gives the speed at the first of them. A motor that is nearly up to speed before the
//! second sample bends otherwise: its first samples lie on a line that does not pass through the first one, and the parabola
//! takes the step from rest for a start in motion. So where the parabola says motion, the first-order motor is fitted to the
//! beginning both ways, and rest stands where it leaves less.

use nalgebra::{Matrix3, Vector3};

use super::{PlainFit, Record, plain_fit};

/// Samples that tell the speed at the first of them.
const START_SAMPLES: usize = 6;
/// A shaft that has this share of its mean speed over them at the first was turning before.
const TURNING: f64 = 0.3;
/// Uncertainty of that speed beside what rounding makes, as a share.
const START_SHARE: f64 = 0.05;
/// Samples to which both are fitted: a motor that bends within the first six has long settled then.
const HEAD_SAMPLES: usize = 200;
/// How much less rest has to leave, in variances of a sample: three standard deviations. Where both follow the samples alike,
/// a shaft that turns evenly from the first sample on was turning before.
const CLEARLY: f64 = 9.0;
/// Variance of what rounding leaves, in counts^2 (Widrow).
const ROUNDING: f64 = 1.0 / 12.0;

/// How a recording begins.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Start {
    /// Speed at the first sample in counts/s; 0 from rest.
    pub speed_counts_s: f64,
    /// Its variance in (counts/s)^2; 0 from rest.
    pub variance: f64,
}

/// How a recording begins: at rest, where it may have.
pub fn start_of(record: &Record<'_>) -> Start {
    let moving = by_parabola(record.t_s, record.counts);
    if moving.speed_counts_s == 0.0 {
        return moving;
    }
    let samples = HEAD_SAMPLES.min(record.counts.len()) as f64;
    let squares = |speed_counts_s: f64| {
        let begun = record.starting(speed_counts_s).head(HEAD_SAMPLES);
        plain_fit(&[begun], &[]).map(|PlainFit { left_counts, .. }| samples * left_counts.powi(2))
    };
    match (squares(0.0), squares(moving.speed_counts_s)) {
        (Some(at_rest), Some(in_motion)) => {
            let variance = (at_rest / samples).max(ROUNDING);
            if in_motion - at_rest > CLEARLY * variance {
                Start::default()
            } else {
                moving
            }
        }
        _ => moving,
    }
}

/// Least squares of a parabola through the first samples; rest where it may have been.
fn by_parabola(t_s: &[f64], counts: &[f64]) -> Start {
    let n = START_SAMPLES.min(counts.len());
    if n < 4 {
        return Start::default();
    }
    let span_s = t_s[n - 1] - t_s[0];
    if span_s <= 0.0 {
        return Start::default();
    }
    let rows: Vec<Vector3<f64>> = t_s[..n]
        .iter()
        .map(|t| (t - t_s[0]) / span_s)
        .map(|x| Vector3::new(1.0, x, x * x))
        .collect();
    let normal: Matrix3<f64> = rows.iter().map(|row| row * row.transpose()).sum();
    let right: Vector3<f64> = rows.iter().zip(counts).map(|(row, n)| row * *n).sum();
    let Some(inverse) = normal.try_inverse() else {
        return Start::default();
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
        return Start::default();
    }
    let speed_counts_s = fitted[1] / span_s;
    let deviation = (deviation / span_s).hypot(START_SHARE * speed_counts_s);
    Start {
        speed_counts_s,
        variance: deviation * deviation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_TIME_S: f64 = 0.01;

    /// Counts of a motor with a steady speed of 2,000 counts/s that is `share` of it fast at the first sample.
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
    fn a_fast_motors_step_begins_at_rest() {
        for time_constant_s in [0.005, 0.008, 0.01, 0.02, 0.2] {
            assert_eq!(start(time_constant_s, 0.0), 0.0, "{time_constant_s} s");
        }
    }

    #[test]
    fn a_shaft_that_turns_from_the_first_sample_on_was_turning_before() {
        for (time_constant_s, share) in [(0.05, 1.0), (0.2, 1.0), (0.2, 0.6), (0.05, 1.5)] {
            let speed = start(time_constant_s, share);
            assert!(
                (speed / (2000.0 * share) - 1.0).abs() < 0.1,
                "{speed}, {share}"
            );
        }
    }
}
