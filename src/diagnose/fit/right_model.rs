//! Whether the model in pieces is the motor: a recording of each effect leaves rounding, held against the motor that made it.

use super::Left;
use crate::diagnose::pieces::Pieces;
use crate::motor::catalogue::catalogue;
use crate::motor::{ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, simulate};
use crate::recording::Run;
use crate::units::ROUNDING_VARIANCE;

/// Levels of the command in V.
const REVERSING: [f64; 10] = [4.5, 0.0, -2.0, 0.8, 3.0, -4.0, 0.5, 1.5, -1.1, 0.0];
const STAIRCASE: [f64; 10] = [0.0, 1.0, 2.0, 3.0, 4.0, 4.5, 4.5, 3.0, 2.0, 1.0];
/// Time constant of the handout's motor in s.
const TIME_CONSTANT_S: f64 = 0.034;
/// Most that rounding leaves in counts, a quarter above that of a sample alone: starts of pieces are rounded as well.
const MOST: f64 = 1.25;

/// Eight seconds of levels that each last so long.
fn recording(motor: &Motor, sample_time_s: f64, levels: &[f64; 10], hold_s: f64) -> Run {
    let samples = (8.0 / sample_time_s) as usize;
    let t_s: Vec<f64> = (0..samples).map(|k| k as f64 * sample_time_s).collect();
    let level = |t_s: &f64| levels[(t_s / hold_s) as usize % levels.len()];
    let command: Vec<f64> = t_s.iter().map(level).collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let seen = simulate(motor, &drive, &SimulationOptions::default());
    Run {
        sample_time_s,
        counts_per_rev: motor.parameters.counts_per_rev,
        counts: seen.expect("a motor that can be simulated").counts,
        t_s,
        command,
        ..Run::default()
    }
}

/// What the motor of the catalogue's effect leaves of its own recording, in counts RMS.
fn left(id: &str, counts_per_rev: f64, run: impl Fn(&Motor) -> Run) -> f64 {
    let mut nominal = Motor::default();
    nominal.parameters.counts_per_rev = counts_per_rev;
    let kind = catalogue().iter().find(|kind| kind.id == id);
    let parameters = kind.expect("an effect of the catalogue").parameters;
    let default =
        |p: &crate::motor::catalogue::EffectParameter| p.default(&nominal.parameters, 0.01);
    let values: Vec<f64> = parameters.iter().map(default).collect();
    let mut motor = nominal.clone();
    (motor.effects).set(ActiveEffect::new(id, &values).expect("its own defaults"));
    let pieces = Pieces::new(&[run(&motor)], &nominal).expect("a run");
    let left = Left::of(&pieces, &motor, TIME_CONSTANT_S).expect("a motor");
    (left.iter().map(|r| r * r).sum::<f64>() / left.len() as f64).sqrt()
}

/// An encoder that is off its axis says another angle and another speed than the shaft's, one with other counts as well: a piece starts
/// where the shaft is.
#[test]
fn each_effect_leaves_rounding_of_its_own_motor() {
    let most = MOST * ROUNDING_VARIANCE.sqrt();
    // What comes by chance is not predicted.
    for kind in catalogue().iter().filter(|kind| !kind.random) {
        for (counts_per_rev, sample_time_s) in [(720.0, 0.003), (720.0, 0.03), (8192.0, 0.003)] {
            let found = left(kind.id, counts_per_rev, |motor| {
                recording(motor, sample_time_s, &REVERSING, 0.51)
            });
            assert!(found < most, "{}, {sample_time_s} s: {found}", kind.id);
        }
        for counts_per_rev in [720.0, 8192.0] {
            let found = left(kind.id, counts_per_rev, |motor| {
                recording(motor, 0.01, &STAIRCASE, 0.8)
            });
            assert!(found < most, "{}, staircase: {found}", kind.id);
        }
    }
}

/// A start whose speed is measured over a bend, of a time constant between two samples and of many counts, is no gap. It is to first order
/// where the torque is one of the place.
#[test]
fn a_speed_that_is_measured_over_a_bend_leaves_rounding() {
    let most = MOST * ROUNDING_VARIANCE.sqrt();
    let of_place = ["cogging", "gravity_load"];
    let others = catalogue().iter().filter(|kind| !kind.random);
    let others: Vec<&str> = others
        .map(|kind| kind.id)
        .filter(|id| !of_place.contains(id))
        .collect();
    let left = |id: &&&str| left(id, 8192.0, |motor| recording(motor, 0.03, &REVERSING, 0.51));
    let leave_more: Vec<&&str> = others.iter().filter(|id| left(id) > most).collect();
    assert!(leave_more.len() <= 1, "{leave_more:?}");
    for id in of_place {
        let found = left(&&id);
        assert!(found < 2.0, "{id}: {found}");
    }
}
