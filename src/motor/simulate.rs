//! A whole run of the chain: command in, encoder counts out.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::chain::Chain;
use super::dynamics::{Machine, TH1, W1};
use super::engine::{Engine, TICKS};
use super::scalar::Scalar;
use super::sensor::Sensor;
use super::{Model, Motor};
use crate::CommandKind;

/// What is commanded, and when the encoder is read: `command[k]` is in force from `t_s[k]` until `t_s[k + 1]`, and the
/// samples are taken at `t_s` (zero-order hold).
#[derive(Debug, Clone, Copy)]
pub struct Drive<'a> {
    /// Sample times on the board's clock in s, increasing; the first is the start, at rest.
    pub t_s: &'a [f64],
    /// Commands in V, A or N m.
    pub command: &'a [f64],
    /// What `command` commands.
    pub kind: CommandKind,
}

/// How a run is simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// With the inductance of the motor file or without.
    pub model: Model,
    /// Seed of what is random: lost edges, late samples.
    pub seed: u64,
    /// Where inside a count the shaft starts, 0 .. 1: `counts = floor(N theta / 2 pi + fraction)`; 0.5 rounds.
    pub start_count_fraction: f64,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self {
            model: Model::SecondOrder,
            seed: 1,
            start_count_fraction: 0.5,
        }
    }
}

/// A simulated run, sample by sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    /// Angle of the shaft that bears the encoder, in rad.
    pub angle_rad: Vec<f64>,
    /// Its speed in rad/s.
    pub speed_rad_s: Vec<f64>,
    /// Current in A.
    pub current_a: Vec<f64>,
    /// What the encoder says.
    pub counts: Vec<i64>,
    /// What the encoder would say before it rounds, with the effects of sensor and timing, as an angle at the motor
    /// file's counts per revolution; the mean where an effect is random.
    pub measured_angle_rad: Vec<f64>,
}

/// Why a run cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// Times and commands do not pair up.
    #[error("{times} sample times but {commands} commands: there must be one command a sample")]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of commands.
        commands: usize,
    },
    /// Time does not advance, or is no number.
    #[error("sample {sample}: t_s = {t_s} does not come after the sample before it")]
    Time {
        /// Index of the sample.
        sample: usize,
        /// Its time.
        t_s: f64,
    },
    /// A command that is no number.
    #[error("sample {sample}: the command is {command}, expected a finite number")]
    Command {
        /// Index of the sample.
        sample: usize,
        /// The command.
        command: f64,
    },
    /// The motor's numbers leave the range of floating point.
    #[error("sample {sample}: the simulated angle is {angle_rad}; check the motor's parameters")]
    Diverged {
        /// Index of the sample.
        sample: usize,
        /// The angle there.
        angle_rad: f64,
    },
    /// Events follow each other so fast that the run would not end.
    #[error(
        "sample {sample}: the motor is too stiff to simulate (over {steps} steps up to there); check the \
         motor's parameters, stiffness and gaps first"
    )]
    TooStiff {
        /// Index of the sample that was reached.
        sample: usize,
        /// Steps taken so far.
        steps: u64,
    },
}

/// Most steps for each longest step of a run that is simulated once: four a tick, where one without events takes one.
const MOST_STEPS: u64 = 4000;

/// Longest step of the engine in s; the step of a run is a whole fraction of its sample time and at most this.
pub(super) const LONGEST_STEP_S: f64 = 0.003;

/// A drive made ready: which samples change the command, and how time is divided.
#[derive(Debug, Clone)]
pub(super) struct Schedule {
    /// Sample times from the first, on the board's clock.
    times_s: Vec<f64>,
    /// Samples at which the command changes, and to what.
    changes: Vec<(usize, f64)>,
    /// Longest step in s of the board's clock.
    step_s: f64,
    /// Steps a sample where all samples are the same time apart, else 0.
    steps_per_sample: u64,
}

impl Schedule {
    pub(super) fn new(drive: &Drive<'_>) -> Result<Self, SimulationError> {
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
        let steps = (mean_s / LONGEST_STEP_S - 1e-6).ceil().max(1.0);
        Ok(Self {
            times_s,
            changes,
            step_s: mean_s / steps,
            steps_per_sample: if uniform { steps as u64 } else { 0 },
        })
    }

    pub(super) fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Longest step in real time, by a clock that is off.
    pub(super) fn longest_s(&self, stretch: f64) -> f64 {
        self.step_s * stretch
    }

    /// Where `time of sample k + later_s` lies in ticks: whole ticks and the rest. Time on the board's clock times
    /// `stretch` is real time; `later_s` is real.
    fn tick<S: Scalar>(&self, k: usize, stretch: S, later_s: S) -> (u64, S) {
        if self.steps_per_sample > 0 && S::DERIVATIVES == 0 && later_s.value() == 0.0 {
            return (k as u64 * self.steps_per_sample * TICKS, S::zero());
        }
        let tick_s = self.longest_s(stretch.value()) / TICKS as f64;
        let (whole, rest_s) = if self.steps_per_sample > 0 {
            let whole = k as u64 * self.steps_per_sample * TICKS;
            // Derivatives of the stretch remain.
            let board_s = k as f64 * self.steps_per_sample as f64 * self.step_s;
            (whole, (stretch - stretch.value()) * board_s + later_s)
        } else {
            (0, stretch * self.times_s[k] + later_s)
        };
        let rest = rest_s / tick_s;
        let mut floor = rest.value().floor();
        if rest.value() - floor > 1.0 - 1e-6 {
            floor += 1.0;
        }
        let mut offset = rest - floor;
        if offset.value() < 1e-6 {
            offset = offset - offset.value();
        }
        (whole + floor as u64, offset)
    }

    /// Runs an engine through the drive; `late_s` says by how much sample `k` is late in real time, `emit` takes the
    /// state at each sample.
    ///
    /// # Errors
    /// [`SimulationError::TooStiff`] from `most_steps` for each longest step of the run on.
    pub(super) fn run<S: Scalar, const N: usize>(
        &self,
        engine: &mut Engine<S, N>,
        most_steps: u64,
        mut late_s: impl FnMut(usize) -> S,
        mut emit: impl FnMut(usize, &Engine<S, N>, &[S; N]),
    ) -> Result<(), SimulationError> {
        let budget = most_steps.saturating_mul(self.base_steps());
        let stretch = engine.machine.chain.timing.stretch;
        let delay_s = engine.machine.chain.command.delay_s;
        let mut changes = self
            .changes
            .iter()
            .map(|&(k, command)| (self.tick(k, stretch, delay_s), command))
            .peekable();
        // Samples that lie on a step's end, whatever the parameters.
        let regular = self.steps_per_sample > 0
            && (stretch - stretch.value()).is_nought()
            && engine.machine.chain.timing.jitter_s.is_nought();
        let mut k = 0;
        while k < self.len() {
            let (tick, offset) = self.tick(k, stretch, late_s(k));
            while let Some(&((at, after), command)) = changes.peek() {
                if (at, after.value()) > (tick, offset.value()) {
                    break;
                }
                engine.go_to(at);
                engine.command(command, after);
                changes.next();
            }
            let y = engine.state_at(tick, offset);
            if engine.steps > budget {
                return Err(SimulationError::TooStiff {
                    sample: k,
                    steps: engine.steps,
                });
            }
            emit(k, engine, &y);
            k += 1;
            if regular {
                let until = match changes.peek() {
                    Some(&(at, _)) => self.first_sample_from(at),
                    None => self.len(),
                };
                let most = until.saturating_sub(k);
                k += engine.cruise(self.steps_per_sample, most, |n, engine, y| {
                    emit(k + n, engine, y)
                });
            }
        }
        Ok(())
    }

    /// The first sample that is not before a time in ticks and the rest, where all are the same time apart.
    fn first_sample_from<S: Scalar>(&self, (tick, offset): (u64, S)) -> usize {
        let past = tick + u64::from(offset.value() > 0.0);
        let sample = past.div_ceil(self.steps_per_sample * TICKS);
        usize::try_from(sample).map_or(self.len(), |sample| sample.min(self.len()))
    }

    /// Steps that a run takes at least, and ten for its start.
    fn base_steps(&self) -> u64 {
        let duration_s = self.times_s.last().copied().unwrap_or(0.0);
        (duration_s / self.step_s).ceil() as u64 + 10
    }
}

/// Angle and speed of the shaft that bears the encoder.
#[inline(always)]
pub(super) fn encoder_shaft<S: Scalar, const N: usize>(machine: &Machine<S>, y: &[S; N]) -> (S, S) {
    if N > super::dynamics::ONE_BODY && machine.chain.transmission.encoder_on_load {
        (y[N - 2], y[N - 1])
    } else {
        (y[TH1], y[W1])
    }
}

/// Simulates a motor from rest.
pub fn simulate(
    motor: &Motor,
    drive: &Drive<'_>,
    options: &SimulationOptions,
) -> Result<Trajectory, SimulationError> {
    let schedule = Schedule::new(drive)?;
    let chain = Chain::new(
        &motor.parameters,
        &motor.effects,
        options.model,
        drive.kind,
        |x| x,
    );
    let machine = Machine::new(chain);
    let trajectory = match (machine.two, machine.warms()) {
        (false, false) => trajectory::<3>(&schedule, machine, options),
        (false, true) => trajectory::<4>(&schedule, machine, options),
        (true, false) => trajectory::<5>(&schedule, machine, options),
        (true, true) => trajectory::<6>(&schedule, machine, options),
    }?;
    match trajectory.angle_rad.iter().position(|x| !x.is_finite()) {
        Some(sample) => Err(SimulationError::Diverged {
            sample,
            angle_rad: trajectory.angle_rad[sample],
        }),
        None => Ok(trajectory),
    }
}

fn trajectory<const N: usize>(
    schedule: &Schedule,
    machine: Machine<f64>,
    options: &SimulationOptions,
) -> Result<Trajectory, SimulationError> {
    let longest_s = schedule.longest_s(machine.chain.timing.stretch);
    let mut engine = Engine::<f64, N>::new(machine, longest_s);
    let mut out = Trajectory::default();
    let sensor = machine.chain.sensor;
    let per_count = std::f64::consts::TAU / machine.chain.stated_counts_per_rev;
    let mut mean = MeanCounts::new(sensor);
    let mut encoder = Encoder::new(sensor, options.start_count_fraction, options.seed);
    let jitter_s = machine.chain.timing.jitter_s;
    schedule.run(
        &mut engine,
        MOST_STEPS,
        |_| 0.5 * jitter_s,
        |_, engine, y| {
            let (angle, speed) = encoder_shaft(&engine.machine, y);
            out.angle_rad.push(angle);
            out.speed_rad_s.push(speed);
            out.current_a.push(engine.machine.current(&engine.mode, y));
            out.measured_angle_rad
                .push(per_count * mean.read(angle, speed));
            if jitter_s == 0.0 {
                out.counts.push(encoder.read(angle, speed));
            }
        },
    )?;
    if jitter_s > 0.0 {
        let mut late = Lateness::new(jitter_s, options.seed);
        engine.restart(machine, longest_s);
        schedule.run(
            &mut engine,
            MOST_STEPS,
            |_| late.next_s(),
            |_, engine, y| {
                let (angle, speed) = encoder_shaft(&engine.machine, y);
                out.counts.push(encoder.read(angle, speed));
            },
        )?;
    }
    Ok(out)
}

/// A number in 0 .. 1.
fn uniform(random: &mut Pcg64Mcg) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Random lateness of samples.
#[derive(Debug, Clone)]
pub(super) struct Lateness {
    spread_s: f64,
    random: Pcg64Mcg,
}

impl Lateness {
    pub(super) fn new(spread_s: f64, seed: u64) -> Self {
        Self {
            spread_s,
            random: Pcg64Mcg::seed_from_u64(seed ^ 0x6a69_7474_6572),
        }
    }

    /// Lateness of the next sample.
    pub(super) fn next_s(&mut self) -> f64 {
        self.spread_s * uniform(&mut self.random)
    }
}

/// The encoder's integer counts, edge by edge.
#[derive(Debug, Clone)]
pub(super) struct Encoder {
    sensor: Sensor<f64>,
    start_fraction: f64,
    edge: i64,
    counts: i64,
    speed_rad_s: f64,
    random: Pcg64Mcg,
}

impl Encoder {
    pub(super) fn new(sensor: Sensor<f64>, start_fraction: f64, seed: u64) -> Self {
        let edge = (sensor.unrounded(0.0) + start_fraction).floor() as i64;
        Self {
            sensor,
            start_fraction,
            edge,
            counts: edge,
            speed_rad_s: 0.0,
            random: Pcg64Mcg::seed_from_u64(seed),
        }
    }

    /// Counts when the shaft has come to this angle at this speed.
    pub(super) fn read(&mut self, angle_rad: f64, speed_rad_s: f64) -> i64 {
        let edge = (self.sensor.unrounded(angle_rad) + self.start_fraction).floor() as i64;
        let steps = edge - self.edge;
        if self.sensor.faithful() {
            self.counts += steps;
        } else {
            let before = self.speed_rad_s;
            for k in 0..steps.unsigned_abs() {
                let share = (k as f64 + 0.5) / steps.unsigned_abs() as f64;
                let speed = before + share * (speed_rad_s - before);
                let too_fast = self.sensor.too_fast(speed);
                let lost = self.sensor.loss > 0.0 && uniform(&mut self.random) < self.sensor.loss;
                if !too_fast && !lost {
                    self.counts += steps.signum();
                }
            }
        }
        (self.edge, self.speed_rad_s) = (edge, speed_rad_s);
        self.counts
    }
}

/// The encoder's counts before rounding, their mean where edges are lost.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeanCounts<S> {
    sensor: Sensor<S>,
    unrounded: S,
    speed_rad_s: S,
    mean: S,
}

impl<S: Scalar> MeanCounts<S> {
    pub(super) fn new(sensor: Sensor<S>) -> Self {
        let unrounded = sensor.unrounded(S::zero());
        Self {
            sensor,
            unrounded,
            speed_rad_s: S::zero(),
            mean: unrounded,
        }
    }

    /// Mean counts when the shaft has come to this angle at this speed.
    #[inline(always)]
    pub(super) fn read(&mut self, angle_rad: S, speed_rad_s: S) -> S {
        let unrounded = self.sensor.unrounded(angle_rad);
        if self.sensor.faithful() {
            return unrounded;
        }
        let kept = self.sensor.kept_share(self.speed_rad_s, speed_rad_s);
        self.mean += (unrounded - self.unrounded) * kept;
        (self.unrounded, self.speed_rad_s) = (unrounded, speed_rad_s);
        self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ActiveEffect;

    /// A reversing run at TS = 0.003 s.
    fn schedule() -> Schedule {
        let command: Vec<f64> = (0..2000)
            .map(|k| [4.5, -1.0, 0.35, -4.0, 2.0, -0.6, 0.0][k / 90 % 7])
            .collect();
        let t_s: Vec<f64> = (0..2000).map(|k| k as f64 * 0.003).collect();
        Schedule::new(&Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        })
        .unwrap()
    }

    /// Angle at the samples, and the number of steps.
    fn angles<const N: usize>(machine: Machine<f64>, tolerance: f64) -> (Vec<f64>, u64) {
        let mut engine = Engine::<f64, N>::new(machine, 0.003);
        engine.tolerance = tolerance;
        let mut out = Vec::new();
        schedule()
            .run(&mut engine, MOST_STEPS, |_| 0.0, |_, _, y| out.push(y[TH1]))
            .unwrap();
        (out, engine.steps)
    }

    #[test]
    fn what_is_not_exact_converges() {
        let effects: [(&str, &[f64]); 7] = [
            ("stribeck", &[0.03, 0.5]),
            ("presliding", &[0.035]),
            ("quadratic_drag", &[0.002]),
            ("gravity_load", &[0.04, 0.6]),
            ("cogging", &[0.03, 12.0, 1.1]),
            ("torque_ripple", &[0.12, 11.0, 0.7]),
            ("winding_heating", &[0.8, 5.0]),
        ];
        let mut table =
            String::from("effect: error in counts, steps a sample at tolerance 2e-3 .. 2e-6\n");
        for (id, values) in effects {
            let mut motor = Motor::default();
            motor.effects.set(ActiveEffect::new(id, values).unwrap());
            let chain = Chain::new(
                &motor.parameters,
                &motor.effects,
                Model::SecondOrder,
                CommandKind::Voltage,
                |x| x,
            );
            let machine = Machine::new(chain);
            let run = |tolerance| match machine.warms() {
                false => angles::<3>(machine, tolerance),
                true => angles::<4>(machine, tolerance),
            };
            let (finest, _) = run(1e-9);
            let mut errors = Vec::new();
            table += id;
            for tolerance in [2e-3, 2e-4, 2e-5, 2e-6] {
                let (angle, steps) = run(tolerance);
                let error = angle
                    .iter()
                    .zip(&finest)
                    .map(|(a, b)| (a - b).abs() * 720.0 / std::f64::consts::TAU)
                    .fold(0.0, f64::max);
                let (decade, steps) = (error.log10().ceil(), steps as f64 / angle.len() as f64);
                table += &format!(" | < 1e{decade}, {steps:.1}");
                errors.push(error);
            }
            table.push('\n');
            assert!(errors[3] < 2e-5, "{id}: {errors:?}");
            assert!(
                errors[0] < 1e-5 || errors[3] < 0.05 * errors[0],
                "{id}: {errors:?}"
            );
        }
        let shown = "\
effect: error in counts, steps a sample at tolerance 2e-3 .. 2e-6\n\
stribeck | < 1e-3, 1.2 | < 1e-4, 1.3 | < 1e-5, 1.5 | < 1e-7, 2.1\n\
presliding | < 1e-4, 1.2 | < 1e-4, 1.2 | < 1e-5, 1.4 | < 1e-6, 2.2\n\
quadratic_drag | < 1e-3, 1.3 | < 1e-3, 1.3 | < 1e-5, 1.5 | < 1e-6, 2.2\n\
gravity_load | < 1e-6, 1.3 | < 1e-6, 1.3 | < 1e-6, 1.3 | < 1e-6, 1.5\n\
cogging | < 1e-5, 1.2 | < 1e-5, 1.3 | < 1e-6, 2.0 | < 1e-7, 3.6\n\
torque_ripple | < 1e-3, 1.3 | < 1e-3, 1.6 | < 1e-5, 2.6 | < 1e-6, 5.4\n\
winding_heating | < 1e-4, 1.3 | < 1e-4, 1.4 | < 1e-4, 1.8 | < 1e-6, 3.2\n\
";
        assert_eq!(table, shown);
    }
}
