//! The simulated motor of a virtual board, stepped command by command.

use std::collections::VecDeque;

use crate::CommandKind;
use crate::chain::Chain;
use crate::integrator::dynamics::Machine;
use crate::integrator::engine::Engine;
use crate::integrator::schedule::LONGEST_STEP_S;
use crate::reading::{Encoder, Lateness, encoder_shaft};
use crate::simulate::SimulationError;
use crate::{Model, Motor};

/// A motor on a bench. Time starts at 0, at rest; the results do not depend on the division into calls.
#[derive(Debug, Clone)]
pub struct Plant {
    engine: AnyEngine,
    supply_v: f64,
    stated_counts_per_rev: f64,
    clock_scale: f64,
    delay_s: f64,
    notes_late_s: f64,
    /// Present command of the board.
    command: f64,
    /// Delayed commands: real arrival time in s and value.
    on_their_way: VecDeque<(f64, f64)>,
    now_s: f64,
    encoder: Encoder,
    late: Option<Lateness>,
    /// Angle, speed and current at `now_s`.
    shaft: (f64, f64, f64),
}

/// One body or two, and whether the winding warms up.
#[derive(Debug, Clone)]
enum AnyEngine {
    Rigid(Box<Engine<f64, 3>>),
    RigidWarm(Box<Engine<f64, 4>>),
    Two(Box<Engine<f64, 5>>),
    TwoWarm(Box<Engine<f64, 6>>),
}

impl AnyEngine {
    /// Angle, speed and current at a time, with the commands that arrive until then.
    fn at(&mut self, on_their_way: &mut VecDeque<(f64, f64)>, real_s: f64) -> (f64, f64, f64) {
        match self {
            Self::Rigid(engine) => reach(engine, on_their_way, real_s),
            Self::RigidWarm(engine) => reach(engine, on_their_way, real_s),
            Self::Two(engine) => reach(engine, on_their_way, real_s),
            Self::TwoWarm(engine) => reach(engine, on_their_way, real_s),
        }
    }
}

impl Plant {
    /// A motor at rest; `seed` is that of random effects.
    pub fn new(motor: &Motor, kind: CommandKind, seed: u64) -> Result<Self, SimulationError> {
        Self::starting_at(motor, kind, seed, 0.5)
    }

    /// A motor at rest at this fraction of a count (0 .. 1).
    pub fn starting_at(
        motor: &Motor,
        kind: CommandKind,
        seed: u64,
        start_count_fraction: f64,
    ) -> Result<Self, SimulationError> {
        let chain = Chain::new(
            &motor.parameters,
            &motor.effects,
            Model::SecondOrder,
            kind,
            |x| x,
        );
        let machine = Machine::new(chain);
        let clock_scale = chain.timing.clock_scale;
        let longest_s = LONGEST_STEP_S * clock_scale;
        let jitter_s = chain.timing.jitter_s;
        let plant = Self {
            engine: match (machine.two, machine.warms()) {
                (false, false) => AnyEngine::Rigid(Box::new(Engine::new(machine, longest_s))),
                (false, true) => AnyEngine::RigidWarm(Box::new(Engine::new(machine, longest_s))),
                (true, false) => AnyEngine::Two(Box::new(Engine::new(machine, longest_s))),
                (true, true) => AnyEngine::TwoWarm(Box::new(Engine::new(machine, longest_s))),
            },
            supply_v: motor.parameters.supply_v,
            stated_counts_per_rev: motor.parameters.counts_per_rev,
            clock_scale,
            delay_s: chain.command.delay_s,
            notes_late_s: chain.command.ahead_s,
            command: 0.0,
            on_their_way: VecDeque::new(),
            now_s: 0.0,
            encoder: Encoder::new(chain.sensor, start_count_fraction, seed),
            late: (jitter_s > 0.0).then(|| Lateness::new(jitter_s, seed)),
            shaft: (0.0, 0.0, 0.0),
        };
        // A motor without inertia or with an invalid parameter does not move.
        let (angle_rad, speed, current) = plant
            .engine
            .clone()
            .at(&mut VecDeque::new(), LONGEST_STEP_S);
        if !(angle_rad + speed + current).is_finite() {
            return Err(SimulationError::Diverged {
                sample: 0,
                angle_rad,
            });
        }
        Ok(plant)
    }

    /// Advances the motor to `until_s` (on the board's clock) with a constant `command`.
    ///
    /// Time does not decrease: an earlier `until_s` changes the command only.
    pub fn hold(&mut self, command: f64, until_s: f64) {
        if command.is_finite() && command != self.command {
            self.command = command;
            let at_s = self.now_s * self.clock_scale + self.delay_s;
            self.on_their_way.push_back((at_s, command));
        }
        if until_s.is_finite() && until_s > self.now_s {
            self.now_s = until_s;
        }
        self.shaft = self.at(self.now_s * self.clock_scale);
    }

    /// Angle of the shaft that carries the encoder, in rad.
    pub fn angle_rad(&self) -> f64 {
        self.shaft.0
    }

    /// Speed of the shaft that carries the encoder, in rad/s.
    pub fn speed_rad_s(&self) -> f64 {
        self.shaft.1
    }

    /// Current in A.
    pub fn current_a(&self) -> f64 {
        self.shaft.2
    }

    /// Driver supply in V: the largest command.
    pub fn supply_v(&self) -> f64 {
        self.supply_v
    }

    /// Encoder counts per revolution that the motor file states.
    pub fn counts_per_rev(&self) -> f64 {
        self.stated_counts_per_rev
    }

    /// Delay of the logged commands in s of the motor's time: the board applies a profile's command earlier than it
    /// logs it.
    pub fn notes_late_s(&self) -> f64 {
        self.notes_late_s
    }

    /// Reads the encoder, with the random lateness of a sample.
    pub fn counts(&mut self) -> i64 {
        let mut at_s = self.now_s * self.clock_scale;
        let (angle, speed, _) = match &mut self.late {
            Some(late) => {
                // The command may change before the late sample is taken: the time after it is simulated in a copy.
                at_s += late.next_s();
                let (mut engine, mut on_their_way) =
                    (self.engine.clone(), self.on_their_way.clone());
                engine.at(&mut on_their_way, at_s)
            }
            None => self.shaft,
        };
        self.encoder.read(angle, speed, at_s)
    }

    fn at(&mut self, real_s: f64) -> (f64, f64, f64) {
        self.engine.at(&mut self.on_their_way, real_s)
    }
}

/// Integral ticks and the rest of a time; a rest due to rounding is 0.
fn ticks(real_s: f64, tick_s: f64) -> (u64, f64) {
    let ticks = real_s / tick_s;
    // Sample times are decimal fractions: rounding errors are removed.
    let near = ticks.round();
    if (ticks - near).abs() < 1e-5 {
        (near as u64, 0.0)
    } else {
        (ticks.floor() as u64, ticks - ticks.floor())
    }
}

fn reach<const N: usize>(
    engine: &mut Engine<f64, N>,
    on_their_way: &mut VecDeque<(f64, f64)>,
    real_s: f64,
) -> (f64, f64, f64) {
    let tick_s = engine.tick_s();
    let (tick, offset) = ticks(real_s, tick_s);
    while let Some(&(at_s, command)) = on_their_way.front() {
        let (at, after) = ticks(at_s, tick_s);
        if (at, after) > (tick, offset) {
            break;
        }
        engine.go_to(at);
        engine.command(command, after);
        on_their_way.pop_front();
    }
    let y = engine.state_at(tick, offset);
    let shaft = encoder_shaft::<N>(engine.machine.chain.transmission.encoder_on_load);
    (
        y[shaft],
        y[shaft + 1],
        engine.machine.current(&engine.mode, &y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::catalogue;
    use crate::{ActiveEffect, Drive, SimulationOptions, simulate};

    fn motor(effects: &[(&str, &[f64])]) -> Motor {
        let mut motor = Motor::default();
        for (id, values) in effects {
            motor.effects.set(ActiveEffect::new(id, values).unwrap());
        }
        motor
    }

    fn command(t_s: f64) -> f64 {
        [4.5, -1.0, 0.0, 0.7, -4.5, 0.25][(t_s / 0.21).floor() as usize % 6]
    }

    #[test]
    fn counts_do_not_depend_on_how_a_run_is_split() {
        let all = || catalogue().iter().map(|kind| kind.id);
        let by_default = |ids: &[&str]| {
            let mut motor = Motor::default();
            for id in ids {
                let effect = ActiveEffect::from_keys(id, [], &motor.parameters).unwrap();
                motor.effects.set(effect);
            }
            motor
        };
        let mut motors: Vec<Motor> = all().map(|id| by_default(&[id])).collect();
        motors.push(by_default(&all().collect::<Vec<_>>()));
        motors.extend([
            motor(&[]),
            motor(&[("stribeck", &[0.03, 0.3]), ("transport_delay", &[0.0047])]),
            motor(&[
                ("backlash", &[0.05, 0.4, 1.0]),
                ("missed_counts", &[0.1, 0.0]),
            ]),
            motor(&[("presliding", &[0.02]), ("voltage_drop", &[0.4])]),
        ]);
        for motor in motors {
            let mut whole = Plant::new(&motor, CommandKind::Voltage, 7).unwrap();
            let mut split = whole.clone();
            for k in 1..900_u32 {
                let (from, to) = (f64::from(k - 1) * 0.003, f64::from(k) * 0.003);
                let u = command(from + 1e-9);
                whole.hold(u, to);
                for part in 1..=(k % 4) {
                    split.hold(u, from + 0.003 * f64::from(part) / 5.1);
                }
                split.hold(u, to);
                assert_eq!(whole.counts(), split.counts());
                assert_eq!(whole.angle_rad().to_bits(), split.angle_rad().to_bits());
            }
        }
    }

    #[test]
    fn a_plant_is_the_simulation_stepped_from_outside() {
        for sample_time_s in [0.003, 0.03] {
            let motor = motor(&[("voltage_drop", &[0.3]), ("cogging", &[0.02, 12.0, 0.3])]);
            let t_s: Vec<f64> = (0..200).map(|k| f64::from(k) * sample_time_s).collect();
            let u: Vec<f64> = t_s.iter().map(|t| command(t + 1e-9)).collect();
            let drive = Drive {
                t_s: &t_s,
                command: &u,
                kind: CommandKind::Voltage,
            };
            let run = simulate(&motor, &drive, &SimulationOptions::default()).unwrap();
            let mut plant = Plant::new(&motor, CommandKind::Voltage, 1).unwrap();
            for k in 1..t_s.len() {
                plant.hold(u[k - 1], t_s[k]);
                assert!((plant.angle_rad() - run.angle_rad[k]).abs() < 1e-9);
                assert_eq!(plant.counts(), run.counts[k]);
            }
        }
    }
}
