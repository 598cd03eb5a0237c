//! A threshold between two commanded levels: the error does not change until it reaches one of them.

use motorlab::diagnose::{Options, diagnose};
use motorlab::motor::Motor;

use crate::recorded::{recorded, with};

/// Levels of 0.5 s in V, 0.5 V apart: up and down, both ways.
const STAIRCASE: [f64; 24] = [
    0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5, 0.0, //
    -0.5, -1.0, -1.5, -2.0, -2.5, -3.0, -2.5, -2.0, -1.5, -1.0, -0.5, 0.0,
];

/// One threshold is more probable than two equal ones, wherever it lies between the levels; its interval ends at them.
#[test]
fn a_threshold_is_known_to_lie_between_two_levels() {
    for threshold in [1.1, 1.25, 1.4] {
        let run = recorded(
            &with(&[("dead_zone", &[threshold])]),
            &STAIRCASE,
            0.01,
            14.0,
        );
        let found = diagnose(&[run], &Motor::default(), &Options::default()).expect("a diagnosis");
        assert_eq!(found.effects, ["dead_zone"], "{}", found.sentence);
        let number = found.causes[0].parameters["threshold_v"];
        let off = (number.lo95 - 1.0).abs().max((number.hi95 - 1.5).abs());
        assert!(off < 0.05, "{threshold} V: {number:?}");
    }
}
