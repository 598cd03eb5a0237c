//! The diagnosis on cases that other code made: the generator shares nothing with the simulator.

use case_generator::{Case, generate};
use motorlab::diagnose::{DiagnoseError, Diagnosis, Verdict, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::{Run, read_run_from};

fn runs(case: &Case) -> Vec<Run> {
    let texts = case.runs.iter().map(|run| run.to_csv());
    texts
        .map(|text| read_run_from(text.as_bytes(), "case").unwrap().0)
        .collect()
}

fn diagnosis(seed: u64, kind: &str) -> (Case, Diagnosis) {
    let case = generate(seed, &kind.parse().unwrap());
    let motor = Motor::from_toml(&case.nominal.to_toml()).unwrap();
    let found = diagnose(&runs(&case), &motor, &|_| {}).unwrap();
    (case, found)
}

#[test]
fn probabilities_of_all_causes_add_to_one() {
    let (_, found) = diagnosis(3, "stribeck");
    let total: f64 = found.causes.iter().map(|cause| cause.probability).sum();
    assert!((total - 1.0).abs() < 1e-9, "{total}");
    let stages: f64 = found.place.stage_probabilities.values().sum();
    assert!((stages - 1.0).abs() < 1e-9, "{stages}");
}

#[test]
fn a_motor_without_an_effect_is_not_accused() {
    let (_, found) = diagnosis(8, "none");
    assert!(found.effects.is_empty(), "{}", found.sentence);
    assert!(matches!(
        found.verdict,
        Verdict::NoGap | Verdict::Parameters
    ));
}

#[test]
fn runs_that_say_nothing_are_errors() {
    let motor = Motor::default();
    assert!(matches!(
        diagnose(&[], &motor, &|_| {}),
        Err(DiagnoseError::NoRuns)
    ));
    let short = Run {
        sample_time_s: 0.003,
        counts_per_rev: 720.0,
        t_s: vec![0.0, 0.003],
        command: vec![0.0, 4.5],
        counts: vec![0, 1],
        ..Run::default()
    };
    let error = diagnose(&[short], &motor, &|_| {}).unwrap_err();
    assert!(error.to_string().contains("at least 20"), "{error}");
}
#[test]
fn stribeck_friction_is_named_and_closes_the_gap() {
    let (_, found) = diagnosis(5, "stribeck");
    assert_eq!(found.verdict, Verdict::Effect, "{}", found.sentence);
    assert_eq!(found.effects, ["stribeck"]);
    assert_eq!(found.place.stage, Some("mechanical"));
    assert!(found.gap.after_effect < found.gap.after_parameters);
    assert!(found.gap.closed > 0.9, "{:?}", found.gap);
}
