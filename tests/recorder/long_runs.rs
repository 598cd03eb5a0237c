//! Long recordings: no drift, wrap, growth or busy loop. `benches/soak.rs` measures the same in real time.
#![cfg(unix)]

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support;
use crate::support::command::{RunFile, finish, run, start};
use crate::support::process;
use firmware_protocol::{
    BoardFields, BoardMessage, EndReason, Hello, HostMessage, MAX_WIRE, PROTOCOL_VERSION, Sample,
    SampleFlags, ShortText,
};
use motorlab::board::rawlog;
use motorlab::board::{IdealBench, VirtualBoard, VirtualBoardOptions};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Samples of an hour at 3 ms.
const AN_HOUR: u64 = 1_200_000;

/// Checks every row of a run at 3 ms without holding it in memory; returns their number.
fn check_rows(path: &Path) -> u64 {
    let mut k = 0_u64;
    for line in BufReader::new(File::open(path).expect("a run file")).lines() {
        let line = line.expect("text");
        if line.starts_with('#') || line.starts_with("seq") {
            continue;
        }
        let micros = k * 3000;
        let start = format!("{k},{}.{:06},", micros / 1_000_000, micros % 1_000_000);
        assert!(line.starts_with(&start), "{line}");
        k += 1;
    }
    k
}

#[test]
fn an_accelerated_hour_is_complete_with_constant_memory() {
    let directory = tempfile::tempdir().expect("a directory");
    // micros() wraps after 55 minutes.
    let board = "virtual:?speed=max&micros_start=994967296";
    let arguments = ["capture", board, "--duration", "3600", "--json"];
    let child = start(directory.path(), &arguments);
    let path = directory.path().join("run.csv");
    let (mut early_kb, mut peak_kb) = (None, None);
    // Until it has ended: after that its memory cannot be read.
    let started = Instant::now();
    while started.elapsed() < Duration::from_secs(600) {
        let Some(now_kb) = process::peak_memory_kb(child.id()) else {
            break;
        };
        peak_kb = Some(now_kb);
        let written = path.metadata().map_or(0, |file| file.len());
        if early_kb.is_none() && written > 1_000_000 {
            early_kb = peak_kb;
        }
        sleep(Duration::from_millis(5));
    }
    let done = finish(child);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let json: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
    assert_eq!(json["samples"], AN_HOUR);
    assert_eq!(json["lost"], 0);
    assert_eq!(check_rows(&path), AN_HOUR);
    match (early_kb, peak_kb) {
        // The queue of a recorder without processor time may take 32 MB; an hour of samples kept in memory would take
        // 67 MB at 56 bytes each.
        (Some(early_kb), Some(peak_kb)) => {
            assert!(peak_kb < early_kb + 40_000, "{early_kb} to {peak_kb} kB");
        }
        _ => support::skip("memory of an_hour_in_accelerated_time", "no /proc"),
    }
}

#[test]
fn at_333_hertz_a_capture_uses_little_processor_time() {
    let board = VirtualBoard::spawn(IdealBench::new(100.0), VirtualBoardOptions::default());
    let board = board.expect("a virtual board");
    let directory = tempfile::tempdir().expect("a directory");
    let port = board.path().display().to_string();
    let child = start(directory.path(), &["capture", &port, "--duration", "5"]);
    sleep(Duration::from_secs(1));
    let before = process::cpu_s(child.id());
    let since = Instant::now();
    sleep(Duration::from_secs(3));
    let after = process::cpu_s(child.id());
    let elapsed_s = since.elapsed().as_secs_f64();
    let done = finish(child);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let (Some(before), Some(after)) = (before, after) else {
        return support::skip(
            "at_333_hertz_a_capture_uses_little_processor_time",
            "no /proc",
        );
    };
    // Below 2 % in a release build on an idle machine; a busy loop uses all it can get.
    let share = (after - before) / elapsed_s;
    assert!(share < 0.1, "{share}");
}

struct Board<W: Write> {
    log: rawlog::Writer<W>,
}

impl<W: Write> Board<W> {
    fn says(&mut self, host_us: u64, message: &BoardMessage) {
        let mut wire = [0; MAX_WIRE];
        let length = message.encode(&mut wire).expect("a message fits");
        self.log
            .from_board(host_us, &wire[..length])
            .expect("a disk");
    }

    fn is_told(&mut self, host_us: u64, message: &HostMessage) {
        let mut wire = [0; MAX_WIRE];
        let length = message.encode(&mut wire).expect("a message fits");
        self.log.to_board(host_us, &wire[..length]).expect("a disk");
    }
}

/// Samples of ten minutes at 3 ms.
const TEN_MINUTES: u32 = 200_000;

/// A raw log of ten minutes from a board whose crystal is `ppm` fast and whose `micros()` wraps in the middle. Each
/// read returns 0.3 to 4.4 ms late, as through a USB serial chip.
fn ten_minutes(path: &Path, ppm: f64, seed: u64) {
    let mut header = toml::Table::new();
    header.insert("port".to_owned(), "/dev/ttyACM0".into());
    header.insert("profile".to_owned(), "step".into());
    let file = BufWriter::new(File::create(path).expect("a file"));
    let log = rawlog::Writer::new(file, &header).expect("a disk");
    let mut board = Board { log };
    board.says(
        0,
        &BoardMessage::Hello(Hello {
            protocol_version: PROTOCOL_VERSION,
            firmware_version: (1, 0),
            boot_id: 7,
            sample_time_us: 3000,
            shortest_sample_time_us: 1000,
            counts_per_rev: 720,
            supply_mv: 4500,
            fields: BoardFields::default(),
            max_segments: 128,
            name: ShortText::new(b"crystal"),
        }),
    );
    let configure = HostMessage::Configure {
        sample_time_us: 3000,
        coast_at_zero: false,
    };
    board.is_told(10, &configure);
    board.is_told(
        20,
        &HostMessage::Start {
            samples: TEN_MINUTES,
        },
    );
    let mut noise = Pcg64::seed_from_u64(seed);
    let mut host_us = 0_u64;
    for k in 0..TEN_MINUTES {
        // Sample k is taken at k TS of the board's clock.
        let true_us = f64::from(k) * 3000.0 / (1.0 + ppm * 1e-6);
        let arrives = 1000.0 + true_us + noise.random_range(300.0..4400.0);
        host_us = host_us.max(arrives as u64);
        board.says(
            host_us,
            &BoardMessage::Data(Sample {
                sequence: k as u16,
                time_us: (k * 3000).wrapping_sub(300_000_000),
                counts: k as i32 / 7,
                command_mv: 0,
                flags: SampleFlags::default(),
                current_ma: None,
                supply_mv: None,
            }),
        );
    }
    board.says(
        host_us + 1,
        &BoardMessage::End {
            taken: TEN_MINUTES,
            dropped: 0,
            reason: EndReason::Complete,
        },
    );
    board.log.flush().expect("a disk");
}

#[test]
fn a_crystal_error_of_200_ppm_is_fitted_to_within_1_ppm() {
    for (ppm, seed) in [(200.0, 1), (-200.0, 2)] {
        let directory = tempfile::tempdir().expect("a directory");
        ten_minutes(&directory.path().join("raw.log"), ppm, seed);
        let done = run(directory.path(), &["replay", "raw.log"]);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let path = directory.path().join("run.csv");
        assert_eq!(check_rows(&path), u64::from(TEN_MINUTES));
        let file = RunFile::read(&path);
        assert_eq!(file.summary("lost"), 0);
        let number = |key: &str| file.header["summary"][key].as_float().expect("a number");
        let fitted = number("clock_fast_ppm");
        assert!((fitted - ppm).abs() < 1.0, "{ppm} fitted as {fitted}");
        // A uniform delay of width 4.1 ms has a standard deviation of 4.1 ms / sqrt(12); delays after a previous one
        // are slightly less spread.
        let residual_s = number("clock_residual_rms_s");
        let uniform_s = 4.1e-3 / 12_f64.sqrt();
        assert!(
            (0.7 * uniform_s..1.05 * uniform_s).contains(&residual_s),
            "{residual_s}"
        );
        // The time base is the board's clock nevertheless.
        assert_eq!(file.rows[199_999][1], "599.997000");
    }
}
