//! What a diagnosis costs on whatever machine: samples simulated, as the document counts them. A change of cost is seen here.

use motorlab::diagnose::{Options, diagnose};
use motorlab::motor::{
    ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, catalogue, simulate,
};
use motorlab::recording::Run;

/// Samples of each recording: five seconds at 10 ms.
const SAMPLES: usize = 500;
/// Relative change from which on a figure is to be written anew, with its reason: another machine's exponentials end a fit a step
/// later, a change of the method does more.
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
fn what_each_diagnosis_simulates_is_as_written() {
    let gravity = (catalogue::find("gravity_load")
        .expect("an effect")
        .1
        .parameters)
        .iter();
    let motor = Motor::default();
    let defaults: Vec<f64> = gravity
        .map(|parameter| parameter.default(&motor.parameters, 0.01))
        .collect();
    let written: [(Effects<'_>, f64); 4] = [
        (&[], 727.0),
        (&[("dead_zone", &[0.8])], 4020.0),
        (&[("gravity_load", &defaults)], 11800.0),
        (
            &[("dead_zone", &[0.8]), ("viscous_friction", &[0.02])],
            4066.0,
        ),
    ];
    let found: Vec<(f64, f64)> = (written.iter())
        .map(|(effects, written)| (work(effects, SAMPLES), *written))
        .collect();
    for (found_now, written) in &found {
        assert!(
            (found_now / written - 1.0).abs() < CHANGED,
            "simulated samples a sample, found and written: {found:.0?}"
        );
    }
}

/// Twice the samples are at most twice the work: no more a sample.
#[test]
fn work_grows_no_faster_than_the_samples() {
    let (once, twice) = (work(&[], SAMPLES), work(&[], 2 * SAMPLES));
    assert!(twice < (1.0 + CHANGED) * once, "{once} {twice}");
}
