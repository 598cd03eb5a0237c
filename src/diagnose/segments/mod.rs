//! Runs cut into segments, each predicted from its measured initial state (multiple shooting; Bock 1983).
//!
//! In: runs and a motor (its time constant sets the length of a segment). Out: [`Segments`]. An initial state is the
//! measured angle and a speed by local regression; hidden states (temperature, current, side of a backlash, delayed
//! command) continue from the past. The error of the measured initial state is removed from every residual and
//! derivative by one linear operator per segment ([`correction`]), the same for all models.

mod correction;
mod feedback;
mod recording;
mod regimes;
mod subset;
mod work;

pub(crate) use recording::{Recording, driven};
pub(crate) use regimes::regimes;
pub(crate) use subset::Subset;
pub(crate) use work::Work;

use std::ops::Range;
use std::sync::Arc;

use crate::motor::{CommandKind, Motor, Parameters};
use crate::recording::Run;

use super::error::{DiagnoseError, name_of};
use super::settings::Settings;
use super::settings::conventions::CUT_REACH;
use correction::Correction;

/// A contiguous part of one run.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    pub run: usize,
    pub from: usize,
    pub to: usize,
    /// Index of its first sample in the concatenation of all segments.
    pub at: usize,
    /// Standard deviation of its initial speed in counts/s.
    pub start_speed_sd: f64,
}

impl Segment {
    pub fn len(&self) -> usize {
        self.to - self.from
    }

    /// Its samples in the concatenation of all segments.
    pub fn range(&self) -> Range<usize> {
        self.at..self.at + self.len()
    }
}

/// All segments of all runs.
#[derive(Debug, Clone)]
pub(crate) struct Segments {
    /// Shared by copies: an hour at 3 ms has more than 100 MB of them.
    pub runs: Arc<Vec<Recording>>,
    pub segments: Vec<Segment>,
    /// Number of samples.
    pub len: usize,
    /// Counts relative to the segment's first sample, concatenated.
    pub counts: Vec<f64>,
    /// Information of each sample relative to an independent one: samples at rest repeat one observation.
    pub weight: Vec<f64>,
    /// Spread of arrival times in s, if times are arrivals at the host.
    pub arrivals_s: f64,
    /// Simulation cost of these and of copies of them.
    pub work: Work,
    correction: Vec<Correction>,
}

impl Segments {
    /// Cuts runs of a motor.
    pub fn new(runs: &[Run], motor: &Motor, settings: &Settings) -> Result<Self, DiagnoseError> {
        let mut recordings = Vec::new();
        for (k, run) in runs.iter().enumerate() {
            let made = Recording::new(run, settings).map_err(|source| DiagnoseError::Simulation {
                run: name_of(k, run),
                source,
            });
            recordings.push(made?);
        }
        let length_s = settings
            .segment_s
            .max(settings.segment_time_constants * time_constant_s(motor).min(settings.segment_s));
        let mut segments = Vec::new();
        let mut len = 0;
        for (number, run) in recordings.iter_mut().enumerate() {
            // In closed loop a motor that ignores its command predicts best in the long run; a short segment is an
            // equation error (Ljung 1999, section 13.4).
            let least = match run.is_closed_loop {
                true => settings.segment_samples,
                false => {
                    ((length_s / run.sample_time_s).round() as usize).max(settings.segment_samples)
                }
            };
            let mut restarts = Vec::new();
            for part in run.driven() {
                let begins = cuts(run, &part, (part.len() / least).max(1));
                let ends = begins.iter().skip(1).copied().chain([part.end]);
                for (&from, to) in begins.iter().zip(ends) {
                    segments.push(Segment {
                        run: number,
                        from,
                        to,
                        at: len,
                        start_speed_sd: run.start(from).1,
                    });
                    len += to - from;
                }
                restarts.extend(begins);
            }
            run.restart(restarts);
        }
        let arrivals_s = (runs.iter().filter(|run| run.is_host_timed()))
            .map(|run| arrival_spread_s(&run.t_s))
            .fold(0.0, f64::max);
        let made = Self::of(recordings, segments, arrivals_s);
        Ok(made.with_time_constant(time_constant_s(motor)))
    }

    /// From segments of recordings, without a correction.
    fn of(recordings: Vec<Recording>, segments: Vec<Segment>, arrivals_s: f64) -> Self {
        let len = segments.iter().map(Segment::len).sum();
        let mut counts = Vec::with_capacity(len);
        let mut weight = Vec::with_capacity(len);
        for segment in &segments {
            let seen = &recordings[segment.run].counts[segment.from..segment.to];
            counts.extend(seen.iter().map(|n| n - seen[0]));
            let mut k = 0;
            while k < seen.len() {
                let same = at_rest(&seen[k..]);
                weight.extend(std::iter::repeat_n(1.0 / same as f64, same));
                k += same;
            }
        }
        Self {
            runs: Arc::new(recordings),
            segments,
            len,
            counts,
            weight,
            arrivals_s,
            work: Work::default(),
            correction: Vec::new(),
        }
    }

    /// With the correction of initial states for a motor with this time constant.
    #[must_use]
    pub fn with_time_constant(mut self, time_constant_s: f64) -> Self {
        self.correction = (self.segments.iter())
            .map(|segment| Correction::new(&self.runs[segment.run], segment, time_constant_s))
            .collect();
        self
    }

    /// The same segments with other counts (relative to each run's first sample), for a motor with this time
    /// constant.
    pub fn with_counts(
        &self,
        counts: impl IntoIterator<Item = Vec<f64>>,
        time_constant_s: f64,
    ) -> Self {
        let pairs = self.runs.iter().zip(counts);
        let runs: Vec<Recording> = pairs.map(|(run, n)| run.with_counts(n)).collect();
        let mut segments = self.segments.clone();
        for segment in &mut segments {
            segment.start_speed_sd = runs[segment.run].start(segment.from).1;
        }
        let mut made = Self::of(runs, segments, self.arrivals_s);
        made.work = self.work.clone();
        made.with_time_constant(time_constant_s)
    }

    /// Removes the response to errors of the initial states from a residual or derivative in counts.
    pub fn correct(&self, column: &mut [f64]) {
        for (segment, correction) in self.segments.iter().zip(&self.correction) {
            correction.apply(&mut column[segment.range()]);
        }
    }

    /// The corrected copy of a column.
    pub fn corrected(&self, column: &[f64]) -> Vec<f64> {
        let mut out = column.to_vec();
        self.correct(&mut out);
        out
    }

    /// Measured minus predicted, in counts.
    pub fn residual(&self, predicted: &[f64]) -> Vec<f64> {
        (self.counts.iter().zip(predicted))
            .map(|(seen, p)| seen - p)
            .collect()
    }
}

/// Uniform cuts of a part of a run, moved away from changes of speed if the shaft moves steadily nearby.
fn cuts(run: &Recording, part: &Range<usize>, count: usize) -> Vec<usize> {
    let n = part.len();
    let reach = n / count / CUT_REACH;
    let is_better = |k: &usize| run.moving[*k] && !run.bends(*k);
    let cut = |j: usize| {
        let even = part.start + j * n / count;
        let mut near = (1..=reach).flat_map(|by| [even - by, even + by]);
        match j > 0 && run.bends(even) {
            true => near.find(is_better).unwrap_or(even),
            false => even,
        }
    };
    (0..count).map(cut).collect()
}

/// Mechanical time constant of a motor in s.
pub(crate) fn time_constant_s(motor: &Motor) -> f64 {
    let drag = drag(&motor.parameters, CommandKind::Voltage);
    motor.parameters.inertia_kg_m2 / drag.max(f64::MIN_POSITIVE)
}

/// Damping in N m s/rad: viscous friction, and the back EMF of a voltage-driven motor.
pub(crate) fn drag(p: &Parameters, kind: CommandKind) -> f64 {
    let coupling = match kind {
        CommandKind::Voltage => {
            p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm
        }
        _ => 0.0,
    };
    p.viscous_friction_nm_s_per_rad + coupling
}

/// Number of samples from the first on that are one observation of a shaft at rest: of one count, or of two
/// neighbours between which the encoder dithers.
/// the encoder dithers.
fn at_rest(seen: &[f64]) -> usize {
    let first = seen[0];
    let same = seen.iter().take_while(|n| **n == first).count();
    let Some(&second) = seen.get(same) else {
        return same;
    };
    let mut after = seen[same..].iter().skip_while(|n| **n == second);
    if (second - first).abs() == 1.0 && after.next() == Some(&first) {
        let of_both = seen.iter().take_while(|n| **n == first || **n == second);
        return of_both.count();
    }
    same
}

/// Width in s of a uniform distribution of arrival times whose intervals have the measured variance: that of an
/// interval is twice that of an arrival, and a uniform distribution of width 1 has variance 1/12.
fn arrival_spread_s(t_s: &[f64]) -> f64 {
    let n = (t_s.len() - 1) as f64;
    let mean = (t_s[t_s.len() - 1] - t_s[0]) / n;
    let squares = t_s
        .windows(2)
        .map(|pair| (pair[1] - pair[0] - mean).powi(2));
    (squares.sum::<f64>() / n / 2.0 * 12.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::model::predict;
    use crate::diagnose::samples::recording;
    use crate::motor::{Drive, SimulationOptions, simulate};

    /// A command that steps at uniform cuts: with moved cuts the true motor leaves quantization, 1/sqrt(12) = 0.29
    /// counts, and with cuts at the steps 0.45, since the initial speed cannot be measured there.
    #[test]
    fn residuals_of_the_true_motor_are_quantization_with_steps_at_cuts() {
        let motor = Motor::default();
        let command: Vec<f64> = (0..1500)
            .map(|k| if (k / 250) % 2 == 0 { 4.5 } else { -4.5 })
            .collect();
        let mut run = recording(&motor, command.len());
        let drive = Drive {
            t_s: &run.t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let made = simulate(&motor, &drive, &SimulationOptions::default());
        run.counts = made.expect("it can be simulated").counts;
        run.command = command;
        let segments = Segments::new(&[run], &motor, &Settings::default()).expect("a run");
        let steps = |segment: &Segment| segment.from > 0 && segment.from.is_multiple_of(250);
        assert!(!segments.segments.iter().any(steps));
        let mut residual = segments.residual(&predict(&segments, &motor).expect("a prediction"));
        segments.correct(&mut residual);
        let rms = (residual.iter().map(|r| r * r).sum::<f64>() / segments.len as f64).sqrt();
        assert!(rms < 0.31, "{rms}");
    }

    #[test]
    fn dither_of_one_edge_is_one_observation() {
        assert_eq!(at_rest(&[4.0, 4.0, 4.0, 9.0]), 3);
        assert_eq!(at_rest(&[4.0, 5.0, 4.0, 4.0, 5.0, 6.0]), 5);
        assert_eq!(at_rest(&[4.0, 4.0, 5.0, 5.0, 6.0]), 2);
        assert_eq!(at_rest(&[4.0, 6.0, 4.0]), 1);
    }
}
