//! Time grid of a run: samples, changes of the command, and the engine's steps.

use crate::integrator::dense_output::Sample;
use crate::integrator::engine::{Engine, PART, TICKS};
use crate::scalar::Scalar;
use crate::simulate::{Drive, SimulationError};

/// Longest step of the engine in s; the step of a run is an integral fraction of its sample time, up to this length
/// except for clock errors.
pub(crate) const LONGEST_STEP_S: f64 = 0.003;
const CLOCK: f64 = 1e-3;

/// Doublings of it in a fit, for samples closer than that and for samples farther apart.
const COARSER: usize = 2;
const COARSER_APART: usize = 1;

/// Largest distance in ticks at which, in a fit, a time is referred to a part of a longest step ([`PART`]): the jitter
/// of a clock that counts microseconds.
const NEAR_TICKS: f64 = 4.0;

/// Most steps of a run per longest step, which the fastest plausible spring and ripple need, and in addition the
/// number for a nonsmooth run of some ten seconds.
const MOST_BY_LENGTH: u64 = 16;
const MOST_FURTHER_STEPS: u64 = 30_000_000;

/// Receiver of the state at each sample. A trait and not a closure, so that the compiler inlines it.
pub(crate) trait Reader<S, const N: usize> {
    /// Called for sample `k`.
    fn read(&mut self, k: usize, engine: &Engine<S, N>, sample: &Sample<'_, S, N>);

    /// Called when the shaft is set to this angle (rad) and speed (rad/s) just before sample `k`.
    fn restart(&mut self, _k: usize, _angle_rad: S, _speed_rad_s: S) {}
}

/// A restart of the shaft within a run, at the time of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reset {
    /// Number of the sample.
    pub sample: usize,
    /// Angle in rad of the encoder at the motor file's counts per revolution.
    pub angle_rad: f64,
    /// Speed in rad/s of the encoder by the board's clock.
    pub speed_rad_s: f64,
}

/// An omitted interval of a run just before a [`Reset`]: only the winding's temperature continues through it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skipped {
    /// Number of the sample after it: that of a reset.
    pub before: usize,
    /// Duration in s.
    pub span_s: f64,
    /// Means over it: of the squared command, of the command times the speed (rad/s), and of the squared speed.
    pub means: [f64; 3],
}

impl<S, const N: usize, F> Reader<S, N> for F
where
    F: FnMut(usize, &Engine<S, N>, &Sample<'_, S, N>),
{
    #[inline(always)]
    fn read(&mut self, k: usize, engine: &Engine<S, N>, sample: &Sample<'_, S, N>) {
        self(k, engine, sample);
    }
}

/// A drive prepared for simulation: changes of the command, and the time grid.
#[derive(Debug, Clone)]
pub(crate) struct Schedule {
    /// Sample times from the first, on the board's clock.
    times_s: Vec<f64>,
    /// Samples at which the command changes, and to what.
    changes: Vec<(usize, f64)>,
    /// Longest step in s of the board's clock.
    step_s: f64,
    /// Steps per sample for uniform samples, else 0.
    steps_per_sample: u64,
    /// Doublings of the longest step for a fit; times near a part of it are then referred to that.
    coarsened: usize,
    /// Positions of non-uniform samples by an exact clock: integral ticks and the rest.
    places: Vec<(u64, f64)>,
    /// Restarts of the shaft, by sample.
    resets: Vec<Reset>,
    /// Omitted intervals before some of them, in order.
    skipped: Vec<Skipped>,
}

impl Schedule {
    pub(crate) fn new(drive: &Drive<'_>) -> Result<Self, SimulationError> {
        let (t, u) = (drive.t_s, drive.command);
        if t.len() != u.len() {
            let (times, commands) = (t.len(), u.len());
            return Err(SimulationError::Lengths { times, commands });
        }
        for (sample, (&t_s, &command)) in t.iter().zip(u).enumerate() {
            if !t_s.is_finite() || (sample > 0 && t_s <= t[sample - 1]) {
                return Err(SimulationError::Time { sample, t_s });
            }
            if !command.is_finite() {
                return Err(SimulationError::Command { sample, command });
            }
        }
        let start = t.first().copied().unwrap_or(0.0);
        let times_s: Vec<f64> = t.iter().map(|x| x - start).collect();
        let mut changes: Vec<(usize, f64)> = Vec::new();
        for (k, &command) in u.iter().enumerate() {
            if changes.last().map_or(0.0, |c| c.1) != command {
                changes.push((k, command));
            }
        }
        let mean_s = match times_s.last() {
            Some(last) if times_s.len() > 1 => last / (times_s.len() - 1) as f64,
            _ => LONGEST_STEP_S,
        };
        let uniform = times_s
            .iter()
            .enumerate()
            .all(|(k, x)| (x - k as f64 * mean_s).abs() < 1e-9);
        let steps = (mean_s / LONGEST_STEP_S - CLOCK).ceil().max(1.0);
        let schedule = Self {
            times_s,
            changes,
            step_s: mean_s / steps,
            steps_per_sample: if uniform { steps as u64 } else { 0 },
            coarsened: 0,
            places: Vec::new(),
            resets: Vec::new(),
            skipped: Vec::new(),
        };
        Ok(schedule.placed())
    }

    /// Sets the restarts.
    pub(crate) fn with_resets(mut self, resets: Vec<Reset>) -> Self {
        self.resets = resets;
        self
    }

    /// Sets the omitted intervals.
    pub(crate) fn with_skipped(mut self, skipped: Vec<Skipped>) -> Self {
        self.skipped = skipped;
        self
    }

    fn placed(mut self) -> Self {
        if self.steps_per_sample == 0 {
            self.places = (0..self.len()).map(|k| self.tick(k, 1.0, 0.0)).collect();
        }
        self
    }

    /// Longer steps if samples are between the ends of steps anyway, for fits: samples are interpolated, which
    /// differs by some thousandths of a count after a change of the command, and by a ten-thousandth RMS.
    pub(crate) fn coarser(mut self) -> Self {
        if self.steps_per_sample == 0 {
            let intervals = self.len().saturating_sub(1).max(1) as f64;
            let mean_s = self.times_s.last().copied().unwrap_or(0.0) / intervals;
            self.coarsened = if mean_s > f64::from(1 << COARSER) * self.step_s {
                COARSER_APART
            } else {
                COARSER
            };
            self.step_s *= f64::from(1 << self.coarsened);
        }
        self.placed()
    }

    /// Takes the steps of the run that it was cut from, whose mean sample time is the same, so that both share their
    /// matrices.
    pub(crate) fn with_steps_of(mut self, run: &Self) -> Self {
        if self.steps_per_sample == run.steps_per_sample {
            self.step_s = run.step_s;
        }
        self.placed()
    }

    pub(crate) fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Number of changes of the command.
    pub(crate) fn changes(&self) -> usize {
        self.changes.len()
    }

    /// Sample times from the first, on the board's clock.
    pub(crate) fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Longest step in real time, by a clock with an error.
    pub(crate) fn longest_s(&self, clock_scale: f64) -> f64 {
        self.step_s * clock_scale
    }

    /// Position of `time of sample k + later_s` in integral ticks and the rest. Time on the board's clock times
    /// `clock_scale` is real time; `later_s` is real. Times before the start are clamped. The rest is from 0 to 1, or
    /// in a fit the distance to a part of a longest step that is near.
    fn tick<S: Scalar>(&self, k: usize, clock_scale: S, later_s: S) -> (u64, S) {
        if self.steps_per_sample > 0 && S::DERIVATIVES == 0 && later_s.value() == 0.0 {
            return (k as u64 * self.steps_per_sample * TICKS, S::zero());
        }
        let tick_s = self.longest_s(clock_scale.value()) / TICKS as f64;
        let (whole, rest_s) = if self.steps_per_sample > 0 {
            let whole = k as u64 * self.steps_per_sample * TICKS;
            // Derivatives by clock_scale remain.
            let board_s = k as f64 * self.steps_per_sample as f64 * self.step_s;
            (
                whole,
                (clock_scale - clock_scale.value()) * board_s + later_s,
            )
        } else {
            (0, clock_scale * self.times_s[k] + later_s)
        };
        let rest = rest_s / tick_s;
        if self.coarsened > 0 {
            let part = PART as f64;
            let near = (rest.value() / part).round() * part;
            if near >= 0.0 && (rest.value() - near).abs() <= NEAR_TICKS {
                return (near as u64, rest - near);
            }
        }
        let mut floor = rest.value().floor();
        if rest.value() - floor > 1.0 - 1e-6 {
            floor += 1.0;
        }
        let mut offset = rest - floor;
        if offset.value() < 1e-6 {
            offset = offset - offset.value();
        }
        let tick = whole as f64 + floor;
        if tick < 0.0 {
            return (0, S::zero());
        }
        (tick as u64, offset)
    }

    /// Runs an engine through the drive; `late_s` is the lateness of sample `k` in real time, `reader` receives the
    /// state at each sample.
    ///
    /// # Errors
    /// [`SimulationError::TooStiff`] above `most_steps` per longest step of the run.
    pub(crate) fn run<S: Scalar, const N: usize>(
        &self,
        engine: &mut Engine<S, N>,
        most_steps: u64,
        mut late_s: impl FnMut(usize) -> S,
        mut reader: impl Reader<S, N>,
    ) -> Result<(), SimulationError> {
        let budget = most_steps
            .saturating_mul(self.base_steps())
            .min(MOST_BY_LENGTH * self.base_steps() + MOST_FURTHER_STEPS);
        engine.most_steps = budget;
        engine.coarsened = self.coarsened;
        let clock_scale = engine.machine.chain.timing.clock_scale;
        let command = &engine.machine.chain.command;
        let delay_s = command.delay_s - command.ahead_s;
        let mut changes = self
            .changes
            .iter()
            .map(|&(k, command)| (self.tick(k, clock_scale, delay_s), command))
            .peekable();
        // Samples at the end of a step, for any parameters.
        let regular = self.steps_per_sample > 0
            && (clock_scale - clock_scale.value()).is_nought()
            && engine.machine.chain.timing.jitter_s.is_nought();
        // Samples whose time does not depend on parameters.
        let known = self.steps_per_sample == 0
            && (clock_scale - 1.0).is_nought()
            && engine.machine.chain.timing.jitter_s.is_nought();
        let mut resets = self.resets.iter().peekable();
        let mut skipped = self.skipped.as_slice();
        let mut k = 0;
        while k < self.len() {
            let (tick, offset) = if known {
                (self.places[k].0, S::from(self.places[k].1))
            } else {
                self.tick(k, clock_scale, late_s(k))
            };
            while let Some(&((at, after), command)) = changes.peek() {
                if (at, after.value()) > (tick, offset.value()) {
                    break;
                }
                engine.go_to(at);
                engine.command(command, after);
                changes.next();
            }
            if let Some(reset) = resets.next_if(|reset| reset.sample == k) {
                engine.go_to(tick);
                let until = skipped.partition_point(|interval| interval.before <= k);
                let (left_out, others) = skipped.split_at(until);
                let (angle_rad, speed_rad_s) =
                    engine.put(reset.angle_rad, reset.speed_rad_s, offset, left_out);
                skipped = others;
                reader.restart(k, angle_rad, speed_rad_s);
            }
            let free = resets.peek().map_or(self.len(), |reset| reset.sample);
            engine.reach(tick, offset);
            if engine.steps > budget {
                return Err(SimulationError::TooStiff {
                    sample: k,
                    steps: engine.steps,
                });
            }
            reader.read(k, engine, &engine.sample(tick, offset));
            k += 1;
            if regular {
                let until = match changes.peek() {
                    Some(&(at, _)) => self.first_sample_from(at),
                    None => self.len(),
                };
                let most = until.min(free).saturating_sub(k);
                k += engine.steady_steps(self.steps_per_sample, most, |n, engine, y| {
                    reader.read(k + n, engine, &Sample::At(y))
                });
            } else if known {
                let change = changes.peek().map(|&((at, after), _)| (at, after.value()));
                let first = k;
                let at = |n: usize| {
                    let place = self.places[..free].get(first + n).copied();
                    place.filter(|place| change.is_none_or(|change| *place < change))
                };
                k += engine.steady_steps_between(at, |n, engine, sample| {
                    reader.read(first + n, engine, sample)
                });
            }
        }
        Ok(())
    }

    /// The first sample at or after a time in ticks and the rest, for uniform samples.
    fn first_sample_from<S: Scalar>(&self, (tick, offset): (u64, S)) -> usize {
        let past = tick + u64::from(offset.value() > 0.0);
        let sample = past.div_ceil(self.steps_per_sample * TICKS);
        usize::try_from(sample).map_or(self.len(), |sample| sample.min(self.len()))
    }

    /// Least number of steps of a run, plus ten for its start.
    fn base_steps(&self) -> u64 {
        let duration_s = self.times_s.last().copied().unwrap_or(0.0);
        (duration_s / self.step_s).ceil() as u64 + 10
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_takes_the_steps_of_its_run() {
        let late_s = |k: u32| f64::from(k * 7919 % 7) * 1e-6;
        let even: Vec<f64> = (0..2000_u32).map(|k| f64::from(k) * 0.003).collect();
        let uneven: Vec<f64> = (0..2000_u32)
            .map(|k| f64::from(k) * 0.003 + late_s(k))
            .collect();
        let command = vec![4.5; 2000];
        let schedule = |t_s: &[f64]| {
            let drive = Drive {
                t_s,
                command: &command[..t_s.len()],
                kind: crate::CommandKind::Voltage,
            };
            Schedule::new(&drive).expect("a drive").coarser()
        };
        for (t_s, step_s) in [(&even, 0.003), (&uneven, 0.012)] {
            let run = schedule(t_s);
            assert!((run.step_s - step_s).abs() < 1e-8, "{}", run.step_s);
            let mut differ = false;
            for (from, to) in [(0, 333), (333, 666), (1801, 1951)] {
                let segment = schedule(&t_s[from..to]);
                differ |= segment.step_s != run.step_s;
                let segment = segment.with_steps_of(&run);
                assert_eq!(segment.step_s, run.step_s);
                assert_eq!(segment.steps_per_sample, run.steps_per_sample);
                let tick_s = run.step_s / TICKS as f64;
                for (place, t) in segment.places.iter().zip(&segment.times_s) {
                    assert!(((place.0 as f64 + place.1) * tick_s - t).abs() < 1e-12);
                }
            }
            assert!(differ, "nothing to take over");
        }
        // A uniform segment of a non-uniform run.
        let segment = schedule(&even[..100]);
        let step_s = segment.step_s;
        assert_eq!(segment.with_steps_of(&schedule(&uneven)).step_s, step_s);
    }

    #[test]
    fn a_sample_time_slightly_above_a_step_does_not_halve_the_steps() {
        let steps = |sample_time_s: f64| {
            let t_s: Vec<f64> = (0..100).map(|k| f64::from(k) * sample_time_s).collect();
            let drive = Drive {
                t_s: &t_s,
                command: &vec![4.5; 100],
                kind: crate::CommandKind::Voltage,
            };
            Schedule::new(&drive).expect("a drive").steps_per_sample
        };
        let found = [0.003, 0.003_000_3, 0.003_01, 0.03, 0.030_002].map(steps);
        assert_eq!(found, [1, 1, 2, 10, 10]);
    }
}
