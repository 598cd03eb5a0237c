//! A proposed known change on the bench is printed with its instructions and with the flag for `diagnose`.

use std::fs;

use crate::support::command::run;

#[test]
fn a_proposed_known_load_has_its_flag() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    let why = r#"{"shape": "motorlab-diagnosis/3", "next_experiment": {"profile": "reversing,15s", "sample_time_s": 0.003,
        "duration_s": 15.0, "command": "motorlab capture PORT --profile reversing,15s",
        "change": {"key": "gravity_torque_nm", "value": 0.09},
        "tells_apart": ["supply_error", "resolution_error"], "expected_separation": 21.0}}"#;
    fs::write(here.join("why.json"), why).expect("written");
    let said = run(here, &["design", "--diagnosis", "why.json"]).output;
    let flag = "--with next.csv:gravity_torque_nm=0.09";
    assert!(
        said.contains("a load on an arm") && said.contains(flag),
        "{said}"
    );
}

/// With the flag the load is part of the model, without it there is a gap.
#[test]
fn a_known_load_is_no_gap() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    let loaded = "[effects.gravity_load]\ntorque_nm = 0.02\nphase_rad = 0\n";
    fs::write(here.join("truth.toml"), loaded).expect("written");
    fs::write(here.join("nominal.toml"), "").expect("written");
    let asked = [
        "simulate",
        "--motor",
        "truth.toml",
        "--duration",
        "15",
        "--profile",
        "reversing",
        "--ts",
        "0.01",
        "-o",
        "next.csv",
    ];
    let done = run(here, &asked);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let asked = ["diagnose", "next.csv", "--json", "--motor", "nominal.toml"];
    let verdict = |more: &[&str]| {
        let done = run(here, &[&asked[..], more].concat());
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let document: serde_json::Value = serde_json::from_str(&done.output).expect("JSON");
        (document["verdict"].clone(), document["effects"].clone())
    };
    let (told, _) = verdict(&["--with", "next.csv:gravity_torque_nm=0.02"]);
    assert!(told == "no_gap" || told == "parameters", "{told}");
    let (untold, effects) = verdict(&[]);
    assert_eq!(untold, "effect");
    assert_eq!(effects, serde_json::json!(["gravity_load"]));
}
