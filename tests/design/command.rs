//! `motorlab design` from the command line: what a planned profile cannot show or separate.
#![cfg(unix)]

use std::fs;

use crate::support::command::run;
use serde_json::Value;

fn matrix(arguments: &str) -> Value {
    let keep = tempfile::tempdir().expect("a directory");
    let words: Vec<&str> = arguments.split_whitespace().collect();
    let done = run(keep.path(), &[&["design", "--json"], &words[..]].concat());
    assert_eq!(done.status, Some(0), "{}", done.messages);
    serde_json::from_str(&done.output).expect("one JSON document")
}

fn separation(found: &Value, truth: &str, rival: &str) -> f64 {
    let effects = found["effects"].as_array().expect("effects");
    let place = |id: &str| {
        effects
            .iter()
            .position(|e| e == id)
            .expect("a known effect")
    };
    let d = &found["separation"][place(truth)][place(rival)];
    d.as_f64().expect("a number")
}

/// In one direction at constant command Coulomb friction and a voltage drop are the same equation (`Kt/R (u - Vd - Kb
/// w) - Tf`), and one level does not separate supply sag from resistance.
#[test]
fn effects_equivalent_in_one_direction_are_not_separated() {
    let step = matrix("--profile step --ts 0.03 --duration 4");
    assert!(separation(&step, "voltage_drop", "coulomb_friction") < 3.0);
    assert!(separation(&step, "dead_zone", "none") < 1e-6);
    assert!(separation(&step, "coast_at_zero", "none") < 1e-6);
    let both = matrix("--profile reversing --ts 0.03 --duration 4");
    assert!(separation(&both, "coast_at_zero", "none") > 10.0);
    assert!(
        separation(&both, "voltage_drop", "coulomb_friction")
            > 2.0 * separation(&step, "voltage_drop", "coulomb_friction")
    );
}

/// Ten times as many samples of the same motion reduce the variance of quantization to a tenth.
#[test]
fn a_shorter_sample_time_separates_more() {
    let slow = matrix("--profile square --ts 0.03 --duration 3");
    let fast = matrix("--profile square --ts 0.003 --duration 3");
    let ratio = |truth| separation(&fast, truth, "none") / separation(&slow, truth, "none");
    assert!(ratio("compliance") > 1.5, "{}", ratio("compliance"));
}

#[test]
fn a_shaft_at_rest_shows_no_effect() {
    let rest = matrix("--profile rest --ts 0.03 --duration 2");
    let seen = rest["effects"].as_array().expect("effects").len() - 1;
    let unseen = rest["cannot_see"].as_array().expect("a list").len();
    // Only a hanging load turns a resting motor.
    assert!(unseen >= seen - 1, "{}", rest["cannot_see"]);
}

#[test]
fn bad_plans_and_diagnoses_are_errors_with_hints() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    fs::write(
        here.join("no.json"),
        "{\"shape\": \"motorlab-comparison/1\"}",
    )
    .expect("written");
    fs::write(here.join("torn.json"), "{\"shape\"").expect("written");
    for (arguments, says) in [
        (vec!["--duration", "1e7"], "samples"),
        (vec!["--profile", "stpe"], "did you mean 'step'?"),
        (vec!["--diagnosis", "no.json"], "its shape is"),
        (
            vec!["--diagnosis", "torn.json"],
            "motorlab diagnose RUN --json",
        ),
        (vec!["--diagnosis", "away.json"], "away.json"),
    ] {
        let done = run(here, &[&["design"], &arguments[..]].concat());
        assert_eq!(done.status, Some(2), "{arguments:?}");
        assert!(done.messages.contains(says), "{}", done.messages);
    }
}

#[test]
fn a_diagnosis_proposes_the_next_recording() {
    let keep = tempfile::tempdir().expect("a directory");
    let next = r#"{"shape": "motorlab-diagnosis/1", "next_experiment": {"profile": "crawl@0.2,8s",
        "sample_time_s": 0.003, "duration_s": 8.0, "command": "motorlab capture PORT --profile crawl@0.2,8s",
        "tells_apart": ["dead_zone", "stribeck"], "expected_separation": 12.5}}"#;
    fs::write(keep.path().join("d.json"), next).expect("written");
    let done = run(keep.path(), &["design", "--diagnosis", "d.json"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    for part in ["--profile crawl@0.2,8s", "dead_zone; stribeck", "12.5"] {
        assert!(done.output.contains(part), "{}", done.output);
    }
}
