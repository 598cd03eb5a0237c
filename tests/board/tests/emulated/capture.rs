//! `motorlab capture` of the emulated boards, through a pseudo-terminal, compared with the true events.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use emulated_board::bench::{MotorShaft, Shaft, SteadyShaft};
use emulated_board::board::{Board, seconds};
use emulated_board::line::{Line, LineError, LineOptions, Pace};
use emulated_board::truth::Truth;
use emulated_board::wiring::BoardKind;
use motorlab::board::faults::Faults;
use motorlab::board::pty::Pty;
use motorlab::motor::Motor;

use crate::command::{Finished, RunFile, run, start};
use crate::support::micros;

/// A recording: output of the command, its file, and the true events.
struct Recorded {
    finished: Finished,
    file: RunFile,
    truth: Truth,
}

impl Recorded {
    fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.finished.output).expect("one JSON document")
    }
}

fn record(kind: BoardKind, options: LineOptions, arguments: &[&str]) -> Recorded {
    let shaft = MotorShaft::new(&Motor::default()).expect("the default motor");
    record_shaft(kind, shaft, options, arguments)
}

fn record_shaft(
    kind: BoardKind,
    shaft: impl Shaft + 'static,
    options: LineOptions,
    arguments: &[&str],
) -> Recorded {
    let folder = tempfile::tempdir().expect("a directory");
    let directory = folder.path();
    let plugged = Plugged::new(kind, shaft, options);
    let mut all = vec!["--json", "capture", &plugged.path, "-o", "run.csv"];
    all.extend_from_slice(arguments);
    let finished = run(directory, &all);
    Recorded {
        file: RunFile::read(&directory.join("run.csv")),
        truth: plugged.unplug(),
        finished,
    }
}

/// A board on a line, in a thread.
struct Plugged {
    path: String,
    stop: Arc<AtomicBool>,
    line: JoinHandle<Result<Board, LineError>>,
}

impl Plugged {
    fn new(kind: BoardKind, shaft: impl Shaft + 'static, options: LineOptions) -> Self {
        let pty = Pty::open().expect("a pseudo-terminal");
        let path = pty.path().display().to_string();
        let stop = Arc::new(AtomicBool::new(false));
        let line = thread::spawn({
            let stop = Arc::clone(&stop);
            move || {
                let board = Board::new(kind, shaft).expect("a board");
                Line::new(board, pty, options).run(&stop)
            }
        });
        Self { path, stop, line }
    }

    fn unplug(self) -> Truth {
        self.stop.store(true, Ordering::Relaxed);
        let board = self.line.join().expect("no panic").expect("the board ran");
        board.truth().clone()
    }
}

/// Every row of the file is true; rows may be missing.
fn assert_rows_true(recorded: &Recorded) {
    let sequence = recorded.file.column("seq");
    let counts = recorded.file.column("counts");
    let t_s = recorded.file.column("t_s");
    let first = recorded.truth.ticks[sequence[0] as usize];
    assert!(!counts.is_empty());
    for (row, number) in sequence.iter().enumerate() {
        let tick = recorded.truth.ticks[*number as usize];
        assert_eq!(counts[row] as i64, tick.count, "row {row}");
        let true_us = micros(tick.entered - first.entered);
        assert!((t_s[row] * 1e6 - true_us).abs() <= 12.0, "row {row}");
    }
}

#[test]
fn a_capture_equals_the_truth_count_by_count() {
    for kind in BoardKind::ALL {
        for (sample_time, samples) in [("0.003", 667), ("0.03", 67)] {
            for profile in ["step", "reversing"] {
                let arguments = ["--ts", sample_time, "--profile", profile, "--duration", "2"];
                let recorded = record(kind, LineOptions::default(), &arguments);
                assert_eq!(recorded.finished.status, Some(0), "{:?}", recorded.finished);
                assert_eq!(recorded.file.rows.len(), samples);
                assert_eq!(recorded.truth.ticks.len(), samples);
                assert_rows_true(&recorded);
                let json = recorded.json();
                assert_eq!(json["lost"], 0);
                assert_eq!(json["statistics"]["overruns"], 0);
                let dt = &json["statistics"]["device_dt"];
                let sample_time_us = 1e6 * sample_time.parse::<f64>().expect("seconds");
                for (which, most_us) in [("min_us", 12.0), ("median_us", 4.0), ("max_us", 12.0)] {
                    let dt_us = dt[which].as_f64().expect("a number");
                    assert!((dt_us - sample_time_us).abs() <= most_us, "{dt}");
                }
                println!("{kind:?} {sample_time} {profile}: {dt}");
            }
        }
    }
}

#[test]
fn an_overrun_is_reported_to_the_end() {
    for kind in BoardKind::ALL {
        let arguments = ["--ts", "0.0001", "--duration", "0.5"];
        let recorded = record(kind, LineOptions::default(), &arguments);
        assert_eq!(recorded.finished.status, Some(1), "samples were lost");
        let json = recorded.json();
        assert!(json["statistics"]["overruns"].as_u64() > Some(0), "{json}");
        assert_eq!(json["samples_taken_by_board"], 5000);
        let sent = json["samples"].as_u64().expect("a number");
        let lost = json["lost"].as_u64().expect("a number");
        assert_eq!(sent + lost, 5000);
        let flags = recorded
            .file
            .rows
            .iter()
            .filter(|row| row.iter().any(|cell| cell.contains("overrun")));
        assert!(flags.count() > 10);
    }
}

#[test]
fn lost_edges_are_reported_to_the_end() {
    for kind in BoardKind::ALL {
        let arguments = ["--profile", "step", "--duration", "0.6"];
        let shaft = SteadyShaft::new(115_000.0);
        let recorded = record_shaft(kind, shaft, LineOptions::default(), &arguments);
        let json = recorded.json();
        let errors = json["statistics"]["encoder_errors"].as_u64();
        assert!(errors > Some(0), "{json}");
        let sequence = recorded.file.column("seq");
        let counts = recorded.file.column("counts");
        let wrong = (0..counts.len()).find(|&row| {
            let tick = recorded.truth.ticks[sequence[row] as usize];
            counts[row] as i64 != tick.count
        });
        let flagged = recorded
            .file
            .rows
            .iter()
            .position(|row| row.iter().any(|cell| cell.contains("encoder_error")));
        assert!(flagged.is_some() && flagged <= wrong.or(flagged));
    }
}

#[test]
fn a_reset_during_a_run_ends_the_file() {
    let options = LineOptions {
        reset_after_s: Some(0.6),
        ..LineOptions::default()
    };
    let recorded = record(BoardKind::Uno, options, &["--duration", "2"]);
    assert_eq!(recorded.finished.status, Some(3));
    assert_eq!(recorded.json()["ending"], "board_reset");
    assert!(
        !recorded.file.complete(),
        "a run that was cut off is not whole"
    );
    assert!((150..=200).contains(&recorded.file.rows.len()));
    assert_rows_true(&recorded);
    let (_, last) = recorded.truth.drives.last().expect("a drive");
    assert_eq!(last.motor_v, 0.0);
}

#[test]
fn damaged_bytes_lose_only_their_frames() {
    for seed in 1..=3 {
        let faults = Faults {
            flip: 1e-3,
            drop: 5e-4,
            seed,
            ..Faults::default()
        };
        let options = LineOptions {
            faults,
            ..LineOptions::default()
        };
        let recorded = record(BoardKind::Uno, options, &["--duration", "2"]);
        assert_eq!(recorded.finished.status, Some(1), "{:?}", recorded.finished);
        let json = recorded.json();
        let lost = json["lost"].as_u64().expect("a number");
        assert!((1..100).contains(&lost), "{lost}");
        assert_eq!(json["samples"].as_u64().expect("a number") + lost, 667);
        assert_rows_true(&recorded);
    }
}

#[test]
fn damaged_messages_to_the_board_are_sent_again() {
    let options = LineOptions {
        faults_to_board: Faults {
            flip: 0.02,
            seed: 3,
            ..Faults::default()
        },
        ..LineOptions::default()
    };
    let arguments = ["--profile", "staircase", "--duration", "1"];
    let recorded = record(BoardKind::Uno, options, &arguments);
    assert_eq!(recorded.finished.status, Some(0), "{:?}", recorded.finished);
    assert_rows_true(&recorded);
}

#[test]
fn a_capture_continues_through_the_wrap_of_micros() {
    for kind in BoardKind::ALL {
        let options = LineOptions {
            micros_at_start: Some(u32::MAX - 500_000),
            ..LineOptions::default()
        };
        let recorded = record(kind, options, &["--duration", "1.5"]);
        assert_eq!(recorded.finished.status, Some(0), "{:?}", recorded.finished);
        assert_eq!(recorded.file.rows.len(), 500);
        assert_rows_true(&recorded);
    }
}

#[test]
fn captures_from_the_same_initial_state_are_identical() {
    let rows = || {
        let recorded = record(
            BoardKind::Mega,
            LineOptions::default(),
            &["--duration", "1"],
        );
        // As text, without the host's times.
        let host_time = recorded
            .file
            .columns
            .iter()
            .position(|name| name == "host_t_s");
        let mut rows = recorded.file.rows;
        for row in &mut rows {
            row.remove(host_time.expect("the column host_t_s"));
        }
        rows
    };
    assert_eq!(rows(), rows());
}

/// In real time, since a held board stands still without messages.
#[test]
fn the_motor_stops_when_the_recorder_is_killed() {
    let options = LineOptions {
        pace: Pace::RealTime,
        ..LineOptions::default()
    };
    let folder = tempfile::tempdir().expect("a directory");
    let shaft = MotorShaft::new(&Motor::default()).expect("the default motor");
    let plugged = Plugged::new(BoardKind::Uno, shaft, options);
    let file = folder.path().join("run.csv");
    let arguments = ["capture", &plugged.path, "--duration", "60", "-o"];
    let mut capture = start(folder.path(), &[&arguments[..], &["run.csv"]].concat());
    let turns = || {
        let moving = |file: &RunFile| file.column("counts").last().is_some_and(|&n| n > 20.0);
        file.exists() && moving(&RunFile::read(&file))
    };
    while !turns() {
        assert_eq!(capture.try_wait().expect("a state"), None, "it ended");
        thread::sleep(Duration::from_millis(50));
    }
    capture.kill().expect("killed");
    capture.wait().expect("dead");
    // Enough even if the board's time falls behind the wall clock by half.
    thread::sleep(Duration::from_millis(1500));
    let truth = plugged.unplug();
    let (stopped, drive) = *truth.drives.last().expect("a drive");
    assert_eq!(drive.motor_v, 0.0);
    let after_s = seconds(stopped) - seconds(truth.last_received);
    assert!((0.4..0.5).contains(&after_s), "{after_s} s");
    let (_, before) = truth.drives[truth.drives.len() - 2];
    assert_eq!(before.motor_v, 4.5);
}

#[test]
fn a_capture_in_real_time_is_recorded() {
    let options = LineOptions {
        pace: Pace::RealTime,
        ..LineOptions::default()
    };
    // On a busy computer the link may correctly time out after half a second.
    let whole = (0..4).any(|_| {
        let recorded = record(BoardKind::Uno, options.clone(), &["--duration", "1"]);
        assert_rows_true(&recorded);
        recorded.file.complete()
    });
    assert!(whole, "four recordings in real time ended early");
}
