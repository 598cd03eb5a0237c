//! Capture, diagnose, design, capture, diagnose: what one short step leaves open, the recording asked for settles.
//!
//! The virtual board plays each profile as `diagnose` names it, with the disc, load or supply that it asks for. Every case is one of
//! the catalogue's confounded pairs (`confounded_with`): the first diagnosis must leave the truth open, a recording be asked for that
//! tells the two apart, and the last diagnosis name the right one.
#![cfg(unix)]

use std::path::Path;

use crate::support::command;
use crate::support::command::run;
use serde_json::Value;

/// Most recordings that are asked for.
const ROUNDS: usize = 3;

/// One motor on the bench and the first, telling little, recording of it.
struct Case {
    truth: &'static str,
    rival: &'static str,
    numbers: &'static str,
    duration_s: &'static str,
}

fn json(done: &command::Finished) -> Value {
    assert_eq!(done.status, Some(0), "{}", done.messages);
    serde_json::from_str(&done.output).expect("one JSON document")
}

fn capture(here: &Path, case: &Case, change: &str, arguments: &[&str]) {
    let (truth, numbers) = (case.truth, case.numbers);
    let board = format!("virtual:?effect={truth}{numbers}{change}&speed=max");
    let done = run(here, &[&["capture", &board], arguments].concat());
    assert_eq!(done.status, Some(0), "{}", done.messages);
}

/// `known` has what is known to differ, as RUN:KEY=VALUE.
fn diagnosis(here: &Path, runs: &[String], known: &[String]) -> Value {
    let mut arguments = vec!["diagnose", "--json", "--motor", "nominal.toml"];
    arguments.extend(runs.iter().map(String::as_str));
    arguments.extend(known.iter().flat_map(|known| ["--with", known.as_str()]));
    json(&run(here, &arguments))
}

/// What a change that is asked for is on the virtual board: keys of its motor.
fn on_the_board(change: &Value) -> String {
    let value = change["value"].as_f64().expect("a figure");
    match change["key"].as_str().expect("a key") {
        "inertia_added_kg_m2" => {
            let own = motorlab::motor::Parameters::default().inertia_kg_m2;
            format!("&inertia_kg_m2={}", own + value)
        }
        "gravity_torque_nm" => format!("&effect=gravity_load&torque_nm={value}"),
        key => format!("&{key}={value}"),
    }
}

fn probability(diagnosis: &Value, effect: &str) -> f64 {
    let causes = diagnosis["causes"].as_array().expect("causes");
    let cause = causes.iter().find(|cause| cause["effect"] == effect);
    cause.map_or(0.0, |cause| cause["probability"].as_f64().unwrap_or(0.0))
}

fn settles(case: &Case) {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    std::fs::write(here.join("nominal.toml"), "").expect("written");
    let mut runs = vec!["run-0.csv".to_owned()];
    let first = [
        "--ts",
        "0.03",
        "--duration",
        case.duration_s,
        "-o",
        &runs[0],
    ];
    capture(here, case, "", &first);
    let mut known = Vec::new();
    let mut found = diagnosis(here, &runs, &known);
    let before = probability(&found, case.truth);
    assert_ne!(found["verdict"], "effect", "{} was never open", case.truth);
    for round in 1..=ROUNDS {
        let next = found["next_experiment"].clone();
        let word = |key: &str| next[key].as_str().expect("a word").to_owned();
        let (profile, file) = (word("profile"), format!("run-{round}.csv"));
        let sample_time_s = next["sample_time_s"].to_string();
        assert!(word("command").contains(&format!("--profile {profile} ")));
        let change = &next["change"];
        let board = if change.is_null() {
            String::new()
        } else {
            let key = change["key"].as_str().expect("a key");
            known.push(format!("{file}:{key}={}", change["value"]));
            on_the_board(change)
        };
        capture(
            here,
            case,
            &board,
            &["--profile", &profile, "--ts", &sample_time_s, "-o", &file],
        );
        runs.push(file);
        found = diagnosis(here, &runs, &known);
        if found["verdict"] == "effect" {
            break;
        }
    }
    let after = probability(&found, case.truth);
    eprintln!(
        "{} against {}: {before:.3} before, {after:.3} after {} further recordings",
        case.truth,
        case.rival,
        runs.len() - 1
    );
    assert_eq!(found["verdict"], "effect", "{}", found["sentence"]);
    let effects = found["effects"].as_array().expect("effects");
    assert!(effects.contains(&case.truth.into()), "{effects:?}");
}

macro_rules! cases {
    ($($name:ident: $truth:literal, $numbers:literal, $rival:literal, $duration_s:literal;)*) => {
        $(#[test]
        fn $name() {
            settles(&Case { truth: $truth, rival: $rival, numbers: $numbers, duration_s: $duration_s });
        })*
    };
}

cases! {
    a_voltage_drop_is_told_from_friction: "voltage_drop", "&drop_v=0.5", "coulomb_friction", "2";
    a_delay_is_told_from_inductance: "transport_delay", "&delay_s=0.012", "inductance", "0.8";
    inductance_is_told_from_a_delay: "inductance", "&inductance_h=0.1", "transport_delay", "0.6";
    a_gravity_load_is_told_from_an_eccentric_encoder: "gravity_load", "&torque_nm=0.01", "encoder_eccentricity", "1";
    quadratic_drag_is_told_from_viscous_friction: "quadratic_drag", "&coefficient_nm_s2_per_rad2=0.002", "viscous_friction", "2";
    a_wrong_supply_is_told_from_a_wrong_resolution: "supply_error", "&gain=0.8", "resolution_error", "3";
    stribeck_friction_is_told_from_a_dead_zone: "stribeck", "&extra_torque_nm=0.04", "dead_zone", "2";
    static_friction_is_told_from_stribeck_friction: "static_friction", "&torque_nm=0.05", "stribeck", "2";
    a_gain_by_direction_is_told_from_friction_by_direction: "asymmetric_gain", "&ratio=0.2", "asymmetric_friction", "2";
    backlash_is_told_from_compliance: "backlash", "", "compliance", "2";
    cogging_is_told_from_a_torque_ripple: "cogging", "", "torque_ripple", "2";
    a_sagging_supply_is_told_from_friction_of_the_load: "supply_sag", "", "load_friction", "2";
}
