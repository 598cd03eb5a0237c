//! Rows of the regression: windows of steady direction, smoothed by one kernel.

use std::f64::consts::FRAC_PI_2;

use crate::diagnose::segments::{Recording, Segments};

use crate::diagnose::settings::conventions::{MOVED_COUNTS, PAUSE};
use crate::diagnose::settings::solver::{
    ACCELERATION_NOISE, LEAST_ROWS, NARROWEST_SAMPLES, WIDEST_S,
};
use crate::units::ROUNDING_VARIANCE;

/// One window of one run in which the shaft turns throughout.
#[derive(Debug)]
pub(super) struct Row {
    pub command: f64,
    pub acceleration: f64,
    pub speed: f64,
    /// Mean sine and cosine of the angle.
    pub wave: [f64; 2],
    /// Torque in N m of a load or a disc, if known.
    pub known_nm: f64,
}

/// Rows of all runs, at the smallest width at which quantization contributes little to the acceleration.
pub(super) fn rows(segments: &Segments) -> Vec<Row> {
    let mut steps: Vec<f64> = segments.runs.iter().map(|run| run.sample_time_s).collect();
    steps.sort_by(f64::total_cmp);
    let Some(step) = steps.get(steps.len() / 2) else {
        return Vec::new();
    };
    let mut half = NARROWEST_SAMPLES * step;
    loop {
        let (rows, noise) = rows_at(segments, half);
        let squares = rows.iter().map(|row| row.acceleration.powi(2)).sum::<f64>();
        let is_quiet = noise < ACCELERATION_NOISE * (squares / rows.len().max(1) as f64).sqrt();
        if rows.len() < LEAST_ROWS || is_quiet || half > WIDEST_S {
            return rows;
        }
        half *= std::f64::consts::SQRT_2;
    }
}

/// Rows at a half width in s, and the quantization error of an acceleration (one sigma, the median).
fn rows_at(segments: &Segments, half: f64) -> (Vec<Row>, f64) {
    let mut rows = Vec::new();
    let mut noises = Vec::new();
    for segment in &segments.segments {
        let run = &segments.runs[segment.run];
        let (begin, end) = (run.t_s[0] + half, run.t_s[run.t_s.len() - 1] - half);
        // One row per half width with its middle in the segment.
        let mut number = ((run.t_s[segment.from] - begin) / (0.5 * half))
            .ceil()
            .max(0.0);
        loop {
            let middle = begin + 0.5 * half * number;
            if middle >= run.t_s[segment.to - 1] || middle > end {
                break;
            }
            if let Some((row, noise)) = row(run, middle, half) {
                rows.push(row);
                noises.push(noise);
            }
            number += 1.0;
        }
    }
    noises.sort_by(f64::total_cmp);
    let noise = noises.get(noises.len() / 2).copied().unwrap_or(0.0);
    (rows, noise)
}

/// The window around one instant: the angle is interpolated linearly, the command is held between samples.
fn row(run: &Recording, middle: f64, half: f64) -> Option<(Row, f64)> {
    let from = run.t_s.partition_point(|t| *t < middle - half).max(1) - 1;
    let to = run
        .t_s
        .partition_point(|t| *t < middle + half)
        .min(run.t_s.len() - 1);
    // Not across a pause or an omitted part of a long recording.
    let is_whole = run.t_s[to] - run.t_s[from] <= 2.0 * half + PAUSE * run.sample_time_s;
    if to < from + 3 || !is_whole || !turns_throughout(run, from, to) {
        return None;
    }
    let at = |k: usize| (run.t_s[k] - middle) / half;
    let (mut command, mut speed, mut mean_angle, mut acceleration) = (0.0, 0.0, 0.0, 0.0);
    let mut noise = 0.0;
    let mut wave = [0.0; 2];
    let slope =
        |k: usize| (run.counts[k + 1] - run.counts[k]) * run.rad / (run.t_s[k + 1] - run.t_s[k]);
    let bell_over = |k: usize| bell(at(k)) / half / (run.t_s[k + 1] - run.t_s[k]);
    for k in from..to {
        let share = integral(at(k + 1)) - integral(at(k));
        command += share * run.command[k];
        speed += share * slope(k);
        mean_angle += share * 0.5 * (run.angle(k) + run.angle(k + 1));
        wave[0] += share * run.mean_sine(k, 1.0, 0.0);
        wave[1] += share * run.mean_sine(k, 1.0, FRAC_PI_2);
        if k > from {
            acceleration += bell(at(k)) / half * (slope(k) - slope(k - 1));
            // Change of the acceleration by one count at sample k.
            let next = bell(at(k + 1)) / half / (run.t_s[k + 1] - run.t_s[k]);
            let before = bell(at(k - 1)) / half / (run.t_s[k] - run.t_s[k - 1]);
            let own = bell_over(k) + bell(at(k)) / half / (run.t_s[k] - run.t_s[k - 1]);
            noise += (next + before - own).powi(2);
        }
    }
    let row = Row {
        command,
        acceleration,
        speed,
        wave,
        known_nm: run.known.torque_nm(mean_angle, acceleration),
    };
    Some((row, run.rad * (noise * ROUNDING_VARIANCE).sqrt()))
}

/// Whether the shaft moves in the same direction in each third of a window, by more than one count of dither.
fn turns_throughout(run: &Recording, from: usize, to: usize) -> bool {
    let at = |third: usize| run.counts[from + third * (to - from) / 3];
    let travelled = [at(1) - at(0), at(2) - at(1), at(3) - at(2)];
    travelled.iter().all(|d| *d > MOVED_COUNTS) || travelled.iter().all(|d| *d < -MOVED_COUNTS)
}

/// The kernel, with integral 1 over -1 to 1.
fn bell(x: f64) -> f64 {
    if x.abs() < 1.0 {
        35.0 / 32.0 * (1.0 - x * x).powi(3)
    } else {
        0.0
    }
}

fn integral(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    let (x3, x5, x7) = (x.powi(3), x.powi(5), x.powi(7));
    0.5 + 35.0 / 32.0 * (x - x3 + 0.6 * x5 - x7 / 7.0)
}
