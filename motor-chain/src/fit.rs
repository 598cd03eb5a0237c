//! The simulator as a fit calls it: many parameter sets on one drive, without allocation, with derivatives.
//!
//! Derivatives are carried through the equations as dual numbers, through the instants of events too (an event's time
//! depends on the parameters), so they are those of the simulated angle itself, not of a difference scheme.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::catalogue::Stage;
use crate::chain::Chain;
use crate::encoders::{AngleReading, Encoder, Encoders};
use crate::integrator::dynamics::Machine;
use crate::integrator::engine::Engine;
use crate::integrator::schedule::{Reader, Schedule};
use crate::scalar::{Dual, Scalar};
use crate::simulate::{Drive, SimulationError};
use crate::stages::transmission::ENCODER_SIDE;
use crate::workspace::{Engines, work_of, work_of_encoders};
use crate::{KnownDifferences, Model, Motor, Parameters};

pub use crate::integrator::schedule::{Reset, Skipped};
pub use crate::parameter_id::ParameterId;
pub use crate::workspace::Workspace;

/// Most steps for each longest step of a run, on average, and for each as long as a spring allows: a fit has many more motors
/// to try than one that chatters.
const MOST_STEPS: u64 = 40;
const MOST_BY_PACE: u64 = 2;

/// Largest error of a step: a thousandth of a count over a run, a hundredth of what rounding leaves. With a torque ripple, whose
/// steps are many, a hundredth of a count.
const TOLERANCE: f64 = 1e-3;
const TOLERANCE_OF_RIPPLE: f64 = 1e-2;

/// A drive made ready to be simulated with many motors.
///
/// Angles are those that the encoder would say before it rounds, with the effects of sensor and timing, at the motor
/// file's counts per revolution; means where an effect is random ([`super::Trajectory::measured_angle_rad`]).
#[derive(Debug, Clone)]
pub struct Simulator {
    schedule: Schedule,
    kind: crate::CommandKind,
    model: Model,
    start: (f64, f64),
    known: KnownDifferences,
}

impl Simulator {
    /// For this drive and model.
    pub fn new(drive: &Drive<'_>, model: Model) -> Result<Self, SimulationError> {
        Ok(Self {
            schedule: Schedule::new(drive)?.coarser(),
            kind: drive.kind,
            model,
            start: (0.0, 0.0),
            known: KnownDifferences::default(),
        })
    }

    /// The same of a run in which this is known to differ from the motors that are asked for.
    #[must_use]
    pub fn knowing(mut self, known: KnownDifferences) -> Self {
        self.known = known;
        self
    }

    /// The same from an angle (rad) and a speed (rad/s) other than rest at 0: of a recording that begins in motion,
    /// and of effects that depend on where in a turn the shaft is.
    #[must_use]
    pub fn starting(mut self, angle_rad: f64, speed_rad_s: f64) -> Self {
        self.start = (angle_rad, speed_rad_s);
        self
    }

    /// The same with a shaft that is put elsewhere in between: pieces of a run, each from what was measured at its first
    /// sample (multiple shooting: Bock, 1983). What cannot be measured goes on: heat, current, the side of a gap, a command under
    /// way. `resets` are in the order of their samples.
    #[must_use]
    pub fn resetting(mut self, resets: Vec<Reset>) -> Self {
        self.schedule = self.schedule.with_resets(resets);
        self
    }

    /// The same of a run of which stretches are left out: what is long against all that happens in a motor but its warming up. The
    /// drive goes on after each as if nothing had been before, with a reset there. `skipped` is in the order of the samples.
    #[must_use]
    pub fn skipping(mut self, skipped: Vec<Skipped>) -> Self {
        self.schedule = self.schedule.with_skipped(skipped);
        self
    }

    /// The same from where another one starts.
    #[must_use]
    pub fn starting_as(mut self, other: &Self) -> Self {
        self.start = other.start;
        self
    }

    /// The same with the steps, and the known differences, of a run whose drive this one's was cut from.
    #[must_use]
    pub fn cut_from(mut self, run: &Self) -> Self {
        self.schedule = self.schedule.stepping_as(&run.schedule);
        self.known.clone_from(&run.known);
        self
    }

    /// Number of samples of the drive: the length of an angle column.
    pub fn samples(&self) -> usize {
        self.schedule.len()
    }

    /// Writes the encoder's angle in rad at every sample into `angles_rad` ([`Self::samples`] long).
    ///
    /// # Errors
    /// An angle that is not finite; a motor too stiff for a fit, with over 40 steps for each longest one on average (12 ms
    /// at most), and over two for each that its spring asks for.
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

    /// Angles of motors that [`move_alike`], from one simulation: row `m` of `angles_rad`
    /// (`samples` long, one after the other) is what the encoder of motor `m` says.
    ///
    /// # Errors
    /// As [`Self::angles`].
    pub fn angles_by_encoder(
        &self,
        motors: &[Motor],
        workspace: &mut Workspace,
        angles_rad: &mut [f64],
    ) -> Result<(), SimulationError> {
        let chains = motors.iter().map(|motor| self.chain(motor));
        let chains: Vec<Chain<f64>> = chains.collect();
        let Some(first) = chains.first() else {
            return Ok(());
        };
        let samples = self.samples();
        let encoders = chains
            .iter()
            .map(|chain| AngleReading::new(chain, self.start));
        let read = Encoders {
            encoders: encoders.collect(),
            times_s: self.schedule.times_s(),
            emit: |m: usize, k, angle| angles_rad[m * samples + k] = angle,
        };
        let engines = &mut workspace.plain;
        self.measure(*first, engines, read)?;
        engines.work += work_of_encoders(samples, motors.len() - 1);
        let rows = angles_rad.chunks_exact(samples.max(1));
        rows.take(motors.len()).try_for_each(finite)
    }

    /// The motor with what is known to differ in this run.
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
        Chain::new(
            &motor.parameters,
            &motor.effects,
            self.model,
            self.kind,
            |x| x,
        )
    }

    /// The same with the derivatives by the parameters `wanted`: column `j` of `columns` (`samples` long, one after the
    /// other) is `d angle / d wanted[j]`, 0 throughout for one that the motor does not have.
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
            let (ids, others) = wanted.split_at(carried_together(wanted.len()));
            let (block, rest) = columns.split_at_mut(ids.len() * samples);
            match ids.len() {
                ..=4 => self.derivatives::<4>(motor, ids, &mut workspace.four, angles_rad, block),
                5 | 6 => self.derivatives::<6>(motor, ids, &mut workspace.six, angles_rad, block),
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
        // Numbers are asked for in this order: nominal parameters, then each effect's.
        let mut order = (0..Parameters::KEYS.len()).map(ParameterId::Nominal).chain(
            motor.effects.iter().flat_map(|effect| {
                let count = effect.kind().parameters.len();
                (0..count).map(|k| ParameterId::Effect(effect.index(), k))
            }),
        );
        let chain = Chain::new(
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
            .longest_s(machine.chain.timing.stretch.value());
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
        *work += work_of::<S, N>(self.schedule.len(), engine.steps, engine.bent_steps);
        measured
    }

    /// Angles of many motors, on all cores: row `m` of `angles_rad` (`samples` long, one after the other) is motor `m`'s.
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

/// Whether two motors differ in their encoder at most, and in which side of the transmission it sits on.
pub fn move_alike(a: &Motor, b: &Motor) -> bool {
    fn moving(motor: &Motor) -> impl Iterator<Item = (usize, f64)> {
        let effects = motor.effects.iter();
        let moving = effects.filter(|effect| effect.kind().stage != Stage::Sensor);
        moving.flat_map(|effect| {
            let moving = effect
                .parameters()
                .filter(|(number, _)| number.key != ENCODER_SIDE.key);
            let itself = std::iter::once((effect.index(), 0.0));
            itself.chain(moving.map(|(_, value)| (effect.index(), value)))
        })
    }
    a.parameters == b.parameters && moving(a).eq(moving(b))
}

/// How many of so many derivatives the next simulation of [`Simulator::sensitivities`] carries: as few places of 4, 6 or 8
/// as possible stay empty.
pub fn carried_together(left: usize) -> usize {
    match left {
        9 | 10 => 6,
        _ => left.min(8),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ActiveEffect, SimulationOptions, catalogue, simulate};

    /// Fits take steps of four times the sample time and read uneven samples off inside them; what is simulated once takes
    /// shorter ones with a smaller error.
    #[test]
    fn what_fits_see_of_uneven_samples_is_what_is_simulated() {
        const LEVELS_V: [f64; 7] = [4.5, -1.0, 0.35, -4.0, 2.0, -0.6, 0.0];
        let t_s: Vec<f64> = (0..2000_u32)
            .map(|k| f64::from(k) * 0.003 + f64::from(k * 7919 % 7) * 1e-6)
            .collect();
        let command: Vec<f64> = (0..2000).map(|k| LEVELS_V[k / 90 % 7]).collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: crate::CommandKind::Voltage,
        };
        let options = SimulationOptions::default();
        let simulator = Simulator::new(&drive, options.model).expect("a drive");
        let mut workspace = Workspace::default();
        let mut apart = |id: &str, values: &[(&str, f64)]| {
            let mut motor = Motor::default();
            let values = values.iter().copied();
            let effect = ActiveEffect::from_keys(id, values, &motor.parameters);
            motor.effects.set(effect.expect("in the catalogue"));
            let exact = simulate(&motor, &drive, &options).expect("a motor");
            let mut angles = vec![0.0; t_s.len()];
            (simulator.angles(&motor, &mut workspace, &mut angles)).expect("a motor");
            let counts = motor.parameters.counts_per_rev / std::f64::consts::TAU;
            let gap = |(a, b): (&f64, &f64)| ((a - b) * counts).abs();
            let gaps: Vec<f64> = (angles.iter().zip(&exact.measured_angle_rad))
                .map(gap)
                .collect();
            let largest = gaps.iter().copied().fold(0.0, f64::max);
            let rms = (gaps.iter().map(|x| x * x).sum::<f64>() / gaps.len() as f64).sqrt();
            (largest, rms)
        };
        for kind in catalogue::catalogue() {
            let (largest, rms) = apart(kind.id, &[]);
            assert!(largest < 0.01, "{}: {largest} counts", kind.id);
            assert!(rms < 0.002, "{}: {rms} counts RMS", kind.id);
        }
        // The strongest that the catalogue holds plausible of what bends the equations within a step.
        let strong: [(&str, &[(&str, f64)]); 4] = [
            (
                "torque_ripple",
                &[("amplitude", 0.25), ("cycles_per_rev", 30.0)],
            ),
            (
                "torque_ripple",
                &[("amplitude", 0.25), ("cycles_per_rev", 8.0)],
            ),
            ("cogging", &[("torque_nm", 0.02), ("cycles_per_rev", 24.0)]),
            (
                "stribeck",
                &[("extra_torque_nm", 0.1), ("stribeck_speed_rad_s", 0.1)],
            ),
        ];
        for (id, values) in strong {
            let (largest, rms) = apart(id, values);
            assert!(largest < 0.01, "{id} {values:?}: {largest} counts");
            assert!(rms < 0.004, "{id} {values:?}: {rms} counts RMS");
        }
    }

    /// A piece of a run from what is measured at its first sample is what a run of its own from there is, where nothing is hidden; an
    /// encoder that says something else begins anew; times between the ends of steps, too.
    #[test]
    fn a_reset_is_a_start() {
        for late_s in [0.0, 1e-4] {
            let t_s: Vec<f64> = (0..900)
                .map(|k| f64::from(k) * 0.003 + late_s * f64::from(k * 7919 % 7) / 7.0)
                .collect();
            let command: Vec<f64> = (0..900)
                .map(|k| [4.5, -1.0, 0.35, -4.0][k / 70 % 4])
                .collect();
            let drive = |from: usize, to: usize| Drive {
                t_s: &t_s[from..to],
                command: &command[from..to],
                kind: crate::CommandKind::Voltage,
            };
            let whole = Simulator::new(&drive(0, 900), Model::FirstOrder).expect("a drive");
            let effects: [Option<(&str, &[f64])>; 4] = [
                None,
                Some(("resolution_error", &[500.0])),
                Some(("cogging", &[0.03, 12.0, 1.1])),
                Some(("encoder_eccentricity", &[0.03, 1.0])),
            ];
            for effect in effects {
                let mut motor = Motor::default();
                if let Some((id, values)) = effect {
                    motor
                        .effects
                        .set(ActiveEffect::new(id, values).expect("in the catalogue"));
                }
                let resets = vec![
                    Reset {
                        sample: 300,
                        angle_rad: 7.0,
                        speed_rad_s: 2.5,
                    },
                    Reset {
                        sample: 551,
                        angle_rad: -1.0,
                        speed_rad_s: 0.0,
                    },
                ];
                let wanted: Vec<ParameterId> = (0..4).map(ParameterId::Nominal).collect();
                let mut workspace = Workspace::default();
                let (mut all, mut slopes) = (vec![0.0; 900], vec![0.0; 3600]);
                (whole.clone().resetting(resets.clone()))
                    .sensitivities(&motor, &wanted, &mut workspace, &mut all, &mut slopes)
                    .expect("a motor");
                for (reset, to) in resets.iter().zip([551, 900]) {
                    let n = to - reset.sample;
                    let (mut alone, mut alone_slopes) = (vec![0.0; n], vec![0.0; 4 * n]);
                    (Simulator::new(&drive(reset.sample, to), Model::FirstOrder).expect("a drive"))
                        .starting(reset.angle_rad, reset.speed_rad_s)
                        .sensitivities(
                            &motor,
                            &wanted,
                            &mut workspace,
                            &mut alone,
                            &mut alone_slopes,
                        )
                        .expect("a motor");
                    let count = std::f64::consts::TAU / motor.parameters.counts_per_rev;
                    for (a, b) in all[reset.sample..to].iter().zip(&alone) {
                        assert!((a - b).abs() < 0.02 * count, "{effect:?} {late_s}: {a} {b}");
                    }
                    for j in 0..4 {
                        let largest = alone_slopes[j * n..(j + 1) * n]
                            .iter()
                            .fold(1e-9_f64, |m, x| m.max(x.abs()));
                        let part = &slopes[j * 900 + reset.sample..j * 900 + to];
                        for (a, b) in part.iter().zip(&alone_slopes[j * n..(j + 1) * n]) {
                            assert!(
                                (a - b).abs() < 0.02 * largest,
                                "{effect:?} {late_s} slope {j}: {a} {b}"
                            );
                        }
                    }
                }
            }
        }
    }

    /// What is left out warms the winding as it does where it is simulated.
    #[test]
    fn a_winding_goes_on_warming_through_what_is_left_out() {
        let mut motor = Motor::default();
        let values = [("resistance_rise_per_w", 0.5), ("time_constant_s", 8.0)];
        let heating = ActiveEffect::from_keys("winding_heating", values, &motor.parameters);
        motor.effects.set(heating.expect("in the catalogue"));
        let t_s: Vec<f64> = (0..8000).map(|k| f64::from(k) * 0.003).collect();
        let command: Vec<f64> = (0..8000).map(|k| [4.5, 1.5, -4.0][k / 90 % 3]).collect();
        let drive = |range: std::ops::Range<usize>| Drive {
            t_s: &t_s[range.clone()],
            command: &command[range],
            kind: crate::CommandKind::Voltage,
        };
        let whole = simulate(&motor, &drive(0..8000), &SimulationOptions::default());
        let whole = whole.expect("a motor");
        // The last piece is all that is simulated, after 24 samples before what is left out.
        let (until, from) = (24, 7290);
        let shorter: Vec<f64> = (0..until + 8000 - from).map(|k| t_s[k]).collect();
        let their_command = [&command[..until], &command[from..]].concat();
        let reset = Reset {
            sample: until,
            angle_rad: whole.angle_rad[from],
            speed_rad_s: whole.speed_rad_s[from],
        };
        let blocks = (until..from).step_by(300).map(|k| {
            let block = k..(k + 300).min(from);
            let n = block.len() as f64;
            let mean = |of: &dyn Fn(usize) -> f64| block.clone().map(of).sum::<f64>() / n;
            let (u, w) = (&command, &whole.speed_rad_s);
            Skipped {
                before: until,
                span_s: 0.003 * n,
                means: [
                    mean(&|k| u[k] * u[k]),
                    mean(&|k| u[k] * w[k]),
                    mean(&|k| w[k] * w[k]),
                ],
            }
        });
        let blocks: Vec<Skipped> = blocks.collect();
        let apart = |skipped: Vec<Skipped>| {
            let drive = Drive {
                t_s: &shorter,
                command: &their_command,
                kind: crate::CommandKind::Voltage,
            };
            let simulator = Simulator::new(&drive, Model::SecondOrder).expect("a drive");
            let simulator = simulator.resetting(vec![reset]).skipping(skipped);
            let mut angles = vec![0.0; shorter.len()];
            (simulator.angles(&motor, &mut Workspace::default(), &mut angles)).expect("a motor");
            let apart = (angles[until..].iter().zip(&whole.angle_rad[from..]))
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            apart * motor.parameters.counts_per_rev / std::f64::consts::TAU
        };
        let (cold, warm) = (apart(Vec::new()), apart(blocks));
        assert!(cold > 10.0 * warm && warm < 0.5, "{cold} {warm}");
    }

    /// One motion read by encoders with and without effects of their own, on either side of a spring and of a gap: to the bit
    /// what each says alone.
    #[test]
    fn what_encoders_say_of_one_motion_is_what_each_says_alone() {
        let t_s: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.003).collect();
        let command: Vec<f64> = (0..600).map(|k| [4.5, -1.0, 0.35][k / 70 % 3]).collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: crate::CommandKind::Voltage,
        };
        let simulator = Simulator::new(&drive, Model::SecondOrder).expect("a drive");
        let simulator = simulator.starting(0.3, 2.0);
        let with = |effects: &[(&str, &[f64])]| {
            let mut motor = Motor::default();
            for (id, values) in effects {
                let effect = ActiveEffect::new(id, values);
                motor.effects.set(effect.expect("in the catalogue"));
            }
            motor
        };
        for (beside, other_side) in [
            (
                ("compliance", &[8.0, 0.05, 0.4, 1.0][..]),
                ("compliance", &[8.0, 0.05, 0.4, 0.0][..]),
            ),
            (
                ("backlash", &[0.1, 0.5, 0.0]),
                ("backlash", &[0.1, 0.5, 1.0]),
            ),
        ] {
            let motors = [
                with(&[beside]),
                with(&[beside, ("resolution_error", &[500.0])]),
                with(&[beside, ("missed_counts", &[0.02, 0.0])]),
                with(&[beside, ("missed_counts", &[0.0, 200.0])]),
                with(&[beside, ("encoder_eccentricity", &[0.03, 1.0])]),
                with(&[other_side]),
            ];
            assert!(motors.iter().all(|motor| move_alike(motor, &motors[0])));
            let mut workspace = Workspace::default();
            let mut together = vec![0.0; motors.len() * t_s.len()];
            (simulator.angles_by_encoder(&motors, &mut workspace, &mut together)).expect("motors");
            let together_work = workspace.take_work();
            let mut alone = vec![0.0; t_s.len()];
            let mut rows: Vec<&[f64]> = Vec::new();
            for (motor, row) in motors.iter().zip(together.chunks_exact(t_s.len())) {
                (simulator.angles(motor, &mut workspace, &mut alone)).expect("a motor");
                assert_eq!(row, alone);
                assert!(
                    !rows.contains(&row),
                    "an encoder that says what another does"
                );
                rows.push(row);
            }
            assert!(2 * together_work < workspace.take_work());
        }
        let jitter = with(&[("sample_jitter", &[1e-3])]);
        assert!(!move_alike(&jitter, &with(&[])));
    }
}
