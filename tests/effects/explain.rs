//! `motorlab explain`: every effect has a page under the fixed headings, with the catalogue's equation, parameters and source.

use std::fs;
use std::path::Path;

use crate::support::command::{Finished, run};
use motorlab::motor::catalogue::{MAX_PARAMETERS, catalogue};
use serde_json::Value;

/// Headings of every page, in order.
const HEADINGS: [&str; 6] = [
    "What it is",
    "What it does to a recording",
    "What causes it",
    "How to tell it apart",
    "How to model it",
    "References",
];

fn in_folder(arguments: &[&str]) -> Finished {
    run(tempfile::tempdir().expect("a folder").path(), arguments)
}

#[test]
fn every_page_has_the_headings_and_the_facts_of_the_catalogue() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/effects");
    for kind in catalogue() {
        let path = folder.join(format!("{}.md", kind.id));
        let page = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path:?}: {error}"));
        let headings: Vec<&str> = (page.lines())
            .filter_map(|line| line.strip_prefix("## "))
            .collect();
        assert_eq!(headings, HEADINGS, "{}", kind.id);
        assert!(page.contains(kind.equation), "{}: equation", kind.id);
        assert!(page.contains(&kind.source[1..]), "{}: source", kind.id);
        assert!(page.contains(&kind.summary[1..]), "{}: summary", kind.id);
        assert!(page.contains(&format!("({}.svg)", kind.id)), "{}", kind.id);
        assert!(kind.parameters.len() <= MAX_PARAMETERS);
        for parameter in kind.parameters {
            let key = format!("\n{} = ", parameter.key);
            assert!(page.contains(&key), "{}: {}", kind.id, parameter.key);
        }
        for other in kind.confounded_with {
            assert!(page.contains(other), "{}: {other}", kind.id);
        }
    }
}

#[test]
fn every_page_is_printed_as_text_and_as_sections() {
    for kind in catalogue() {
        let text = in_folder(&["explain", kind.id]);
        assert_eq!(text.status, Some(0), "{}", text.messages);
        assert!(text.output.contains(kind.equation), "{}", text.output);
        assert!(!text.output.contains("](") && !text.output.contains("```"));
    }
    let done = in_folder(&["explain", "stribeck", "--json"]);
    let document: Value = serde_json::from_str(&done.output).expect("a document");
    let sections = document["sections"].as_array().expect("sections");
    let headings: Vec<&str> = (sections.iter())
        .map(|section| section["heading"].as_str().expect("a heading"))
        .collect();
    assert_eq!(headings, HEADINGS);
}

#[test]
fn an_unknown_effect_is_an_error_with_a_hint() {
    let done = in_folder(&["explain", "backlsh"]);
    assert_eq!(done.status, Some(2));
    assert!(
        done.messages.contains("hint: motorlab explain backlash"),
        "{}",
        done.messages
    );
}
