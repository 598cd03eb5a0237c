//! `diagnose` with its limit of work, and `--thorough` without.

#[path = "support/command.rs"]
mod command;

use std::path::Path;

use case_generator::generate;
use command::run;

/// A directory with the runs and the motor file of a generated case, and the arguments that diagnose them.
fn case(seed: u64, kind: &str) -> (tempfile::TempDir, Vec<&'static str>) {
    let directory = tempfile::tempdir().expect("a directory");
    let case = generate(seed, &kind.parse().expect("a kind"));
    let names = ["step30.csv", "step3.csv", "reversing.csv"];
    for (name, recorded) in names.iter().zip(&case.runs) {
        std::fs::write(directory.path().join(name), recorded.to_csv()).expect("room");
    }
    std::fs::write(directory.path().join("motor.toml"), case.nominal.to_toml()).expect("room");
    let arguments = [&["diagnose"][..], &names, &["--motor", "motor.toml"]].concat();
    (directory, arguments)
}

/// What is said with these arguments too.
fn said(directory: &Path, arguments: &[&str], more: &[&str]) -> String {
    let done = run(directory, &[arguments, more].concat());
    assert_eq!(done.status, Some(0), "{}", done.messages);
    done.output
}

fn document(directory: &Path, arguments: &[&str], more: &[&str]) -> serde_json::Value {
    serde_json::from_str(&said(directory, arguments, more)).expect("one document")
}

/// What nothing in the catalogue explains is not looked at for long, and where sets were left untried the document, the page and the
/// terminal say so.
#[test]
fn a_search_that_ends_at_its_limit_says_so_and_a_thorough_one_does_not_end_there() {
    let (directory, arguments) = case(11, "vibration");
    let directory = directory.path();
    let hint = "add --thorough to search on";
    let page = || std::fs::read_to_string(directory.join("why.html")).expect("a page");
    let limited = document(directory, &arguments, &["--json", "--html", "why.html"]);
    assert_eq!(limited["cut_short"], true);
    assert!(page().contains(hint));
    assert!(said(directory, &arguments, &[]).contains(hint));
    let thorough = ["--json", "--thorough", "--html", "why.html"];
    let thorough = document(directory, &arguments, &thorough);
    assert_eq!(thorough["cut_short"], false);
    assert!(!page().contains(hint));
}

/// What was left untried beside a set that was found is another matter than what was left where none was.
#[test]
fn of_a_set_that_was_found_it_is_said_that_what_was_left_promised_less() {
    let (directory, arguments) = case(1, "backlash+viscous_friction");
    let found = document(directory.path(), &arguments, &["--json"]);
    assert_ne!(found["verdict"], "outside_catalogue");
    assert_eq!(found["cut_short"], true);
    let said = said(directory.path(), &arguments, &[]);
    assert!(said.contains("untried that promised less than what was found"));
}
