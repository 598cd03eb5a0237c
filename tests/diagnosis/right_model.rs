//! The true model of a recording is within the noise floor: with its effect in the motor file no effect is missing.

use std::fmt::Write as _;

use motorlab::diagnose::{Options, Verdict, diagnose};
use motorlab::motor::catalogue::catalogue;
use motorlab::motor::{ActiveEffect, Motor};
use motorlab::recording::Run;
use motorlab::units::ROUNDING_VARIANCE;

use crate::recorded::{LEVELS, recorded};

/// Largest ratio of the true model's error to quantization, and least one of a model without the effect to the noise
/// floor: the initial fraction of a count is random.
const ABOVE_FLOOR: f64 = 1.25;

/// Eight seconds at 10 ms.
fn recording(motor: &Motor) -> Run {
    recorded(motor, &LEVELS, 0.01, 8.0)
}

/// Each effect of the catalogue, in the motor file with the true values.
#[test]
fn the_true_model_is_within_the_noise_floor() {
    let (mut wrong, mut visible) = (String::new(), 0);
    for kind in catalogue() {
        let mut motor = Motor::default();
        let effect = ActiveEffect::from_keys(kind.id, [], &motor.parameters);
        motor.effects.set(effect.expect("its defaults"));
        let run = recording(&motor);
        visible += usize::from(run.counts != recording(&Motor::default()).counts);
        let found = diagnose(&[run], &motor, &Options::default()).expect("a diagnosis");
        let is_quiet = matches!(found.verdict, Verdict::NoGap | Verdict::Parameters);
        let floor = match kind.random {
            // The random effect is not reproduced; its variance is predicted.
            true => found.gap.floor,
            false => ROUNDING_VARIANCE.sqrt(),
        };
        let is_small = found.gap.before <= ABOVE_FLOOR * floor;
        if !(is_quiet && is_small && found.effects.is_empty()) {
            writeln!(wrong, "{}: {}", kind.id, found.sentence).expect("room");
        }
    }
    // Effects without an influence on this recording at their default values would pass any diagnosis.
    assert!(visible >= 25, "{visible} effects change the recording");
    assert!(wrong.is_empty(), "{wrong}");
}

/// The same recordings without the effect in the motor file are above the floor, so that the test above can fail.
#[test]
fn without_the_effect_the_same_recording_is_above_the_noise_floor() {
    for id in ["dead_zone", "backlash", "gravity_load", "voltage_drop"] {
        let mut motor = Motor::default();
        let effect = ActiveEffect::from_keys(id, [], &motor.parameters);
        motor.effects.set(effect.expect("its defaults"));
        let found = diagnose(&[recording(&motor)], &Motor::default(), &Options::default());
        let found = found.expect("a diagnosis");
        assert_ne!(found.verdict, Verdict::NoGap, "{id}: {}", found.sentence);
        assert!(found.gap.before > ABOVE_FLOOR * found.gap.floor, "{id}");
    }
}
