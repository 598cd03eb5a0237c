//! Raw logs: `capture --log` writes them, `replay` plays them, through the decoder or as a serial device.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::time::Instant;

use crate::support::command;
use crate::support::command::{RunFile, finish, run, start};
use firmware_protocol::{FrameDecoder, HostMessage, MAX_WIRE};
use motorlab::board::rawlog::{Event, Reader, Writer};

/// A run with its raw log.
fn recorded(directory: &Path) -> RunFile {
    let done = run(
        directory,
        &[
            "capture",
            "virtual:?speed=20",
            "--profile",
            "reversing",
            "--duration",
            "3",
            "-o",
            "first.csv",
            "--log",
            "raw.log",
        ],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    RunFile::read(&directory.join("first.csv"))
}

#[test]
fn a_log_replays_to_the_same_rows() {
    let directory = tempfile::tempdir().expect("a directory");
    let first = recorded(directory.path());
    let done = run(directory.path(), &["replay", "raw.log", "-o", "again.csv"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let again = RunFile::read(&directory.path().join("again.csv"));
    assert_eq!(again.rows, first.rows);
    assert!(again.complete());
    for key in ["sample_time_s", "counts_per_rev", "supply_v", "profile"] {
        assert_eq!(again.header[key], first.header[key]);
    }
}

#[test]
fn a_log_as_a_serial_device_is_captured_again() {
    let directory = tempfile::tempdir().expect("a directory");
    let first = recorded(directory.path());
    let mut device = start(
        directory.path(),
        &["replay", "raw.log", "--pty", "--speed", "max"],
    );
    let mut port = String::new();
    BufReader::new(device.stdout.take().expect("a pipe"))
        .read_line(&mut port)
        .expect("a port");
    let port = port.trim();
    let capture = |ts: &str, name: &str| {
        let arguments = [
            "capture",
            port,
            "--ts",
            ts,
            "--profile",
            "reversing",
            "--duration",
            "3",
            "-o",
            name,
        ];
        run(directory.path(), &arguments)
    };
    // Only the recorded sample time can be played.
    let refused = capture("0.03", "slow.csv");
    assert_eq!(refused.status, Some(2), "{}", refused.messages);
    assert!(refused.messages.contains("cannot keep this sample time"));
    for name in ["second.csv", "third.csv"] {
        let done = capture("0.003", name);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let again = RunFile::read(&directory.path().join(name));
        for column in ["seq", "t_s", "command_v", "counts"] {
            assert_eq!(again.column(column), first.column(column));
        }
    }
    device.kill().expect("it runs");
    finish(device);
}

#[test]
fn a_speed_factor_scales_the_replay_time() {
    let directory = tempfile::tempdir().expect("a directory");
    let first = recorded(directory.path());
    let log = std::fs::read_to_string(directory.path().join("raw.log")).expect("a log");
    let arrivals: Vec<u64> = log
        .lines()
        .filter_map(|line| line.split_once(" <")?.0.trim().parse().ok())
        .collect();
    let from_first_s = (arrivals[arrivals.len() - 1] - arrivals[0]) as f64 * 1e-6;
    // Not faster than requested: a busy computer can only delay it.
    let begun = Instant::now();
    let arguments = ["replay", "raw.log", "--speed", "0.5", "-o", "slow.csv"];
    let done = run(directory.path(), &arguments);
    assert!(begun.elapsed().as_secs_f64() > from_first_s / 0.5);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let slow = RunFile::read(&directory.path().join("slow.csv"));
    assert_eq!(slow.rows, first.rows);
}

#[test]
fn a_truncated_log_replays_up_to_its_end_and_is_reported() {
    let directory = tempfile::tempdir().expect("a directory");
    let first = recorded(directory.path());
    let log = std::fs::read(directory.path().join("raw.log")).expect("a log");
    let half = log.len() / 2;
    std::fs::write(directory.path().join("torn.log"), &log[..half]).expect("a file");
    let done = run(directory.path(), &["replay", "torn.log", "-o", "torn.csv"]);
    assert_eq!(done.status, Some(1));
    assert!(done.messages.contains("ends before the recording does"));
    let torn = RunFile::read(&directory.path().join("torn.csv"));
    assert!(!torn.complete());
    assert!(torn.rows.len() > 300, "{}", torn.rows.len());
    assert_eq!(torn.rows[..], first.rows[..torn.rows.len()]);
}

/// An invalid line in the middle ends the run there: every row before it is in the file, and reported.
#[test]
fn a_log_damaged_in_the_middle_gives_the_rows_before_and_their_number() {
    let directory = tempfile::tempdir().expect("a directory");
    let first = recorded(directory.path());
    let damaged = |name: &str| {
        let text = std::fs::read_to_string(directory.path().join(name)).expect("a log");
        let mut lines: Vec<&str> = text.lines().collect();
        let at = lines.len() * 3 / 4;
        lines[at] = "nothing";
        std::fs::write(directory.path().join("damaged.log"), lines.join("\n")).expect("a file");
        at + 1
    };
    let is_said = |done: &command::Finished, line: usize, rows: usize| {
        assert_eq!(done.status, Some(2), "{}", done.messages);
        let said =
            format!("damaged.csv holds {rows} rows, and the log gives no more: line {line} ");
        assert!(done.messages.contains(&said), "{said}: {}", done.messages);
        let error: serde_json::Value = serde_json::from_str(&done.output).expect("a document");
        assert_eq!(error["error"]["row"], line, "{error}");
    };
    let arguments = ["replay", "damaged.log", "-o", "damaged.csv", "--json"];
    let line = damaged("raw.log");
    let done = run(directory.path(), &arguments);
    let file = RunFile::read(&directory.path().join("damaged.csv"));
    assert!(
        !file.complete() && file.rows.len() > 300,
        "{}",
        file.rows.len()
    );
    assert_eq!(file.rows[..], first.rows[..file.rows.len()]);
    is_said(&done, line, file.rows.len());
    // The same for text lines of a plain sketch.
    std::fs::remove_file(directory.path().join("damaged.csv")).expect("a file");
    let mut plain =
        String::from("# format = \"motorlab-rawlog/1\"\n# columns = \"t_us,counts,pwm\"\n");
    for k in 0..400 {
        let at = k * 10_000;
        writeln!(plain, "{at} < \"{at},{},255\\r\\n\"", 3 * k).expect("a text");
    }
    std::fs::write(directory.path().join("plain.log"), plain).expect("a file");
    let line = damaged("plain.log");
    let done = run(directory.path(), &arguments);
    let file = RunFile::read(&directory.path().join("damaged.csv"));
    // After two lines of header; the first line may be incomplete, and is left out.
    assert_eq!(file.rows.len(), line - 4, "{}", done.messages);
    is_said(&done, line, file.rows.len());
}

#[test]
fn a_file_that_is_no_raw_log_is_refused_with_its_first_line() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("x.csv"), "t_s,counts\n0,1\n").expect("a file");
    let done = run(directory.path(), &["replay", "x.csv"]);
    assert_eq!(done.status, Some(2));
    assert!(
        done.messages.contains("x.csv: this is no raw log") && done.messages.contains("t_s,counts"),
        "{}",
        done.messages
    );
    let done = run(directory.path(), &["replay", "missing.log"]);
    assert_eq!(done.status, Some(2));
    let bad = "# format = \"motorlab-rawlog/1\"\n12 < zz\n";
    std::fs::write(directory.path().join("bad.log"), bad).expect("a file");
    let done = run(directory.path(), &["replay", "bad.log"]);
    assert_eq!(done.status, Some(2));
    assert!(done.messages.contains("bad.log: line 2 of the raw log"));
}

/// Rewrites `raw.log` as `told.log`, with the host's messages mapped by `retell`, which drops a message by returning
/// `None`.
fn retold(directory: &Path, retell: impl Fn(HostMessage) -> Option<HostMessage>) {
    let log = File::open(directory.join("raw.log")).expect("a log");
    let mut log = Reader::new(BufReader::new(log)).expect("a raw log");
    let told = File::create(directory.join("told.log")).expect("a disk");
    let mut told = Writer::new(told, log.header()).expect("a disk");
    let mut decoder = FrameDecoder::new();
    while let Some((at_us, event)) = log.next_event().expect("a whole log") {
        match event {
            Event::FromBoard(bytes) => told.from_board(at_us, &bytes).expect("a disk"),
            Event::HangUp => told.hang_up(at_us).expect("a disk"),
            Event::ToBoard(bytes) => {
                for byte in bytes {
                    let Some(Ok(frame)) = decoder.push(byte) else {
                        continue;
                    };
                    let message = HostMessage::parse(frame).expect("a message of our own");
                    let mut wire = [0; MAX_WIRE];
                    if let Some(message) = retell(message) {
                        let length = message.encode(&mut wire).expect("room");
                        told.to_board(at_us, &wire[..length]).expect("a disk");
                    }
                }
            }
        }
    }
}

#[test]
fn a_log_without_a_sample_time_is_no_recording() {
    let directory = tempfile::tempdir().expect("a directory");
    let first = recorded(directory.path());
    let replay = || run(directory.path(), &["replay", "told.log", "-o", "told.csv"]);
    retold(directory.path(), Some);
    let done = replay();
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let told = directory.path().join("told.csv");
    assert_eq!(RunFile::read(&told).rows, first.rows);
    std::fs::remove_file(&told).expect("a file");

    retold(directory.path(), |message| {
        (!matches!(message, HostMessage::Configure { .. })).then_some(message)
    });
    let without = replay();
    retold(directory.path(), |message| match message {
        HostMessage::Configure { coast_at_zero, .. } => Some(HostMessage::Configure {
            sample_time_us: 0,
            coast_at_zero,
        }),
        other => Some(other),
    });
    for done in [without, replay()] {
        assert_eq!(done.status, Some(2), "{}", done.messages);
        let why = "the raw log holds no recording: no sample time is said before START";
        assert!(done.messages.contains(why), "{}", done.messages);
        assert!(!told.exists());
    }
}
