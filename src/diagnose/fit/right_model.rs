//! Whether the model in pieces is the motor: a recording of each effect leaves rounding, held against the motor that made it.

use super::{Base, Left, Model, Starts, finished};
use crate::diagnose::noise::Noise;
use crate::diagnose::pieces::Pieces;
use crate::diagnose::samples::{base_of, fitted, member, motor_with};
use crate::diagnose::settings::USUAL_WANDER;
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

/// A motor with the catalogue's effect, and its recording in the pieces of one without.
fn of_its_own(id: &str, counts_per_rev: f64, run: impl Fn(&Motor) -> Run) -> (Motor, Pieces) {
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
    (motor, pieces)
}

/// What the motor of the catalogue's effect leaves of its own recording, in counts RMS.
fn left(id: &str, counts_per_rev: f64, run: impl Fn(&Motor) -> Run) -> f64 {
    let (motor, pieces) = of_its_own(id, counts_per_rev, run);
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
            // Two bodies swing about a start that is measured over 0.1 s: what that leaves is bounded as it is weighed, below.
            if sample_time_s > 0.01 && ["backlash", "compliance"].contains(&kind.id) {
                continue;
            }
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

/// A shaft that turns round between two samples does not rest: what it leaves under its own model is rounding, and no load wanders.
#[test]
fn what_turns_round_in_a_sample_is_fitted_as_it_is() {
    let jogs = [3.0, -3.0, 3.0, -3.0, 2.0, -2.0, 2.0, -2.0, 3.0, -3.0];
    let run = recording(
        &motor_with(&[("coulomb_friction", &[0.06])]),
        0.03,
        &jogs,
        0.09,
    );
    let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
    let fit = fitted(
        &pieces,
        &base_of(&pieces),
        &[member("coulomb_friction", 0.04)],
    );
    assert!(
        fit.mean_square().sqrt() < MOST * ROUNDING_VARIANCE.sqrt(),
        "{}",
        fit.mean_square()
    );
    assert!(fit.noise.strength < 0.1 * USUAL_WANDER, "{:?}", fit.noise);
    let own = fit.model.motor(&fit.x).parameters.coulomb_friction_nm;
    assert!((own - 0.06).abs() < 0.002, "{own}");
}

/// What is left is what the filter expects, a mean square of 1, with no load that wanders. Scores rest on it.
#[test]
fn what_a_right_model_leaves_is_what_the_filter_expects() {
    // How many effects at most leave more: two bodies at 30 ms, and there with many counts what depends on the place, a dead zone and
    // freewheeling.
    for (counts_per_rev, sample_time_s, leave_more) in [
        (720.0, 0.003, 0),
        (720.0, 0.03, 2),
        (8192.0, 0.003, 0),
        (8192.0, 0.03, 4),
    ] {
        let white = |id: &'static str| {
            let run = |motor: &Motor| recording(motor, sample_time_s, &REVERSING, 0.51);
            let (motor, pieces) = of_its_own(id, counts_per_rev, run);
            let base = Base {
                motor: motor.clone(),
                ..base_of(&pieces)
            };
            let model = Model::new(&base, Vec::new());
            let starts = Starts::of(&pieces, &motor, TIME_CONSTANT_S).expect("a motor");
            let fit = finished(
                &pieces,
                &model,
                base.kind,
                model.start(),
                Noise::NONE,
                starts.0,
            );
            let white = fit.expect("a motor").white;
            let looks: f64 = pieces.weight.iter().sum();
            (white.iter().map(|w| w * w).sum::<f64>() / looks, id)
        };
        let kinds = catalogue().iter().filter(|kind| !kind.random);
        let mut all: Vec<(f64, &str)> = kinds.map(|kind| white(kind.id)).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        assert!(all[leave_more].0 < MOST, "{sample_time_s} s: {all:?}");
        let middle = all[all.len() / 2].0;
        assert!((0.9..1.1).contains(&middle), "{sample_time_s} s: {middle}");
    }
}
