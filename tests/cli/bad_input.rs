//! Invalid files and wrong use: error, place, remedy, and status 2.

use std::path::Path;

use crate::support::command::{Finished, run};

const HEADER: &str = "# format = \"motorlab-run/1\"\n# sample_time_s = 0.003\n# counts_per_rev = 720\n# supply_v = 4.5\n# complete = true\nt_s,command_v,counts\n";

fn with_file(name: &str, text: &str, arguments: &[&str]) -> Finished {
    let directory = tempfile::tempdir().expect("a directory");
    write(directory.path(), name, text);
    run(directory.path(), arguments)
}

fn write(directory: &Path, name: &str, text: &str) {
    std::fs::write(directory.join(name), text).expect("a file");
}

#[test]
fn a_bad_run_file_is_named_with_row_and_column() {
    let text = format!("{HEADER}0,0,0\n0.003,4.5,twelve\n0.006,4.5,24\n");
    for arguments in [
        &["compare", "run.csv"][..],
        &["compare", "run.csv", "--json"],
    ] {
        let done = with_file("run.csv", &text, arguments);
        assert_eq!(done.status, Some(2));
        assert!(
            done.messages
                .contains("error: run.csv: row 8, column `counts`: `twelve`"),
            "{}",
            done.messages
        );
        if arguments.contains(&"--json") {
            let document: serde_json::Value =
                serde_json::from_str(&done.output).expect("one document");
            assert_eq!(document["error"]["row"], 8);
        } else {
            assert_eq!(done.output, "");
        }
    }
}

#[test]
fn a_missing_or_newer_run_file_is_reported() {
    let done = with_file("other.csv", "", &["compare", "run.csv"]);
    assert_eq!(done.status, Some(2));
    assert!(done.messages.contains("run.csv: cannot be read"));
    let newer = HEADER.replace("run/1", "run/2");
    let done = with_file("run.csv", &newer, &["compare", "run.csv"]);
    assert_eq!(done.status, Some(2));
    assert!(
        done.messages.contains("motorlab-run/2"),
        "{}",
        done.messages
    );
}

#[test]
fn an_unknown_motor_key_gets_the_nearest_known_one() {
    for (text, line, wrong, nearest) in [
        (
            "resistance_ohm = 10.0\ninertia_kgm2 = 0.002\n",
            "line 2",
            "inertia_kgm2",
            "'inertia_kg_m2'",
        ),
        (
            "[tolerance]\nresistence_ohm = 0.05\n",
            "line 2",
            "resistence_ohm",
            "'resistance_ohm'",
        ),
        (
            "[effects.backlsh]\ngap_rad = 0.02\n",
            "backlsh",
            "backlsh",
            "'backlash'",
        ),
        (
            "[effects.backlash]\ngap_rd = 0.02\n",
            "line 2",
            "gap_rd",
            "'gap_rad'",
        ),
    ] {
        let arguments = ["simulate", "--motor", "motor.toml", "--duration", "0.1"];
        let done = with_file("motor.toml", text, &arguments);
        assert_eq!(done.status, Some(2), "{text}");
        for part in ["motor.toml", line, wrong, nearest] {
            assert!(done.messages.contains(part), "{part}: {}", done.messages);
        }
    }
}

#[test]
fn a_gap_above_the_limit_exits_with_status_1() {
    let directory = tempfile::tempdir().expect("a directory");
    let simulated = ["simulate", "--duration", "0.6", "-o", "run.csv"];
    assert_eq!(run(directory.path(), &simulated).status, Some(0));
    write(directory.path(), "heavy.toml", "inertia_kg_m2 = 0.01\n");
    let compare = |motor: &[&str]| {
        let mut arguments = vec!["compare", "run.csv", "--fail-above", "1.0", "--json"];
        arguments.extend(motor);
        run(directory.path(), &arguments)
    };
    let good = compare(&[]);
    assert_eq!(good.status, Some(0), "{}", good.messages);
    let bad = compare(&["--motor", "heavy.toml"]);
    assert_eq!(bad.status, Some(1));
    assert!(bad.messages.contains("above --fail-above 1"));
    // The document is complete in both cases.
    let document: serde_json::Value = serde_json::from_str(&bad.output).expect("one document");
    assert_eq!(document["shape"], "motorlab-comparison/1");
    let figures = document["runs"][0].as_object().expect("an object");
    for key in [
        "path",
        "sample_time_s",
        "samples",
        "lost",
        "position_rmse_counts",
        "velocity_rmse_rpm",
        "velocity_nrmse",
        "floor_counts",
    ] {
        assert!(figures.contains_key(key), "{key}");
    }
    let floor = document["runs"][0]["floor_counts"].as_f64();
    assert!(floor.is_some_and(|floor| (floor - 1.0 / 12f64.sqrt()).abs() < 1e-12));
}

#[test]
fn wrong_use_exits_with_status_2_and_a_hint() {
    let directory = tempfile::tempdir().expect("a directory");
    for (arguments, hint) in [
        (&["captur", "virtual:"][..], "capture"),
        (&["capture"], "PORT"),
        (&["capture", "virtual:", "--ts", "0"], "sample time"),
        (
            &["capture", "virtual:", "--profile", "stp"],
            "did you mean 'step'",
        ),
        (&["compare"], "RUN"),
        (
            &["replay", "x.log", "--speed", "fast"],
            "a speed is a factor above 0, or max",
        ),
        (
            &["simulate", "--ts", "1e-6", "--duration", "1e6"],
            "lower --duration or raise --ts",
        ),
    ] {
        let done = run(directory.path(), arguments);
        assert_eq!(done.status, Some(2), "{arguments:?}");
        assert!(
            done.messages.contains(hint),
            "{arguments:?}: {}",
            done.messages
        );
    }
    let files = std::fs::read_dir(directory.path()).expect("a directory");
    assert_eq!(files.count(), 0, "nothing is left behind");
}

#[test]
fn numbers_that_no_motor_has_are_refused_with_their_range() {
    let profile = ("profile.csv", "0,1\n1,4e7\n");
    let late = ("profile.csv", "0,1\n1e9,2\n");
    let none = ("note.txt", "");
    for ((name, text), arguments, wanted) in [
        (none, &["simulate", "--ts", "0"][..], "1e-6 .. 60 s"),
        (
            none,
            &["simulate", "--duration", "1e99"],
            "1e-6 .. 10000000 s",
        ),
        (
            none,
            &[
                "simulate",
                "--ts",
                "1e-6",
                "--duration",
                "100",
                "-o",
                "x.csv",
            ],
            "too many",
        ),
        (
            none,
            &["capture", "virtual:", "--supply", "1e300"],
            "0.001 .. 100000 V",
        ),
        (
            none,
            &["capture", "virtual:", "--counts-per-rev=-720"],
            "0.01 .. 1e12",
        ),
        (
            none,
            &["capture", "virtual:", "--ts", "0.001", "--duration", "9999"],
            "5000000 rows",
        ),
        (none, &["design", "--ts", "100"], "1e-6 .. 60 s"),
        (
            profile,
            &["simulate", "--profile", "profile.csv"],
            "'4e7' lies outside",
        ),
        (
            late,
            &["simulate", "--profile", "profile.csv"],
            "'1e9' lies outside",
        ),
    ] {
        let done = with_file(name, text, arguments);
        assert_eq!(done.status, Some(2), "{arguments:?}: {}", done.messages);
        assert!(
            done.messages.contains(wanted),
            "{arguments:?}: {}",
            done.messages
        );
    }
    let header = "# counts_per_rev = 720\nt_s,command_v,counts\n";
    for (rows, wanted) in [
        (
            "0,0,1\n0.1,2e6,1\n",
            "row 4, column `command_v`: 2000000 lies outside",
        ),
        (
            "0,0,1\n1e11,0,1\n",
            "row 4, column `t_s`: 1e11 lies outside",
        ),
        (
            "0,0,9000000000000000000\n",
            "row 3, column `counts`: 9e18 lies outside",
        ),
    ] {
        let done = with_file("run.csv", &format!("{header}{rows}"), &["check", "run.csv"]);
        assert_eq!(done.status, Some(2), "{}", done.messages);
        assert!(done.messages.contains(wanted), "{}", done.messages);
    }
    let log = "# format = \"motorlab-rawlog/1\"\n# columns = \"counts\"\n# supply_v = 1e9\n";
    let done = with_file("x.log", log, &["replay", "x.log"]);
    assert_eq!(done.status, Some(2), "{}", done.messages);
    assert!(
        done.messages.contains("`supply_v` is 1e9"),
        "{}",
        done.messages
    );
}
