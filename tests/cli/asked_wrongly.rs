//! Wrong use that is refused: exit status, and remedy.

use std::path::Path;

use crate::support::command::{RunFile, finish, run, start};

fn written(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("a file");
}

#[test]
fn without_arguments_the_program_prints_a_short_summary() {
    let folder = tempfile::tempdir().expect("a folder");
    let done = run(folder.path(), &[]);
    assert_eq!((done.status, done.messages.as_str()), (Some(0), ""));
    assert!(done.output.len() < 900, "{}", done.output);
    assert!(done.output.contains("motorlab --help"), "{}", done.output);
}

#[test]
fn a_virtual_clock_has_a_range() {
    let folder = tempfile::tempdir().expect("a folder");
    for ppm in ["-2000000", "1e9", "-1000000", "nan"] {
        let board = format!("virtual:?clock_ppm={ppm}");
        let done = run(folder.path(), &["capture", &board, "--duration", "0.3"]);
        assert_eq!(done.status, Some(2), "{}", done.messages);
        assert!(done.messages.contains("clock_ppm"), "{}", done.messages);
        assert!(!done.messages.contains("panicked"), "{}", done.messages);
    }
}

#[test]
fn a_simulation_that_does_not_fit_the_memory_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for arguments in [
        &["simulate", "--ts", "0.003", "--duration", "1e5"][..],
        &["simulate", "--ts", "0.001", "--duration", "2000", "--json"][..],
    ] {
        let done = run(folder.path(), arguments);
        assert_eq!(done.status, Some(2), "{}", done.messages);
        assert!(done.messages.contains("500 MB"), "{}", done.messages);
    }
}

#[test]
fn a_profile_is_read_by_the_names_of_its_columns() {
    let folder = tempfile::tempdir().expect("a folder");
    let step = [
        "simulate",
        "--ts",
        "0.03",
        "--duration",
        "3",
        "-o",
        "first.csv",
    ];
    assert_eq!(run(folder.path(), &step).status, Some(0));
    let again = [
        "simulate",
        "--ts",
        "0.03",
        "--duration",
        "3",
        "--profile",
        "first.csv",
        "-o",
        "again.csv",
    ];
    let done = run(folder.path(), &again);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let commands = |name: &str| RunFile::read(&folder.path().join(name)).column("command_v");
    assert_eq!(commands("again.csv"), commands("first.csv"));
    written(
        folder.path(),
        "counts.csv",
        "seq,t_s,counts\n0,0,0\n1,0.03,7\n",
    );
    let done = run(folder.path(), &["simulate", "--profile", "counts.csv"]);
    assert_eq!(done.status, Some(2));
    assert!(done.messages.contains("command_v"), "{}", done.messages);
}

#[test]
fn a_run_that_is_diagnosed_is_not_held_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let simulated = ["simulate", "--duration", "0.6", "-o", "run.csv"];
    assert_eq!(run(folder.path(), &simulated).status, Some(0));
    let done = run(
        folder.path(),
        &["diagnose", "run.csv", "--hold-out", "./run.csv"],
    );
    assert_eq!(done.status, Some(2), "{}", done.messages);
    assert!(
        done.messages.contains("hold out another run"),
        "{}",
        done.messages
    );
    // Nor is a copy of it, nor the beginning of a copy; another run is.
    let whole = std::fs::read_to_string(folder.path().join("run.csv")).expect("a run");
    let lines: Vec<&str> = whole.lines().collect();
    written(folder.path(), "copy.csv", &whole);
    written(
        folder.path(),
        "head.csv",
        &(lines[..lines.len() - 40].join("\n") + "\n"),
    );
    for copy in ["copy.csv", "head.csv"] {
        let done = run(folder.path(), &["diagnose", "run.csv", "--hold-out", copy]);
        assert_eq!(done.status, Some(2), "{}", done.messages);
        assert!(
            done.messages
                .contains("it has the counts and commands of run.csv"),
            "{}",
            done.messages
        );
    }
    let other = [
        "simulate",
        "--duration",
        "0.6",
        "--profile",
        "reversing",
        "-o",
        "other.csv",
    ];
    assert_eq!(run(folder.path(), &other).status, Some(0));
    let done = run(
        folder.path(),
        &["diagnose", "run.csv", "--hold-out", "other.csv"],
    );
    assert!(
        !done.messages.contains("counts and commands of"),
        "{}",
        done.messages
    );
}

#[test]
fn a_second_blind_run_on_the_same_set_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let make = ["blind", "make", "--cases", "2", "--kind", "none", "set"];
    let made = run(folder.path(), &make);
    assert_eq!(made.status, Some(0), "{}", made.messages);
    let runs = [(); 2].map(|()| start(folder.path(), &["blind", "run", "set"]));
    let ended = runs.map(finish);
    let refused = |done: &crate::support::command::Finished| {
        done.status == Some(2) && done.messages.contains("another `blind run` is running")
    };
    // One may be finished before the other begins; then that has nothing left to do.
    assert!(
        ended
            .iter()
            .all(|done| done.status == Some(0) || refused(done)),
        "{ended:?}"
    );
    let lines = std::fs::read_to_string(folder.path().join("set/verdicts.log")).expect("a log");
    assert_eq!(lines.lines().count(), 2);
    let score = ["blind", "score", "set", "--labels", "set.labels.json"];
    let scored = run(folder.path(), &score);
    assert!(!scored.messages.contains("breaks"), "{}", scored.messages);
}

#[cfg(unix)]
#[test]
fn a_capture_that_is_stopped_before_the_board_speaks_prints_a_document() {
    let pty = motorlab::board::pty::Pty::open().expect("a pseudo-terminal");
    let port = pty.path().display().to_string();
    let folder = tempfile::tempdir().expect("a folder");
    let child = start(folder.path(), &["capture", &port, "--json", "-o", "x.csv"]);
    std::thread::sleep(std::time::Duration::from_millis(800));
    let told = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(told.expect("kill").success());
    let done = finish(child);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let document: serde_json::Value = serde_json::from_str(&done.output).expect("a document");
    assert_eq!(document["error"]["kind"], "stopped");
}

/// Every command with a missing file names similar files.
#[test]
fn a_missing_file_is_reported_with_similar_names() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in [
        "step30.csv",
        "ramp.csv",
        "nice.motor.toml",
        "session.log",
        "verdict.json",
    ] {
        written(folder.path(), name, "");
    }
    for (arguments, hint) in [
        (&["diagnose", "step3.csv"][..], "this folder has step30.csv"),
        (&["check", "step3.csv"][..], "this folder has step30.csv"),
        (&["compare", "step3.csv"][..], "this folder has step30.csv"),
        (
            &["import", "x.csv"][..],
            "this folder has ramp.csv, step30.csv",
        ),
        (
            &["import", "x.csv", "--map", "m.map"][..],
            "this folder has",
        ),
        (
            &["replay", "sesion.log", "-o", "new.csv"][..],
            "this folder has session.log",
        ),
        (
            &["simulate", "--motor", "nic.motor.toml"][..],
            "this folder has nice.motor.toml",
        ),
        (
            &["simulate", "--profile", "ramp2.csv"][..],
            "this folder has ramp.csv",
        ),
        (
            &["motor", "nic.motor.toml"][..],
            "this folder has nice.motor.toml",
        ),
        (
            &["export", "parquet", "step3.csv"][..],
            "this folder has step30.csv",
        ),
        (&["blind", "run", "set"][..], "there is no folder set"),
        (
            &["tabulate", "verdic.json", "-o", "new.csv"][..],
            "this folder has verdict.json",
        ),
        (&["check", "runs/step30.csv"][..], "there is no folder runs"),
        (
            &["simulate", "-o", "runs/new.csv"][..],
            "there is no folder runs",
        ),
    ] {
        let done = run(folder.path(), arguments);
        assert!(
            done.status.is_some_and(|status| status > 0),
            "{arguments:?}"
        );
        let said = done.messages;
        assert!(
            said.contains(&format!("hint: {hint}")),
            "{arguments:?}: {said}"
        );
        assert!(!said.contains("panicked"), "{said}");
    }
}
