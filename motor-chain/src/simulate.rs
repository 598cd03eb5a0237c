//! Simulation of a run of the chain: command in, encoder counts out.

use crate::CommandKind;
use crate::chain::Chain;
use crate::integrator::dense_output::Sample;
use crate::integrator::dynamics::Machine;
use crate::integrator::engine::Engine;
use crate::integrator::schedule::Schedule;
use crate::reading::{Encoder, Lateness, MeanCounts, encoder_shaft};
use crate::{Model, Motor};

/// Commands and sample times: `command[k]` is in force from `t_s[k]` until `t_s[k + 1]`, and the
/// samples are taken at `t_s` (zero-order hold).
#[derive(Debug, Clone, Copy)]
pub struct Drive<'a> {
    /// Sample times on the board's clock in s, increasing; the run starts at the first, at rest.
    pub t_s: &'a [f64],
    /// Commands in V, A or N m.
    pub command: &'a [f64],
    /// Quantity that `command` sets.
    pub kind: CommandKind,
}

/// Options of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// With the inductance of the motor file or without.
    pub model: Model,
    /// Seed of random effects: lost edges, late samples.
    pub seed: u64,
    /// Initial fraction of a count, 0 .. 1: `counts = floor(N theta / 2 pi + fraction)`; 0.5 rounds.
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

/// A simulated run at its samples.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    /// Angle of the shaft that carries the encoder, in rad.
    pub angle_rad: Vec<f64>,
    /// Its speed in rad/s.
    pub speed_rad_s: Vec<f64>,
    /// Current in A.
    pub current_a: Vec<f64>,
    /// Encoder reading.
    pub counts: Vec<i64>,
    /// Encoder reading before quantization, with the effects of sensor and timing, as an angle at the motor file's
    /// counts per revolution; the mean if an effect is random.
    pub measured_angle_rad: Vec<f64>,
}

/// Errors of a simulation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// Different numbers of times and commands.
    #[error("{times} sample times but {commands} commands\nhint: give one command per sample")]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of commands.
        commands: usize,
    },
    /// Time does not increase, or is not finite.
    #[error(
        "sample {sample}: t_s = {t_s} does not come after the sample before it\nhint: give sample times that rise from sample to sample"
    )]
    Time {
        /// Index of the sample.
        sample: usize,
        /// Its time.
        t_s: f64,
    },
    /// A command is not finite.
    #[error(
        "sample {sample}: the command is {command}, expected a finite number\nhint: replace missing commands by the command in force"
    )]
    Command {
        /// Index of the sample.
        sample: usize,
        /// The command.
        command: f64,
    },
    /// The motor's states exceed the range of floating point.
    #[error(
        "sample {sample}: the simulated angle is {angle_rad}\nhint: check the motor's parameters: `motorlab motor FILE` lists them with their units"
    )]
    Diverged {
        /// Index of the sample.
        sample: usize,
        /// The angle there.
        angle_rad: f64,
    },
    /// Events follow each other too closely for the run to end.
    #[error(
        "sample {sample}: the motor is too stiff to simulate (over {steps} steps up to there)\n\
         hint: check the motor's parameters, stiffness and gaps first"
    )]
    TooStiff {
        /// Index of the sample reached.
        sample: usize,
        /// Steps taken so far.
        steps: u64,
    },
}

/// Most steps per longest step of a simulation: four per tick, where one without events takes one.
const MOST_STEPS: u64 = 4000;
/// Samples between two progress reports.
const REPORTED_SAMPLES: usize = 4096;

/// Simulates a motor from rest.
pub fn simulate(
    motor: &Motor,
    drive: &Drive<'_>,
    options: &SimulationOptions,
) -> Result<Trajectory, SimulationError> {
    simulate_reporting(motor, drive, options, &|_| ())
}

/// Simulates a motor from rest; `done` is called with the number of simulated samples, once in some thousands.
pub fn simulate_reporting(
    motor: &Motor,
    drive: &Drive<'_>,
    options: &SimulationOptions,
    done: &dyn Fn(usize),
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
        (false, false) => trajectory::<3>(&schedule, machine, options, done),
        (false, true) => trajectory::<4>(&schedule, machine, options, done),
        (true, false) => trajectory::<5>(&schedule, machine, options, done),
        (true, true) => trajectory::<6>(&schedule, machine, options, done),
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
    done: &dyn Fn(usize),
) -> Result<Trajectory, SimulationError> {
    let longest_s = schedule.longest_s(machine.chain.timing.clock_scale);
    let mut engine = Engine::<f64, N>::new(machine, longest_s);
    let shaft = encoder_shaft::<N>(machine.chain.transmission.encoder_on_load);
    let mut out = Trajectory::default();
    let sensor = machine.chain.sensor;
    let per_count = std::f64::consts::TAU / machine.chain.stated_counts_per_rev;
    let mut mean = MeanCounts::new(sensor, 0.0, 0.0);
    let mut encoder = Encoder::new(sensor, options.start_count_fraction, options.seed);
    let jitter_s = machine.chain.timing.jitter_s;
    let (times_s, clock_scale) = (schedule.times_s(), machine.chain.timing.clock_scale);
    schedule.run(
        &mut engine,
        MOST_STEPS,
        |_| 0.5 * jitter_s,
        |k: usize, engine: &Engine<f64, N>, sample: &Sample<'_, f64, N>| {
            if k.is_multiple_of(REPORTED_SAMPLES) {
                done(k);
            }
            let y = sample.state();
            let (angle, speed) = (y[shaft], y[shaft + 1]);
            out.angle_rad.push(angle);
            out.speed_rad_s.push(speed);
            out.current_a.push(engine.machine.current(&engine.mode, &y));
            let at_s = clock_scale * times_s[k] + 0.5 * jitter_s;
            out.measured_angle_rad
                .push(per_count * mean.read(angle, || speed, || at_s));
            if jitter_s == 0.0 {
                out.counts.push(encoder.read(angle, speed, at_s));
            }
        },
    )?;
    if jitter_s > 0.0 {
        let mut late = Lateness::new(jitter_s, options.seed);
        let by_s: Vec<f64> = times_s.iter().map(|_| late.next_s()).collect();
        engine.restart(machine, longest_s);
        schedule.run(
            &mut engine,
            MOST_STEPS,
            |k| by_s[k],
            |k, _: &Engine<f64, N>, sample: &Sample<'_, f64, N>| {
                let (angle, speed) = (sample.angle(shaft), sample.speed(shaft));
                let at_s = clock_scale * times_s[k] + by_s[k];
                out.counts.push(encoder.read(angle, speed, at_s));
            },
        )?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ActiveEffect;
    use crate::integrator::dynamics::TH1;

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
            .run(
                &mut engine,
                MOST_STEPS,
                |_| 0.0,
                |_, _: &Engine<f64, N>, sample: &Sample<'_, f64, N>| out.push(sample.angle(TH1)),
            )
            .unwrap();
        (out, engine.steps)
    }

    #[test]
    fn inexact_steps_converge() {
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
