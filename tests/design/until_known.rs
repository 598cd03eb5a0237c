//! `capture --until-known`: its recordings, its end, and its files.
#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::support::command::{Finished, RunFile, finish, run, start};
use serde_json::Value;

fn document(done: &Finished) -> Value {
    serde_json::from_str(&done.output).unwrap_or_else(|error| panic!("{error}: {}", done.messages))
}

fn until_known(here: &Path, port: &str, more: &[&str]) -> Finished {
    let arguments = ["capture", port, "--ts", "0.01", "--duration", "5", "--json"];
    run(here, &[&arguments, more].concat())
}

/// The virtual board's effect is named, every run is complete, and the printed `diagnose` command gives the same
/// result for the files.
fn settles(effect: &str) {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    let port = format!("virtual:?effect={effect}&speed=max&seed=3");
    let done = until_known(here, &port, &["--until-known", "15s", "-o", "run.csv"]);
    let found = document(&done);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert_eq!(found["ended"], "known", "{found:#}");
    let rounds = found["rounds"].as_array().expect("rounds");
    assert!((1..=3).contains(&rounds.len()));
    for (k, round) in rounds.iter().enumerate() {
        assert_eq!(round["path"], format!("run-{}.csv", k + 1));
        let file = RunFile::read(&here.join(format!("run-{}.csv", k + 1)));
        assert!(file.complete() && file.rows.len() == 500);
    }
    assert_eq!(found["verdict"], "effect");
    assert_eq!(
        found["effects"],
        serde_json::json!([effect.split('&').next()])
    );
    assert!(found["probability"].as_f64() >= Some(0.9));
    let command = found["diagnose"].as_str().expect("a command");
    let words: Vec<&str> = command.split(' ').skip(1).chain(["--json"]).collect();
    let again = document(&run(here, &words));
    assert_eq!(again["verdict"], "effect", "{command}");
    assert_eq!(again["probability"], found["probability"]);
}

#[test]
fn a_dead_zone_becomes_known() {
    settles("dead_zone");
}

#[test]
fn backlash_becomes_known() {
    settles("backlash");
}

#[test]
fn coasting_at_zero_becomes_known() {
    settles("coast_at_zero");
}

/// On a port as a board's: a pseudo-terminal that stays plugged in. Existing devices stay.
#[test]
fn a_port_is_recorded_from_again_and_no_file_is_overwritten() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    std::fs::write(here.join("run-2.csv"), "mine").expect("written");
    let mut board = start(here, &["virtual", "virtual:?effect=dead_zone&speed=max"]);
    let mut port = String::new();
    let output = board.stdout.take().expect("a pipe");
    BufReader::new(output).read_line(&mut port).expect("a line");
    let more = ["--profile", "step", "--until-known", "2", "-o", "run.csv"];
    let done = until_known(here, port.trim(), &more);
    board.kill().expect("it runs");
    finish(board);
    let found = document(&done);
    assert_eq!(found["rounds"][0]["profile"], "step");
    assert_eq!(found["rounds"][0]["path"], "run-3.csv", "{}", done.messages);
    assert!(done.messages.contains("run-2.csv exists and stays"));
    assert_eq!(
        std::fs::read_to_string(here.join("run-2.csv"))
            .ok()
            .as_deref(),
        Some("mine")
    );
    // A step of one voltage does not determine a dead zone: it is recorded once more, from the same board.
    assert_eq!(found["rounds"][1]["path"], "run-4.csv", "{found:#}");
}

#[test]
fn ctrl_c_keeps_what_was_recorded() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    let arguments = ["capture", "virtual:", "--until-known", "60s", "--json"];
    let child = start(here, &arguments);
    let begun = Instant::now();
    let rows =
        || std::fs::read_to_string(here.join("run-1.csv")).map_or(0, |text| text.lines().count());
    while rows() < 100 {
        assert!(
            begun.elapsed() < Duration::from_secs(30),
            "nothing is recorded"
        );
        std::thread::sleep(Duration::from_millis(50));
    }
    let asked = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(asked.is_ok_and(|status| status.success()));
    let done = finish(child);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let found = document(&done);
    assert_eq!(found["ended"], "stopped");
    assert_eq!(found["diagnose"], "motorlab diagnose run-1.csv");
    let file = RunFile::read(&here.join("run-1.csv"));
    assert_eq!(found["rounds"][0]["samples"], file.rows.len());
    assert!(file.rows.len() >= 50);
}

#[test]
fn a_bound_that_is_too_short_and_conflicting_options_are_refused() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    for (more, said) in [
        (
            vec!["--until-known", "10s"],
            "less than one recording of 15 s",
        ),
        (vec!["--until-known", "1m"], "seconds of recording in all"),
        (
            vec!["--until-known", "2", "--duration", "0"],
            "needs an end",
        ),
        (vec!["--until-known", "2", "--live"], "cannot be used with"),
        (
            vec!["--until-known", "2", "--columns", "t_us,counts,pwm"],
            "cannot be used with",
        ),
        (vec!["--motor", "m.toml"], "--until-known"),
    ] {
        let done = run(
            here,
            &[vec!["capture", "virtual:?speed=max"], more].concat(),
        );
        assert_eq!(done.status, Some(2), "{}", done.messages);
        assert!(done.messages.contains(said), "{}", done.messages);
    }
    assert_eq!(std::fs::read_dir(here).expect("a folder").count(), 0);
}
