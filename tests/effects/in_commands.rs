//! Every effect of the catalogue in the three commands that take one: `simulate --motor`, `compare --motor`, `capture
//! "virtual:?effect=..."`; and axes that are driven by voltage, current or torque.

use std::fmt::Write as _;
use std::path::Path;

use crate::support::command::{RunFile, run};
use motorlab::motor::Motor;
use motorlab::motor::catalogue::{EffectKind, catalogue};

const SAMPLE_TIME_S: f64 = 0.003;

/// The keys of an effect with values in its plausible range, stronger than the defaults, so that a value that is not
/// passed on is visible.
fn values(kind: &EffectKind) -> Vec<(&'static str, f64)> {
    let parameters = Motor::default().parameters;
    kind.parameters
        .iter()
        .map(|p| {
            let (lo, hi) = p.range(&parameters, SAMPLE_TIME_S);
            let value = match p.key {
                "encoder_side" => 1.0,
                "counts_per_rev" => 500.0,
                // A level that the drive below has and whose loss is visible.
                "threshold_v" => 1.0,
                "phase_rad" => 0.4,
                "max_rate_hz" => 0.0,
                "time_constant_s" => 1.0,
                // Holds when the drive below returns to 0.9 V.
                "torque_nm" if kind.id == "static_friction" => hi,
                // Slips in every reversal of the drive below.
                "torque_nm" if kind.id == "slipping_clutch" => lo,
                // The shaft comes to rest near the middle of a count: at rest quantization is up to half a count.
                "gain" => 1.15,
                // The speed at full level is below the back-EMF limit.
                "rate_hz" => lo,
                _ => 0.5 * (hi + p.default(&parameters, SAMPLE_TIME_S)),
            };
            (p.key, value)
        })
        .collect()
}

/// A motor file with one effect, and the same as a virtual board.
fn motor_file(directory: &Path, kind: &EffectKind) -> (String, String) {
    let mut file = format!("[effects.{}]\n", kind.id);
    let mut board = format!("virtual:?speed=max&seed=3&effect={}", kind.id);
    for (key, value) in values(kind) {
        writeln!(file, "{key} = {value:?}").unwrap();
        write!(board, "&{key}={value:?}").unwrap();
    }
    let path = directory.join(format!("{}.toml", kind.id));
    std::fs::write(&path, file).unwrap();
    (path.to_str().unwrap().to_owned(), board)
}

/// Levels, slow motion and reversals, which excite every effect.
fn profile(directory: &Path, factor: f64) -> String {
    let levels = [
        (0.0, 0.0),
        (0.1, 4.5),
        (0.7, 0.0),
        (0.9, -3.0),
        (1.3, 0.9),
        (1.7, 0.45),
        (2.1, -0.9),
        (2.4, 2.0),
        (2.9, 0.0),
    ];
    let mut rows = String::from("t_s,command_v\n");
    for (t_s, level) in levels {
        writeln!(rows, "{t_s},{}", level * factor).unwrap();
    }
    let path = directory.join("levels.csv");
    std::fs::write(&path, rows).unwrap();
    path.to_str().unwrap().to_owned()
}

/// The gap that `compare` prints for a run against a motor file, or against the nominal motor.
fn gap_counts(directory: &Path, recorded: &str, motor: Option<&str>) -> f64 {
    let mut arguments = vec!["compare", recorded, "--json"];
    arguments.extend(motor.iter().flat_map(|path| ["--motor", path]));
    let done = run(directory, &arguments);
    assert_eq!(done.status, Some(0), "{recorded}: {}", done.messages);
    let document: serde_json::Value = serde_json::from_str(&done.output).unwrap();
    document["runs"][0]["position_rmse_counts"]
        .as_f64()
        .expect("a number")
}

#[test]
fn every_effect_is_simulated_captured_and_compared() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let profile = profile(directory, 1.0);
    let mut wrong = Vec::new();
    for kind in catalogue() {
        let id = kind.id;
        let (motor, board) = motor_file(directory, kind);
        let simulated = format!("{id}-simulated.csv");
        let captured = format!("{id}-captured.csv");
        let drive = ["--profile", &profile, "--duration", "3", "--ts", "0.003"];
        for head in [
            ["simulate", "--motor", &motor, "-o", &simulated],
            ["capture", &board, "--json", "-o", &captured],
        ] {
            let arguments: Vec<&str> = head.into_iter().chain(drive).collect();
            let done = run(directory, &arguments);
            assert_eq!(done.status, Some(0), "{id}: {}", done.messages);
        }
        for path in [&simulated, &captured] {
            assert!(RunFile::read(&directory.join(path)).rows.len() >= 1000);
            let with = gap_counts(directory, path, Some(&motor));
            let without = gap_counts(directory, path, None);
            // Quantization is 0.29 counts at most; randomly lost edges and late samples are more.
            let most = if kind.random { 8.0 } else { 0.35 };
            if with > most || without < with + 0.05 {
                wrong.push(format!(
                    "{path}: {with:.3} counts with the effect, {without:.3} without"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn axes_driven_by_current_or_torque_go_through_simulate_and_compare() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let mut wrong = Vec::new();
    for (unit, column, factor) in [
        ("v", "command_v", 1.0),
        ("a", "command_a", 0.013),
        ("nm", "command_nm", 0.0091),
    ] {
        let profile = profile(directory, factor);
        for kind in catalogue() {
            let (motor, _) = motor_file(directory, kind);
            let path = format!("{}-{unit}.csv", kind.id);
            let done = run(
                directory,
                &[
                    "simulate",
                    "--motor",
                    &motor,
                    "--profile",
                    &profile,
                    "--duration",
                    "3",
                    "--command",
                    unit,
                    "-o",
                    &path,
                ],
            );
            assert_eq!(done.status, Some(0), "{}: {}", kind.id, done.messages);
            assert!(
                RunFile::read(&directory.join(&path))
                    .columns
                    .iter()
                    .any(|name| name == column)
            );
            let gap = gap_counts(directory, &path, Some(&motor));
            if gap > if kind.random { 8.0 } else { 0.35 } {
                wrong.push(format!("{path}: {gap:.3} counts"));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
