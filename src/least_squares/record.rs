//! A recording as input of the fit, and the residuals of a first-order motor over several.

use std::borrow::Cow;

use super::{FirstOrder, start_of};
use crate::recording::Run;

/// Columns of a run for the fit.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    /// Sample times in s.
    pub t_s: &'a [f64],
    /// Drive of the axis from each sample to the next.
    pub command: &'a [f64],
    /// Counts relative to the first sample, plus half a count of quantization ([`counts_from_first`]).
    pub counts: &'a [f64],
    /// Counts per radian.
    pub counts_per_rad: f64,
    /// Speed at the first sample in rad/s.
    pub start_rad_s: f64,
}

/// Counts relative to the first sample of a run, plus half a count of quantization.
pub fn counts_from_first(run: &Run) -> Vec<f64> {
    let first = i128::from(run.counts.first().copied().unwrap_or(0));
    let counted = run.counts.iter();
    counted
        .map(|&n| (i128::from(n) - first) as f64 + 0.5)
        .collect()
}

pub(crate) type Columns<'a> = (Cow<'a, [f64]>, Vec<f64>);

/// Command and counts of each run, input of [`records`].
pub(crate) fn columns(runs: &[Run]) -> Vec<Columns<'_>> {
    let columns = runs.iter();
    columns
        .map(|run| (run.driving_command(), counts_from_first(run)))
        .collect()
}

/// The runs as input of the fit, each beginning at rest or in motion, as its first samples show.
pub(crate) fn records<'a>(runs: &'a [Run], columns: &'a [Columns<'a>]) -> Vec<Record<'a>> {
    (runs.iter().zip(columns))
        .map(|(run, (command, counts))| {
            let record = Record::from_rest(&run.t_s, command, counts, run.counts_per_rev);
            record.starting(start_of(&record).speed_counts_s)
        })
        .collect()
}

impl<'a> Record<'a> {
    /// A run that begins at rest.
    pub fn from_rest(
        t_s: &'a [f64],
        command: &'a [f64],
        counts: &'a [f64],
        counts_per_rev: f64,
    ) -> Self {
        Self {
            t_s,
            command,
            counts,
            counts_per_rad: counts_per_rev / std::f64::consts::TAU,
            start_rad_s: 0.0,
        }
    }

    /// The same with this initial speed.
    #[must_use]
    pub fn starting(self, speed_counts_s: f64) -> Self {
        Self {
            start_rad_s: speed_counts_s / self.counts_per_rad,
            ..self
        }
    }

    /// Simulated counts relative to the first sample, not quantized.
    pub(super) fn counts_for(&self, gain: f64, shape: FirstOrder) -> Vec<f64> {
        let mut angles = shape.angles(self.t_s, self.command, self.start_rad_s / gain);
        for angle in &mut angles {
            *angle *= gain * self.counts_per_rad;
        }
        angles
    }
}

pub(super) struct Records<'a>(pub(super) &'a [Record<'a>]);

impl Records<'_> {
    /// Largest absolute command.
    pub(super) fn largest_command(&self) -> f64 {
        let commands = self.0.iter().flat_map(|run| run.command);
        commands.fold(0.0, |most, u| f64::max(most, u.abs()))
    }

    /// The shortest mean sample time and the longest run, in s; `None` if no time passes.
    pub(super) fn step_and_length_s(&self) -> Option<(f64, f64)> {
        let ends = self.0.iter().filter_map(|run| {
            let last = run.t_s.last()? - run.t_s.first()?;
            (last > 0.0).then_some((last / (run.t_s.len() - 1) as f64, last))
        });
        ends.reduce(|(step, length), (a, b)| (step.min(a), length.max(b)))
    }

    /// The best gain for this shape; `None` if it turns against the command. The initial speed is proportional to the
    /// gain `guess`.
    pub(super) fn best_gain(&self, guess: f64, shape: FirstOrder) -> Option<f64> {
        let (mut with, mut square) = (0.0, 0.0);
        for run in self.0 {
            let angles = run.counts_for(guess, shape);
            let mean = mean(&angles);
            let counts_mean = self::mean(run.counts);
            for (angle, counts) in angles.iter().zip(run.counts) {
                with += (angle - mean) * (counts - counts_mean);
                square += (angle - mean).powi(2);
            }
        }
        let gain = guess * with / square;
        (gain.is_finite() && gain > 0.0).then_some(gain)
    }

    /// Recorded minus simulated counts of all runs, concatenated.
    pub(super) fn residuals(&self, gain: f64, shape: FirstOrder) -> Vec<f64> {
        let of_run = |run: &Record<'_>| {
            let angles = run.counts_for(gain, shape);
            let raw: Vec<f64> = run.counts.iter().zip(&angles).map(|(n, x)| n - x).collect();
            // Initial fraction of a count, including half a count of quantization.
            let start = mean(&raw).clamp(0.0, 1.0);
            raw.into_iter().map(move |r| r - start)
        };
        self.0.iter().flat_map(of_run).collect()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
