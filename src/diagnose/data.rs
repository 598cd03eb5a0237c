//! A recorded run made ready for the likelihood.
//!
//! A count says nothing new while it stands still: the rounding error of a resting shaft is the same in
//! every sample. Each sample's likelihood therefore counts with the weight
//! `w_k = min(1, travel_k + TS / 1 s)`, travel in counts: white rounding (variance 1/12, Widrow) where the
//! shaft passes a count a sample, one look a second where it rests. The filter learns from it as from a
//! rounding of variance `1/(12 w_k)`. The travel is the
//! recording's own, smoothed, so that the weights are the same for every model.
//!
//! A recording may begin in motion, and anywhere in a turn: the simulation starts at the first count's angle, and at
//! the speed that its first samples show (`least_squares`) where that is not rest.

use super::tones;
use crate::check::host_clock::host_clock;
use crate::least_squares::{Record, counts_from_first, start_of};
use crate::motor::fit::Simulator;
use crate::motor::{Drive, Model, SimulationError};
use crate::recording::{CommandKind, Run};

/// Half width in s of the window over which travel is measured.
const WINDOW_S: f64 = 0.045;
/// Below this share of its top speed a shaft turns slowly.
const SLOW: f64 = 0.05;
/// Length of a piece in s, and its least number of samples.
pub(super) const PIECE_S: f64 = 1.0;
const PIECE_SAMPLES: usize = 60;
/// The least of one that is short since its shaft is held by an angle.
const SHORT_PIECE_SAMPLES: usize = 20;
/// Uncertainty of the speed at the start of a piece beside what rounding makes, as a share of the top speed.
const PIECE_SHARE: f64 = 0.02;

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
    /// Number of the run that it is, or is a piece of.
    pub origin: usize,
    /// Counts that the first sample itself showed.
    pub first_counts: f64,
    /// Speed in counts/s at which the simulation starts; 0 from rest.
    pub start_speed_counts_s: f64,
    /// Variance in (counts/s)^2 of the speed at which the simulation starts; 0 from rest.
    pub start_variance: f64,
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
    /// Makes a run ready, the `origin`-th.
    pub fn new(run: &Run, origin: usize) -> Result<Self, SimulationError> {
        let first = run.counts.first().copied().unwrap_or(0);
        let counts = counts_from_first(run);
        let sample_time_s = sample_time(run);
        let half = ((WINDOW_S / sample_time_s).round() as usize).clamp(1, 1000);
        let last = counts.len().saturating_sub(1);
        let mut speed_counts_s = Vec::with_capacity(counts.len());
        let mut weight = Vec::with_capacity(counts.len());
        let mut moving = Vec::with_capacity(counts.len());
        for k in 0..counts.len() {
            let (from, to) = (k.saturating_sub(half), (k + half).min(last));
            let span_s = (run.t_s[to] - run.t_s[from]).max(sample_time_s);
            let travelled = counts[to] - counts[from];
            let speed = travelled / span_s;
            let travel = speed.abs() * sample_time_s;
            speed_counts_s.push(speed);
            weight.push((travel + sample_time_s).min(1.0));
            moving.push(travelled.abs() >= 1.5);
        }
        let first_counts = first as f64;
        let rad = std::f64::consts::TAU / run.counts_per_rev;
        let command = run.driving_command();
        let record = Record::from_rest(&run.t_s, &command, &counts, run.counts_per_rev);
        let start = start_of(&record);
        let largest_command = largest(&command, 1e-12);
        let simulator = simulator(&run.t_s, &command, run.command_kind)?
            .knowing(run.known.clone())
            .starting(first_counts * rad, start.speed_counts_s * rad);
        Ok(Self {
            t_s: run.t_s.clone(),
            command: command.into_owned(),
            kind: run.command_kind,
            tones: tones::columns(&run.t_s, &counts),
            counts,
            origin,
            first_counts,
            start_speed_counts_s: start.speed_counts_s,
            start_variance: start.variance,
            top_speed_counts_s: largest(&speed_counts_s, 1.0),
            largest_command,
            speed_counts_s,
            weight,
            moving,
            sample_time_s,
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

    /// Whether the shaft turns so slowly at sample `k` that friction follows laws of its own.
    pub fn is_slow(&self, k: usize) -> bool {
        self.speed_counts_s[k].abs() < SLOW * self.top_speed_counts_s
    }

    /// Largest acceleration of the shaft where it moves, over the window, in counts/s^2.
    pub fn largest_acceleration(&self) -> f64 {
        let half = ((WINDOW_S / self.sample_time_s).round() as usize).clamp(1, 1000);
        let moves = |k: &usize| self.moving[k - half] && self.moving[k + half];
        let inside = (half..self.len().saturating_sub(half)).filter(moves);
        let change = |k: usize| {
            let change = self.speed_counts_s[k + half] - self.speed_counts_s[k - half];
            change.abs() / (self.t_s[k + half] - self.t_s[k - half])
        };
        inside.map(change).fold(0.0, f64::max)
    }

    /// Time in s from the last sample of a piece to the first of this one; none where they are not of one run, or not in
    /// this order.
    pub fn gap_s(&self, last: &Self) -> Option<f64> {
        let gap_s = self.t_s.first()? - last.t_s.last()?;
        (self.origin == last.origin && gap_s > 0.0).then_some(gap_s)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.counts.len()
    }

    /// Time in s from the first sample to the last.
    pub fn length_s(&self) -> f64 {
        let ends = (self.t_s.first(), self.t_s.last());
        if let (Some(first), Some(last)) = ends {
            last - first
        } else {
            0.0
        }
    }

    /// The part from sample `from` to before `to`, which starts at the angle and the speed recorded there.
    fn piece(&self, from: usize, to: usize) -> Result<Self, SimulationError> {
        if from == 0 {
            return self.head(to);
        }
        let (t_s, command) = (self.t_s[from..to].to_vec(), self.command[from..to].to_vec());
        let shown = self.counts[from] - 0.5;
        let first_counts = self.first_counts + shown;
        let (speed, variance) = if self.moving[from] {
            let rounding = 1.0 / (6.0 * (2.0 * WINDOW_S).powi(2));
            let bend = PIECE_SHARE * self.top_speed_counts_s;
            (self.speed_counts_s[from], rounding + bend * bend)
        } else {
            (0.0, 0.0)
        };
        let rad = std::f64::consts::TAU / self.counts_per_rev;
        Ok(Self {
            simulator: simulator(&t_s, &command, self.kind)?
                .cut_from(&self.simulator)
                .starting(first_counts * rad, speed * rad),
            t_s,
            command,
            counts: self.counts[from..to].iter().map(|n| n - shown).collect(),
            first_counts,
            start_speed_counts_s: speed,
            start_variance: variance,
            speed_counts_s: self.speed_counts_s[from..to].to_vec(),
            weight: self.weight[from..to].to_vec(),
            moving: self.moving[from..to].to_vec(),
            tones: self
                .tones
                .iter()
                .map(|tone| tone[from..to].to_vec())
                .collect(),
            ..*self
        })
    }

    /// The part up to sample `end`, for fits that keep the rest back.
    ///
    /// # Errors
    /// None that the whole run did not have.
    pub fn head(&self, end: usize) -> Result<Self, SimulationError> {
        let end = end.min(self.len());
        let (t_s, command) = (self.t_s[..end].to_vec(), self.command[..end].to_vec());
        Ok(Self {
            simulator: simulator(&t_s, &command, self.kind)?
                .cut_from(&self.simulator)
                .starting_as(&self.simulator),
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

/// The stated sample time; where the times contradict it by more than two, their median.
fn sample_time(run: &Run) -> f64 {
    let mut steps_s: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps_s.sort_by(f64::total_cmp);
    match steps_s.get(steps_s.len() / 2) {
        Some(&median_s) if !(0.5..=2.0).contains(&(median_s / run.sample_time_s)) => median_s,
        _ => run.sample_time_s,
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

/// Cuts runs into pieces of about this length in s, [`PIECE_S`] or shorter; a run that is no longer stays whole.
///
/// # Errors
/// None that the whole runs did not have.
pub(super) fn pieces(runs: &[RunData], length_s: f64) -> Result<Vec<RunData>, SimulationError> {
    let fewest = if length_s < PIECE_S {
        SHORT_PIECE_SAMPLES
    } else {
        PIECE_SAMPLES
    };
    let mut cut = Vec::new();
    for run in runs {
        let least = ((length_s / run.sample_time_s).round() as usize).max(fewest);
        let count = (run.len() / least).max(1);
        for j in 0..count {
            let (from, to) = (j * run.len() / count, (j + 1) * run.len() / count);
            cut.push(run.piece(from, to)?);
        }
    }
    Ok(cut)
}

/// Pieces spread evenly over all, with this many samples together.
pub(super) fn spread(pieces: Vec<RunData>, samples: usize) -> Vec<RunData> {
    let all: usize = pieces.iter().map(RunData::len).sum();
    let share = samples as f64 / all.max(1) as f64;
    let mut due = 0.5;
    let is_due = |_: &RunData| {
        due += share;
        let is_due = due >= 1.0;
        due -= f64::from(u8::from(is_due));
        is_due
    };
    pieces.into_iter().filter(is_due).collect()
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
