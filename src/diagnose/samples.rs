//! Simulated recordings for unit tests.

use crate::motor::{ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, simulate};
use crate::recording::Run;

/// Sample time in s.
pub(crate) const SAMPLE_TIME_S: f64 = 0.01;

/// The handout's motor with effects.
pub(crate) fn motor_with(effects: &[(&str, &[f64])]) -> Motor {
    let mut motor = Motor::default();
    for (id, values) in effects {
        let effect = ActiveEffect::new(id, values).expect("an effect of the catalogue");
        motor.effects.set(effect);
    }
    motor
}

/// A motor at levels of both signs with rests, 0.51 s each, from rest.
pub(crate) fn recording(motor: &Motor, samples: usize) -> Run {
    let levels = [4.5, 0.0, -2.0, 0.8, 3.0, -4.0, 0.5, 1.5, -1.1, 0.0];
    let t_s: Vec<f64> = (0..samples).map(|k| k as f64 * SAMPLE_TIME_S).collect();
    let command: Vec<f64> = (0..samples)
        .map(|k| levels[k / 51 % levels.len()])
        .collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let counts = simulate(motor, &drive, &SimulationOptions::default())
        .expect("a motor that can be simulated")
        .counts;
    Run {
        sample_time_s: SAMPLE_TIME_S,
        counts_per_rev: 720.0,
        t_s,
        command,
        counts,
        ..Run::default()
    }
}
