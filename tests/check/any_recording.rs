//! `check` returns for every possible recording.

use motorlab::check::check;
use motorlab::motor::Motor;
use motorlab::recording::{CommandKind, Run};
use proptest::prelude::*;

/// Floating-point special values, and ordinary numbers.
fn numbers() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(-0.0),
        Just(f64::MIN_POSITIVE),
        Just(5e-324),
        Just(1e6),
        Just(-1e6),
        Just(f64::MAX),
        Just(f64::MIN),
        Just(f64::NAN),
        -12.0..12.0_f64,
        -1e-9..1e-9_f64,
    ]
}

fn counts() -> impl Strategy<Value = i64> {
    prop_oneof![
        Just(0),
        Just(i64::MAX),
        Just(i64::MIN),
        -2_i64..3,
        -100_000_i64..100_000,
        any::<i64>(),
    ]
}

/// Steps of time: increasing, zero, or jumping.
fn steps() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.003),
        Just(0.003),
        Just(0.003),
        0.0..0.1_f64,
        Just(0.0),
        Just(1e-300),
        Just(3600.0),
        Just(1e300),
    ]
}

/// A column in which a value holds for some samples, as commands and resting shafts do.
fn held<T: Clone + std::fmt::Debug>(
    values: impl Strategy<Value = T>,
    samples: usize,
) -> impl Strategy<Value = Vec<T>> {
    let intervals = prop::collection::vec((values, 1_usize..80), 1..20);
    intervals.prop_map(move |intervals| {
        let all = intervals
            .into_iter()
            .flat_map(|(value, n)| std::iter::repeat_n(value, n));
        let mut column: Vec<T> = all.take(samples).collect();
        let last = column[column.len() - 1].clone();
        column.resize(samples, last);
        column
    })
}

prop_compose! {
    fn runs()(samples in 1_usize..300)(
        steps_s in prop::collection::vec(steps(), samples),
        command in prop_oneof![held(numbers(), samples), prop::collection::vec(numbers(), samples)],
        counts in prop_oneof![held(counts(), samples), prop::collection::vec(counts(), samples), turning(samples)],
        host in prop::option::of(prop::collection::vec(numbers(), samples)),
        supply in prop::option::of(prop::collection::vec(numbers(), samples)),
        seq in prop::option::of(prop::collection::vec(any::<u64>(), samples)),
        sample_time_s in numbers(),
        counts_per_rev in numbers(),
        supply_v in prop::option::of(numbers()),
        kind in prop_oneof![Just(CommandKind::Voltage), Just(CommandKind::Current), Just(CommandKind::Torque)],
        header in prop_oneof![
            Just(""),
            Just("sample_time_s = 0.003"),
            Just("[imported]\nwrap_counts = 256"),
            Just("[imported]\nwrap_counts = 0.0\ncommand = \"not recorded\""),
            Just("[imported]\nposition = \"not recorded\""),
        ],
    ) -> Run {
        let mut t_s = 0.0;
        Run {
            t_s: steps_s.iter().map(|step_s| { t_s += step_s; t_s }).collect(),
            command,
            counts,
            host_t_s: host,
            measured_supply_v: supply,
            seq,
            sample_time_s,
            counts_per_rev,
            supply_v,
            command_kind: kind,
            header: header.parse().expect("TOML"),
            ..Run::default()
        }
    }
}

/// A turning shaft, so that checks of motion are reached.
fn turning(samples: usize) -> impl Strategy<Value = Vec<i64>> {
    (-500_i64..500, 1_i64..5000).prop_map(move |(speed, range)| {
        (0..samples as i64)
            .map(|k| (speed * k).rem_euclid(range))
            .collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn every_recording_has_a_result(runs in prop::collection::vec(runs(), 1..4), is_given in any::<bool>()) {
        let motor = Motor::default();
        let findings = check(&runs, is_given.then_some(&motor));
        for finding in findings {
            prop_assert!(!finding.message.is_empty() && !finding.remedy.is_empty());
        }
    }
}

#[test]
fn no_recording_and_an_empty_one_have_a_result() {
    assert!(check(&[], None).is_empty());
    let found = check(&[Run::default()], None);
    assert_eq!(found.len(), 1);
}
