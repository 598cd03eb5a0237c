//! `diagnose` with its limit of work, and `--thorough` without.

#[path = "support/command.rs"]
mod command;

use case_generator::generate;
use command::run;

/// What nothing in the catalogue explains is not looked at for long, and where sets were left untried the document, the page and the
/// terminal say so.
#[test]
fn a_search_that_ends_at_its_limit_says_so_and_a_thorough_one_does_not_end_there() {
    let directory = tempfile::tempdir().expect("a directory");
    let case = generate(11, &"vibration".parse().expect("a kind"));
    let mut arguments = vec!["diagnose"];
    let names = ["step30.csv", "step3.csv", "reversing.csv"];
    for (name, recorded) in names.iter().zip(&case.runs) {
        std::fs::write(directory.path().join(name), recorded.to_csv()).expect("room");
        arguments.push(name);
    }
    std::fs::write(directory.path().join("motor.toml"), case.nominal.to_toml()).expect("room");
    arguments.extend(["--motor", "motor.toml"]);
    let with = |more: &[&str]| {
        let arguments: Vec<&str> = arguments.iter().chain(more).copied().collect();
        let done = run(directory.path(), &arguments);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        done.output
    };
    let document = |more: &[&str]| -> serde_json::Value {
        serde_json::from_str(&with(more)).expect("one document")
    };
    let hint = "add --thorough to try them";
    assert_eq!(
        document(&["--json", "--html", "why.html"])["cut_short"],
        true
    );
    let page = std::fs::read_to_string(directory.path().join("why.html")).expect("a page");
    assert!(page.contains(hint));
    assert!(with(&[]).contains(hint));
    let thorough = document(&["--json", "--thorough", "--html", "why.html"]);
    assert_eq!(thorough["cut_short"], false);
    let page = std::fs::read_to_string(directory.path().join("why.html")).expect("a page");
    assert!(!page.contains(hint));
}
