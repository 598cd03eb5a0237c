//! Changes of the data that affect an answer, and those that do not: uninformative host times, more data.

use motorlab::diagnose::{Options, Settings, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::Run;

use crate::recorded::{LEVELS, recorded, with};

/// The host's times are used for the board's clock only: without them, or with an uninformative column, the answer is
/// the same.
#[test]
fn uninformative_host_times_change_no_result() {
    for effects in [&[("dead_zone", &[0.8][..])][..], &[]] {
        let run = recorded(&with(effects), &LEVELS, 0.01, 8.0);
        let samples = run.len();
        // Arrivals at an idle host: 1000 s after the board's origin, and 0.3 to 0.5 ms late.
        let late = |k: usize| 0.0003 + 0.0002 * ((k * k) as f64 * std::f64::consts::PI).fract();
        let arrivals = (0..samples)
            .map(|k| 1000.0 + run.t_s[k] + late(k))
            .collect();
        let hosts = [None, Some(vec![0.0; samples]), Some(arrivals)];
        let found = hosts.map(|host_t_s| {
            let run = Run {
                host_t_s,
                ..run.clone()
            };
            diagnose(&[run], &Motor::default(), &Options::default()).expect("a diagnosis")
        });
        for (other, what) in found[1..].iter().zip(["constant", "in real time"]) {
            assert_eq!(
                other.verdict, found[0].verdict,
                "{what}: {}",
                other.sentence
            );
            assert_eq!(
                other.effects, found[0].effects,
                "{what}: {}",
                other.sentence
            );
        }
    }
}

/// Lengths in s of the recordings that are cut from one.
const CUTS_S: [f64; 3] = [4.0, 8.0, 15.0];
/// Tolerated decrease of a probability: the posterior is of another choice of segments.
const SLACK: f64 = 0.05;

/// More data is never worse: the inclusion probability of the true effect (or of its class) does not decrease.
#[test]
fn an_effect_is_no_less_probable_with_more_data() {
    let cases: [(&str, &[f64]); 5] = [
        ("dead_zone", &[0.8]),
        ("backlash", &[0.03, 0.5, 0.0]),
        ("gravity_load", &[0.02, 0.4]),
        ("voltage_drop", &[0.3]),
        ("transport_delay", &[0.02]),
    ];
    let (mut falls, mut last) = (Vec::new(), Vec::new());
    for (id, values) in cases {
        let whole = recorded(&with(&[(id, values)]), &LEVELS, 0.01, 15.0);
        let probability = CUTS_S.map(|duration_s| {
            let samples = (duration_s / 0.01).round() as usize;
            let part = Run {
                t_s: whole.t_s[..samples].to_vec(),
                command: whole.command[..samples].to_vec(),
                counts: whole.counts[..samples].to_vec(),
                ..whole.clone()
            };
            let found = diagnose(&[part], &Motor::default(), &Options::default());
            let found = found.expect("a diagnosis");
            let cause = found.causes.iter().find(|cause| cause.effect == id);
            cause.map_or(0.0, |cause| {
                cause.class_probability.unwrap_or(cause.inclusion)
            })
        });
        println!("{id}: {probability:.3?}");
        falls.extend(
            (!probability.is_sorted_by(|a, b| b + SLACK >= *a)).then_some((id, probability)),
        );
        last.push(probability[CUTS_S.len() - 1]);
    }
    assert!(falls.is_empty(), "{falls:?}");
    // All are identified from the whole recording: a probability that is always 0 does not decrease either.
    assert!(
        last.iter().all(|p| *p >= Settings::default().identified),
        "{last:?}"
    );
}
