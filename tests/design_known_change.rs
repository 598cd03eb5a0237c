//! Where no profile tells apart what is in play, a known change on the bench is proposed; made, it tells.

#[path = "support/command.rs"]
mod command;

use std::fs;
use std::path::Path;

use command::run;
use serde_json::Value;

/// Resistance and torque constant are known well, what else bends a gain badly.
const NOMINAL: &str = "[tolerance]\nresistance_ohm = 0.01\ntorque_constant_nm_per_a = 0.01\nback_emf_v_s_per_rad = 0.2\n\
    inertia_kg_m2 = 0.2\nviscous_friction_nm_s_per_rad = 0.2\ncoulomb_friction_nm = 0.2\n";
/// The driver gives 15 % more volts than it is asked for: motor constants, inertia and friction can say the same.
const TRUTH: &str = "[effects.supply_error]\ngain = 1.15\n";

fn simulated(here: &Path, motor: &str, profile: &str, name: &str) {
    fs::write(here.join("truth.toml"), motor).expect("written");
    let asked = [
        "simulate",
        "--motor",
        "truth.toml",
        "--duration",
        "15",
        "--profile",
        profile,
        "-o",
        name,
    ];
    let done = run(here, &asked);
    assert_eq!(done.status, Some(0), "{}", done.messages);
}

fn diagnosis(here: &Path, arguments: &[&str]) -> Value {
    let asked = [
        &["diagnose", "--json", "--motor", "nominal.toml"],
        arguments,
    ]
    .concat();
    let done = run(here, &asked);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    fs::write(here.join("why.json"), &done.output).expect("written");
    serde_json::from_str(&done.output).expect("one document")
}

#[test]
fn a_known_load_settles_what_no_profile_does() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    fs::write(here.join("nominal.toml"), NOMINAL).expect("written");
    simulated(here, TRUTH, "reversing", "run.csv");
    let open = diagnosis(here, &["run.csv"]);
    assert_ne!(open["effects"], serde_json::json!(["supply_error"]));
    let next = &open["next_experiment"];
    let change = &next["change"];
    assert_eq!(change["key"], "gravity_torque_nm", "{next}");
    let torque_nm = change["value"].as_f64().expect("a torque");
    let profile = next["profile"].as_str().expect("a profile");
    let said = run(here, &["design", "--diagnosis", "why.json"]).output;
    let flag = format!("next.csv:gravity_torque_nm={torque_nm}");
    assert!(
        said.contains("a load on an arm") && said.contains(&flag),
        "{said}"
    );
    // The same profile without the load leaves it open.
    simulated(here, TRUTH, profile, "plain.csv");
    let plain = diagnosis(here, &["run.csv", "plain.csv"]);
    assert_ne!(plain["effects"], serde_json::json!(["supply_error"]));
    let loaded =
        format!("{TRUTH}[effects.gravity_load]\ntorque_nm = {torque_nm:?}\nphase_rad = 0\n");
    simulated(here, &loaded, profile, "next.csv");
    let settled = diagnosis(here, &["run.csv", "next.csv", "--with", &flag]);
    assert_eq!(
        settled["effects"],
        serde_json::json!(["supply_error"]),
        "{settled}"
    );
}
