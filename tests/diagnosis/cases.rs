//! The folders of `fixtures/cases/diagnosis`, each with the right answer of its README as far as `import` and `check`
//! give it. Output of boards (`us_named_ms`, `label_overrides_columns` and `dash_and_rpm_hint`):
//! tests/recorder/text_boards.rs.

use std::fs;
use std::path::Path;

use crate::support::command::{Finished, RunFile, run};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/cases/diagnosis");

/// Imports a case's log by its mapping, with these replacements in it, into `run.csv`.
fn import(directory: &Path, log: &str, map: &str, replace: &[(&str, &str)]) -> Finished {
    let mut text = fs::read_to_string(format!("{FOLDER}/{map}")).expect("a mapping");
    for (old, new) in replace {
        assert!(text.contains(old), "{text}");
        text = text.replace(old, new);
    }
    fs::write(directory.join("map.toml"), text).expect("written");
    let log = format!("{FOLDER}/{log}");
    run(
        directory,
        &[
            "import", &log, "--map", "map.toml", "-o", "run.csv", "--json",
        ],
    )
}

/// Findings of `check` for `run.csv`: id and severity.
fn found(directory: &Path) -> Vec<(String, String)> {
    let done = run(directory, &["check", "run.csv", "--json"]);
    let document: serde_json::Value = serde_json::from_str(&done.output).expect("JSON");
    let word =
        |finding: &serde_json::Value, key: &str| finding[key].as_str().expect("a word").to_owned();
    document["findings"]
        .as_array()
        .expect("findings")
        .iter()
        .map(|finding| (word(finding, "id"), word(finding, "severity")))
        .collect()
}

fn ids(found: &[(String, String)]) -> Vec<&str> {
    found.iter().map(|finding| finding.0.as_str()).collect()
}

#[test]
fn time_stamps_of_a_terminal_and_dates_are_times() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    // A log with three columns without names is not one with two.
    let done = import(
        path,
        "monitor_log_import/ard.txt",
        "monitor_log_import/ard.toml",
        &[],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&path.join("run.csv"));
    assert_eq!(file.column("t_s"), [0.0, 0.02, 0.04]);
    assert_eq!(file.column("counts"), [0.0, 12.0, 40.0]);
    assert_eq!(file.column("command_v"), [0.0, 9.0, 9.0]);
    fs::remove_file(path.join("run.csv")).expect("it is there");
    let done = import(
        path,
        "monitor_log_import/date.csv",
        "monitor_log_import/date.toml",
        &[],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&path.join("run.csv"));
    assert_eq!(file.column("t_s"), [0.0, 2.0]);
    assert_eq!(file.column("command_v"), [9.0, 9.0]);
}

#[test]
fn time_stamps_continue_over_midnight_and_keep_their_fractions() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    let log = "time;pwm;n\n[23:59:59.990] 255;1\n[23:59:59.995] 255;2\n[00:00:00.000] 0;4\n[00:00:00.005] 0;9\n";
    fs::write(path.join("log.txt"), log).expect("written");
    let map = "counts_per_rev = 720\nsupply_v = 9\n[time]\ncolumn = \"time\"\nunit = \"stamp\"\n\
        [command]\ncolumn = \"pwm\"\nunit = \"pwm\"\nfull = 255\n[position]\ncolumn = \"n\"\nunit = \"counts\"\n";
    fs::write(path.join("map.toml"), map).expect("written");
    let done = run(
        path,
        &["import", "log.txt", "--map", "map.toml", "-o", "run.csv"],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&path.join("run.csv"));
    assert_eq!(file.column("t_s"), [0.0, 0.005, 0.01, 0.015]);
    assert_eq!(file.column("counts"), [1.0, 2.0, 4.0, 9.0]);
}

#[test]
fn a_command_with_its_own_sample_rate_is_held_by_the_mapping() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    let (log, map) = ("multirate_csv/pj.csv", "multirate_csv/pj.toml");
    let done = import(path, log, map, &[]);
    assert_eq!(done.status, Some(2));
    let said = done.output + &done.messages;
    assert!(
        said.contains("is empty") && said.contains("[rows]"),
        "{said}"
    );
    let hold = ("[time]", "[rows]\nempty = \"hold\"\n[time]");
    let done = import(path, log, map, &[hold]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let document: serde_json::Value = serde_json::from_str(&done.output).expect("JSON");
    assert_eq!(
        (&document["rows"], &document["bad_rows"]),
        (&6.into(), &0.into())
    );
    assert_eq!(document["rows_without_position"], 2);
    let file = RunFile::read(&path.join("run.csv"));
    assert_eq!(file.column("seq"), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(file.column("command_v"), [0.0, 6.0, 6.0, 6.0]);
    let near = |found: Vec<f64>, wanted: [f64; 4]| {
        let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6;
        assert!(found.iter().zip(&wanted).all(is_near), "{found:?}");
    };
    near(file.column("t_s"), [0.0, 0.02, 0.04, 0.06]);
    // 0.1 rad are 65.19 counts of 4096.
    assert_eq!(file.column("counts"), [0.0, 65.0, 130.0, 196.0]);
}

#[test]
fn a_pause_in_which_the_angle_may_wrap_is_lost_samples_and_fatal() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    let done = import(path, "wrap_over_gap/gap.csv", "wrap_over_gap/gap.toml", &[]);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let found = found(path);
    assert!(
        found.contains(&("wrap_over_gap".into(), "fatal".into())),
        "{found:?}"
    );
    let file = RunFile::read(&path.join("run.csv"));
    let (seq, t_s) = (file.column("seq"), file.column("t_s"));
    let after = t_s
        .windows(2)
        .position(|pair| pair[1] - pair[0] > 0.5)
        .expect("a pause")
        + 1;
    // One second at 5 ms.
    assert_eq!(seq[after] - seq[after - 1], 200.0);
    assert_eq!(file.summary("lost_in_pauses"), 199);
    let (counts, speeds) = (file.column("counts"), file.column("velocity_rad_s"));
    let over_the_pause = (counts[after] - counts[after - 1]) / 3600.0 * std::f64::consts::TAU / 1.0;
    assert!(
        (speeds[after] - over_the_pause).abs() < 1e-6,
        "{}",
        speeds[after]
    );
    let diagnosed = run(path, &["diagnose", "run.csv", "--json"]);
    let document: serde_json::Value = serde_json::from_str(&diagnosed.output).expect("JSON");
    assert_eq!(document["verdict"], "bad_recording");
}

#[test]
fn milliseconds_declared_as_seconds_are_found_and_stop_a_diagnosis() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    for name in ["vr_ms", "vs_ms"] {
        let _ = fs::remove_file(path.join("run.csv"));
        let (log, map) = (
            format!("ms_as_s/{name}.csv"),
            format!("ms_as_s/{name}.toml"),
        );
        let done = import(path, &log, &map, &[]);
        assert_eq!(done.status, Some(1), "{name}: {}", done.messages);
        assert!(
            done.messages.contains("unit = \"ms\""),
            "{name}: {}",
            done.messages
        );
        let diagnosed = run(path, &["diagnose", "run.csv", "--json"]);
        let document: serde_json::Value = serde_json::from_str(&diagnosed.output).expect("JSON");
        assert_eq!(document["verdict"], "bad_recording", "{name}");
        assert_eq!(document["data"][0]["id"], "time_unit", "{name}");
    }
}

#[test]
fn negated_counts_are_named_and_right_ones_are_not() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    for name in ["vr_neg", "vs_neg"] {
        let (log, map) = (
            format!("sign_reversed/{name}.csv"),
            format!("sign_reversed/{name}.toml"),
        );
        let position = "[position]";
        for (scale, status) in [("-1", 0), ("1", 1)] {
            let _ = fs::remove_file(path.join("run.csv"));
            let turned = format!("{position}\nscale = {scale}");
            let done = import(path, &log, &map, &[(position, &turned)]);
            assert_eq!(
                done.status,
                Some(status),
                "{name} {scale}: {}",
                done.messages
            );
            let found = found(path);
            assert_eq!(
                ids(&found).contains(&"encoder_reversed"),
                status == 1,
                "{name}: {found:?}"
            );
        }
    }
}

#[test]
fn dither_at_rest_is_a_note_and_nothing_else_is() {
    let directory = tempfile::tempdir().expect("a directory");
    let done = import(
        directory.path(),
        "dither_at_rest/dith.csv",
        "dither_at_rest/vr_same.toml",
        &[],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let found = found(directory.path());
    assert_eq!(found, [("dither_at_rest".into(), "note".into())]);
}

#[test]
fn correct_steps_and_first_order_motors_have_no_finding_above_a_note() {
    for (log, map) in [
        ("clean_step_alarm/p8.csv", "clean_step_alarm/p8.toml"),
        ("fit_wrong_valley/p4.csv", "fit_wrong_valley/p4.toml"),
        ("fit_wrong_valley/syn_ok.csv", "fit_wrong_valley/syn.toml"),
    ] {
        let directory = tempfile::tempdir().expect("a directory");
        let done = import(directory.path(), log, map, &[]);
        assert_eq!(done.status, Some(0), "{log}: {}", done.messages);
        let found = found(directory.path());
        assert!(
            found.iter().all(|(_, severity)| severity == "note"),
            "{log}: {found:?}"
        );
    }
    let virtual_board = format!("{FOLDER}/clean_step_alarm/virtual_default.csv");
    let here = std::env::temp_dir();
    let done = run(&here, &["check", &virtual_board, "--json"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert!(!done.output.contains("warning"), "{}", done.output);
}

/// The logs of the cases without a mapping, with missing facts given by flags.
#[test]
fn the_logs_of_the_cases_are_read_without_a_mapping() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    let import = |log: &str, flags: &[&str], status: i32| {
        let _ = fs::remove_file(path.join("run.csv"));
        let log = format!("{FOLDER}/{log}");
        let done = run(path, &[&["import", &log, "-o", "run.csv"], flags].concat());
        assert_eq!(done.status, Some(status), "{log}: {}", done.messages);
        RunFile::read(&path.join("run.csv"))
    };
    let flags = [
        "--command",
        "2:pwm",
        "--position",
        "3:counts",
        "--supply",
        "9",
        "--counts-per-rev",
        "720",
    ];
    let file = import("monitor_log_import/ard.txt", &flags, 0);
    assert_eq!(file.column("t_s"), [0.0, 0.02, 0.04]);
    assert_eq!(file.column("counts"), [0.0, 12.0, 40.0]);
    assert_eq!(file.column("command_v"), [0.0, 9.0, 9.0]);
    let file = import(
        "monitor_log_import/date.csv",
        &["--command", "v:V", "--counts-per-rev", "720"],
        0,
    );
    assert_eq!(file.column("t_s"), [0.0, 2.0]);
    let flags = [
        "--command",
        "/cmd/data:share",
        "--position",
        "/joint_states/left_wheel_joint/position:rad",
        "--supply",
        "12",
        "--counts-per-rev",
        "4096",
    ];
    let file = import("multirate_csv/pj.csv", &flags, 0);
    assert_eq!(file.column("command_v"), [0.0, 6.0, 6.0, 6.0]);
    assert_eq!(file.column("counts"), [0.0, 65.0, 130.0, 196.0]);
    let file = import(
        "wrap_over_gap/gap.csv",
        &["--command", "u:V", "--counts-per-rev", "3600"],
        1,
    );
    assert_eq!(file.summary("lost_in_pauses"), 199);
    // A clock with steps of 3 counts ms: no further facts are needed, and there is no finding.
    let flags = [
        "--command",
        "u:V",
        "--position",
        "c:counts",
        "--counts-per-rev",
        "720",
    ];
    let file = import("ms_as_s/vs_ms.csv", &flags, 0);
    assert_eq!(file.header["sample_time_s"].as_float(), Some(0.003));
}
