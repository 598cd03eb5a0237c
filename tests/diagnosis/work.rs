//! The cost of a diagnosis on any machine: samples simulated, a derivative counted as many again, as the document states them.

use motorlab::diagnose::{Options, diagnose};
use motorlab::motor::{
    ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, catalogue, simulate,
};
use motorlab::recording::Run;

/// Samples of each recording: five seconds at 10 ms.
const SAMPLES: usize = 500;
/// Most samples simulated for each sample of the recording. Within the noise floor nothing is searched: the motor is fitted, and its
/// intervals are. With effects the search fits 15 sets at first and a third as many a round, each some ten steps of Levenberg-Marquardt of
/// up to ten derivatives: 2 s of one core for 500 samples.
const NOTHING: f64 = 1_000.0;
const EFFECTS: f64 = 20_000.0;
/// Least samples simulated for each: a count that stays behind what is done would pass the bounds.
const LEAST: f64 = 20.0;
/// Relative growth that is none: another machine's exponentials end a fit a step later.
const CHANGED: f64 = 0.15;

/// Levels of 0.5 s, both ways.
const LEVELS: [f64; 10] = [3.0, -3.0, 4.5, -4.5, 1.0, -1.0, 2.0, -2.0, 0.5, -4.5];

fn recording(effects: Effects<'_>, samples: usize) -> Run {
    let mut motor = Motor::default();
    for (id, values) in effects {
        let effect = ActiveEffect::new(id, values).expect("an effect");
        motor.effects.set(effect);
    }
    let t_s: Vec<f64> = (0..samples).map(|k| 0.01 * k as f64).collect();
    let command: Vec<f64> = (0..samples)
        .map(|k| LEVELS[k / 50 % LEVELS.len()])
        .collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let counts = simulate(&motor, &drive, &SimulationOptions::default())
        .expect("a motor")
        .counts;
    Run {
        sample_time_s: 0.01,
        counts_per_rev: 720.0,
        t_s,
        command,
        counts,
        ..Run::default()
    }
}

/// Ids with the values of their parameters.
type Effects<'a> = &'a [(&'a str, &'a [f64])];

/// Samples simulated for each sample recorded.
fn work(effects: Effects<'_>, samples: usize) -> f64 {
    let run = recording(effects, samples);
    let found = diagnose(&[run], &Motor::default(), &Options::default()).expect("a diagnosis");
    found.simulated_samples as f64 / samples as f64
}

#[test]
fn what_each_diagnosis_simulates_is_bounded() {
    let gravity = (catalogue::find("gravity_load")
        .expect("an effect")
        .1
        .parameters)
        .iter();
    let motor = Motor::default();
    let defaults: Vec<f64> = gravity
        .map(|parameter| parameter.default(&motor.parameters, 0.01))
        .collect();
    let bounds: [(Effects<'_>, f64); 4] = [
        (&[], NOTHING),
        (&[("dead_zone", &[0.8])], EFFECTS),
        (&[("gravity_load", &defaults)], EFFECTS),
        (
            &[("dead_zone", &[0.8]), ("viscous_friction", &[0.02])],
            EFFECTS,
        ),
    ];
    for (effects, most) in bounds {
        let found = work(effects, SAMPLES);
        println!("{effects:?}: {found:.0}");
        assert!(
            (LEAST..=most).contains(&found),
            "{effects:?}: {found:.0} samples simulated for each, at most {most} expected"
        );
    }
}

/// Twice the samples are at most twice the work: no more a sample.
#[test]
fn work_grows_no_faster_than_the_samples() {
    let (once, twice) = (work(&[], SAMPLES), work(&[], 2 * SAMPLES));
    assert!(twice < (1.0 + CHANGED) * once, "{once} {twice}");
}
