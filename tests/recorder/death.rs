//! Files after the end of the recorder, its disk or its board: everything up to 50 ms before, a message that names
//! the event, the right exit status.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant};

use crate::support;
use crate::support::command::{Finished, RunFile, finish, motorlab, start};
use crate::support::process;
use motorlab::board::{Bench, VirtualBoard, VirtualBoardOptions};

/// Sample time of these recordings in s.
const TS: f64 = 0.003;

/// Samples that may be missing at the end: 50 ms of them, and the current one.
const BOUND: i64 = (0.050 / TS) as i64 + 2;

/// Samples to wait for before the event, taken in less than the half second for which a busy computer may leave the
/// board without a message.
const SOME: i64 = 120;

/// A small file system, unmounted on drop.
struct Disk(tempfile::TempDir);

impl Disk {
    /// `None` if this user cannot mount one: the test is then reported as skipped.
    fn new(test: &str, options: &str) -> Option<Self> {
        let folder = tempfile::tempdir().expect("a directory");
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", options, "tmpfs"])
            .arg(folder.path())
            .stderr(Stdio::null())
            .status();
        if mounted.is_ok_and(|status| status.success()) {
            return Some(Self(folder));
        }
        support::skip(test, "may not mount a tmpfs");
        None
    }

    fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let unmounted = Command::new("umount").arg(self.path()).status();
        let is_gone = unmounted.is_ok_and(|status| status.success());
        assert!(is_gone || std::thread::panicking(), "the disk stays");
    }
}

/// A bench whose counts are the number of samples taken so far.
struct SampleCounter(Arc<AtomicI64>);

impl Bench for SampleCounter {
    fn hold(&mut self, _: f64, _: f64) {}

    fn counts(&mut self) -> i64 {
        self.0.fetch_add(1, Ordering::Relaxed)
    }

    fn supply_v(&self) -> f64 {
        4.5
    }

    fn counts_per_rev(&self) -> f64 {
        720.0
    }
}

/// A board in this process, and its number of samples.
fn a_board() -> (VirtualBoard, Arc<AtomicI64>) {
    let taken = Arc::new(AtomicI64::new(0));
    let bench = SampleCounter(Arc::clone(&taken));
    let board = VirtualBoard::spawn(bench, VirtualBoardOptions::default());
    (board.expect("a pseudo-terminal"), taken)
}

fn wait_for(taken: &AtomicI64, samples: i64) {
    let until = Instant::now() + Duration::from_secs(20);
    while taken.load(Ordering::Relaxed) < samples {
        assert!(Instant::now() < until, "the recording does not start");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Runs a test whose bounds are in milliseconds. A computer may give the recorder no processor time for so long: up
/// to four attempts, of which one must pass.
fn with_processor_time(test: fn()) {
    let held = (0..3).any(|_| std::panic::catch_unwind(test).is_ok());
    if !held {
        test();
    }
}

fn send(signal: &str, child: &Child) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args([signal, &pid]).status();
    assert!(sent.expect("kill runs").success());
}

/// Every row is complete, none is missing, and the last one is at most 50 ms older than `taken`.
fn holds_everything_up_to(file: &RunFile, taken: i64) {
    for (k, counts) in file.column("counts").iter().enumerate() {
        assert_eq!(*counts, k as f64);
    }
    let rows = file.rows.len() as i64;
    assert!(rows >= taken - BOUND, "{rows} rows of {taken} samples");
}

/// Starts a capture of 10 s, waits for some samples, and applies `act` to it.
fn interrupted(act: impl FnOnce(&mut Child, &Path)) -> (Finished, Option<RunFile>, i64) {
    let (board, taken) = a_board();
    let directory = tempfile::tempdir().expect("a directory");
    let port = board.path().display().to_string();
    let mut child = start(directory.path(), &["capture", &port, "--duration", "10"]);
    wait_for(&taken, SOME);
    let at_that_time = taken.load(Ordering::Relaxed);
    act(&mut child, directory.path());
    let done = finish(child);
    let path = directory.path().join("run.csv");
    let file = path.exists().then(|| RunFile::read(&path));
    (done, file, at_that_time)
}

#[test]
fn a_kill_loses_at_most_fifty_milliseconds() {
    with_processor_time(|| {
        let (done, file, taken) = interrupted(|child, _| child.kill().expect("it runs"));
        assert_eq!(done.status, None);
        let file = file.expect("a file");
        holds_everything_up_to(&file, taken);
        assert!(!file.complete());
    });
}

#[test]
fn a_stop_request_ends_the_file_and_the_motor() {
    with_processor_time(|| {
        for signal in ["-INT", "-TERM", "-HUP"] {
            let (done, file, taken) = interrupted(|child, _| send(signal, child));
            assert_eq!(done.status, Some(1), "{signal}: {}", done.messages);
            assert!(
                done.messages.contains("stopped before the time asked for"),
                "{}",
                done.messages
            );
            let file = file.expect("a file");
            // Until the board itself has stopped: nothing is missing.
            holds_everything_up_to(&file, taken + BOUND);
            assert!(file.complete());
            assert_eq!(file.summary("lost"), 0);
            assert_eq!(file.header["summary"]["ending"].as_str(), Some("stopped"));
        }
    });
}

#[test]
fn closed_pipes_do_not_end_the_recorder() {
    let (board, taken) = a_board();
    let directory = tempfile::tempdir().expect("a directory");
    let port = board.path().display().to_string();
    let arguments = ["capture", &port, "--duration", "1.5", "--json"];
    let mut child = start(directory.path(), &arguments);
    // As `| head` after its last line, on both pipes.
    drop(child.stdout.take());
    drop(child.stderr.take());
    wait_for(&taken, SOME);
    // And as a shell may send it.
    send("-PIPE", &child);
    let done = finish(child);
    assert_eq!(done.status, Some(0));
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!((file.rows.len(), file.complete()), (500, true));
}

#[test]
fn a_limit_on_file_sizes_ends_the_file_with_a_complete_row() {
    let (board, _) = a_board();
    let directory = tempfile::tempdir().expect("a directory");
    // 24 blocks of 512 or 1024 bytes, by the shell.
    let script = "ulimit -f 24; exec \"$0\" capture \"$1\" --duration 10";
    let child = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_motorlab")])
        .arg(board.path())
        .current_dir(directory.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    let done = finish(child);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(
        done.messages.contains("run.csv") && done.messages.contains("ulimit -f"),
        "{}",
        done.messages
    );
    ends_with_a_whole_row(&directory.path().join("run.csv"), &done, 12_288);
}

/// The file is as full as possible, to the row, and the message has its number of rows.
fn ends_with_a_whole_row(path: &Path, done: &Finished, at_least: usize) {
    let text = std::fs::read_to_string(path).expect("a file");
    assert!(text.ends_with('\n'));
    assert!(text.len() > at_least - 100, "{}", text.len());
    let file = RunFile::read(path);
    holds_everything_up_to(&file, 0);
    assert!(!file.complete());
    let said = format!("it holds {} whole rows", file.rows.len());
    assert!(done.messages.contains(&said), "{said}: {}", done.messages);
}

#[test]
fn a_full_disk_ends_the_file_with_a_complete_row() {
    let Some(disk) = Disk::new("a_full_disk_ends_the_file_with_a_complete_row", "size=16k") else {
        return;
    };
    let (board, _) = a_board();
    let port = board.path().display().to_string();
    let child = start(disk.path(), &["capture", &port, "--duration", "10"]);
    let done = finish(child);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(
        done.messages.contains("make room on this disk"),
        "{}",
        done.messages
    );
    ends_with_a_whole_row(&disk.path().join("run.csv"), &done, 12_288);
}

#[test]
fn a_full_disk_during_a_replay_is_reported_with_its_rows() {
    let Some(disk) = Disk::new(
        "a_full_disk_during_a_replay_is_reported_with_its_rows",
        "size=16k",
    ) else {
        return;
    };
    let directory = tempfile::tempdir().expect("a directory");
    let capture = [
        "capture",
        "virtual:?speed=max",
        "--duration",
        "3",
        "--log",
        "raw.log",
    ];
    let recorded = finish(start(directory.path(), &capture));
    let run = disk.path().join("again.csv").display().to_string();
    let replay = ["replay", "raw.log", "-o", &run, "--json"];
    let done = finish(start(directory.path(), &replay));
    let rows = std::fs::read_to_string(&run).map(|text| {
        let rows = text.lines().filter(|line| !line.starts_with('#'));
        rows.count() - 1
    });
    assert_eq!(recorded.status, Some(0), "{}", recorded.messages);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    let (rows, error) = (rows.expect("a file"), done.output);
    let error: serde_json::Value = serde_json::from_str(&error).expect("a document");
    assert_eq!(error["error"]["row"], rows, "{error}");
    assert_eq!(error["error"]["file"], run.as_str());
    let said = format!("it holds {rows} whole rows");
    assert!(done.messages.contains(&said), "{said}: {}", done.messages);
}

#[test]
fn a_raw_log_on_a_full_disk_ends_and_the_recording_does_not() {
    let Some(disk) = Disk::new(
        "a_raw_log_on_a_full_disk_ends_and_the_recording_does_not",
        "size=16k",
    ) else {
        return;
    };
    let directory = tempfile::tempdir().expect("a directory");
    let (board, _) = a_board();
    let port = board.path().display().to_string();
    let log = disk.path().join("raw.log").display().to_string();
    let arguments = ["capture", &port, "--duration", "1.5", "--log", &log];
    let done = finish(start(directory.path(), &arguments));
    assert_eq!(done.status, Some(3), "{}", done.messages);
    for said in [log.as_str(), "run.csv holds 500 rows"] {
        assert!(done.messages.contains(said), "{}", done.messages);
    }
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!(file.rows.len(), 500);
}

#[test]
fn a_run_file_truncated_by_another_program_is_reported() {
    let (board, taken) = a_board();
    let directory = tempfile::tempdir().expect("a directory");
    let port = board.path().display().to_string();
    let child = start(directory.path(), &["capture", &port, "--duration", "10"]);
    while taken.load(Ordering::Relaxed) < 100 {
        std::thread::sleep(Duration::from_millis(10));
    }
    let path = directory.path().join("run.csv");
    let file = std::fs::File::options().write(true).open(&path);
    file.expect("a file").set_len(50).expect("it can be cut");
    let done = finish(child);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(
        done.messages.contains("changed by another program") && done.messages.contains("run.csv"),
        "{}",
        done.messages
    );
    assert_eq!(std::fs::metadata(&path).expect("a file").len(), 50);
}

#[test]
fn an_unwritable_directory_is_reported_before_the_motor_turns() {
    let (board, taken) = a_board();
    let directory = tempfile::tempdir().expect("a directory");
    let port = board.path().display().to_string();
    for (output, hint) in [
        ("/proc/run.csv", "cannot create /proc/run.csv"),
        ("nowhere/run.csv", "there is no folder nowhere"),
    ] {
        let arguments = ["capture", &port, "-o", output];
        let done = finish(start(directory.path(), &arguments));
        assert_eq!(done.status, Some(3), "{}", done.messages);
        assert!(done.messages.contains(hint), "{}", done.messages);
    }
    assert_eq!(taken.load(Ordering::Relaxed), 0);
}

#[test]
fn a_read_only_disk_is_reported_before_the_motor_turns() {
    let Some(disk) = Disk::new("a_read_only_disk_is_said", "ro,size=16k") else {
        return;
    };
    let (board, taken) = a_board();
    let port = board.path().display().to_string();
    let done = finish(start(disk.path(), &["capture", &port]));
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(
        done.messages.contains("this disk is read-only"),
        "{}",
        done.messages
    );
    assert_eq!(taken.load(Ordering::Relaxed), 0);
}

#[test]
fn a_deleted_directory_loses_no_sample() {
    let (board, taken) = a_board();
    let outer = tempfile::tempdir().expect("a directory");
    let inner = outer.path().join("lab");
    std::fs::create_dir(&inner).expect("a directory");
    let port = board.path().display().to_string();
    let output = inner.join("vanished-run.csv").display().to_string();
    let arguments = ["capture", &port, "--duration", "2", "-o", &output];
    let child = start(outer.path(), &arguments);
    wait_for(&taken, SOME);
    std::fs::remove_dir_all(&inner).expect("it is there");
    let done = finish(child);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(
        done.messages.contains("vanished while it was written"),
        "{}",
        done.messages
    );
    assert!(done.messages.contains("is in vanished-run.csv"));
    let file = RunFile::read(&outer.path().join("vanished-run.csv"));
    assert_eq!((file.rows.len(), file.complete()), (667, true));
    holds_everything_up_to(&file, 667);
}

#[test]
fn a_recorder_suspended_for_two_seconds_has_every_buffered_sample() {
    with_processor_time(|| {
        let (board, taken) = a_board();
        let directory = tempfile::tempdir().expect("a directory");
        let port = board.path().display().to_string();
        let child = start(directory.path(), &["capture", &port, "--duration", "10"]);
        wait_for(&taken, SOME);
        send("-STOP", &child);
        std::thread::sleep(Duration::from_secs(2));
        // The board has received nothing for 0.5 s and has switched the motor off.
        let stopped_at = taken.load(Ordering::Relaxed);
        send("-CONT", &child);
        let done = finish(child);
        assert_eq!(taken.load(Ordering::Relaxed), stopped_at);
        assert_eq!(done.status, Some(3), "{}", done.messages);
        assert!(
            done.messages.contains("hint: the computer was suspended"),
            "{}",
            done.messages
        );
        let file = RunFile::read(&directory.path().join("run.csv"));
        assert_eq!(file.rows.len() as i64, stopped_at);
        assert_eq!(file.summary("lost"), 0);
        assert_eq!(file.header["summary"]["ending"].as_str(), Some("link_lost"));
    });
}

#[test]
fn a_briefly_suspended_recorder_loses_no_sample() {
    with_processor_time(|| {
        let (done, file, _) = interrupted(|child, _| {
            send("-STOP", child);
            std::thread::sleep(Duration::from_millis(200));
            send("-CONT", child);
            std::thread::sleep(Duration::from_millis(200));
            send("-INT", child);
        });
        assert_eq!(done.status, Some(1), "{}", done.messages);
        assert_eq!(file.expect("a file").summary("lost"), 0);
    });
}

#[test]
fn a_clock_that_is_set_back_changes_nothing() {
    let directory = tempfile::tempdir().expect("a directory");
    let shim = directory.path().join("clock.so");
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .arg(&shim)
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/support/clock_set_back.c"
        ))
        .status();
    if !built.is_ok_and(|status| status.success()) {
        return support::skip("a_clock_that_is_set_back_changes_nothing", "no C compiler");
    }
    let (board, _) = a_board();
    let port = board.path().display().to_string();
    let child = motorlab(directory.path(), &["capture", &port, "--duration", "1.5"])
        .env("LD_PRELOAD", &shim)
        .spawn()
        .expect("the command starts");
    let done = finish(child);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!(file.rows.len(), 500);
    for name in ["t_s", "host_t_s"] {
        let times = file.column(name);
        assert!(times.windows(2).all(|pair| pair[1] >= pair[0]), "{name}");
        assert!(times[499] - times[0] < 2.5, "{name}");
    }
}

#[test]
fn an_unplugged_board_ends_the_file_and_uses_no_processor_time() {
    with_processor_time(|| {
        let (board, taken) = a_board();
        let directory = tempfile::tempdir().expect("a directory");
        let port = board.path().display().to_string();
        let child = start(directory.path(), &["capture", &port, "--duration", "10"]);
        wait_for(&taken, SOME);
        drop(board);
        let unplugged = Instant::now();
        let taken = taken.load(Ordering::Relaxed);
        let done = finish(child);
        assert!(unplugged.elapsed() < Duration::from_secs(2));
        assert_eq!(done.status, Some(3));
        assert!(
            done.messages
                .contains("the board was unplugged; the file ends there"),
            "{}",
            done.messages
        );
        let file = RunFile::read(&directory.path().join("run.csv"));
        holds_everything_up_to(&file, taken);
    });
}

/// A board with the name `name`.
fn a_board_named(name: &str) -> VirtualBoard {
    let mut options = VirtualBoardOptions::default();
    options.firmware.name = name.to_owned();
    VirtualBoard::spawn(SampleCounter(Arc::default()), options).expect("a pseudo-terminal")
}

/// Points the link to the board's port, as udev does for `/dev/serial/by-id`.
fn plug_in(board: &VirtualBoard, link: &Path) {
    let _ = std::fs::remove_file(link);
    std::os::unix::fs::symlink(board.path(), link).expect("a link");
}

#[test]
fn a_board_that_comes_back_opens_a_new_segment_and_another_board_does_not() {
    let directory = tempfile::tempdir().expect("a directory");
    let link = directory.path().join("lab-board");
    let ours = a_board_named("uno 7");
    plug_in(&ours, &link);
    let port = link.display().to_string();
    let arguments = [
        "capture",
        &port,
        "--duration",
        "1.5",
        "--reconnect",
        "--json",
    ];
    let child = start(directory.path(), &arguments);
    std::thread::sleep(Duration::from_millis(900));
    drop(ours);
    // Another board takes its name first.
    let other = a_board_named("uno 8");
    plug_in(&other, &link);
    std::thread::sleep(Duration::from_millis(900));
    assert!(!directory.path().join("run-2.csv").exists());
    let ours = a_board_named("uno 7");
    plug_in(&ours, &link);
    let done = finish(child);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    for said in [
        "the board is gone",
        "another board (uno 8)",
        "the board is back",
    ] {
        assert!(done.messages.contains(said), "{said}: {}", done.messages);
    }
    let first = RunFile::read(&directory.path().join("run.csv"));
    let second = RunFile::read(&directory.path().join("run-2.csv"));
    assert!(!first.complete() && first.rows.len() > 100 && first.rows.len() < 400);
    assert!(second.complete());
    assert_eq!(second.rows.len(), 500);
    assert_eq!(second.header["segment"].as_integer(), Some(2));
    assert_eq!(second.header["segment_before"].as_str(), Some("run.csv"));
    let json: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
    assert_eq!(json["segments_before"][0]["path"], "run.csv");
}

#[test]
fn a_stop_while_waiting_for_the_board_reports_the_recorded_samples() {
    with_processor_time(|| {
        let directory = tempfile::tempdir().expect("a directory");
        let (board, taken) = a_board();
        let port = board.path().display().to_string();
        let arguments = [
            "capture",
            &port,
            "--duration",
            "10",
            "--reconnect",
            "--json",
            "--log",
            "raw.log",
        ];
        let child = start(directory.path(), &arguments);
        wait_for(&taken, SOME);
        drop(board);
        // Until it waits, and for a while after that.
        std::thread::sleep(Duration::from_millis(500));
        let before = process::cpu_s(child.id());
        std::thread::sleep(Duration::from_secs(2));
        let after = process::cpu_s(child.id());
        if let (Some(before), Some(after)) = (before, after) {
            // A busy loop uses all available processor time.
            assert!(after - before < 0.4, "{} s of 2 s", after - before);
        }
        send("-INT", &child);
        let done = finish(child);
        assert_eq!(done.status, Some(3), "{}", done.messages);
        assert!(
            done.messages
                .contains("stopped; the board did not come back"),
            "{}",
            done.messages
        );
        let json: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
        assert_eq!(
            (&json["ending"], &json["lost"]),
            (&"unplugged".into(), &0.into())
        );
        let file = RunFile::read(&directory.path().join("run.csv"));
        assert_eq!(json["samples"], file.rows.len());
        holds_everything_up_to(&file, taken.load(Ordering::Relaxed));
    });
}
