//! Prediction bands: the RMS error as a function of the time since the segment's start.

use crate::diagnose::PredictedRun;
use crate::report::{Series, Stroke};

/// Parts of a segment over which errors are pooled.
const PARTS: usize = 8;
/// Ends of the central 95 % of a normal distribution in standard deviations.
const WITHIN_95: f64 = 1.96;

/// RMS held-out error by part of the segment, over all runs.
pub(super) struct Spread {
    rms: [f64; PARTS],
}

impl Spread {
    pub fn of<'a>(all: impl Iterator<Item = (&'a PredictedRun, Vec<f64>)>) -> Self {
        let (mut squares, mut counts) = ([0.0; PARTS], [0.0; PARTS]);
        for (predicted, errors) in all {
            for (from, to) in segments(predicted, errors.len()) {
                for (k, error) in errors[from..to].iter().enumerate() {
                    if error.is_finite() {
                        let part = k * PARTS / (to - from);
                        squares[part] += error * error;
                        counts[part] += 1.0;
                    }
                }
            }
        }
        let mut rms = [0.0; PARTS];
        for (k, rms) in rms.iter_mut().enumerate() {
            *rms = (squares[k] / f64::max(counts[k], 1.0)).sqrt();
        }
        Self { rms }
    }

    /// Half width of the band at each sample.
    fn half(&self, predicted: &PredictedRun, count: usize) -> Vec<f64> {
        let mut half = vec![f64::NAN; count];
        for (from, to) in segments(predicted, count) {
            for (k, half) in half[from..to].iter_mut().enumerate() {
                // Linear interpolation between the middles of the parts.
                let at = (k as f64 / (to - from) as f64 * PARTS as f64 - 0.5)
                    .clamp(0.0, PARTS as f64 - 1.0);
                let (low, share) = (at.floor() as usize, at.fract());
                let next = self.rms[(low + 1).min(PARTS - 1)];
                *half = WITHIN_95 * (self.rms[low] + share * (next - self.rms[low]));
            }
        }
        half
    }

    /// Lower and upper end of the band around a curve.
    pub fn around(
        &self,
        predicted: &PredictedRun,
        t_s: &[f64],
        middle: &[f64],
        colour: usize,
    ) -> [Series; 2] {
        let half = self.half(predicted, middle.len());
        let end = |sign: f64| -> Vec<f64> {
            let both = middle.iter().zip(&half);
            both.map(|(middle, half)| middle + sign * half).collect()
        };
        [
            Series::new("", Stroke::Lower, colour, t_s, &end(-1.0)),
            Series::new("95\u{a0}% band", Stroke::Upper, colour, t_s, &end(1.0)),
        ]
    }
}

/// Range of samples of each segment. Samples between two segments have no error.
pub(super) fn segments(
    predicted: &PredictedRun,
    count: usize,
) -> impl Iterator<Item = (usize, usize)> {
    let starts = predicted.starts.iter().copied();
    let ends = predicted.starts.iter().skip(1).copied().chain([count]);
    let errors = &predicted.gap_counts[0];
    let is_within = |k: &usize| errors.get(*k).is_none_or(|error| error.is_finite());
    let trimmed = move |(from, to): (usize, usize)| {
        let last = (from..to).rev().find(is_within);
        (from, last.map_or(from, |last| last + 1))
    };
    starts.zip(ends).map(trimmed).filter(|(from, to)| from < to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_as_wide_as_the_errors_at_this_time_since_the_start() {
        let predicted = PredictedRun {
            run: 0,
            gap_counts: Default::default(),
            starts: vec![0, 80],
        };
        // An error that grows from 0 to 4 in each segment of 80 samples.
        let errors: Vec<f64> = (0..160).map(|k| f64::from(k % 80) / 20.0).collect();
        let spread = Spread::of([(&predicted, errors)].into_iter());
        let t_s: Vec<f64> = (0..160).map(f64::from).collect();
        let [lower, upper] = spread.around(&predicted, &t_s, &[0.0; 160], 1);
        for k in [15, 40, 65, 95] {
            let error = f64::from(k % 80) / 20.0;
            let half = upper.points[k as usize].1;
            assert!((half - 1.96 * error).abs() < 0.15, "{k} {half}");
            assert_eq!(lower.points[k as usize].1, -half);
        }
    }
}
