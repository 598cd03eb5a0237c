//! The simulator for fits: many parameter sets under one drive, without allocation, with derivatives.
//!
//! Derivatives are propagated as dual numbers through the equations and through the times of events, which depend on
//! the parameters, so that they are those of the simulated angle and not of finite differences.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::chain::Chain;
use crate::encoders::{AngleReading, Encoder};
use crate::integrator::dynamics::Machine;
use crate::integrator::engine::Engine;
use crate::integrator::schedule::{Reader, Schedule};
use crate::scalar::{Dual, Scalar};
use crate::simulate::{Drive, SimulationError};
use crate::workspace::{Done, Engines, work_of};
use crate::{KnownDifferences, Model, Motor, Parameters};

pub use crate::integrator::schedule::{Reset, Skipped};
pub use crate::parameter_id::ParameterId;
pub use crate::workspace::Workspace;

/// Largest mean number of steps per longest step of a run, and per longest step that a spring allows. A small motor
/// with a voltage drop takes more than 40 under a chirp at 1 ms, where an event ends nearly every sample.
const MOST_STEPS: u64 = 100;
const MOST_BY_PACE: u64 = 2;

/// Largest error of a step: a thousandth of a count over a run, a hundredth of quantization. With a torque ripple,
/// whose steps are many, a hundredth of a count.
const TOLERANCE: f64 = 1e-3;
const TOLERANCE_OF_RIPPLE: f64 = 1e-2;

/// Most derivatives carried by one simulation: more are computed in groups of eight. There are two widths, 4 and 8,
/// each a copy of the integrator; a width of 6 would save 15 to 20 % for five or six derivatives.
const MOST_DERIVATIVES: usize = 8;

/// A drive prepared for simulations with many motors.
///
/// Angles are encoder readings before quantization, with the effects of sensor and timing, at the motor file's counts
/// per revolution; means if an effect is random ([`super::Trajectory::measured_angle_rad`]).
#[derive(Debug, Clone)]
pub struct Simulator {
    schedule: Schedule,
    kind: crate::CommandKind,
    model: Model,
    start: (f64, f64),
    known: KnownDifferences,
    filters_samples: bool,
}

impl Simulator {
    /// A simulator for this drive and model.
    pub fn new(drive: &Drive<'_>, model: Model) -> Result<Self, SimulationError> {
        Ok(Self {
            schedule: Schedule::new(drive)?.coarser(),
            kind: drive.kind,
            model,
            start: (0.0, 0.0),
            known: KnownDifferences::default(),
            filters_samples: false,
        })
    }

    /// Sets the known differences of this run from the motors.
    #[must_use]
    pub fn with_known(mut self, known: KnownDifferences) -> Self {
        self.known = known;
        self
    }

    /// Sets whether the speeds of the log are means since the previous sample: a filter is then updated once per
    /// sample (exponential smoothing by `1 - exp(-TS/tau)`), as in firmware.
    #[must_use]
    pub fn with_sample_filter(mut self, does: bool) -> Self {
        self.filters_samples = does;
        self
    }

    /// Sets the initial angle (rad) and speed (rad/s): for a recording that begins in motion, and for effects that
    /// depend on the angle.
    #[must_use]
    pub fn with_start(mut self, angle_rad: f64, speed_rad_s: f64) -> Self {
        self.start = (angle_rad, speed_rad_s);
        self
    }

    /// Sets restarts of the shaft: segments of a run, each from the measured state at its first sample (multiple
    /// shooting: Bock, 1983). Unmeasured states continue: heat, current, side of a gap, delayed commands. `resets`
    /// are in ascending order of their samples.
    #[must_use]
    pub fn with_resets(mut self, resets: Vec<Reset>) -> Self {
        self.schedule = self.schedule.with_resets(resets);
        self
    }

    /// Sets omitted intervals of the run, long compared with all of a motor's time constants except the thermal one.
    /// The drive continues after each from a restart there. `skipped` is in ascending order of the samples.
    #[must_use]
    pub fn with_skipped(mut self, skipped: Vec<Skipped>) -> Self {
        self.schedule = self.schedule.with_skipped(skipped);
        self
    }

    /// Sets steps, known differences and filter of the run that this drive was cut from.
    #[must_use]
    pub fn with_steps_of(mut self, run: &Self) -> Self {
        self.schedule = self.schedule.with_steps_of(&run.schedule);
        self.known.clone_from(&run.known);
        self.filters_samples = run.filters_samples;
        self
    }

    /// Number of samples of the drive.
    pub fn samples(&self) -> usize {
        self.schedule.len()
    }

    /// Writes the encoder's angle in rad at every sample into `angles_rad` ([`Self::samples`] long).
    ///
    /// # Errors
    /// An angle that is not finite; a motor too stiff for a fit, with over 100 steps per longest one on average (12
    /// ms at most), and over two per step that its spring needs.
    pub fn angles(
        &self,
        motor: &Motor,
        workspace: &mut Workspace,
        angles_rad: &mut [f64],
    ) -> Result<(), SimulationError> {
        let chain = self.chain(motor);
        let read = Encoder {
            encoder: AngleReading::new(&chain, self.start),
            times_s: self.schedule.times_s(),
            emit: |k, angle| angles_rad[k] = angle,
        };
        self.measure(chain, &mut workspace.plain, read)?;
        finite(angles_rad)
    }

    /// The motor with the known differences of this run.
    fn in_this_run<'a>(&self, motor: &'a Motor) -> Cow<'a, Motor> {
        if self.known.is_empty() {
            Cow::Borrowed(motor)
        } else {
            Cow::Owned(self.known.applied_to(motor))
        }
    }

    /// The chain of a motor under this drive.
    fn chain(&self, motor: &Motor) -> Chain<f64> {
        let motor = &*self.in_this_run(motor);
        let mut chain = Chain::new(
            &motor.parameters,
            &motor.effects,
            self.model,
            self.kind,
            |x| x,
        );
        chain.sensor.filters_samples = self.filters_samples;
        chain
    }

    /// The angles with their derivatives by the parameters `wanted`: column `j` of `columns` (`samples` long,
    /// concatenated) is `d angle / d wanted[j]`, 0 for one that the motor does not have.
    ///
    /// # Errors
    /// As [`Self::angles`].
    pub fn sensitivities(
        &self,
        motor: &Motor,
        wanted: &[ParameterId],
        workspace: &mut Workspace,
        angles_rad: &mut [f64],
        columns: &mut [f64],
    ) -> Result<(), SimulationError> {
        if wanted.is_empty() {
            return self.angles(motor, workspace, angles_rad);
        }
        let samples = self.samples();
        let (mut wanted, mut columns) = (wanted, columns);
        while !wanted.is_empty() {
            let (ids, others) = wanted.split_at(wanted.len().min(MOST_DERIVATIVES));
            let (block, rest) = columns.split_at_mut(ids.len() * samples);
            match ids.len() {
                ..=4 => self.derivatives::<4>(motor, ids, &mut workspace.four, angles_rad, block),
                _ => self.derivatives::<8>(motor, ids, &mut workspace.eight, angles_rad, block),
            }?;
            (wanted, columns) = (others, rest);
        }
        finite(angles_rad)
    }

    fn derivatives<const D: usize>(
        &self,
        motor: &Motor,
        ids: &[ParameterId],
        engines: &mut Engines<Dual<D>>,
        angles_rad: &mut [f64],
        columns: &mut [f64],
    ) -> Result<(), SimulationError> {
        let samples = self.samples();
        let motor = &*self.in_this_run(motor);
        // Values are numbered in this order: nominal parameters, then each effect's.
        let mut order = (0..Parameters::KEYS.len()).map(ParameterId::Nominal).chain(
            motor.effects.iter().flat_map(|effect| {
                let count = effect.kind().parameters.len();
                (0..count).map(|k| ParameterId::Effect(effect.index(), k))
            }),
        );
        let mut chain = Chain::new(
            &motor.parameters,
            &motor.effects,
            self.model,
            self.kind,
            |x| {
                let id = order.next();
                let wanted = ids.iter().position(|wanted| Some(*wanted) == id);
                match wanted.filter(|k| !self.known.overrides(ids[*k])) {
                    Some(k) => Dual::parameter(x, k),
                    None => Dual::from(x),
                }
            },
        );
        chain.sensor.filters_samples = self.filters_samples;
        let read = Encoder {
            encoder: AngleReading::new(&chain, self.start),
            times_s: self.schedule.times_s(),
            emit: |k, angle: Dual<D>| {
                angles_rad[k] = angle.v;
                for (j, _) in ids.iter().enumerate() {
                    columns[j * samples + k] = angle.d[j];
                }
            },
        };
        self.measure(chain, engines, read)
    }

    fn measure<S: Scalar>(
        &self,
        chain: Chain<S>,
        engines: &mut Engines<S>,
        read: impl Reader<S, 3> + Reader<S, 4> + Reader<S, 5> + Reader<S, 6>,
    ) -> Result<(), SimulationError> {
        let machine = Machine::new(chain);
        let work = &mut engines.work;
        match (machine.two, machine.warms()) {
            (false, false) => self.measure_with(machine, &mut engines.rigid, work, read),
            (false, true) => self.measure_with(machine, &mut engines.rigid_warm, work, read),
            (true, false) => self.measure_with(machine, &mut engines.two, work, read),
            (true, true) => self.measure_with(machine, &mut engines.two_warm, work, read),
        }
    }

    fn measure_with<S: Scalar, const N: usize>(
        &self,
        machine: Machine<S>,
        slot: &mut Option<Box<Engine<S, N>>>,
        work: &mut u64,
        read: impl Reader<S, N>,
    ) -> Result<(), SimulationError> {
        let longest_s = self
            .schedule
            .longest_s(machine.chain.timing.clock_scale.value());
        let engine = match slot {
            Some(engine) => {
                engine.restart(machine, longest_s);
                engine
            }
            None => slot.insert(Box::new(Engine::new(machine, longest_s))),
        };
        engine.tolerance = match machine.chain.electrical.ripple {
            Some(_) => TOLERANCE_OF_RIPPLE,
            None => TOLERANCE,
        };
        if self.start != (0.0, 0.0) {
            let (angle_rad, speed_rad_s) = self.start;
            engine.start(angle_rad, speed_rad_s);
        }
        let late_s = machine.chain.timing.jitter_s * 0.5;
        let most_steps = MOST_STEPS.max(MOST_BY_PACE << engine.floor);
        let measured = self.schedule.run(engine, most_steps, |_| late_s, read);
        *work += work_of::<S, N>(&Done {
            samples: self.schedule.len(),
            changes: self.schedule.changes(),
            steps: engine.steps,
            curved_steps: engine.curved_steps,
            tables: engine.step_tables.computed,
        });
        measured
    }

    /// Angles of many motors in parallel: row `m` of `angles_rad` (`samples` long, concatenated) is motor `m`'s.
    ///
    /// # Errors
    /// As [`Self::angles`], of the first motor that has one.
    pub fn batch(&self, motors: &[Motor], angles_rad: &mut [f64]) -> Result<(), SimulationError> {
        motors
            .par_iter()
            .zip(angles_rad.par_chunks_mut(self.samples().max(1)))
            .map_init(Workspace::default, |workspace, (motor, row)| {
                self.angles(motor, workspace, row)
            })
            .collect()
    }
}

fn finite(angles_rad: &[f64]) -> Result<(), SimulationError> {
    // A state that is not finite stays so.
    match angles_rad.last() {
        Some(last) if !last.is_finite() => {
            let sample = angles_rad.iter().position(|x| !x.is_finite()).unwrap_or(0);
            let angle_rad = angles_rad[sample];
            Err(SimulationError::Diverged { sample, angle_rad })
        }
        _ => Ok(()),
    }
}
