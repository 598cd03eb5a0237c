//! Delays as long as a recording shows.

use motorlab::diagnose::{Options, Verdict, diagnose};
use motorlab::motor::Motor;

use crate::recorded::{LEVELS, recorded, with};

/// A delay longer than the catalogue's range of 0.3 s is fitted where the first motion shows it, and is at no bound.
#[test]
fn a_delay_may_be_as_long_as_the_recording_shows() {
    for delay_s in [0.1, 0.35, 0.6] {
        let run = recorded(
            &with(&[("transport_delay", &[delay_s])]),
            &LEVELS,
            0.01,
            8.0,
        );
        let found = diagnose(&[run], &Motor::default(), &Options::default()).expect("a diagnosis");
        assert_eq!(found.verdict, Verdict::Effect, "{}", found.sentence);
        assert_eq!(found.effects, ["transport_delay"], "{}", found.sentence);
        assert!(!found.causes[0].at_bound, "{}", found.sentence);
        let fitted = found.causes[0].parameters["delay_s"];
        assert!(
            fitted.lo95 <= delay_s && delay_s <= fitted.hi95,
            "{delay_s} s: {fitted:?}"
        );
    }
}
