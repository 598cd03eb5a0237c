//! `diagnose`, `compare` and `check` of a log of another program, and `import --force`.

use std::fs;
use std::path::Path;

use crate::support::command::{RunFile, run};
use crate::support::foreign_logs::{Truth, counts, log};

/// A log without open questions: its speed has steps of counts, its command is in V.
fn clear_log(truth: &Truth) -> String {
    let ms = |k: usize| truth.ms(k).to_string();
    let volts = |k: usize| format!("{:.6}", truth.volts(k));
    log(
        "time_ms,voltage,rpm",
        truth.rows(),
        &[&ms, &volts, &|k| truth.rpm(k)],
    )
}

fn written(directory: &Path, name: &str, text: &str) {
    fs::write(directory.join(name), text).expect("written");
}

fn files(directory: &Path) -> usize {
    fs::read_dir(directory).expect("a folder").count()
}

#[test]
fn a_log_without_open_questions_is_diagnosed_directly() {
    let truth = Truth::steps(0.02, 300);
    let directory = tempfile::tempdir().expect("a directory");
    written(directory.path(), "log.csv", &clear_log(&truth));
    for command in ["check", "compare", "diagnose"] {
        let finished = run(directory.path(), &[command, "log.csv", "--json"]);
        assert!(
            matches!(finished.status, Some(0 | 1)),
            "{command}: {}",
            finished.messages
        );
        assert!(
            finished.messages.contains("`rpm` in rpm, in steps of"),
            "{}",
            finished.messages
        );
        let document: serde_json::Value =
            serde_json::from_str(&finished.output).expect("one JSON document");
        if command == "compare" {
            assert_eq!(document["runs"][0]["path"], "log.csv");
            assert_eq!(document["runs"][0]["samples"], 300);
        }
        assert_eq!(files(directory.path()), 1, "nothing is left behind");
    }
}

#[test]
fn a_question_has_the_completed_command_line() {
    let truth = Truth::steps(0.02, 300);
    let directory = tempfile::tempdir().expect("a directory");
    written(directory.path(), "log.csv", &truth.counts_log());
    for command in [
        &["check", "log.csv"][..],
        &["compare", "log.csv", "--fail-above", "1e9"],
        &["diagnose", "log.csv", "--good-enough", "1%"],
    ] {
        let flags = [command, &["--supply", "12"]].concat();
        let finished = run(directory.path(), &flags);
        assert_eq!(
            finished.status,
            Some(2),
            "{command:?}: {}",
            finished.messages
        );
        let proposed = format!(
            "motorlab {} --supply 12 --counts-per-rev COUNTS",
            command.join(" ")
        );
        assert!(
            finished.messages.contains(&proposed),
            "{proposed}: {}",
            finished.messages
        );
        // Pasted, and filled in.
        let flags = [command, &["--supply", "12", "--counts-per-rev", "720"]].concat();
        let finished = run(directory.path(), &flags);
        assert!(
            matches!(finished.status, Some(0 | 1)),
            "{command:?}: {}",
            finished.messages
        );
    }
    assert_eq!(files(directory.path()), 1, "nothing is left behind");
}

#[test]
fn flags_of_a_log_are_refused_with_run_files() {
    let truth = Truth::steps(0.02, 300);
    let directory = tempfile::tempdir().expect("a directory");
    let row = |k: usize| format!("{},{},{}\n", truth.t_s(k), truth.volts(k), truth.counts[k]);
    let rows: String = truth.rows().map(row).collect();
    let header = "# format = \"motorlab-run/1\"\n# sample_time_s = 0.02\n# counts_per_rev = 720\n";
    written(
        directory.path(),
        "run.csv",
        &format!("{header}t_s,command_v,counts\n{rows}"),
    );
    let finished = run(directory.path(), &["check", "run.csv", "--supply", "12"]);
    assert_eq!(finished.status, Some(2), "{}", finished.messages);
    assert!(
        finished
            .messages
            .contains("--supply: it describes a log of another program"),
        "{}",
        finished.messages
    );
}

#[test]
fn force_replaces_the_run_of_another_log() {
    let directory = tempfile::tempdir().expect("a directory");
    let (first, second) = (Truth::steps(0.02, 300), Truth::steps(0.02, 200));
    written(directory.path(), "a.csv", &clear_log(&first));
    written(directory.path(), "b.csv", &clear_log(&second));
    let import = |log: &str, flags: &[&str]| {
        let flags = [&["import", log, "-o", "run.csv"], flags].concat();
        let finished = run(directory.path(), &flags);
        assert_eq!(finished.status, Some(0), "{}", finished.messages);
        finished
    };
    let in_place = || counts(&RunFile::read(&directory.path().join("run.csv")));
    import("a.csv", &[]);
    assert_eq!(in_place(), first.counts);
    let kept = import("b.csv", &[]);
    assert!(
        kept.messages.contains("--force replaces it"),
        "{}",
        kept.messages
    );
    assert_eq!(in_place(), first.counts);
    let replaced = import("b.csv", &["--force"]);
    assert_eq!(in_place(), second.counts);
    assert_eq!(replaced.output, "run.csv\n");
    // Two logs, the run, and the one beside it.
    assert_eq!(files(directory.path()), 4);
    // Never the log itself, and never a run that was not imported.
    let finished = run(
        directory.path(),
        &["import", "b.csv", "-o", "b.csv", "--force"],
    );
    assert_eq!(finished.status, Some(2), "{}", finished.messages);
    written(directory.path(), "none.csv", "Dear reader,\nno log\n");
    let finished = run(
        directory.path(),
        &["import", "none.csv", "-o", "run.csv", "--force"],
    );
    assert_eq!(finished.status, Some(2), "{}", finished.messages);
    assert_eq!(in_place(), second.counts);
}
