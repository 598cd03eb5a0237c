//! `motorlab lab --class FOLDER`: one page over the recordings of many students, and those that are unusable.

use std::fs;
use std::path::Path;

use crate::support::command::{Finished, run};
use crate::support::reversed::reversed;
use serde_json::Value;

fn record(here: &Path, student: &str, name: &str, board: &str) {
    fs::create_dir_all(here.join(student)).expect("a folder");
    let port = format!("virtual:?speed=max{board}");
    let file = format!("{student}/{name}");
    let arguments = [
        "capture",
        &port,
        "--ts",
        "0.01",
        "--duration",
        "6",
        "--profile",
        "reversing",
        "-o",
        &file,
    ];
    let done = run(here, &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
}

fn class(here: &Path, more: &[&str]) -> Finished {
    run(here, &[&["lab", "--class", "monday"], more].concat())
}

fn student<'a>(document: &'a Value, name: &str) -> &'a Value {
    let students = document["students"].as_array().expect("students");
    let found = students.iter().find(|student| student["name"] == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn each_student_has_a_row_and_unusable_recordings_are_listed() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    record(here, "monday/anna", "run.csv", "");
    record(
        here,
        "monday/ben",
        "a.csv",
        "&effect=voltage_drop&drop_v=0.8",
    );
    record(
        here,
        "monday/ben",
        "b.csv",
        "&effect=voltage_drop&drop_v=0.8&seed=2",
    );
    // Another motor, described by the student's motor file.
    record(here, "monday/cleo", "run.csv", "&resistance_ohm=14");
    fs::write(here.join("monday/cleo/motor.toml"), "resistance_ohm = 14\n").expect("written");
    // An encoder with swapped channels: the counts run backwards.
    record(here, "monday/dora", "run.csv", "");
    let text = fs::read_to_string(here.join("monday/dora/run.csv")).expect("a run");
    fs::write(here.join("monday/dora/run.csv"), reversed(&text)).expect("written");
    fs::create_dir_all(here.join("monday/emil")).expect("a folder");
    fs::create_dir_all(here.join("monday/fritz")).expect("a folder");
    fs::write(
        here.join("monday/fritz/notes.csv"),
        "day,mood\nmonday,fine\n",
    )
    .expect("written");
    record(here, "monday/gina", "run.csv", "");
    fs::write(here.join("monday/gina/motor.toml"), "resistance = 14\n").expect("written");
    fs::write(here.join("monday/readme.txt"), "no folder").expect("written");

    let done = class(here, &["--json"]);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let document: Value = serde_json::from_str(&done.output).expect("one document");
    assert_eq!(document["shape"], "motorlab-class/1");
    assert_eq!(document["students"].as_array().map(Vec::len), Some(7));
    assert_eq!(student(&document, "anna")["together"]["verdict"], "no_gap");
    let ben = student(&document, "ben");
    assert_eq!(
        ben["together"]["effects"],
        serde_json::json!(["voltage_drop"])
    );
    assert_eq!(ben["recordings"].as_array().map(Vec::len), Some(2));
    assert!(ben["recordings"][1]["outcome"]["gap_counts"].as_f64() > Some(5.0));
    // With the handout's motor there would be a gap.
    assert_eq!(student(&document, "cleo")["together"]["verdict"], "no_gap");
    let dora = student(&document, "dora");
    assert!(dora["together"].is_null());
    assert_eq!(
        dora["recordings"][0]["findings"][0]["id"],
        "encoder_reversed"
    );
    assert!(dora["recordings"][0]["unusable"].is_string());
    let problem = |name: &str| student(&document, name)["problem"].to_string();
    assert!(problem("emil").contains("no recording"));
    assert!(
        problem("gina").contains("resistance_ohm"),
        "{}",
        problem("gina")
    );
    assert!(student(&document, "fritz")["recordings"][0]["unusable"].is_string());
    // Each is reported when it is finished.
    assert!(
        done.messages.contains("2/7  ben: voltage_drop"),
        "{}",
        done.messages
    );

    let page = fs::read_to_string(here.join("class/index.html")).expect("a page");
    for name in ["anna", "ben", "cleo", "dora", "emil", "fritz", "gina"] {
        assert!(page.contains(name), "{name}");
    }
    // All numbers of the page are of the diagnosis' measure.
    assert!(!page.contains("over the whole run"));
    assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("readme"));
    let file = fs::read_to_string(here.join("class/class.json")).expect("a file");
    let file: Value = serde_json::from_str(&file).expect("JSON");
    assert_eq!(file["students"], document["students"]);

    // It replaces its own page, and nothing else.
    assert_eq!(class(here, &[]).status, Some(1));
    fs::write(here.join("class/index.html"), "mine").expect("written");
    let refused = class(here, &[]);
    assert_eq!(refused.status, Some(2), "{}", refused.messages);
    assert_eq!(
        fs::read_to_string(here.join("class/index.html"))
            .ok()
            .as_deref(),
        Some("mine")
    );
}

#[test]
fn a_folder_without_folders_is_refused() {
    let keep = tempfile::tempdir().expect("a folder");
    fs::create_dir(keep.path().join("monday")).expect("a folder");
    let empty = class(keep.path(), &[]);
    assert_eq!(empty.status, Some(2));
    assert!(
        empty.messages.contains("one folder per student"),
        "{}",
        empty.messages
    );
    assert_eq!(
        run(keep.path(), &["lab", "--class", "nowhere"]).status,
        Some(2)
    );
    assert!(!keep.path().join("class").exists());
}
