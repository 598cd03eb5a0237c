//! Recorder and simulator compute the same speeds from the same counts: a board with the simulated counts is
//! recorded, and the two `velocity_rad_s` columns agree bitwise.
#![cfg(unix)]

use std::time::Duration;

use crate::support::command::{RunFile, run};
use motorlab::board::faults::Faults;
use motorlab::board::{
    Bench, Board, BoardOptions, Pace, Profile, VirtualBoard, VirtualBoardOptions,
};
use motorlab::recording::{CaptureRequest, SharedLive, capture};

const SAMPLE_TIME_US: u32 = 3_000;
const SAMPLES: u32 = 1_000;

/// Counts from a list, one per sample.
struct Counted {
    counts: Vec<i64>,
    sample: usize,
}

impl Bench for Counted {
    fn hold(&mut self, _: f64, until_s: f64) {
        self.sample = (until_s * 1e6 / f64::from(SAMPLE_TIME_US)).round() as usize;
    }

    fn counts(&mut self) -> i64 {
        self.counts[self.sample.min(self.counts.len() - 1)]
    }

    fn supply_v(&self) -> f64 {
        4.5
    }

    fn counts_per_rev(&self) -> f64 {
        720.0
    }
}

/// Simulates a run and records a board with the same counts; `(simulated, recorded)`.
fn the_same_counts(faults: Faults) -> (RunFile, RunFile) {
    let directory = tempfile::tempdir().expect("a directory");
    let arguments = [
        "simulate",
        "--ts",
        "0.003",
        "--profile",
        "reversing",
        "--duration",
        "2.997",
        "-o",
        "simulated.csv",
    ];
    let done = run(directory.path(), &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let simulated = RunFile::read(&directory.path().join("simulated.csv"));
    let counts: Vec<i64> = simulated
        .column("counts")
        .iter()
        .map(|&n| n as i64)
        .collect();
    assert_eq!(counts.len(), SAMPLES as usize);
    let options = VirtualBoardOptions {
        pace: Pace::AsFastAsPossible,
        faults,
        ..VirtualBoardOptions::default()
    };
    let bench = Counted { counts, sample: 0 };
    let plugged = VirtualBoard::spawn(bench, options).expect("a pseudo-terminal");
    let request = CaptureRequest {
        sample_time_us: SAMPLE_TIME_US,
        profile: Profile::named("reversing", 4.5, 2.997).expect("built in"),
        samples: SAMPLES,
        counts_per_rev: None,
        supply_v: None,
        output: directory.path().join("recorded.csv"),
        port: "virtual:".to_owned(),
        usb: None,
        further: toml::Table::new(),
    };
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let captured = runtime.block_on(async {
        let options = BoardOptions {
            baud: 115_200,
            patience: Duration::from_secs(6),
            log: None,
        };
        let mut board = Board::open(plugged.path(), options).await.expect("a board");
        let never = std::future::pending();
        capture(&mut board, &request, &SharedLive::default(), never).await
    });
    let captured = captured.expect("a recording");
    (simulated, RunFile::read(&captured.path))
}

#[test]
fn the_same_counts_give_the_same_speeds() {
    let (simulated, recorded) = the_same_counts(Faults::default());
    assert_eq!(recorded.column("counts"), simulated.column("counts"));
    let speeds = |file: &RunFile| -> Vec<u64> {
        let column = file.column("velocity_rad_s");
        column.into_iter().map(f64::to_bits).collect()
    };
    assert_eq!(speeds(&recorded), speeds(&simulated));
    let moving = recorded.column("velocity_rad_s");
    assert!(moving.iter().any(|&w| w > 5.0) && moving.iter().any(|&w| w < -5.0));
}

#[test]
fn after_a_loss_recorder_and_simulator_divide_by_the_same_samples() {
    let faults = Faults {
        drop: 0.002,
        seed: 3,
        ..Faults::default()
    };
    let (simulated, recorded) = the_same_counts(faults);
    let simulated = simulated.column("velocity_rad_s");
    let (seq, speeds) = (recorded.column("seq"), recorded.column("velocity_rad_s"));
    let mut over_losses = 0;
    for k in 1..seq.len() {
        let (from, to) = (seq[k - 1] as usize, seq[k] as usize);
        over_losses += usize::from(to - from > 1);
        // The mean of the simulator's speeds over the elapsed samples.
        let mean = simulated[from + 1..=to].iter().sum::<f64>() / (to - from) as f64;
        assert!((speeds[k] - mean).abs() < 1e-9, "row {k}");
    }
    assert!(over_losses > 5, "{over_losses}");
}
