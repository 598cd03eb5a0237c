//! The raw logs in `fixtures/`, replayed directly and as a serial device, give the content of their bytes.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use crate::support::command::{Finished, RunFile, finish, run, start};
use crate::support::log_by_hand;

/// A log of a board with the wire protocol, and its content.
struct Fixture {
    name: &'static str,
    ts: &'static str,
    profile: &'static str,
    duration: &'static str,
    /// Samples taken by the board.
    taken: usize,
    lost: i64,
}

const FIXTURES: [Fixture; 4] = [
    Fixture {
        name: "step30.log",
        ts: "0.03",
        profile: "step",
        duration: "2",
        taken: 67,
        lost: 0,
    },
    Fixture {
        name: "step3.log",
        ts: "0.003",
        profile: "step",
        duration: "2",
        taken: 667,
        lost: 0,
    },
    Fixture {
        name: "reversing3.log",
        ts: "0.003",
        profile: "reversing",
        duration: "3",
        taken: 1000,
        lost: 0,
    },
    Fixture {
        name: "faults.log",
        ts: "0.003",
        profile: "step",
        duration: "1.5",
        taken: 500,
        lost: 17,
    },
];

fn path_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(name)
}

/// Captures from a log that is replayed as a serial device; `arguments` follow the port.
fn captured_from_device(directory: &Path, log: &Path, arguments: &[&str]) -> Finished {
    let log = log.display().to_string();
    let mut device = start(directory, &["replay", &log, "--pty", "--speed", "max"]);
    let mut port = String::new();
    BufReader::new(device.stdout.take().expect("a pipe"))
        .read_line(&mut port)
        .expect("a port");
    let mut all = vec!["capture", port.trim()];
    all.extend(arguments);
    let done = run(directory, &all);
    device.kill().expect("it runs");
    finish(device);
    done
}

/// `(seq, counts)` of a run's rows.
fn sequence_and_counts(file: &RunFile) -> Vec<(u64, i64)> {
    let counts = file.column("counts").into_iter().map(|n| n as i64);
    let sequence = file.column("seq").into_iter().map(|n| n as u64);
    sequence.zip(counts).collect()
}

#[test]
fn each_log_replays_to_the_samples_in_its_bytes() {
    for fixture in FIXTURES {
        let directory = tempfile::tempdir().expect("a directory");
        let log = path_of(fixture.name);
        let wanted = log_by_hand::frames(&log);
        assert_eq!(wanted.len() + fixture.lost as usize, fixture.taken);
        let done = run(directory.path(), &["replay", &log.display().to_string()]);
        assert_eq!(
            done.status,
            Some(i32::from(fixture.lost > 0)),
            "{}",
            done.messages
        );
        let file = RunFile::read(&directory.path().join("run.csv"));
        assert_eq!(sequence_and_counts(&file), wanted, "{}", fixture.name);
        assert_eq!(file.summary("lost"), fixture.lost);
        assert_eq!(file.header["profile"].as_str(), Some(fixture.profile));
        assert_eq!(file.complete(), fixture.lost == 0);
    }
}

#[test]
fn each_log_as_a_serial_device_is_captured_to_the_same_samples() {
    for fixture in FIXTURES {
        let directory = tempfile::tempdir().expect("a directory");
        let log = path_of(fixture.name);
        let arguments = [
            "--ts",
            fixture.ts,
            "--profile",
            fixture.profile,
            "--duration",
            fixture.duration,
        ];
        let done = captured_from_device(directory.path(), &log, &arguments);
        assert_eq!(
            done.status,
            Some(i32::from(fixture.lost > 0)),
            "{}",
            done.messages
        );
        let file = RunFile::read(&directory.path().join("run.csv"));
        assert_eq!(sequence_and_counts(&file), log_by_hand::frames(&log));
        assert_eq!(file.summary("lost"), fixture.lost, "{}", fixture.name);
        // The board's time, not that of the replaying device.
        let t_s = file.column("t_s");
        let ts: f64 = fixture.ts.parse().expect("a number");
        for (seq, t_s) in file.column("seq").iter().zip(t_s) {
            assert!((t_s - seq * ts).abs() < 1e-9);
        }
    }
}

#[test]
fn text_lines_of_a_sketch_are_replayed_and_captured_to_the_printed_numbers() {
    let directory = tempfile::tempdir().expect("a directory");
    let log = path_of("plain_sketch.log");
    let printed = log_by_hand::printed_numbers(&log);
    assert_eq!(printed.len(), 400);
    let replayed = run(
        directory.path(),
        &["replay", &log.display().to_string(), "-o", "direct.csv"],
    );
    assert_eq!(replayed.status, Some(0), "{}", replayed.messages);
    let arguments = [
        "--columns",
        "auto",
        "--supply",
        "4.5",
        "--duration",
        "2",
        "-o",
        "device.csv",
    ];
    let captured = captured_from_device(directory.path(), &log, &arguments);
    assert_eq!(captured.status, Some(0), "{}", captured.messages);
    for name in ["direct.csv", "device.csv"] {
        let file = RunFile::read(&directory.path().join(name));
        assert_eq!(file.header["sample_time_s"].as_float(), Some(0.005));
        assert_eq!(file.header["timing"].as_str(), Some("device"));
        let (t_s, counts) = (file.column("t_s"), file.column("counts"));
        let command_v = file.column("command_v");
        assert_eq!(t_s.len(), 400, "{name}");
        for (k, row) in printed.iter().enumerate() {
            assert_eq!(counts[k], row[1]);
            assert!((t_s[k] - (row[0] - printed[0][0]) * 1e-6).abs() < 1e-9);
            assert!((command_v[k] - row[2] / 255.0 * 4.5).abs() < 1e-6);
        }
    }
}

#[test]
fn the_recorded_board_agrees_with_the_simulated_motor_within_a_count() {
    let directory = tempfile::tempdir().expect("a directory");
    for name in ["step30", "step3", "reversing3", "plain_sketch"] {
        let log = path_of(&format!("{name}.log")).display().to_string();
        let csv = format!("{name}.csv");
        let replayed = run(directory.path(), &["replay", &log, "-o", &csv]);
        assert_eq!(replayed.status, Some(0), "{}", replayed.messages);
        let compared = run(directory.path(), &["compare", &csv, "--json"]);
        let document: serde_json::Value =
            serde_json::from_str(&compared.output).expect("one document");
        let rmse = &document["runs"][0]["position_rmse_counts"];
        let rmse = rmse.as_f64().expect("a number");
        // Quantization alone is 1/sqrt(12) = 0.289.
        assert!((0.2..0.35).contains(&rmse), "{name}: {rmse}");
    }
}
