//! `--threads N`: the same answer to the bit for every N.

#[path = "support/command.rs"]
mod command;

use std::fs;
use std::path::Path;

use command::run;
use serde_json::Value;

/// What the words print, without how long it took.
fn printed(here: &Path, words: &str, threads: &str) -> String {
    let words: Vec<&str> = words.split_whitespace().collect();
    let done = run(
        here,
        &[&words[..], &["--threads", threads, "--json"]].concat(),
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let mut document: Value = serde_json::from_str(&done.output).expect("a document");
    if let Some(document) = document.as_object_mut() {
        document.remove("elapsed_s");
    }
    // Numbers are printed so that they are read as the same bits.
    document.to_string()
}

#[test]
fn one_thread_and_two_come_to_the_same_bits() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    // A cause to be found, late samples and a load that wanders: whatever is drawn or added up is drawn and added up.
    let motor = "[effects.backlash]\ngap_rad = 0.03\n[effects.sample_jitter]\nspread_s = 0.002\n";
    fs::write(here.join("played.toml"), motor).expect("written");
    let simulate =
        "simulate --profile reversing --duration 3 --ts 0.01 --motor played.toml -o run.csv";
    let done = run(here, &simulate.split_whitespace().collect::<Vec<_>>());
    assert_eq!(done.status, Some(0), "{}", done.messages);
    for words in ["diagnose run.csv", "design --duration 1 --ts 0.03"] {
        let of = |threads| printed(here, words, threads);
        let one = of("1");
        assert_eq!(one, of("2"), "{words}");
        assert_eq!(one, of("3"), "{words}");
    }
}

#[test]
fn no_thread_and_no_number_are_refused() {
    let keep = tempfile::tempdir().expect("a folder");
    for threads in ["0", "-1", "many", "99999999"] {
        let done = run(keep.path(), &["diagnose", "run.csv", "--threads", threads]);
        assert_eq!(done.status, Some(2), "{threads}: {}", done.messages);
    }
}
