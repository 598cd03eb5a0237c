//! An ordinary motor with other constants than the handout's: usual first attempts end in re-identified parameters or
//! no error.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use motorlab::motor::Parameters;
use serde_json::Value;

use crate::support::command::{RunFile, run};

/// Values of a motor file, in its order: of a gear motor of 12 V, and of a small one of 6 V.
const GEAR: [f64; 9] = [3.2, 0.75, 0.75, 0.006, 0.0018, 0.012, 0.09, 1320.0, 12.0];
const SMALL: [f64; 9] = [5.5, 0.14, 0.14, 0.0002, 0.002, 0.0003, 0.012, 360.0, 6.0];
/// A large winding: its electrical time constant L/R is 5 ms, a quarter of the mechanical one.
const WOUND: [f64; 9] = [1.2, 0.35, 0.35, 0.001, 0.006, 0.002, 0.03, 1024.0, 12.0];
/// A guess: each value a quarter too large or a fifth too small, except those of a data sheet.
const GUESSED: [f64; 9] = [0.8, 1.25, 1.25, 1.25, 0.8, 0.8, 0.8, 1.0, 1.0];
/// The right verdicts.
const RIGHT: [&str; 2] = ["parameters", "no_gap"];

fn motor_file(values: [f64; 9], factors: [f64; 9]) -> String {
    let mut text = String::new();
    for ((key, value), factor) in Parameters::KEYS.iter().zip(values).zip(factors) {
        writeln!(text, "{key} = {}", value * factor).expect("a text");
    }
    text
}

/// Two steps and a reversing recording of the motor, as run files and as logs of another program, and a guessed motor
/// file.
fn recorded(values: [f64; 9]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    fs::write(here.join("true.toml"), motor_file(values, [1.0; 9])).expect("a file");
    fs::write(here.join("guess.toml"), motor_file(values, GUESSED)).expect("a file");
    for (name, more) in [
        ("step3", "--ts 0.003 --duration 2.5"),
        ("step10", "--ts 0.01 --duration 2.5"),
        ("reversing", "--ts 0.005 --duration 10 --profile reversing"),
    ] {
        let run_file = format!("{name}.csv");
        let mut words = vec!["simulate", "--motor", "true.toml", "-o", &run_file];
        words.extend(more.split(' '));
        let done = run(here, &words);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        as_log(&here.join(&run_file), &here.join(format!("{name}.log.csv")));
    }
    folder
}

fn as_log(run_file: &Path, log: &Path) {
    let recorded = RunFile::read(run_file);
    let columns = ["t_s", "command_v", "counts"].map(|name| recorded.column(name));
    let mut text = "time_ms,voltage_v,counts\n".to_owned();
    for (k, t_s) in columns[0].iter().enumerate() {
        let (volts, counts) = (columns[1][k], columns[2][k]);
        writeln!(text, "{:.3},{volts},{counts}", 1000.0 * t_s).expect("a text");
    }
    fs::write(log, text).expect("a log");
}

fn right(here: &Path, words: &str) -> Value {
    let done = run(
        here,
        &[&words.split(' ').collect::<Vec<_>>()[..], &["--json"]].concat(),
    );
    assert_eq!(done.status, Some(0), "{words}: {}", done.messages);
    let found: Value = serde_json::from_str(&done.output).expect("a document");
    let verdict = found["verdict"].as_str().expect("a verdict");
    assert!(RIGHT.contains(&verdict), "{words}: {}", found["sentence"]);
    found
}

/// Also for `lab`, which assumes the handout's motor.
fn right_in_lab(here: &Path, words: &str) {
    let done = run(here, &words.split(' ').collect::<Vec<_>>());
    assert_eq!(done.status, Some(0), "{words}: {}", done.messages);
    let text = fs::read_to_string(here.join("lab/lab.json")).expect("lab.json");
    let lab: Value = serde_json::from_str(&text).expect("a document");
    let found = &lab["missing"]["diagnosed"];
    let verdict = found["verdict"].as_str().expect("a verdict");
    assert!(RIGHT.contains(&verdict), "{words}: {}", found["sentence"]);
}

const LAB: &str = "lab --run step3.csv --run step10.csv";

#[test]
fn a_gear_motor_has_no_effect() {
    let folder = recorded(GEAR);
    let here = folder.path();
    right(
        here,
        "diagnose step3.log.csv step10.log.csv --counts-per-rev 1320",
    );
    right(here, "diagnose step3.csv step10.csv --nominal fit");
    right(here, "diagnose step3.csv step10.csv --motor guess.toml");
    right(
        here,
        "diagnose step3.csv step10.csv reversing.csv --motor guess.toml",
    );
    right_in_lab(here, LAB);
    right_in_lab(here, &format!("{LAB} --run reversing.csv"));
}

#[test]
fn a_small_motor_has_no_effect() {
    let folder = recorded(SMALL);
    let here = folder.path();
    right(
        here,
        "diagnose step3.log.csv step10.log.csv --counts-per-rev 360",
    );
    right(here, "diagnose step3.csv step10.csv --nominal fit");
    right(here, "diagnose step3.csv step10.csv --motor guess.toml");
    right(
        here,
        "diagnose step3.csv step10.csv reversing.csv --nominal fit",
    );
    right(
        here,
        "diagnose step3.log.csv step10.log.csv reversing.log.csv --counts-per-rev 360",
    );
    right_in_lab(here, LAB);
    right_in_lab(here, &format!("{LAB} --run reversing.csv"));
}

/// Without a motor file L/R is free, as the other parameters. Voltage and counts determine `R/L + b/J`: L/R is wrong
/// by the share of viscous friction.
#[test]
fn a_motor_with_a_large_inductance_has_no_effect() {
    let folder = recorded(WOUND);
    let here = folder.path();
    for words in [
        "diagnose step3.log.csv step10.log.csv --counts-per-rev 1024",
        "diagnose step3.log.csv --counts-per-rev 1024",
        "diagnose step3.csv step10.csv --nominal fit",
        "diagnose step3.csv step10.csv reversing.csv --nominal fit",
    ] {
        let found = right(here, words);
        let fitted_s = &found["identifiable"]["electrical_time_constant_s"]["value"];
        let off = fitted_s.as_f64().expect("a number") / 0.005 - 1.0;
        assert!(off.abs() < 0.2, "{words}: L/R is off by {off}");
    }
    right(here, "diagnose step3.csv step10.csv --motor guess.toml");
    right_in_lab(here, LAB);
    right_in_lab(here, "lab --run step3.csv");
    right_in_lab(here, &format!("{LAB} --run reversing.csv"));
}
