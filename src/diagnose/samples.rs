//! Recordings of simulated motors for unit tests, and fits to them.

use super::fit::{Base, Fit, Member, Model, Most, fit};
use super::pieces::Pieces;
use super::validation::Presence;
use crate::motor::catalogue::catalogue;
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

/// A motor on levels of both signs with rests, 0.51 s each, from a share of a count beyond 0 on.
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

/// The handout's motor, of which nothing but its numbers is known.
pub(crate) fn base_of(pieces: &Pieces) -> Base {
    Base {
        motor: Motor::default(),
        kind: CommandKind::Voltage,
        sample_time_s: pieces.runs[0].sample_time_s,
        clock: None,
        is_host_timed: false,
        knows_torque: false,
        then: None,
    }
}

/// An effect of one number.
pub(crate) fn member(id: &str, value: f64) -> Member {
    let index = catalogue().iter().position(|kind| kind.id == id);
    Member {
        index: index.expect("an effect of the catalogue"),
        values: vec![value],
    }
}

/// A model with these members, fitted from where they stand.
pub(crate) fn fitted(pieces: &Pieces, base: &Base, members: &[Member]) -> Fit {
    let model = Model::new(base, members.to_vec());
    let starts = [model.start()];
    fit(pieces, &model, base.kind, &starts, Most::anything()).expect("a motor")
}

/// What promises far more than chance.
pub(crate) fn present() -> Presence {
    Presence {
        gain: 50.0,
        by_chance: vec![1.0; 99],
    }
}
