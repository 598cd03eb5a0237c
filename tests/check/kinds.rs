//! Findings of `motorlab check`: each kind of finding on a case of its own, and nothing on valid recordings.

use std::f64::consts::TAU;
use std::path::Path;

use crate::support::command;
use motorlab::check::{Finding, Kind, Severity, check};
use motorlab::recording::{Run, write_run};

const SAMPLE_TIME_S: f64 = 0.003;

/// A first-order motor with these commands: 6 rad/s/V, a time constant of 50 ms, 720 counts per revolution.
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
fn the_command_prints_its_findings_and_a_fatal_one_sets_the_exit_status() {
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
    written(&turning(&step(11)), directory.path(), "shorter.csv");
    let told = |flags: &[&str]| {
        let words = [&["check", "short.csv", "shorter.csv"], flags].concat();
        let output = command::run(directory.path(), &words).output;
        (
            output.matches("(too_short)").count(),
            output.contains("samples = 11"),
        )
    };
    assert_eq!(told(&[]), (1, false));
    assert_eq!(told(&["--verbose"]), (2, true));
    let sound = command::run(directory.path(), &["check", "sound.csv"]);
    assert_eq!(sound.status, Some(0));
    assert!(
        sound.output.starts_with("no findings in "),
        "{}",
        sound.output
    );
}

#[test]
fn counts_that_fall_while_the_command_is_positive_are_reversed_on_any_profile() {
    let shape = |command: &dyn Fn(usize) -> f64| -> Run {
        let mut run = turning(&step(600));
        let mut counts = 0_i64;
        for k in 0..600 {
            run.command[k] = command(k);
            run.counts[k] = counts;
            counts += command(k).round() as i64;
        }
        run
    };
    let profiles: [&dyn Fn(usize) -> f64; 4] = [
        &|k| if k < 50 { 0.0 } else { 4.5 },
        &|k| if k < 50 { 0.0 } else { -4.5 },
        &|k| if (k / 100) % 2 == 0 { 4.5 } else { -4.5 },
        &|k| 4.5 * (k as f64 / 40.0).sin(),
    ];
    for profile in profiles {
        let sound = shape(profile);
        let mut swapped = sound.clone();
        swapped.counts.iter_mut().for_each(|n| *n = -*n);
        let found = check(std::slice::from_ref(&sound), None);
        assert!(
            found.iter().all(|f| f.severity == Severity::Note),
            "{found:?}"
        );
        let found = check(&[swapped], None);
        assert_eq!(found[0].id, Kind::EncoderReversed);
        assert_eq!(found[0].severity, Severity::Fatal);
        assert!(
            found[0]
                .sentence()
                .ends_with("swap either A and B or the motor leads, not both, and record again"),
            "{}",
            found[0].sentence()
        );
    }
    // A shaft that turns from the beginning and is braked to rest against its motion, with a small bounce.
    let mut braked = turning(&step(600));
    for k in 0..600 {
        let left = (1.0 - k as f64 / 500.0).max(0.0);
        braked.command[k] = -1.0;
        braked.counts[k] = (5000.0 * (1.0 - left * left)) as i64 + (k as i64 / 20) % 2;
    }
    assert!(
        check(&[braked], None)
            .iter()
            .all(|f| f.id != Kind::EncoderReversed)
    );
    // An arm that falls against a weak command, by half a turn and its oscillation.
    let mut falls = turning(&step(600));
    for k in 0..600 {
        let swing = (k as f64 / 30.0).cos() * (-(k as f64) / 100.0).exp();
        falls.command[k] = 0.5;
        falls.counts[k] = -(180.0 - 180.0 * swing) as i64;
    }
    assert!(
        check(&[falls], None)
            .iter()
            .all(|f| f.id != Kind::EncoderReversed)
    );
    // A load that is lifted and lowered under a holding command.
    let mut lifted = turning(&step(600));
    for k in 0..600 {
        lifted.command[k] = 2.0;
        lifted.counts[k] = if k < 300 {
            4 * k as i64
        } else {
            4 * (600 - k as i64)
        };
    }
    assert!(
        check(&[lifted], None)
            .iter()
            .all(|f| f.id != Kind::EncoderReversed)
    );
}

#[test]
fn multiples_units_constants_dither_and_motion_before_the_start_are_found() {
    let found = |run: &Run| kinds(&check(std::slice::from_ref(run), None));
    let sound = turning(&step(600));
    for factor in [2_i64, 4] {
        let mut run = sound.clone();
        for k in 0..600 {
            // Steps of different sizes.
            run.counts[k] = factor * (run.counts[k] + (k as i64 / 7));
        }
        assert!(found(&run).contains(&Kind::CountsScale), "{factor}");
    }
    let mut run = sound.clone();
    run.command.fill(0.0);
    let findings = check(std::slice::from_ref(&run), None);
    assert_eq!(findings[0].id, Kind::CommandConstant);
    assert_eq!(findings[0].severity, Severity::Fatal);
    run.command.fill(4.5);
    let findings = check(&[run], None);
    assert!(
        findings.iter().all(|f| f.severity == Severity::Note),
        "{findings:?}"
    );
    let mut dithers = sound.clone();
    for k in 0..100 {
        dithers.command[k] = 0.0;
        dithers.counts[k] = k as i64 % 2;
    }
    assert!(found(&dithers).contains(&Kind::DitherAtRest));
    assert!(!found(&sound).contains(&Kind::DitherAtRest));
    let mut turns = sound.clone();
    for k in 0..100 {
        turns.command[k] = 0.0;
        turns.counts[k] = 3 * k as i64 - 300;
    }
    assert!(found(&turns).contains(&Kind::StartsInMotion));
    let mut stuck = sound.clone();
    stuck.counts.fill(7);
    stuck.supply_v = Some(4.5);
    assert!(found(&stuck).contains(&Kind::ChannelStuck));
    // A tenth of the supply may be too little for a shaft with friction.
    stuck.command.iter_mut().for_each(|u| *u *= 0.1);
    assert!(!found(&stuck).contains(&Kind::ChannelStuck));
}

#[test]
fn a_position_in_a_wrong_unit_is_found_by_the_motor_file() {
    let motor = motorlab::motor::Motor::default();
    let t_s: Vec<f64> = (0..2000).map(|k| 0.003 * f64::from(k)).collect();
    let command: Vec<f64> = (0..2000)
        .map(|k| if (k / 300) % 2 == 0 { 4.5 } else { -2.0 })
        .collect();
    let drive = motorlab::motor::Drive {
        t_s: &t_s,
        command: &command,
        kind: motorlab::recording::CommandKind::Voltage,
    };
    let options = motorlab::motor::SimulationOptions::default();
    let trajectory = motorlab::motor::simulate(&motor, &drive, &options).expect("it simulates");
    let recorded = |factor: f64| Run {
        sample_time_s: 0.003,
        counts_per_rev: 720.0,
        supply_v: Some(4.5),
        t_s: t_s.clone(),
        command: command.clone(),
        counts: (trajectory.counts.iter())
            .map(|n| (*n as f64 * factor).round() as i64)
            .collect(),
        complete: true,
        ..Run::default()
    };
    assert_eq!(check(&[recorded(1.0)], Some(&motor)), []);
    for factor in [360.0 / TAU, TAU, 360.0, 1.0 / TAU] {
        let found = check(&[recorded(factor)], Some(&motor));
        assert!(
            found
                .iter()
                .any(|f| f.id == Kind::PositionUnit && f.severity == Severity::Fatal),
            "{factor}: {found:?}"
        );
    }
    // The command of a controller changes in every sample, and depends on the position.
    let mut controlled = recorded(TAU);
    (controlled.command.iter_mut().step_by(2)).for_each(|command| *command += 1e-3);
    let found = check(&[controlled], Some(&motor));
    let unit = found.iter().find(|f| f.id == Kind::PositionUnit);
    assert!(
        unit.is_some_and(|f| f.severity == Severity::Warning),
        "{found:?}"
    );
    for factor in [4.0, 0.25, 2.0, 0.5] {
        let found = check(&[recorded(factor)], Some(&motor));
        assert!(
            found.iter().any(|f| f.id == Kind::CountsScale),
            "{factor}: {found:?}"
        );
    }
}

#[test]
fn swapped_wires_stop_a_diagnosis_and_are_reported_by_import_and_compare() {
    let folder = tempfile::tempdir().expect("a folder");
    let case = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/fixtures/cases/diagnosis/sign_reversed"
    );
    let run = |arguments: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_motorlab"))
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .expect("it runs")
    };
    for name in ["vr", "vs"] {
        let log = format!("{case}/{name}_neg.csv");
        let map = format!("{case}/{name}_neg.toml");
        let file = format!("{name}.csv");
        let imported = run(&["import", &log, "--map", &map, "-o", &file]);
        assert_eq!(imported.status.code(), Some(1));
        let compared = run(&["compare", &file]);
        for said in [&imported.stderr, &compared.stderr] {
            let said = String::from_utf8_lossy(said);
            assert!(
                said.contains("the counts fall while the command is positive: channels A and B of the encoder, or the motor leads, are swapped; --reverse of the import (scale = -1"),
                "{said}"
            );
        }
    }
    let diagnosed = run(&["diagnose", "vr.csv", "vs.csv", "--json"]);
    std::fs::write(folder.path().join("why.json"), &diagnosed.stdout).expect("a file");
    let designed = run(&["design", "--diagnosis", "why.json"]);
    assert_eq!(designed.status.code(), Some(2));
    let said = String::from_utf8_lossy(&designed.stderr).into_owned();
    assert!(
        said.contains("proposes no experiment") && said.contains("scale = -1"),
        "{said}"
    );
    // With the flag: the computed verdict, marked.
    let forced = run(&["diagnose", "vs.csv", "--despite-findings", "--json"]);
    let document: serde_json::Value = serde_json::from_slice(&forced.stdout).expect("JSON");
    assert_eq!(document["shape"], "motorlab-diagnosis/3");
    let sets = document["sets"].as_array().expect("sets");
    let probabilities = sets.iter().filter_map(|set| set["probability"].as_f64());
    assert!((probabilities.sum::<f64>() - 1.0).abs() < 1e-6, "{sets:?}");
    let note = document["note"].as_str().expect("a note");
    assert!(note.contains("is fatal: correct it"), "{note}");
    assert_eq!(diagnosed.status.code(), Some(1));
    let document: serde_json::Value = serde_json::from_slice(&diagnosed.stdout).expect("JSON");
    assert_eq!(document["shape"], "motorlab-diagnosis/3");
    assert_eq!(document["verdict"], "bad_recording");
    assert_eq!(document["data"][0]["id"], "encoder_reversed");
    for key in ["effects", "classes", "budget", "causes", "sets"] {
        assert_eq!(document[key], serde_json::json!([]), "{key}");
    }
    for key in ["gap", "where", "unexplained", "identifiable"] {
        assert!(document[key].is_null(), "{key}");
    }
}
