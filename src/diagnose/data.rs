//! A recorded run made ready for the likelihood.
//!
//! A count says nothing new while it stands still: the rounding error of a resting shaft is the same in
//! every sample. Each sample's likelihood therefore counts with the weight
//! `w_k = min(1, travel_k + TS / 1 s)`, travel in counts: white rounding (variance 1/12, Widrow) where the
//! shaft passes a count a sample, one look a second where it rests. The filter learns from it as from a
//! rounding of variance `1/(12 w_k)`. The travel is the
//! recording's own, smoothed, so that the weights are the same for every model.

use super::checks::host_clock;
use super::tones;
use crate::motor::fit::Simulator;
use crate::motor::{Drive, Model, SimulationError};
use crate::recording::{CommandKind, Run};

/// Half width in s of the window over which travel is measured.
const WINDOW_S: f64 = 0.045;

/// Columns of one run as the fit needs them.
#[derive(Debug, Clone)]
pub(super) struct RunData {
    /// Sample times in s.
    pub t_s: Vec<f64>,
    /// Commands.
    pub command: Vec<f64>,
    /// What they command.
    pub kind: CommandKind,
    /// Counts from the first sample, with half a count of rounding put back.
    pub counts: Vec<f64>,
    /// Speed in counts/s, smoothed over the window, signed.
    pub speed_counts_s: Vec<f64>,
    /// Largest of its sizes, at least 1 count/s.
    pub top_speed_counts_s: f64,
    /// Size of the largest command.
    pub largest_command: f64,
    /// How much of a look of its own each sample is, up to 1.
    pub weight: Vec<f64>,
    /// Whether the shaft moves there.
    pub moving: Vec<bool>,
    /// Tones of its rounding.
    pub tones: Vec<Vec<f64>>,
    /// Nominal sample time in s.
    pub sample_time_s: f64,
    /// Counts per revolution that the file states.
    pub counts_per_rev: f64,
    /// Supply that the file states, in V.
    pub supply_v: Option<f64>,
    /// Error of the board's clock as the host saw it, and the time in s between first and last look.
    pub clock: Option<(f64, f64)>,
    /// Where the times are arrival times at the host: the width in s over which they scatter.
    pub arrivals_scatter_s: Option<f64>,
    /// The simulator on this run's commands.
    pub simulator: Simulator,
}

impl RunData {
    /// Makes a run ready.
    pub fn new(run: &Run) -> Result<Self, SimulationError> {
        let first = run.counts.first().copied().unwrap_or(0);
        let counts: Vec<f64> = run
            .counts
            .iter()
            .map(|&n| (i128::from(n) - i128::from(first)) as f64 + 0.5)
            .collect();
        let half = ((WINDOW_S / run.sample_time_s).round() as usize).clamp(1, 1000);
        let last = counts.len().saturating_sub(1);
        let mut speed_counts_s = Vec::with_capacity(counts.len());
        let mut weight = Vec::with_capacity(counts.len());
        let mut moving = Vec::with_capacity(counts.len());
        for k in 0..counts.len() {
            let (from, to) = (k.saturating_sub(half), (k + half).min(last));
            let span_s = (run.t_s[to] - run.t_s[from]).max(run.sample_time_s);
            let travelled = counts[to] - counts[from];
            let speed = travelled / span_s;
            let travel = speed.abs() * run.sample_time_s;
            speed_counts_s.push(speed);
            weight.push((travel + run.sample_time_s).min(1.0));
            moving.push(travelled.abs() >= 1.5);
        }
        let simulator = simulator(&run.t_s, &run.command, run.command_kind)?;
        Ok(Self {
            t_s: run.t_s.clone(),
            command: run.command.clone(),
            kind: run.command_kind,
            tones: tones::columns(&run.t_s, &counts),
            counts,
            top_speed_counts_s: largest(&speed_counts_s, 1.0),
            largest_command: largest(&run.command, 1e-12),
            speed_counts_s,
            weight,
            moving,
            sample_time_s: run.sample_time_s,
            counts_per_rev: run.counts_per_rev,
            supply_v: run.supply_v,
            clock: host_clock(run),
            arrivals_scatter_s: run.is_host_timed().then(|| scatter_of(&run.t_s)),
            simulator,
        })
    }

    /// Whether the shaft starts, stops or turns back at sample `k`.
    pub fn slips(&self, k: usize) -> bool {
        k > 0
            && (self.moving[k] != self.moving[k - 1]
                || (self.moving[k] && self.speed_counts_s[k] * self.speed_counts_s[k - 1] < 0.0))
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.counts.len()
    }

    /// The part up to sample `end`, for fits that keep the rest back.
    ///
    /// # Errors
    /// None that the whole run did not have.
    pub fn head(&self, end: usize) -> Result<Self, SimulationError> {
        let end = end.min(self.len());
        let (t_s, command) = (self.t_s[..end].to_vec(), self.command[..end].to_vec());
        Ok(Self {
            simulator: simulator(&t_s, &command, self.kind)?,
            t_s,
            command,
            counts: self.counts[..end].to_vec(),
            speed_counts_s: self.speed_counts_s[..end].to_vec(),
            weight: self.weight[..end].to_vec(),
            moving: self.moving[..end].to_vec(),
            tones: self.tones.iter().map(|tone| tone[..end].to_vec()).collect(),
            ..*self
        })
    }
}

/// Width `w` of times that scatter evenly: the variance of their intervals is `2 w^2/12`.
fn scatter_of(t_s: &[f64]) -> f64 {
    let n = t_s.len().saturating_sub(1).max(1) as f64;
    let mean = (t_s.last().unwrap_or(&0.0) - t_s.first().unwrap_or(&0.0)) / n;
    let squares = t_s
        .windows(2)
        .map(|pair| (pair[1] - pair[0] - mean).powi(2));
    (6.0 * squares.sum::<f64>() / n).sqrt()
}

/// Size of the largest value, `least` at least.
fn largest(values: &[f64], least: f64) -> f64 {
    values.iter().fold(least, |most, v| most.max(v.abs()))
}

fn simulator(
    t_s: &[f64],
    command: &[f64],
    kind: CommandKind,
) -> Result<Simulator, SimulationError> {
    let drive = Drive { t_s, command, kind };
    Simulator::new(&drive, Model::SecondOrder)
}
