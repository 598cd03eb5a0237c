//! Logged speeds without steps: instantaneous, or the mean since the previous row. The rule with the smaller residual
//! for a first-order motor is used, and the motor is that of the log.

use std::fmt::Write as _;

use crate::support::foreign_logs::{asked, import, imported};
use motorlab::least_squares::{PlainFit, fit_runs};
use motorlab::recording::read_run;

/// The motor in rev/s and V, and its friction in V.
const GAIN_REV_S_V: f64 = 16.67 / 60.0;
const TIME_CONSTANTS_S: [f64; 2] = [0.05, 0.12];
const COUNTS: [&str; 2] = ["--counts-per-rev", "4000"];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Speed {
    Instant,
    Mean,
}

/// Levels of both signs, each held for 0.9 s.
fn command_v(t_s: f64) -> f64 {
    [0.0, 6.0, 3.0, -5.0, 0.0, 4.0][((t_s + 1e-9) / 0.9) as usize % 6]
}

/// A perfect first-order motor in closed form from row to row, its speed in rad/s with four digits.
fn text(time_constant_s: f64, sample_time_s: f64, speed_is: Speed) -> String {
    let settled = -(-sample_time_s / time_constant_s).exp_m1();
    let (mut speed, mut shown) = (0.0, 0.0);
    let mut text = "time_s,voltage,speed_rad_s\n".to_owned();
    for k in 0..(9.0 / sample_time_s) as usize {
        let t_s = k as f64 * sample_time_s;
        let _ = writeln!(text, "{t_s:.3},{},{shown:.4}", command_v(t_s));
        let end = GAIN_REV_S_V * std::f64::consts::TAU * command_v(t_s);
        let off = speed - end;
        speed = end + off * (1.0 - settled);
        shown = match speed_is {
            Speed::Instant => speed,
            Speed::Mean => end + off * settled * time_constant_s / sample_time_s,
        };
    }
    text
}

/// The plain first-order fit of the imported run.
fn fitted(text: &str, flags: &[&str]) -> (PlainFit, String) {
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "log.csv", text, flags);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let (run, _) = read_run(&directory.path().join("run.csv")).expect("a run");
    let fit = fit_runs(&[run], &[]).expect("it turns");
    (fit, finished.messages)
}

#[test]
fn a_perfect_motor_keeps_its_time_constant_at_rows_of_5_to_50_ms() {
    for time_constant_s in TIME_CONSTANTS_S {
        for sample_time_s in [0.005, 0.01, 0.02, 0.05] {
            for speed_is in [Speed::Instant, Speed::Mean] {
                let text = text(time_constant_s, sample_time_s, speed_is);
                let (fit, said) = fitted(&text, &COUNTS);
                let what = format!("{time_constant_s} {sample_time_s} {speed_is:?}: {said}");
                let off = fit.motor.shape.time_constant_s / time_constant_s - 1.0;
                assert!(off.abs() < 0.03, "{off:+.4} {what}");
                let gain = fit.motor.gain / std::f64::consts::TAU / GAIN_REV_S_V - 1.0;
                assert!(gain.abs() < 0.01, "{gain:+.4} {what}");
                assert!(fit.left_counts < 0.7, "{} {what}", fit.left_counts);
                let (taken, other) = match speed_is {
                    Speed::Instant => ("it is the speed at the instant", "--integrate backward"),
                    Speed::Mean => (
                        "it is the mean since the row before",
                        "--integrate trapezoid",
                    ),
                };
                assert!(said.contains(taken) && said.contains(other), "{what}");
            }
        }
    }
}

/// For rows of 20 ms the wrong rule shifts the position by half a row's travel, and a flag selects the rule.
#[test]
fn the_flag_states_the_other_rule() {
    let text = text(0.12, 0.02, Speed::Instant);
    let (right, _) = fitted(&text, &COUNTS);
    let flags = [&COUNTS[..], &["--integrate", "backward"]].concat();
    let (wrong, said) = fitted(&text, &flags);
    assert!(
        said.contains("summed up to a position (backward)"),
        "{said}"
    );
    assert!(wrong.left_counts > 5.0 * right.left_counts);
}

#[test]
fn a_speed_without_a_motor_model_is_instantaneous_and_reported() {
    let mut text = "time_s,voltage,speed_rad_s\n".to_owned();
    for k in 0..400_u32 {
        let speed = 5.0 + f64::from(k * k * 7919 % 1009) * 1.037e-2;
        let _ = writeln!(text, "{:.2},6,{speed:.5}", f64::from(k) * 0.01);
    }
    let (file, said) = imported("log.csv", &text, &COUNTS);
    assert!(said.contains("which the motion does not show"), "{said}");
    assert!(said.contains("--integrate backward"), "{said}");
    assert_eq!(
        file.header["imported"]["position"].as_str(),
        Some("integrated from speed, trapezoid")
    );
}

/// Speeds in thousandths with more digits are no counts: 1,200,000 per revolution at 10 ms.
#[test]
fn steps_far_finer_than_an_encoders_are_questioned() {
    let motor = text(0.05, 0.01, Speed::Instant);
    let mut text = "time_s,voltage,speed_rpm\n".to_owned();
    for line in motor.lines().skip(1) {
        let (rest, speed) = line.rsplit_once(',').expect("cells");
        let rpm: f64 = speed.parse::<f64>().expect("a number") * 60.0 / std::f64::consts::TAU;
        let _ = writeln!(text, "{rest},{:.6}", (rpm * 20.0).round() / 20.0);
    }
    let said = asked("log.csv", &text, &[]);
    assert!(
        said.contains("--counts-per-rev COUNTS") && said.contains("more than encoders have"),
        "{said}"
    );
}

/// Whole RPM: under a constant command the rounding error is the same in each row, and accumulates. It is part of the
/// noise floor.
#[test]
fn a_perfect_motor_with_speeds_in_whole_rpm_has_no_further_cause() {
    for (sample_time_s, speed_is) in [
        (0.01, Speed::Instant),
        (0.02, Speed::Mean),
        (0.05, Speed::Instant),
        (0.05, Speed::Mean),
    ] {
        let mut log = "time_s,voltage,speed_rpm\n".to_owned();
        for line in text(0.08, sample_time_s, speed_is).lines().skip(1) {
            let (rest, speed) = line.rsplit_once(',').expect("cells");
            let rpm: f64 = speed.parse::<f64>().expect("a number") * 60.0 / std::f64::consts::TAU;
            let _ = writeln!(log, "{rest},{}", rpm.round());
        }
        let directory = tempfile::tempdir().expect("a directory");
        std::fs::write(directory.path().join("log.csv"), log).expect("a log");
        let asked = ["diagnose", "log.csv", "--counts-per-rev", "720", "--json"];
        let done = crate::support::command::run(directory.path(), &asked);
        let document: serde_json::Value = serde_json::from_str(&done.output).expect("a document");
        let verdict = document["verdict"].as_str().expect("a verdict");
        let what = format!("{sample_time_s} {speed_is:?}: {verdict}");
        assert!(matches!(verdict, "no_gap" | "parameters"), "{what}");
        let tau_s = document["identifiable"]["time_constant_s"]["value"].as_f64();
        let off = tau_s.expect("a time constant") / 0.08 - 1.0;
        assert!(off.abs() < 0.03, "{off:+.4} {what}");
    }
}

/// A step that is not a count's is the rounding of the log: it determines no counts, and the run states it.
#[test]
fn rounded_speeds_are_no_differences_of_counts() {
    let mut log = "time_s,voltage,speed_rpm\n".to_owned();
    for line in text(0.08, 0.01, Speed::Instant).lines().skip(1) {
        let (rest, speed) = line.rsplit_once(',').expect("cells");
        let rpm: f64 = speed.parse::<f64>().expect("a number") * 60.0 / std::f64::consts::TAU;
        let _ = writeln!(log, "{rest},{:.1}", rpm.round());
    }
    let said = asked("log.csv", &log, &[]);
    assert!(said.contains("are the rounding of its numbers"), "{said}");
    let (file, said) = imported("log.csv", &log, &["--counts-per-rev", "720"]);
    assert!(said.contains("it is the speed at the instant"), "{said}");
    // 1 RPM is 12 counts/s.
    let resolution = file.header["imported"]["speed_resolution_counts_s"].as_float();
    assert!(
        (resolution.expect("a resolution") - 12.0).abs() < 1e-9,
        "{resolution:?}"
    );
}

/// A speed of the instant is summed up between rows, where every other step would have an edge.
#[test]
fn rows_without_an_edge_are_counted_in_the_log_and_not_in_its_sum() {
    let sound = text(0.08, 0.01, Speed::Instant);
    let mut lines = sound.lines();
    let mut log = lines.next().expect("names").to_owned() + "\n";
    for (k, line) in lines.enumerate() {
        let (before, speed) = line.rsplit_once(',').expect("cells");
        let _ = writeln!(log, "{before},{}", if k % 3 == 0 { speed } else { "0" });
    }
    let directory = tempfile::tempdir().expect("a directory");
    let done = import(directory.path(), "log.csv", &log, &COUNTS);
    let said = done.output + &done.messages;
    let share = said.split(" % of these rows are 0").next();
    let share = share.and_then(|before| before.rsplit(' ').next()?.parse::<f64>().ok());
    assert!(
        share.is_some_and(|share| (share - 66.7).abs() < 2.0),
        "{said}"
    );
}
