//! One run prepared for fitting: its columns, smoothed speed, and simulators with its initial state.

use std::f64::consts::TAU;
use std::ops::Range;

use super::feedback::depends_on_motion;
use crate::check::host_clock::host_clock;
use crate::check::off_under_command;
use crate::diagnose::noise::Noise;
use crate::diagnose::settings::Settings;
use crate::diagnose::settings::conventions::MOVED_COUNTS;
use crate::diagnose::settings::solver::WINDOW_SAMPLES;
use crate::least_squares::{Record, start_of};
use crate::motor::fit::{Reset, Simulator};
use crate::motor::{Drive, KnownDifferences, Model, SimulationError};
use crate::recording::Run;
use crate::units::ROUNDING_VARIANCE;

#[derive(Debug, Clone)]
pub(crate) struct Recording {
    pub t_s: Vec<f64>,
    pub command: Vec<f64>,
    /// Counts relative to the first sample.
    pub counts: Vec<f64>,
    /// Counts of the first sample.
    pub first_counts: f64,
    /// Smoothed speed in counts/s.
    pub speed: Vec<f64>,
    /// Whether the shaft moves.
    pub moving: Vec<bool>,
    pub sample_time_s: f64,
    /// Rad per count.
    pub rad: f64,
    /// Stated supply of the run in V.
    pub supply_v: Option<f64>,
    /// Its known differences.
    pub known: KnownDifferences,
    /// Rate error of the board's clock relative to the host's, and the interval in s over which it was measured.
    pub clock: Option<(f64, f64)>,
    /// Whether the position is integrated from logged speeds.
    pub is_integrated: bool,
    /// Whether these are means since the previous sample.
    pub is_integrated_backward: bool,
    /// Their resolution in the log, in counts/s.
    pub speed_resolution: Option<f64>,
    /// Whether the command depends on the motion.
    pub is_closed_loop: bool,
    /// Largest speed in counts/s, at least 1.
    pub top: f64,
    /// Initial speed in counts/s with its standard deviation.
    pub first_speed: (f64, f64),
    /// Simulator with a restart at every segment.
    pub simulator: Simulator,
    /// Simulator without restarts: the source of simulated recordings.
    pub continuous: Simulator,
    /// Samples at which the simulation restarts.
    pub restarts: Vec<usize>,
    /// Intervals in which the drive was off under its command: they are in no segment, and the command is 0 in them.
    pub off: Vec<Range<usize>>,
    pub settings: Settings,
}

impl Recording {
    pub fn new(run: &Run, settings: &Settings) -> Result<Self, SimulationError> {
        let first = run.counts.first().copied().unwrap_or(0);
        let counts: Vec<f64> = (run.counts.iter())
            .map(|&n| (i128::from(n) - i128::from(first)) as f64)
            .collect();
        let mut steps: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let sample_time_s = steps
            .get(steps.len() / 2)
            .copied()
            .unwrap_or(run.sample_time_s);
        let (speed, moving) = motion(&run.t_s, &counts, sample_time_s, settings.speed_window_s());
        let mut command = run.driving_command();
        let mut off = off_under_command(run);
        let whole = 0..run.t_s.len();
        if driven(whole.end, &off, settings.segment_samples).first() == Some(&whole) {
            off.clear();
        }
        for samples in &off {
            command.to_mut()[samples.clone()].fill(0.0);
        }
        let drive = Drive {
            t_s: &run.t_s,
            command: &command,
            kind: run.command_kind,
        };
        let simulator = Simulator::new(&drive, Model::SecondOrder)?
            .with_known(run.known.clone())
            .with_sample_filter(run.is_integrated_backward());
        let first_speed = first_speed(&run.t_s, &command, &counts, run.counts_per_rev);
        Ok(Self {
            is_closed_loop: depends_on_motion(&command, &counts, settings),
            is_integrated: run.is_integrated(),
            is_integrated_backward: run.is_integrated_backward(),
            speed_resolution: run.speed_resolution_counts_s(),
            top: speed.iter().fold(1.0_f64, |most, v| most.max(v.abs())),
            t_s: run.t_s.clone(),
            command: command.into_owned(),
            counts,
            first_counts: first as f64,
            speed,
            moving,
            sample_time_s,
            rad: TAU / run.counts_per_rev,
            supply_v: run.supply_v,
            known: run.known.clone(),
            clock: host_clock(run),
            first_speed,
            continuous: simulator.clone(),
            simulator,
            restarts: Vec::new(),
            off,
            settings: *settings,
        })
    }

    /// The samples between the intervals in which the drive was off, in parts of at least one segment.
    pub fn driven(&self) -> Vec<Range<usize>> {
        driven(self.t_s.len(), &self.off, self.settings.segment_samples)
    }

    /// Restarts the simulation at these samples, the first of which begins it, from the measured states.
    pub fn restart(&mut self, samples: Vec<usize>) {
        let resets: Vec<Reset> = samples.iter().map(|k| self.start(*k).0).collect();
        let mut resets = resets.into_iter();
        if let Some(first) = resets.next() {
            self.continuous =
                (self.continuous.clone()).with_start(first.angle_rad, first.speed_rad_s);
            let resets: Vec<Reset> = resets.collect();
            self.simulator = (self.simulator.clone())
                .with_start(first.angle_rad, first.speed_rad_s)
                .with_resets(resets);
        }
        self.restarts = samples;
    }

    /// The same recording with other counts relative to the first sample, its initial states measured again.
    pub fn with_counts(&self, counts: Vec<f64>) -> Self {
        let (speed, moving) = motion(
            &self.t_s,
            &counts,
            self.sample_time_s,
            self.settings.speed_window_s(),
        );
        let first_speed = first_speed(&self.t_s, &self.command, &counts, TAU / self.rad);
        let mut other = Self {
            speed,
            moving,
            first_speed,
            counts,
            ..self.clone()
        };
        other.restart(self.restarts.clone());
        other
    }

    /// Speed at a sample in counts/s with its standard deviation: by regression over the neighbouring samples, with
    /// an additional uncertainty where the slopes before and after differ. At the start of a run it is that of its
    /// first samples.
    pub fn start_speed(&self, k: usize) -> (f64, f64) {
        if k == 0 {
            return self.first_speed;
        }
        if !self.moving[k] {
            return (0.0, 0.0);
        }
        let share = self.settings.start_speed_share * self.top;
        match self.slopes(k) {
            Some([(speed, sd), (before, _), (behind, _)]) => {
                (speed, sd.hypot(share).hypot(0.5 * (behind - before)))
            }
            None => (
                self.speed[k],
                (0.5 / self.settings.speed_window_s()).hypot(share),
            ),
        }
    }

    /// Whether a change of the speed at a sample dominates the uncertainty of its initial state, as at a step of the
    /// command.
    pub fn bends(&self, k: usize) -> bool {
        let share = self.settings.start_speed_share * self.top;
        self.moving[k]
            && (self.slopes(k)).is_some_and(|[(_, sd), (before, _), (behind, _)]| {
                0.5 * (behind - before).abs() > sd.hypot(share)
            })
    }

    /// Speed in counts/s with its standard deviation by regressions over the samples around one, before it, and after
    /// it.
    fn slopes(&self, k: usize) -> Option<[(f64, f64); 3]> {
        let half = ((self.settings.start_window_s / self.sample_time_s).ceil() as usize).max(2);
        let (from, to) = (
            k.saturating_sub(half),
            (k + half).min(self.counts.len() - 1),
        );
        let line = |from: usize, to: usize| slope(&self.t_s[from..=to], &self.counts[from..=to]);
        Some([line(from, to)?, line(from, k)?, line(k, to)?])
    }

    /// Standard deviation in counts of a position integrated from noisy logged speeds, at a sample.
    pub fn scatter(&self, noise: Noise, k: usize) -> f64 {
        if !self.is_integrated || !self.moving[k] {
            return 0.0;
        }
        noise.speed_counts_s * (self.t_s[k] - self.t_s[k - 1])
    }

    /// Error in counts of a position integrated from rounded speeds, at each sample; `phase` is the position of 0
    /// within the rounding interval.
    pub fn rounding_of_speeds(&self, position: &[f64], phase: f64) -> Vec<f64> {
        let n = position.len();
        let Some(resolution) = self.speed_resolution else {
            return vec![0.0; n];
        };
        let rate = |a: usize, b: usize| {
            let span_s = self.t_s[b] - self.t_s[a];
            if span_s > 0.0 {
                (position[b] - position[a]) / span_s
            } else {
                0.0
            }
        };
        let off = |k: usize| {
            let speed = match self.is_integrated_backward {
                true => rate(k.saturating_sub(1), k),
                false => rate(k.saturating_sub(1), (k + 1).min(n - 1)),
            };
            resolution * ((speed / resolution + phase).round() - phase) - speed
        };
        let mut sum = 0.0;
        let mut before = if n > 0 { off(0) } else { 0.0 };
        (0..n)
            .map(|k| {
                let here = off(k);
                if k > 0 && self.moving[k] {
                    let mean = match self.is_integrated_backward {
                        true => here,
                        false => 0.5 * (before + here),
                    };
                    sum += mean * (self.t_s[k] - self.t_s[k - 1]);
                }
                before = here;
                sum
            })
            .collect()
    }

    /// The angle at a sample in rad.
    pub fn angle(&self, sample: usize) -> f64 {
        (self.first_counts + self.counts[sample]) * self.rad
    }

    /// Mean of `sin(order angle + shift)` between a sample and the next at even speed, so that fast turning cancels it
    /// instead of an aliased value.
    pub fn mean_sine(&self, sample: usize, order: f64, shift: f64) -> f64 {
        let from = order * self.angle(sample) + shift;
        let half = 0.5 * order * (self.angle(sample + 1) - self.angle(sample));
        let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
        (from + half).sin() * sinc
    }

    /// The initial state at a sample, with the standard deviation of its speed in counts/s.
    pub fn start(&self, sample: usize) -> (Reset, f64) {
        let (speed, sd) = self.start_speed(sample);
        let reset = Reset {
            sample,
            angle_rad: self.angle(sample),
            speed_rad_s: speed * self.rad,
        };
        (reset, sd)
    }
}

/// The parts of at least this number of samples between ordered intervals; all samples if there is no such part.
pub(crate) fn driven(samples: usize, off: &[Range<usize>], least: usize) -> Vec<Range<usize>> {
    let begins = std::iter::once(0).chain(off.iter().map(|off| off.end));
    let ends = off.iter().map(|off| off.start).chain([samples]);
    let parts = begins.zip(ends).map(|(from, to)| from..to);
    let long: Vec<Range<usize>> = parts.filter(|part| part.len() >= least.max(1)).collect();
    match long.is_empty() {
        true => std::iter::once(0..samples).collect(),
        false => long,
    }
}

/// Initial speed in counts/s from the plain fit of the first samples, with its standard deviation.
fn first_speed(t_s: &[f64], command: &[f64], counts: &[f64], per_rev: f64) -> (f64, f64) {
    let start = start_of(&Record::from_rest(t_s, command, counts, per_rev));
    (start.speed_counts_s, start.variance.sqrt())
}

/// Smoothed speed in counts/s, and whether the shaft moves by more than one count of dither.
fn motion(t_s: &[f64], counts: &[f64], sample_time_s: f64, window_s: f64) -> (Vec<f64>, Vec<bool>) {
    let half = (window_s / sample_time_s)
        .round()
        .clamp(1.0, WINDOW_SAMPLES) as usize;
    let last = counts.len().saturating_sub(1);
    (0..counts.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(half), (k + half).min(last));
            let span_s = (t_s[to] - t_s[from]).max(sample_time_s);
            let (low, high) = (counts[from..=to].iter())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), n| {
                    (a.min(*n), b.max(*n))
                });
            (
                (counts[to] - counts[from]) / span_s,
                high - low > MOVED_COUNTS,
            )
        })
        .unzip()
}

/// Slope of a regression line, with its standard deviation due to quantization.
fn slope(t_s: &[f64], y: &[f64]) -> Option<(f64, f64)> {
    let n = t_s.len() as f64;
    let (mt, my) = (t_s.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let stt: f64 = t_s.iter().map(|t| (t - mt).powi(2)).sum();
    let sty: f64 = t_s.iter().zip(y).map(|(t, y)| (t - mt) * (y - my)).sum();
    (stt > 0.0).then(|| (sty / stt, (ROUNDING_VARIANCE / stt).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;
    use crate::diagnose::settings::Settings;
    use crate::motor::Motor;

    #[test]
    fn mean_sine_is_the_integral_over_a_sample_interval() {
        let run = recording(&Motor::default(), 200);
        let run = Recording::new(&run, &Settings::default()).expect("a recording");
        let (order, shift) = (41.0, 0.3);
        for sample in 0..199 {
            let (from, to) = (run.angle(sample), run.angle(sample + 1));
            let n = 10_000;
            let at = |k: usize| from + (to - from) * (k as f64 + 0.5) / n as f64;
            let sum: f64 = (0..n).map(|k| (order * at(k) + shift).sin()).sum();
            let mean = run.mean_sine(sample, order, shift);
            assert!((mean - sum / n as f64).abs() < 1e-6, "sample {sample}");
        }
    }
}
