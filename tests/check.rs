//! What `motorlab check` finds: each kind of finding on a case of its own, and nothing on sound recordings.

use std::path::Path;

use motorlab::check::{Finding, Kind, Severity, check};
use motorlab::recording::{Run, write_run};

#[path = "support/command.rs"]
mod command;

const SAMPLE_TIME_S: f64 = 0.003;

/// A motor of first order with these commands: 6 rad/s/V, a time constant of 50 ms, 720 counts a turn.
fn turning(command: &[f64]) -> Run {
    let mut run = Run {
        sample_time_s: SAMPLE_TIME_S,
        counts_per_rev: 720.0,
        supply_v: Some(4.5),
        complete: true,
        ..Run::default()
    };
    let (mut angle_rad, mut speed_rad_s) = (0.0, 0.0);
    let keep = (-SAMPLE_TIME_S / 0.05_f64).exp();
    for (k, &command_v) in command.iter().enumerate() {
        run.t_s.push(k as f64 * SAMPLE_TIME_S);
        run.command.push(command_v);
        let counts = angle_rad * 720.0 / std::f64::consts::TAU;
        run.counts.push(f64::round(counts) as i64);
        angle_rad += speed_rad_s * SAMPLE_TIME_S;
        speed_rad_s = keep * speed_rad_s + (1.0 - keep) * 6.0 * command_v;
    }
    run
}

/// Rest, then a step.
fn step(samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|k| if k < 20 { 0.0 } else { 4.5 })
        .collect()
}

fn kinds(findings: &[Finding]) -> Vec<Kind> {
    findings.iter().map(|finding| finding.id).collect()
}

/// Writes a run for a command to read.
fn written(run: &Run, directory: &Path, name: &str) {
    write_run(run, &directory.join(name)).expect("it can be written");
}

#[test]
fn a_few_samples_are_too_short() {
    let findings = check(&[turning(&step(12))], None);
    assert_eq!(kinds(&findings), [Kind::TooShort]);
    let found = &findings[0];
    assert_eq!(found.severity, Severity::Fatal);
    assert_eq!(found.evidence["samples"], 12.0);
    assert_eq!(found.run, "1");
    assert!(found.remedy.contains("record longer"), "{}", found.remedy);
}

#[test]
fn the_command_prints_what_it_finds_and_a_fatal_finding_is_its_exit_status() {
    let directory = tempfile::tempdir().expect("a directory");
    written(&turning(&step(12)), directory.path(), "short.csv");
    written(&turning(&step(600)), directory.path(), "sound.csv");
    let bad = command::run(directory.path(), &["check", "short.csv", "--json"]);
    assert_eq!(bad.status, Some(1), "{}", bad.messages);
    let document: serde_json::Value = serde_json::from_str(&bad.output).expect("one document");
    assert_eq!(document["shape"], "motorlab-check/1");
    let finding = &document["findings"][0];
    assert_eq!(finding["id"], "too_short");
    assert_eq!(finding["severity"], "fatal");
    assert_eq!(finding["run"], "short.csv");
    let text = command::run(directory.path(), &["check", "short.csv"]);
    assert_eq!(text.status, Some(1));
    assert!(
        text.output.contains("fatal (too_short), short.csv"),
        "{}",
        text.output
    );
    let sound = command::run(directory.path(), &["check", "sound.csv"]);
    assert_eq!(
        (sound.status, sound.output.as_str()),
        (Some(0), "nothing found\n")
    );
}
