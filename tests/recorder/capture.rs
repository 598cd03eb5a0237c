//! `capture` from the virtual board, over a real pseudo-terminal, into a run file.

use std::f64::consts::TAU;
use std::process::Command;
use std::time::Duration;

use crate::support::command::{RunFile, finish, run, start};
use motorlab::recording::difference_velocities;

/// More than 10,000 samples at a sample time, none lost; every column as in the format.
fn a_long_run(sample_time_us: u32) {
    let directory = tempfile::tempdir().expect("a directory");
    let ts = f64::from(sample_time_us) * 1e-6;
    let duration = (ts * 12_000.0).to_string();
    let done = run(
        directory.path(),
        &[
            "capture",
            "virtual:?speed=max",
            "--ts",
            &ts.to_string(),
            "--profile",
            "reversing",
            "--duration",
            &duration,
            "-o",
            "long.csv",
        ],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&directory.path().join("long.csv"));
    assert!(file.complete());
    assert_eq!(file.header["format"].as_str(), Some("motorlab-run/1"));
    assert_eq!(file.header["sample_time_s"].as_float(), Some(ts));
    assert_eq!(file.header["counts_per_rev"].as_integer(), Some(720));
    assert_eq!(file.header["supply_v"].as_float(), Some(4.5));
    assert_eq!(file.header["profile"].as_str(), Some("reversing"));
    assert_eq!(
        file.columns.join(","),
        "seq,t_s,host_t_s,command_v,counts,velocity_rad_s,flags"
    );
    assert_eq!((file.rows.len(), file.summary("lost")), (12_000, 0));
    let (seq, t_s) = (file.column("seq"), file.column("t_s"));
    for k in 0..12_000_usize {
        assert_eq!(seq[k], k as f64);
        let micros = k as u64 * u64::from(sample_time_us);
        let text = format!("{}.{:06}", micros / 1_000_000, micros % 1_000_000);
        assert_eq!(file.rows[k][1], text);
        assert!((t_s[k] - micros as f64 * 1e-6).abs() < 1e-9);
    }
    // The speed column is the velocity estimate from the counts column, to the last digit.
    let counts: Vec<i64> = file.column("counts").iter().map(|&n| n as i64).collect();
    let rule = difference_velocities(&counts, None, 720.0, ts);
    assert_eq!(file.rows[0][5], "");
    for (k, speed) in file.column("velocity_rad_s").iter().enumerate().skip(1) {
        assert_eq!(Some(*speed), rule[k]);
        let by_hand = (counts[k] - counts[k - 1]) as f64 * TAU / (720.0 * ts);
        assert!((speed - by_hand).abs() < 1e-9);
    }
    assert!(counts.iter().any(|&n| n > 100));
}

#[test]
fn twelve_thousand_samples_at_three_milliseconds_without_a_loss() {
    a_long_run(3_000);
}

#[test]
fn twelve_thousand_samples_at_thirty_milliseconds_without_a_loss() {
    a_long_run(30_000);
}

#[test]
fn in_real_time_a_capture_takes_its_stated_duration() {
    let directory = tempfile::tempdir().expect("a directory");
    let arguments = ["capture", "virtual:", "--duration", "1.5", "--json"];
    let done = run(directory.path(), &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let json: serde_json::Value = serde_json::from_str(&done.output).expect("one JSON document");
    assert_eq!(json["format"], "motorlab-capture/1");
    assert_eq!((&json["samples"], &json["lost"]), (&500.into(), &0.into()));
    assert_eq!(json["statistics"]["device_dt"]["median_us"], 3000);
    let rpm = json["statistics"]["steady_rpm"].as_f64().expect("a speed");
    // The handout's motor at 4.5 V: (Kt V / R - Tf) / (b + Kt Kb / R), in RPM.
    let expected = (0.7 * 4.5 / 10.0 - 0.02) / (0.01 + 0.049) * 60.0 / TAU;
    assert!((rpm - expected).abs() < 0.01 * expected, "{rpm} {expected}");
    let file = RunFile::read(&directory.path().join("run.csv"));
    // Arrival times are a separate, increasing column.
    let host = file.column("host_t_s");
    assert!(host.windows(2).all(|pair| pair[1] >= pair[0]));
}

#[test]
fn an_existing_file_is_kept_and_a_free_name_is_printed() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("run.csv"), "mine").expect("a file");
    let arguments = ["capture", "virtual:?speed=max", "--duration", "0.3"];
    let done = run(directory.path(), &arguments);
    assert_eq!(done.status, Some(0));
    assert!(
        done.messages
            .contains("run.csv exists and stays as it is; recording into run-2.csv"),
        "{}",
        done.messages
    );
    let kept = std::fs::read_to_string(directory.path().join("run.csv")).expect("a file");
    assert_eq!(kept, "mine");
    assert!(RunFile::read(&directory.path().join("run-2.csv")).complete());
}

#[test]
fn the_summary_agrees_with_the_file() {
    let directory = tempfile::tempdir().expect("a directory");
    let board = "virtual:?drop=0.0005&seed=3";
    let done = run(directory.path(), &["capture", board, "--duration", "3"]);
    // Status 1: samples were lost.
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    let (seq, t_s) = (file.column("seq"), file.column("t_s"));
    let (rows, lost) = (file.rows.len(), 1000 - file.rows.len());
    assert!(lost > 0);
    let whole: Vec<i64> = (1..rows)
        .filter(|&k| seq[k] - seq[k - 1] == 1.0)
        .map(|k| ((t_s[k] - t_s[k - 1]) * 1e6).round() as i64)
        .collect();
    let (min, max) = (whole.iter().min(), whole.iter().max());
    let duration = t_s[rows - 1] - t_s[0];
    // The handout's motor at 4.5 V: (Kt V / R - Tf) / (b + Kt Kb / R), in RPM.
    let rpm = (0.7 * 4.5 / 10.0 - 0.02) / (0.01 + 0.049) * 60.0 / TAU;
    for line in [
        "wrote run.csv".to_owned(),
        format!("  {rows} samples in {duration:.3} s, {lost} lost, 0 overruns"),
        format!(
            "  device dt {} / 3000 / {} us (min / median / max)",
            min.expect("an interval"),
            max.expect("an interval")
        ),
        format!("  steady speed {rpm:.1}"),
        "ppm against the host's".to_owned(),
    ] {
        assert!(done.output.contains(&line), "{line}: {}", done.output);
    }
    let said = format!("{lost} of 1000 samples were lost");
    assert!(done.messages.contains(&said), "{}", done.messages);
    assert_eq!(file.summary("lost"), lost as i64);
}

#[test]
fn wrapping_microseconds_and_sixteen_bit_counts_are_unwrapped() {
    let directory = tempfile::tempdir().expect("a directory");
    let capture = |board: &str, name: &str| {
        let arguments = ["capture", board, "--duration", "200", "-o", name];
        let done = run(directory.path(), &arguments);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        RunFile::read(&directory.path().join(name))
    };
    let plain = capture("virtual:?speed=max", "plain.csv");
    // micros() wraps after 100 s, the counter several times.
    let start = (u32::MAX - 100_000_000).to_string();
    let wrapping = format!("virtual:?speed=max&counter_bits=16&micros_start={start}");
    let wrapping = capture(&wrapping, "wrapping.csv");
    assert!(plain.column("counts").iter().any(|&n| n > 100_000.0));
    for name in ["t_s", "counts", "command_v", "seq"] {
        assert_eq!(plain.column(name), wrapping.column(name), "{name}");
    }
}

#[test]
fn the_board_commands_the_profile_of_a_file() {
    let directory = tempfile::tempdir().expect("a directory");
    let rows = "t_s,command_v\n0,1.25\n0.3,-2\n0.6,6\n";
    std::fs::write(directory.path().join("mine.csv"), rows).expect("a file");
    let done = run(
        directory.path(),
        &[
            "capture",
            "virtual:?speed=max",
            "--profile",
            "mine.csv",
            "--duration",
            "0.9",
        ],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    let commands = file.column("command_v");
    assert_eq!(
        (commands[99], commands[100], commands[200]),
        (1.25, -2.0, 6.0)
    );
    // 6 V exceed the supply of 4.5 V, and every such sample is flagged.
    assert_eq!(file.rows[199][6], "");
    assert_eq!(file.rows[200][6], "saturated");
    assert_eq!(file.summary("saturated"), 100);
}

#[test]
fn a_suspended_virtual_board_loses_nothing() {
    let directory = tempfile::tempdir().expect("a directory");
    let arguments = ["capture", "virtual:", "--duration", "1.5"];
    let child = start(directory.path(), &arguments);
    let signal = |name: &str| {
        let sent = Command::new("kill")
            .args([name, &child.id().to_string()])
            .status();
        assert!(sent.is_ok_and(|status| status.success()));
    };
    while !directory.path().join("run.csv").exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    signal("-STOP");
    std::thread::sleep(Duration::from_millis(1200));
    signal("-CONT");
    let done = finish(child);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!((file.rows.len(), file.summary("lost")), (500, 0));
}

#[test]
fn bunched_arrivals_do_not_change_the_time_base() {
    let directory = tempfile::tempdir().expect("a directory");
    // Samples accumulate for up to 20 ms before they are read, which reduces the observed length of a stall by as
    // much.
    let board = "virtual:?stall=0.0005&stall_ms=100&seed=1";
    let done = run(directory.path(), &["capture", board, "--duration", "1.5"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    let host = file.column("host_t_s");
    let longest = host.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(longest.fold(0.0, f64::max) > 0.05, "no stall");
    for (k, row) in file.rows.iter().enumerate() {
        let micros = k * 3000;
        let text = format!("{}.{:06}", micros / 1_000_000, micros % 1_000_000);
        assert_eq!(row[1], text);
    }
    assert_eq!(file.summary("device_dt_max_us"), 3000);
}

#[test]
fn a_board_is_asked_until_it_answers_however_slowly_it_boots() {
    let directory = tempfile::tempdir().expect("a directory");
    for (boot_ms, name) in [(0, "fast.csv"), (800, "usual.csv"), (4000, "slow.csv")] {
        let board = format!("virtual:?boot_ms={boot_ms}&banner=Motor lab ready\\n&speed=max");
        let arguments = ["capture", &board, "--duration", "0.9", "-o", name];
        let done = run(directory.path(), &arguments);
        assert_eq!(done.status, Some(0), "{boot_ms}: {}", done.messages);
        let file = RunFile::read(&directory.path().join(name));
        assert_eq!(file.rows.len(), 300);
        // Text before it was ready is no damaged frame.
        assert_eq!((file.summary("lost"), file.summary("bad_frames")), (0, 0));
    }
    let board = "virtual:?boot_ms=4000";
    let arguments = ["capture", board, "--patience", "1", "-o", "none.csv"];
    let done = run(directory.path(), &arguments);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(!directory.path().join("none.csv").exists());
}
