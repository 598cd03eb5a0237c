//! Machine-independent cost of a diagnosis: samples simulated, a derivative counted as many again, as in the
//! document.

use motorlab::diagnose::{Options, diagnose};
use motorlab::motor::{Motor, catalogue};

use crate::recorded::{Effects, LEVELS, recorded, with};

/// Samples of each recording: five seconds at 10 ms.
const SAMPLES: usize = 500;
/// Most samples simulated per recorded sample. Within the noise floor the motor and its intervals are fitted, and some
/// effects that its parameters imitate. With effects the search fits 15 sets in the first round and a third as many in
/// others, each with some ten steps of Levenberg-Marquardt and up to ten derivatives: 2 s of one core for 500 samples.
const NOTHING: f64 = 1_500.0;
const EFFECTS: f64 = 20_000.0;
/// Least samples simulated per recorded sample: a count that misses work would pass the upper bounds.
const LEAST: f64 = 20.0;
/// Tolerated relative increase: another machine's exponentials may end a fit a step later.
const CHANGED: f64 = 0.15;

/// Samples simulated per recorded sample.
fn work(effects: Effects<'_>, samples: usize) -> f64 {
    let run = recorded(&with(effects), &LEVELS, 0.01, 0.01 * samples as f64);
    let found = diagnose(&[run], &Motor::default(), &Options::default()).expect("a diagnosis");
    found.simulated_samples as f64 / samples as f64
}

#[test]
fn simulations_of_each_diagnosis_are_bounded() {
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

/// Twice the samples are at most twice the work, for recordings in which a single step of a fit is a small part of it.
#[test]
fn work_grows_no_faster_than_the_samples() {
    let (once, twice) = (work(&[], 2 * SAMPLES), work(&[], 4 * SAMPLES));
    assert!(twice < (1.0 + CHANGED) * once, "{once} {twice}");
}
