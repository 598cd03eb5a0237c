//! A recording and a simulation are as long as the profile, unless the call states a duration.

use std::fs;
use std::path::Path;

use motorlab::board::BUILT_IN;

use crate::support::command::{RunFile, run};

/// Sample time in s, as an argument.
const TS: &str = "0.003";

/// Duration in s of a written run: its samples times the sample time. A simulation has a sample at both ends.
fn length_s(here: &Path, words: &[&str]) -> f64 {
    let file = here.join("run.csv");
    let _ = fs::remove_file(&file);
    let done = run(here, &[words, &["--ts", TS, "-o", "run.csv"]].concat());
    assert_eq!(done.status, Some(0), "{words:?}: {}", done.messages);
    let run = RunFile::read(&file);
    let samples = run.rows.len() - usize::from(words[0] == "simulate");
    samples as f64 * 0.003
}

#[test]
fn every_profile_is_played_for_the_time_in_its_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    for (name, _) in BUILT_IN {
        let profile = format!("{name},1.2s");
        for command in [
            &["simulate"][..],
            &["capture", "virtual:?speed=max", "--counts-per-rev", "720"],
        ] {
            let found_s = length_s(here, &[command, &["--profile", &profile]].concat());
            assert!(
                (found_s - 1.2).abs() < 1e-9,
                "{command:?} {name}: {found_s} s"
            );
        }
    }
}

#[test]
fn a_file_is_played_to_its_last_row_unless_the_call_has_a_duration() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    fs::write(
        here.join("mine.csv"),
        "t_s,command_v\n0,0\n0.3,4.5\n0.9,0\n",
    )
    .expect("a file");
    for (asked, expected_s) in [
        (&["--profile", "mine.csv"][..], 0.9),
        (&["--profile", "mine.csv", "--duration", "1.5"], 1.5),
        (&["--profile", "chirp,3s", "--duration", "1.5"], 1.5),
        (&["--profile", "chirp"], 2.0),
    ] {
        let found_s = length_s(here, &[&["simulate"], asked].concat());
        // Up to a whole number of samples.
        assert!(
            (found_s - expected_s).abs() < 0.5 * 0.003,
            "{asked:?}: {found_s} s"
        );
    }
}

#[test]
fn rounds_until_known_are_as_long_as_their_profile() {
    let folder = tempfile::tempdir().expect("a folder");
    let words = [
        "capture",
        "virtual:",
        "--until-known",
        "1s",
        "--profile",
        "chirp,3s",
    ];
    let done = run(folder.path(), &words);
    assert_eq!(done.status, Some(2));
    let said = "less than one recording of 3 s";
    assert!(done.messages.contains(said), "{}", done.messages);
}
