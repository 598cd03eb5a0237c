//! `--threads N`: bitwise the same answer for every N.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::support::command::run;
use serde_json::Value;

/// Commands that do not compute in parallel.
const WITHOUT: [&str; 15] = [
    "ports",
    "replay",
    "virtual",
    "effects",
    "explain",
    "motor",
    "names",
    "export",
    "import",
    "firmware",
    "flash",
    "schema",
    "completions",
    "man",
    "help",
];

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

/// Seals have a random salt.
const SALTED: [&str; 2] = ["out/labels.json", "out/set/manifest.json"];

/// Start of the line of a page with a duration.
const DURATION: &str = "The diagnosis took ";

/// Everything in a folder by path, without durations.
fn files(folder: &Path, at: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in fs::read_dir(folder.join(at)).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = format!("{at}/{}", entry.file_name().to_string_lossy());
        match entry.path().is_dir() {
            true => files(folder, &name, found),
            false if SALTED.contains(&name.as_str()) => {}
            false => {
                let mut bytes = fs::read(entry.path()).expect("a file");
                if name.ends_with(".html") {
                    let page = String::from_utf8(bytes).expect("a page");
                    let lines = page.lines().filter(|line| !line.contains(DURATION));
                    bytes = lines.collect::<Vec<_>>().join("\n").into_bytes();
                }
                found.insert(name, bytes);
            }
        }
    }
}

/// Output of the command and files in the folder `out`, without durations.
fn answer(here: &Path, text: &str, threads: &str) -> (String, BTreeMap<String, Vec<u8>>) {
    let done = run(
        here,
        &[&words(text)[..], &["--threads", threads, "--json"]].concat(),
    );
    assert_eq!(done.status, Some(0), "{text}: {}", done.messages);
    let mut document: Value = serde_json::from_str(&done.output).expect("a document");
    if let Some(document) = document.as_object_mut() {
        document.remove("elapsed_s");
    }
    let mut written = BTreeMap::new();
    if here.join("out").exists() {
        files(here, "out", &mut written);
        fs::remove_dir_all(here.join("out")).expect("removed");
    }
    // Numbers are printed so that they read back bitwise.
    (document.to_string(), written)
}

#[test]
fn results_are_bit_identical_for_any_number_of_threads() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    // An effect, late samples and a random load: everything that is drawn or summed in parallel.
    let motor = "[effects.backlash]\ngap_rad = 0.03\n[effects.sample_jitter]\nspread_s = 0.002\n";
    fs::write(here.join("played.toml"), motor).expect("written");
    let simulate = "simulate --profile reversing --duration 3 --ts 0.01 --motor played.toml";
    let done = run(here, &words(&format!("{simulate} -o run.csv")));
    assert_eq!(done.status, Some(0), "{}", done.messages);
    fs::create_dir_all(here.join("class/ada")).expect("a folder");
    fs::copy(here.join("run.csv"), here.join("class/ada/step3.csv")).expect("copied");
    let diagnosed = run(here, &words("diagnose run.csv --json"));
    fs::create_dir(here.join("documents")).expect("a folder");
    for k in 0..3 {
        fs::write(here.join(format!("documents/{k}.json")), &diagnosed.output).expect("written");
    }
    for text in [
        simulate,
        "check run.csv",
        "compare run.csv",
        "diagnose run.csv",
        "design --duration 1 --ts 0.03",
        "lab --run run.csv --no-diagnosis -o out",
        "lab --class class -o out",
        "tabulate documents --html out/fleet.html -o out/fleet.csv --causes out/causes.csv --numbers out/numbers.csv",
        "blind make out/set --labels out/labels.json --cases 2 --seed 7",
    ] {
        let of = |threads| {
            if text.starts_with("tabulate") || text.starts_with("blind") {
                fs::create_dir(here.join("out")).expect("a folder");
            }
            answer(here, text, threads)
        };
        let one = of("1");
        assert!(one == of("2"), "{text}");
        assert!(one == of("3"), "{text}");
    }
}

#[test]
fn every_command_that_computes_takes_threads() {
    let keep = tempfile::tempdir().expect("a folder");
    let help = run(keep.path(), &["--help"]).output;
    let commands: Vec<&str> = (help.lines())
        .skip_while(|line| *line != "Tour:")
        .take_while(|line| *line != "Options:")
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(commands.len() > WITHOUT.len(), "{help}");
    for command in commands {
        let steps: &[&str] = match command {
            "blind" => &["make", "run", "score"],
            _ => &[""],
        };
        for step in steps {
            let asked = format!("{command} {step} --help");
            let help = run(keep.path(), &words(&asked)).output;
            let takes = help.contains("--threads");
            assert_eq!(takes, !WITHOUT.contains(&command), "{asked}");
        }
    }
}

#[test]
fn zero_threads_and_non_numbers_are_refused() {
    let keep = tempfile::tempdir().expect("a folder");
    for threads in ["0", "-1", "many", "99999999"] {
        let done = run(keep.path(), &["diagnose", "run.csv", "--threads", threads]);
        assert_eq!(done.status, Some(2), "{threads}: {}", done.messages);
    }
}
