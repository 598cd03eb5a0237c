//! The diagnosis on cases of a second generator: Python with SciPy, with other friction and integration laws than the
//! simulator and `case-generator` (`tests/reference/README.md`), judged as the blind cases.

use std::collections::BTreeMap;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use crate::support;
use motorlab::blind::{Judgement, NewCase, Program, Truth, TruthKind, add_cases, judge, open, run};
use motorlab::diagnose::{Options, Verdict, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::{Run, read_run_from};

/// Chosen before any of it was diagnosed.
const KINDS: &str = "stribeck,voltage_drop,dead_zone,backlash,cogging,transport_delay,asymmetric_friction,gravity_load,\
                     coast_at_zero,inertia,voltage_drop+gravity_load,none";
const SEED: &str = "1";
/// A motor with an effect of the catalogue and one outside it.
const BESIDE: &str = "gravity_load+eddy_brake";
const BESIDE_SEED: &str = "91";
/// Least share of single effects that is named, or in a stated tie.
const SINGLES_RIGHT: f64 = 0.9;

/// A Python with SciPy: that of `tests/reference/install`, or the system's.
fn python() -> Option<PathBuf> {
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/reference-venv/bin/python");
    let has_scipy = |python: &PathBuf| {
        let tried = Command::new(python).args(["-c", "import scipy"]).output();
        tried.is_ok_and(|output| output.status.success())
    };
    [installed, PathBuf::from("python3")]
        .into_iter()
        .find(has_scipy)
}

fn made(python: &Path, directory: &Path, seed: &str, kinds: &str) -> Vec<NewCase> {
    let labels = directory.join("labels.json");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/diagnosis_cases.py");
    let output = Command::new(python)
        .arg(script)
        .args([directory, &labels])
        .args(["--seed", seed, "--kinds", kinds])
        .output()
        .expect("Python starts");
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaint}");
    let labels = read_to_string(labels).expect("labels");
    let labels: BTreeMap<String, Truth> = serde_json::from_str(&labels).expect("labels as written");
    let cases = labels.into_iter().map(|(name, truth)| {
        let file = |file: &str| read_to_string(directory.join(&name).join(file)).expect("a file");
        NewCase {
            runs: ["run1.csv", "run2.csv", "run3.csv"].map(file).into(),
            motor: file("motor.toml"),
            unseen: None,
            truth,
        }
    });
    cases.collect()
}

fn judged(python: &Path) -> Vec<Judgement> {
    let keep = tempfile::tempdir().expect("a directory");
    let (set, labels) = (keep.path().join("set"), keep.path().join("sealed.json"));
    let cases = made(python, &keep.path().join("made"), SEED, KINDS);
    add_cases(&set, &labels, None, cases).expect("sealed");
    let diagnoser = Program::new(Path::new(env!("CARGO_BIN_EXE_motorlab")), 1);
    let diagnoser = diagnoser.expect("it starts");
    run(&set, &diagnoser, 2, &AtomicBool::new(false), &|_| ()).expect("judged");
    let opened = open(&set, &labels, None).expect("opened");
    opened.cases.iter().map(|case| judge(case, None)).collect()
}

#[test]
fn effects_under_other_laws_are_identified() {
    let Some(python) = python() else {
        return support::skip(
            "effects_under_other_laws_are_identified",
            "no Python with SciPy: tests/reference/install makes one",
        );
    };
    let judged = judged(&python);
    let mut report = String::new();
    for case in &judged {
        let truth: Vec<&str> = case.truth.effects.iter().map(|e| e.id.as_str()).collect();
        report += &format!(
            "{:?}: {} -> {} of {:?}\n",
            case.bearing,
            truth.join("+"),
            case.said_in_words(),
            case.likeliest
        );
    }
    println!("{report}");
    let right = |kind: TruthKind| {
        let of: Vec<bool> = judged
            .iter()
            .filter(|case| case.truth.kind == kind)
            .map(Judgement::is_right)
            .collect();
        of.iter().filter(|right| **right).count() as f64 / of.len() as f64
    };
    assert!(right(TruthKind::Single) >= SINGLES_RIGHT, "{report}");
    for kind in [TruthKind::None, TruthKind::Pair] {
        assert_eq!(right(kind), 1.0, "{kind:?}\n{report}");
    }
}

/// An unknown cause does not exclude an effect that is present.
#[test]
fn an_effect_is_identified_beside_an_unmodelled_one() {
    let Some(python) = python() else {
        return support::skip(
            "an_effect_is_identified_beside_an_unmodelled_one",
            "no Python with SciPy: tests/reference/install makes one",
        );
    };
    let keep = tempfile::tempdir().expect("a directory");
    let cases = made(&python, keep.path(), BESIDE_SEED, BESIDE);
    for case in &cases {
        let runs = case.runs.iter();
        let runs: Vec<Run> = runs
            .map(|text| read_run_from(text.as_bytes(), "case").expect("a run").0)
            .collect();
        let motor = Motor::from_toml(&case.motor).expect("a motor file");
        let found = diagnose(&runs, &motor, &Options::default()).expect("a diagnosis");
        println!("{}", found.sentence);
        // The size of the unexplained share depends on the case; its presence does not.
        assert!(
            matches!(found.verdict, Verdict::Effect | Verdict::Partial),
            "{}",
            found.sentence
        );
        assert_eq!(found.effects, ["gravity_load"], "{}", found.sentence);
        assert!(found.unexplained.lo95 > 0.0, "{}", found.sentence);
    }
}
