//! `--quick`: an answer from a tenth of the samples, marked as such, with less computation.

use motorlab::diagnose::{Diagnosis, Options, Verdict, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::Run;

use crate::recorded::{LEVELS, recorded, with};
use crate::support::command;

fn diagnosed(runs: &[Run], quick: bool) -> Diagnosis {
    let options = Options {
        quick,
        ..Options::default()
    };
    diagnose(runs, &Motor::default(), &options).expect("a diagnosis")
}

#[test]
fn a_quick_answer_names_the_same_effect_from_a_tenth_of_the_samples() {
    let run = recorded(&with(&[("dead_zone", &[0.8])]), &LEVELS, 0.01, 100.0);
    let runs = [run];
    let (whole, quick) = (diagnosed(&runs, false), diagnosed(&runs, true));
    assert_eq!(whole.quick, None);
    let of = quick.quick.as_ref().expect("it is marked");
    assert_eq!(of.of_samples, 10_000);
    assert!((1000..=1200).contains(&of.samples), "{of:?}");
    for found in [&whole, &quick] {
        assert_eq!(found.effects, ["dead_zone"], "{}", found.sentence);
        assert_eq!(found.verdict, Verdict::Effect, "{}", found.sentence);
    }
    let said = format!("Quick answer: {} of 10000 samples", of.samples);
    assert!(quick.sentence.contains(&said), "{}", quick.sentence);
    assert!(!whole.sentence.contains("Quick"), "{}", whole.sentence);
    // The errors are those of all samples; only the search is restricted.
    assert!((quick.gap.before / whole.gap.before - 1.0).abs() < 0.02);
    assert!(
        3 * quick.simulated_samples < whole.simulated_samples,
        "{} of {}",
        quick.simulated_samples,
        whole.simulated_samples
    );
}

/// Too short to omit samples: five segments are needed for the folds.
#[test]
fn a_short_recording_is_used_completely_and_marked_as_quick() {
    let runs = [recorded(&Motor::default(), &LEVELS, 0.01, 4.0)];
    let quick = diagnosed(&runs, true);
    let of = quick.quick.expect("it is marked");
    assert_eq!((of.samples, of.of_samples), (400, 400));
    assert_eq!(quick.verdict, diagnosed(&runs, false).verdict);
}

#[test]
fn sentence_page_and_document_state_that_the_answer_is_quick() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = [
        "simulate",
        "--profile",
        "reversing",
        "--ts",
        "0.01",
        "--duration",
        "30",
        "-o",
        "run.csv",
    ];
    assert_eq!(command::run(folder.path(), &made).status, Some(0));
    let done = command::run(
        folder.path(),
        &[
            "diagnose",
            "run.csv",
            "--quick",
            "--html",
            "page.html",
            "--json",
        ],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    // No progress without a terminal.
    assert!(
        !done.messages.contains('%') && !done.messages.contains('\u{1b}'),
        "{}",
        done.messages
    );
    let document: serde_json::Value = serde_json::from_str(&done.output).expect("a document");
    let samples = document["quick"]["samples"].as_u64().expect("a number");
    let share = document["quick"]["share"].as_f64().expect("a number");
    let said = format!(
        "Quick answer: {samples} of 3001 samples ({:.0} %)",
        100.0 * share
    );
    assert!(
        document["sentence"]
            .as_str()
            .is_some_and(|text| text.contains(&said)),
        "{document}"
    );
    let page = std::fs::read_to_string(folder.path().join("page.html")).expect("the page");
    assert!(page.contains(&said), "the page");
}
