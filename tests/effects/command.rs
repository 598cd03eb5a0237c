//! `motorlab effects` and `motorlab motor`: the catalogue for readers, and templates of motor files.

use std::fs;

use crate::support::command::{Finished, RunFile, run};
use motorlab::motor::catalogue::{Stage, catalogue};
use motorlab::motor::{Motor, Parameters, read_motor};
use serde_json::Value;

fn in_folder(arguments: &[&str]) -> Finished {
    run(tempfile::tempdir().expect("a folder").path(), arguments)
}

fn document(done: &Finished) -> Value {
    serde_json::from_str(&done.output).unwrap_or_else(|error| panic!("{error}: {done:?}"))
}

#[test]
fn every_effect_is_listed_by_stage_with_its_parameters_and_its_experiment() {
    let done = in_folder(&["effects"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let mut at = 0;
    for stage in Stage::ALL {
        let heading = format!("{stage}\n\n");
        at += done.output[at..].find(&heading).expect("the stage") + heading.len();
        for kind in catalogue().iter().filter(|kind| kind.stage == stage) {
            let title = format!("  {}: {}\n", kind.id, kind.summary);
            at += done.output[at..]
                .find(&title)
                .expect("in the chain's order");
            let block = done.output[at..].split("\n\n").next().expect("a block");
            assert!(
                block.contains(kind.equation) && block.contains(kind.excited_by),
                "{block}"
            );
            assert!(
                kind.parameters.iter().all(|p| block.contains(p.key)),
                "{block}"
            );
            assert!(
                kind.confounded_with.iter().all(|id| block.contains(id)),
                "{block}"
            );
            assert!(block.contains("--profile "), "{block}");
        }
    }
}

#[test]
fn the_list_can_be_limited_to_an_effect_or_stage_and_another_motor() {
    let all = document(&in_folder(&["effects", "--json"]));
    assert_eq!(all["shape"], "motorlab-effects/1");
    assert_eq!(
        all["effects"].as_array().expect("a list").len(),
        catalogue().len()
    );
    let sensor = document(&in_folder(&["effects", "sensor", "--json"]));
    let sensor = sensor["effects"].as_array().expect("a list");
    assert!(sensor.len() > 1 && sensor.iter().all(|effect| effect["stage"] == "sensor"));
    // A current limit is relative to the stall current: twice the resistance, half the range.
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(
        folder.path().join("motor.toml"),
        "resistance_ohm = 20\nsupply_v = 4.5",
    )
    .unwrap();
    let asked = [
        "effects",
        "current_limit",
        "--motor",
        "motor.toml",
        "--json",
    ];
    let found = document(&run(folder.path(), &asked));
    let hi = |document: &Value| {
        document["effects"][0]["parameters"][0]["hi"]
            .as_f64()
            .unwrap()
    };
    let usual = document(&in_folder(&["effects", "current_limit", "--json"]));
    assert!(
        (hi(&found) - 0.5 * hi(&usual)).abs() < 1e-12,
        "{found} {usual}"
    );
    let wrong = in_folder(&["effects", "backlas"]);
    assert_eq!(wrong.status, Some(2));
    assert!(
        wrong.messages.contains("did you mean 'backlash'?"),
        "{}",
        wrong.messages
    );
}

/// The printed command to try an effect runs, and its run differs from the nominal motor's.
#[test]
fn the_printed_command_line_records_the_effect() {
    let text = in_folder(&["effects", "dead_zone"]).output;
    let line = text
        .lines()
        .find_map(|line| line.split_once("motorlab "))
        .expect("a command");
    let words: Vec<&str> = line
        .1
        .split(' ')
        .map(|word| word.trim_matches('\''))
        .collect();
    let folder = tempfile::tempdir().expect("a folder");
    let done = run(folder.path(), &words);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let recorded = RunFile::read(&folder.path().join("dead_zone.csv"));
    assert!(recorded.complete());
    let done = run(folder.path(), &["compare", "dead_zone.csv", "--json"]);
    let gap = document(&done)["runs"][0]["position_rmse_counts"].as_f64();
    assert!(gap.is_some_and(|counts| counts > 3.0), "{gap:?}");
}

#[test]
fn every_command_reads_the_template_without_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let done = run(folder.path(), &["motor", "--template", "-o", "motor.toml"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let path = folder.path().join("motor.toml");
    assert_eq!(read_motor(&path).expect("a motor file"), Motor::default());
    let printed = in_folder(&["motor", "--template"]).output;
    assert!(
        fs::read_to_string(&path)
            .unwrap()
            .starts_with(printed.trim_end())
    );
    let simulate = [
        "simulate",
        "--motor",
        "motor.toml",
        "--duration",
        "0.1",
        "--json",
    ];
    let done = run(folder.path(), &simulate);
    assert_eq!((done.status, done.messages.as_str()), (Some(0), ""));
    assert_eq!(document(&done).get("handout_values"), None);
    // Its own file is replaced, another's is not.
    fs::write(folder.path().join("mine.toml"), "supply_v = 6\n").unwrap();
    let again = |name: &str| run(folder.path(), &["motor", "--template", "-o", name]).status;
    assert_eq!(
        (again("motor.toml"), again("mine.toml")),
        (Some(0), Some(2))
    );
}

#[test]
fn every_command_reports_missing_keys_of_a_motor_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = "resistance_ohm = 8\nback_emf_v_s_per_rad = 0.7\ntorque_constant_nm_per_a = 0.7\nviscous_friction_nm_s_per_rad = 0.01\ncoulomb_friction_nm = 0.02\ncounts_per_rev = 720\nsupply_v = 4.5\n";
    fs::write(folder.path().join("part.toml"), part).unwrap();
    let simulated = run(
        folder.path(),
        &["simulate", "--duration", "1", "-o", "run.csv"],
    );
    assert_eq!(simulated.status, Some(0), "{}", simulated.messages);
    let handout = Parameters::default();
    let with_motor: [&[&str]; 9] = [
        &["simulate", "--duration", "0.1", "--motor", "part.toml"],
        &["compare", "run.csv", "--motor", "part.toml"],
        &["check", "run.csv", "--motor", "part.toml"],
        &["diagnose", "run.csv", "--motor", "part.toml"],
        &[
            "design",
            "--duration",
            "0.5",
            "--ts",
            "0.03",
            "--motor",
            "part.toml",
        ],
        &["effects", "backlash", "--motor", "part.toml"],
        &["motor", "part.toml"],
        &["export", "json", "--motor", "part.toml"],
        &[
            "capture",
            "virtual:?speed=max&motor=part.toml",
            "--duration",
            "0.1",
        ],
    ];
    for arguments in with_motor {
        let done = run(folder.path(), &[arguments, &["--json"]].concat());
        assert_eq!(done.status, Some(0), "{arguments:?}: {}", done.messages);
        for said in [
            "part.toml",
            "inductance_h = 0.004",
            "inertia_kg_m2 = 0.002",
            "handout",
        ] {
            assert!(
                done.messages.contains(said),
                "{arguments:?}: {}",
                done.messages
            );
        }
        assert!(!done.messages.contains("resistance_ohm ="), "{arguments:?}");
        let filled = &document(&done)["handout_values"]["part.toml"];
        let expected = serde_json::json!({
            "inductance_h": handout.inductance_h,
            "inertia_kg_m2": handout.inertia_kg_m2,
        });
        assert_eq!(filled, &expected, "{arguments:?}");
    }
    let failed = run(
        folder.path(),
        &["compare", "none.csv", "--motor", "part.toml", "--json"],
    );
    let keys: Vec<String> = document(&failed)
        .as_object()
        .expect("an object")
        .keys()
        .cloned()
        .collect();
    assert_eq!(keys, ["error"]);
}
