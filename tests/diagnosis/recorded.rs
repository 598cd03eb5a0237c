//! Recordings of simulated motors.

use motorlab::motor::{ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::Run;

/// Ids with the values of their parameters.
pub type Effects<'a> = &'a [(&'a str, &'a [f64])];

/// Levels of 0.5 s of both signs in V, some below any dead zone.
pub const LEVELS: [f64; 10] = [3.0, -3.0, 4.5, -4.5, 1.0, -1.0, 2.0, -2.0, 0.5, -4.5];

/// The handout's motor with effects.
pub fn with(effects: Effects<'_>) -> Motor {
    let mut motor = Motor::default();
    for (id, values) in effects {
        let effect = ActiveEffect::new(id, values).expect("an effect of the catalogue");
        motor.effects.set(effect);
    }
    motor
}

/// Counts of a motor by the simulator's encoder under levels of 0.5 s.
pub fn recorded(motor: &Motor, levels: &[f64], sample_time_s: f64, duration_s: f64) -> Run {
    let samples = (duration_s / sample_time_s).round() as usize;
    let each = (0.5 / sample_time_s).round() as usize;
    let command = (0..samples).map(|k| levels[k / each % levels.len()]);
    driven(motor, command.collect(), sample_time_s)
}

/// The same under any command.
pub fn driven(motor: &Motor, command: Vec<f64>, sample_time_s: f64) -> Run {
    let t_s: Vec<f64> = (0..command.len())
        .map(|k| k as f64 * sample_time_s)
        .collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let simulated = simulate(motor, &drive, &SimulationOptions::default());
    Run {
        sample_time_s,
        counts_per_rev: motor.parameters.counts_per_rev,
        supply_v: Some(4.5),
        complete: true,
        counts: simulated.expect("a motor").counts,
        t_s,
        command,
        ..Run::default()
    }
}
