//! `motorlab.toml` beside the runs: its flags are used and reported, explicit ones take precedence, and errors in it
//! are reported.

use std::fs;
use std::path::Path;

use crate::support::command::{Finished, RunFile, run};

/// A log that needs a supply.
const LOG: &str = include_str!("../../docs/tutorial/log.csv");
/// A motor that no other file has.
const MOTOR: &str = "resistance_ohm = 9.0\n";

/// A folder `runs` with a log, a run of it and this configuration file.
fn folder(config: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let runs = folder.path().join("runs");
    fs::create_dir(&runs).expect("a folder");
    fs::write(runs.join("log.csv"), LOG).expect("a file");
    fs::write(runs.join("m.toml"), MOTOR).expect("a file");
    let made = [
        "import",
        "runs/log.csv",
        "--supply",
        "12",
        "-o",
        "runs/run.csv",
    ];
    done(run(folder.path(), &made));
    fs::write(runs.join("motorlab.toml"), config).expect("a file");
    folder
}

fn done(finished: Finished) -> Finished {
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    finished
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let finished = run(folder, arguments);
    assert_eq!(
        finished.status,
        Some(2),
        "{arguments:?}: {}",
        finished.messages
    );
    finished.messages
}

#[test]
fn every_command_with_a_key_applies_and_reports_it() {
    let folder = folder("motor = \"m.toml\"\nsupply = 12\ncounts = 720\n");
    let all = "using runs/motorlab.toml: motor = \"m.toml\", supply = 12 V, counts = 720\n";
    for command in ["check", "compare"] {
        let said = done(run(folder.path(), &[command, "runs/log.csv"])).messages;
        assert!(said.starts_with(all), "{said}");
    }
    let import = ["import", "runs/log.csv", "-o", "again.csv"];
    let said = done(run(folder.path(), &import)).messages;
    assert!(
        said.starts_with("using runs/motorlab.toml: supply = 12 V, counts = 720\n"),
        "{said}"
    );
    let header = RunFile::read(&folder.path().join("again.csv")).header;
    assert_eq!(header["supply_v"].as_float(), Some(12.0));
    // In the folder itself, for commands that take no run.
    let runs = folder.path().join("runs");
    for (arguments, taken) in [
        (
            &["simulate", "--duration", "0.1"][..],
            "motor = \"m.toml\"\n",
        ),
        (&["export", "json"], "motor = \"m.toml\"\n"),
        (
            &["capture", "virtual:", "--duration", "0.1"],
            "supply = 12 V, counts = 720\n",
        ),
        (
            &["design", "--duration", "1"],
            "motor = \"m.toml\", supply = 12 V\n",
        ),
        (&["effects", "backlash"], "motor = \"m.toml\"\n"),
    ] {
        let said = done(run(&runs, arguments)).messages;
        assert!(
            said.starts_with(&format!("using motorlab.toml: {taken}")),
            "{arguments:?}: {said}"
        );
    }
    let said = done(run(&runs, &["names", "profiles"])).messages;
    assert_eq!(said, "", "no key is taken");
}

#[test]
fn the_motor_path_is_relative_to_the_file_and_is_used_by_compare() {
    let folder = folder("motor = \"m.toml\"\n");
    let figures = |arguments: &[&str]| done(run(folder.path(), arguments)).output;
    let configured = figures(&["compare", "runs/run.csv", "--json"]);
    let named = [
        "compare",
        "runs/run.csv",
        "--json",
        "--no-config",
        "--motor",
        "runs/m.toml",
    ];
    assert_eq!(configured, figures(&named));
    assert_ne!(
        configured,
        figures(&["compare", "runs/run.csv", "--json", "--no-config"])
    );
}

#[test]
fn explicit_flags_take_precedence_and_no_config_ignores_the_file() {
    let folder = folder("supply = 12\npwm_full = 255\n");
    let explicit = ["import", "runs/log.csv", "--supply", "9", "-o", "nine.csv"];
    let said = done(run(folder.path(), &explicit)).messages;
    assert!(
        said.starts_with("using runs/motorlab.toml: pwm_full = 255\n"),
        "{said}"
    );
    let header = RunFile::read(&folder.path().join("nine.csv")).header;
    assert_eq!(header["supply_v"].as_float(), Some(9.0));
    let said = refused(folder.path(), &["check", "runs/log.csv", "--no-config"]);
    assert!(
        !said.contains("motorlab.toml") && said.contains("--supply"),
        "{said}"
    );
    // A mapping file describes its log completely.
    let save = [
        "import",
        "runs/log.csv",
        "--supply",
        "9",
        "--save-map",
        "map.toml",
        "-o",
        "a.csv",
    ];
    done(run(folder.path(), &save));
    let mapped = ["import", "runs/log.csv", "--map", "map.toml", "-o", "b.csv"];
    let said = done(run(folder.path(), &mapped)).messages;
    assert!(!said.contains("using"), "{said}");
}

#[test]
fn only_the_folder_of_the_log_is_searched() {
    let folder = folder("supply = 12\n");
    let inner = folder.path().join("runs/inner");
    fs::create_dir(&inner).expect("a folder");
    fs::write(inner.join("log.csv"), LOG).expect("a file");
    let runs = folder.path().join("runs");
    // Neither from the parent of the log's folder, nor from the working folder if a log is named.
    for place in [folder.path(), runs.as_path(), inner.as_path()] {
        let said = refused(
            place,
            &["check", inner.join("log.csv").to_str().expect("a path")],
        );
        assert!(!said.contains("using"), "{said}");
    }
    fs::write(inner.join("motorlab.toml"), "supply = 9\n").expect("a file");
    let both = ["check", "runs/log.csv", "runs/inner/log.csv"];
    let said = refused(folder.path(), &both);
    assert!(
        said.contains("differ") && said.contains("--no-config"),
        "{said}"
    );
    fs::write(inner.join("motorlab.toml"), "supply = 12 # the same\n").expect("a file");
    done(run(folder.path(), &both));
}

#[test]
fn flags_of_logs_do_not_refuse_run_files() {
    let folder = folder("supply = 12\ntime = \"time_ms:ms\"\nreverse = false\n");
    let own = ["simulate", "--duration", "1", "-o", "runs/own.csv"];
    done(run(folder.path(), &own));
    done(run(folder.path(), &["check", "runs/own.csv"]));
    let said = refused(folder.path(), &["check", "runs/own.csv", "--supply", "12"]);
    assert!(said.contains("--supply"), "{said}");
}

#[test]
fn every_error_of_the_file_is_one_message() {
    for (config, said) in [
        (
            "suply = 12\n",
            "unknown key 'suply'\nhint: did you mean 'supply'?",
        ),
        ("counts_per_rev = 720\n", "hint: did you mean 'counts'?"),
        ("pwm-full = 255\n", "hint: did you mean 'pwm_full'?"),
        ("colour = 1\n", "its keys are motor, supply, counts, time"),
        (
            "pwm_full = -3\n",
            "pwm_full = -3: expected a number above 0",
        ),
        ("counts = \"many\"\n", "counts = \"many\": no number"),
        ("reverse = 1\n", "reverse = 1\nhint: it is true or false"),
        (
            "supply = [12]\n",
            "supply = [12]\nhint: it is a number or a text",
        ),
        ("supply 12\n", "line 1: "),
        ("motor = \"absent.toml\"\n", "absent.toml"),
    ] {
        let folder = folder(config);
        let messages = refused(folder.path(), &["compare", "runs/run.csv"]);
        assert!(messages.contains(said), "{config}: {messages}");
        assert!(messages.contains("runs/"), "{config}: {messages}");
        assert_eq!(
            messages.matches("error: ").count(),
            1,
            "{config}: {messages}"
        );
        let document = run(folder.path(), &["compare", "runs/run.csv", "--json"]).output;
        let document: serde_json::Value = serde_json::from_str(&document).expect("a document");
        assert!(
            document["error"]["file"].is_string(),
            "{config}: {document}"
        );
        done(run(
            folder.path(),
            &["compare", "runs/run.csv", "--no-config"],
        ));
    }
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("motorlab.toml")).expect("a folder");
    let said = refused(folder.path(), &["simulate"]);
    assert!(said.contains("motorlab.toml: it is no file"), "{said}");
}

#[test]
fn no_output_overwrites_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    for force in [&[][..], &["--force"]] {
        let write = ["motor", "--template", "-o", "motorlab.toml"];
        let said = refused(folder.path(), &[&write[..], force].concat());
        assert!(said.contains("configuration file"), "{said}");
    }
}
