//! Random effects are identified by the variance that they predict: other parameters imitate their mean.

use motorlab::diagnose::{Options, Verdict, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::Run;

use crate::recorded::{LEVELS, recorded, with};

/// Counts per revolution at which a hundredth of the edges is some counts in a segment.
const FINE: f64 = 8192.0;

/// Largest relative difference from the true value: three standard deviations for the shortest recording.
const AGREES: f64 = 0.15;

/// The motor file without these effects, and their recording of 8 s at 5 ms.
fn of(effects: &[(&str, &[f64])]) -> (Motor, Vec<Run>) {
    let mut motor = with(effects);
    motor.parameters.counts_per_rev = FINE;
    let mut run = recorded(&motor, &LEVELS, 0.005, 8.0);
    run.counts_per_rev = FINE;
    motor.effects = Motor::default().effects;
    (motor, vec![run])
}

/// Each is named, with the true parameter.
#[test]
fn a_random_effect_is_identified_with_its_parameter() {
    for (effect, values, key) in [
        ("missed_counts", &[0.01, 0.0][..], "probability"),
        ("missed_counts", &[0.03, 0.0], "probability"),
        ("sample_jitter", &[0.002], "spread_s"),
    ] {
        let (motor, runs) = of(&[(effect, values)]);
        let found = diagnose(&runs, &motor, &Options::default()).expect("a diagnosis");
        let what = format!("{effect} {}: {}", values[0], found.sentence);
        assert_eq!(found.verdict, Verdict::Effect, "{what}");
        assert_eq!(found.effects, [effect], "{what}");
        let cause = found.causes.iter().find(|cause| cause.effect == effect);
        let parameters = &cause.expect("the named one").parameters;
        let interval = parameters.get(key).expect("its parameter");
        let ratio = interval.value / values[0];
        assert!((ratio - 1.0).abs() < AGREES, "{what} {interval:?}");
    }
}

/// The same recordings of a motor without it: none is named.
#[test]
fn without_a_random_effect_none_is_identified() {
    let (motor, runs) = of(&[]);
    let found = diagnose(&runs, &motor, &Options::default()).expect("a diagnosis");
    assert!(found.effects.is_empty(), "{}", found.sentence);
}
