//! Recordings of plain Arduino sketches that print their samples as text.
#![cfg(unix)]

use std::time::{Duration, Instant};

use crate::support::command::{Finished, RunFile, run};
use motorlab::board::BoardSide;
use motorlab::board::pty::Pty;
use motorlab::recording::{ReadNote, read_run_from};

/// Runs `capture` on a line on which a sketch prints `line(k)` every 5 ms.
pub fn capture_from(
    line: impl Fn(u32) -> String + Sync,
    arguments: &[&str],
) -> (Finished, Option<RunFile>) {
    let mut pty = Pty::open().expect("a pseudo-terminal");
    let port = pty.path().display().to_string();
    let directory = tempfile::tempdir().expect("a directory");
    let done = std::thread::scope(|scope| {
        let running = scope.spawn(|| {
            let mut all = vec!["capture", &port, "--patience", "2"];
            all.extend(arguments);
            run(directory.path(), &all)
        });
        let mut next = Instant::now();
        let mut k = 0;
        while !running.is_finished() {
            if pty
                .wait(Duration::ZERO, false)
                .is_ok_and(|ready| ready.connected)
            {
                let text = line(k);
                // The port is opened in the middle of a line.
                let from = if k == 0 { text.len() / 2 } else { 0 };
                pty.write_some(&text.as_bytes()[from..]).expect("room");
                k += 1;
            }
            next += Duration::from_millis(5);
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
        }
        running.join().expect("it does not panic")
    });
    let path = directory.path().join("run.csv");
    (done, path.exists().then(|| RunFile::read(&path)))
}

#[test]
fn named_columns_with_the_boards_time_make_an_ordinary_run() {
    // Samples 40 to 42 are not printed; the supply is 9 V.
    let line = |k: u32| {
        let k = if k < 40 { k } else { k + 3 };
        format!(
            "{}\t{}\t{}\r\n",
            1_000_000 + k * 5000,
            k * 2,
            if k < 20 { 0 } else { 255 }
        )
    };
    let (done, file) = capture_from(
        line,
        &[
            "--columns",
            "t_us,counts,pwm",
            "--supply",
            "9",
            "--duration",
            "1",
        ],
    );
    let file = file.expect("a file");
    assert_eq!(done.status, Some(1), "{}", done.messages);
    assert_eq!(file.summary("lost"), 3, "{}", done.messages);
    assert_eq!(file.header["timing"].as_str(), Some("device"));
    assert_eq!(file.header["sample_time_s"].as_float(), Some(0.005));
    assert_eq!(
        file.header["text_columns"].as_str(),
        Some("t_us,counts,pwm")
    );
    let (seq, t_s) = (file.column("seq"), file.column("t_s"));
    for (seq, t_s) in seq.iter().zip(&t_s) {
        assert!((t_s - seq * 0.005).abs() < 1e-9);
    }
    // Two counts per sample, also over the loss, where the difference is divided by the elapsed samples.
    let speed = 2.0 * std::f64::consts::TAU / (720.0 * 0.005);
    for velocity in &file.column("velocity_rad_s")[1..] {
        assert!((velocity - speed).abs() < 1e-9);
    }
    let commands = file.column("command_v");
    assert!(commands.contains(&0.0) && commands.contains(&9.0));
    assert!(!file.complete(), "three samples are missing");
}

#[test]
fn a_header_line_or_labels_are_enough() {
    let labelled = |k: u32| format!("t_us:{},counts:{},command_v:1.5\n", k * 5000, k);
    let header = |k: u32| match k {
        0 | 1 => "Motor lab v1 ready\n".to_owned(),
        2 => "t_us; counts; command_v\n".to_owned(),
        k => format!("{}; {}; 1.5\n", k * 5000, k),
    };
    for line in [&labelled as &(dyn Fn(u32) -> String + Sync), &header] {
        let (done, file) = capture_from(line, &["--columns", "auto", "--duration", "0.5"]);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let file = file.expect("a file");
        assert_eq!(file.rows.len(), 100);
        assert!(file.column("command_v").iter().all(|&v| v == 1.5));
    }
}

#[test]
fn without_the_boards_time_the_file_states_host_timing() {
    let line = |k: u32| format!("{k}\n");
    let arguments = [
        "--columns",
        "counts",
        "--duration",
        "0.5",
        "--profile",
        "step",
    ];
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert!(
        done.messages.contains("timing is the host's"),
        "{}",
        done.messages
    );
    let file = file.expect("a file");
    assert_eq!(file.header["timing"].as_str(), Some("host"));
    assert!(!file.columns.contains(&"seq".to_owned()));
    // The profile supplies the command: a rest, then the supply.
    let commands = file.column("command_v");
    assert_eq!((commands[0], commands[commands.len() - 1]), (0.0, 4.5));
}

#[test]
fn a_host_timed_run_with_bunched_lines_can_be_read() {
    // Four lines per write, as a USB serial chip delivers them.
    let line = |k: u32| (4 * k..4 * k + 4).map(|n| format!("{n},2.5\n")).collect();
    let arguments = [
        "--columns",
        "counts,command_v",
        "--duration",
        "0.5",
        "--ts",
        "0.00125",
    ];
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let text = file.expect("a file").text;
    let (run, notes) = read_run_from(text.as_bytes(), "run.csv").expect("a run");
    assert!(run.is_host_timed());
    assert_eq!(notes, [ReadNote::HostTimed]);
    assert!(run.t_s.windows(2).all(|pair| pair[1] > pair[0]));
    // No line is missing.
    assert!(run.counts.windows(2).all(|pair| pair[1] - pair[0] == 1));
}

#[test]
fn a_repeated_line_is_recorded_once_and_counted() {
    let line = |k: u32| {
        let line = format!("{},{k},255\n", k * 5000);
        line.repeat(if k == 50 { 2 } else { 1 })
    };
    let arguments = ["--columns", "t_us,counts,pwm", "--duration", "0.5"];
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert!(
        done.messages
            .contains("1 lines had the time of the line before"),
        "{}",
        done.messages
    );
    let file = file.expect("a file");
    assert_eq!((file.rows.len(), file.summary("lost")), (100, 0));
}

#[test]
fn lines_without_a_command_need_a_profile() {
    let (done, file) = capture_from(
        |k| format!("{},{k}\n", k * 5000),
        &["--columns", "t_us,counts"],
    );
    assert_eq!(done.status, Some(2), "{}", done.messages);
    assert!(done.messages.contains("--profile"), "{}", done.messages);
    assert!(file.is_none());
}

#[test]
fn lines_too_long_for_the_baud_rate_have_a_warning() {
    let line = |k: u32| {
        format!(
            "time_us:{:010},counts:{:010},command_v:4.500\n",
            k * 3000,
            k
        )
    };
    let arguments = ["--columns", "auto", "--duration", "0.3", "--ts", "0.003"];
    let (done, file) = capture_from(line, &arguments);
    let file = file.expect("a file");
    assert_eq!(file.summary("longest_line_bytes"), 53);
    assert!(
        done.messages
            .contains("the longest line has 53 bytes, and 34 fit into 0.003 s at 115200 baud"),
        "{}",
        done.messages
    );
    let short = |k: u32| format!("{},{},255\n", k * 3000, k);
    let arguments = [
        "--columns",
        "t_us,counts,pwm",
        "--duration",
        "0.3",
        "--ts",
        "0.003",
    ];
    let (done, _) = capture_from(short, &arguments);
    assert!(!done.messages.contains("longest line"), "{}", done.messages);
}

#[test]
fn lines_that_are_no_samples_are_shown() {
    let line = |k: u32| format!("{k} {k} {k}\n");
    let (done, _) = capture_from(line, &["--columns", "t_us,counts"]);
    assert_eq!(done.status, Some(3));
    assert!(
        done.messages.contains("3 fields where --columns has 2"),
        "{}",
        done.messages
    );
    let (done, _) = capture_from(line, &["--columns", "auto"]);
    assert!(
        done.messages.contains("name them with --columns"),
        "{}",
        done.messages
    );
    let (done, _) = capture_from(line, &["--columns", "t_us,cuonts"]);
    assert_eq!(done.status, Some(2));
}

#[test]
fn a_board_that_is_reset_ends_the_run() {
    let line = |k: u32| format!("{},{},255\n", (k % 100) * 5000, k % 100);
    let (done, file) = capture_from(line, &["--columns", "t_us,counts,pwm", "--duration", "2"]);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    let file = file.expect("a file");
    assert_eq!(file.rows.len(), 99);
    assert!(!file.complete());
}

#[test]
fn a_line_in_between_that_is_no_sample_is_counted_and_shown() {
    let line = |k: u32| match k {
        30 | 60 => "Overrun! check the loop\r\n".to_owned(),
        k => format!("{} {} 255\r\n", k * 5000, k),
    };
    let arguments = ["--columns", "t_us,counts,pwm", "--duration", "0.5"];
    let (done, file) = capture_from(line, &arguments);
    // Their two samples are missing, by the board's time.
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let file = file.expect("a file");
    assert_eq!(
        (file.summary("skipped_lines"), file.summary("lost")),
        (2, 2)
    );
    assert!(
        done.messages
            .contains("2 lines were no samples and were skipped, the last one \"Overrun!"),
        "{}",
        done.messages
    );
}

#[test]
fn a_line_with_an_outlying_time_is_skipped_and_counted() {
    let line = |k: u32| match k {
        // An additional digit.
        30 => "1500000000,30,255\n".to_owned(),
        k => format!("{},{k},255\n", k * 5000),
    };
    let arguments = ["--columns", "t_us,counts,pwm", "--duration", "0.5"];
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let file = file.expect("a file");
    assert_eq!((file.summary("implausible"), file.summary("lost")), (1, 1));
    assert!(file.column("t_s").windows(2).all(|t| t[1] - t[0] < 0.0101));
}

#[test]
fn a_permanent_jump_of_the_clock_ends_the_run() {
    let line = |k: u32| {
        format!(
            "{},{k},255\n",
            k * 5000 + u32::from(k >= 60) * 3_000_000_000
        )
    };
    let (done, file) = capture_from(line, &["--columns", "t_us,counts,pwm", "--duration", "2"]);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    let file = file.expect("a file");
    assert!(!file.complete() && file.column("t_s").iter().all(|t| *t < 0.3));
}

#[test]
fn a_time_unit_that_the_hosts_clock_contradicts_is_reported_at_once() {
    // Microseconds named milliseconds, and the reverse; labels that name them seconds.
    for (line, columns, right) in [
        (
            (|k| format!("{},{k},128\n", k * 5000)) as fn(u32) -> String,
            "t_ms,counts,pwm",
            "t_us,counts,pwm",
        ),
        (
            |k| format!("{},{k},128\n", k * 5),
            "t_us,counts,pwm",
            "t_ms,counts,pwm",
        ),
        (
            |k| format!("T:{} ENC:{k} PWM:128\n", k * 5),
            "auto",
            "t_ms,counts,pwm",
        ),
    ] {
        let (done, _) = capture_from(line, &["--columns", columns, "--duration", "2"]);
        assert_eq!(done.status, Some(2), "{columns}: {}", done.messages);
        let said = format!("hint: --columns {right}");
        assert!(
            done.messages.contains(&said),
            "{columns}: {}",
            done.messages
        );
        assert!(done.messages.contains("1000 times as"), "{}", done.messages);
    }
}

#[test]
fn given_columns_take_precedence_over_labels() {
    let line = |k: u32| format!("T:{} ENC:{k} PWM:128\n", k * 5);
    let arguments = ["--columns", "t_ms,counts,pwm", "--duration", "0.5"];
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let file = file.expect("a file");
    assert_eq!(file.rows.len(), 100);
    assert!((file.column("t_s")[99] - 0.495).abs() < 1e-9);
    // The order of columns does not affect units.
    let (done, _) = capture_from(line, &["--columns", "t_ms,pwm,counts", "--duration", "0.5"]);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(
        done.messages
            .contains("--columns has `pwm` where the label is `ENC`"),
        "{}",
        done.messages
    );
}

#[test]
fn a_column_may_be_left_out_first_and_an_angle_is_no_count() {
    let line = |k: u32| format!("7,{k}\r");
    let arguments = [
        "--columns",
        "-,counts",
        "--profile",
        "step",
        "--duration",
        "0.5",
    ];
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert!(file.expect("a file").rows.len() > 50);
    let (done, _) = capture_from(line, &["--columns", "t_ms,angle,pwm"]);
    assert_eq!(done.status, Some(2));
    assert!(
        done.messages.contains("motorlab import") && !done.messages.contains("did you mean"),
        "{}",
        done.messages
    );
}

#[test]
fn labels_that_name_no_counts_are_named() {
    let (done, _) = capture_from(
        |k| format!("target:0,actual:{k}\r\n"),
        &["--columns", "auto", "--duration", "0.5"],
    );
    assert_eq!(done.status, Some(3));
    assert!(
        done.messages.contains("(target,actual)") && !done.messages.contains("baud rate"),
        "{}",
        done.messages
    );
}

#[test]
fn a_command_beyond_the_supply_is_reported_and_an_unreadable_one_is_no_row() {
    let arguments = [
        "--columns",
        "t_us,counts,command_v",
        "--supply",
        "9",
        "--duration",
        "0.5",
    ];
    let (done, file) = capture_from(|k| format!("{},{k},24\n", k * 5000), &arguments);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    assert!(
        done.messages
            .contains("command_v reached 24 V on a supply of 9 V"),
        "{}",
        done.messages
    );
    assert_eq!(file.expect("a file").rows.len(), 100);
    let line = |k: u32| {
        let command = if k % 25 == 24 { "1e300" } else { "6" };
        format!("{},{k},{command}\n", k * 5000)
    };
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let file = file.expect("a file");
    assert!(file.summary("lost") >= 3, "{}", done.messages);
    assert!(file.rows.iter().all(|row| row[3] == "6"));
}

#[test]
fn commands_beyond_full_scale_and_outlying_counts_are_reported() {
    let arguments = ["--columns", "t_us,counts,pwm", "--duration", "0.5"];
    let (done, _) = capture_from(|k| format!("{},{k},1023\n", k * 5000), &arguments);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    assert!(
        done.messages.contains("pwm reached 1023") && done.messages.contains("up to 18.05"),
        "{}",
        done.messages
    );
    let line = |k: u32| {
        // Permanently: a line that jumps and returns is skipped.
        let counts = k + k / 25 * 1_000_000;
        format!("{},{counts},128\n", k * 5000)
    };
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let file = file.expect("a file");
    assert!(file.summary("counts_leaps") >= 3, "{}", done.messages);
    let flagged = file
        .rows
        .iter()
        .filter(|row| row.last().is_some_and(|f| f == "counts_leap"));
    assert_eq!(flagged.count() as i64, file.summary("counts_leaps"));
}

/// A motor with 10 counts, then 30, every 5 ms, at 360 per revolution.
fn counted(k: u32) -> i64 {
    let k = i64::from(k);
    if k < 40 { 10 * k } else { 400 + 30 * (k - 40) }
}

#[test]
fn speeds_and_increments_are_integrated_and_marked() {
    let since = |k: u32| counted(k) - counted(k.saturating_sub(1));
    let rpm = |k: u32| since(k) as f64 / 360.0 / 0.005 * 60.0;
    let rad_s = |k: u32| since(k) as f64 / 360.0 / 0.005 * std::f64::consts::TAU;
    let speed = |k: u32| format!("{},{:.3},128\n", k * 5, rpm(k));
    let angular = |k: u32| format!("t_ms:{} rad_s:{:.5} pwm:128\n", k * 5, rad_s(k));
    let increments = |k: u32| format!("{},{},128\n", k * 5, since(k));
    type Line<'a> = &'a (dyn Fn(u32) -> String + Sync);
    let cases: [(Line, &str, &str, &str); 4] = [
        (
            &speed,
            "t_ms,rpm,pwm",
            "integrated from rpm, backward",
            "drift",
        ),
        (
            &speed,
            "t_ms,speed,pwm",
            "integrated from speed, backward",
            "is taken as rpm",
        ),
        (&angular, "auto", "integrated from rad_s, backward", "drift"),
        (
            &increments,
            "t_ms,increment,pwm",
            "increments, summed up",
            "lost for good",
        ),
    ];
    for (line, columns, how, cost) in cases {
        let arguments = [
            "--columns",
            columns,
            "--duration",
            "0.5",
            "--counts-per-rev",
            "360",
            "--supply",
            "12",
        ];
        let (done, file) = capture_from(line, &arguments);
        assert_eq!(done.status, Some(0), "{columns}: {}", done.messages);
        assert!(done.messages.contains(cost), "{columns}: {}", done.messages);
        let file = file.expect("a file");
        assert_eq!(file.header["text_position"].as_str(), Some(how));
        let counts = file.column("counts");
        let turned = counts.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(
            turned.clone().all(|step| step == 10.0 || step == 30.0),
            "{columns}: {counts:?}"
        );
        assert_eq!(counts[0], 0.0, "{columns}");
        assert!(
            turned.filter(|step| *step == 30.0).count() >= 55,
            "{columns}: {counts:?}"
        );
    }
}

/// Summed backward, a speed of the instant is ahead by half a row: its time constant is 6 to 7 % low.
#[test]
fn a_speed_of_the_instant_is_integrated_as_one() {
    const TIME_CONSTANT_S: f64 = 0.05;
    const TOP_REV_S: f64 = 5.0;
    let steps = [(0, 0.0), (40, 1.0), (140, -0.5), (220, 0.25)];
    // Speed in rev/s and position in revolutions of row `k`.
    let state = |k: u32| {
        let (mut speed, mut turns) = (0.0_f64, 0.0_f64);
        for (at, (from, share)) in steps.iter().enumerate() {
            let to = steps.get(at + 1).map_or(k, |(next, _)| *next).min(k);
            let passed_s = 0.005 * f64::from(to.saturating_sub(*from));
            let left = (-passed_s / TIME_CONSTANT_S).exp();
            let end = TOP_REV_S * share;
            turns += end * passed_s + (speed - end) * TIME_CONSTANT_S * (1.0 - left);
            speed = end + (speed - end) * left;
        }
        (speed, turns)
    };
    let pwm = |k: u32| {
        let reached = steps.iter().rev().find(|(from, _)| *from <= k);
        reached.map_or(0.0, |(_, share)| 255.0 * share)
    };
    let line = |k: u32| format!("{},{:.3},{}\n", k * 5, 60.0 * state(k).0, pwm(k));
    let arguments = [
        "--columns",
        "t_ms,rpm,pwm",
        "--duration",
        "1.5",
        "--counts-per-rev",
        "2000",
        "--supply",
        "12",
    ];
    let (done, file) = capture_from(line, &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert!(
        done.messages
            .contains("the speed at the instant of the row: a first-order motor leaves")
            && done.messages.contains("--integrate backward says that one"),
        "{}",
        done.messages
    );
    let file = file.expect("a file");
    let how = file.header["text_position"].as_str();
    assert_eq!(how, Some("integrated from rpm, trapezoid"));
    assert_eq!(file.header["complete"].as_bool(), Some(true));
    let first = state(1).1;
    for (t_s, counts) in file.column("t_s").iter().zip(file.column("counts")) {
        let k = 1 + (t_s / 0.005).round() as u32;
        let turned = 2000.0 * (state(k).1 - first);
        assert!(
            (counts - turned).abs() < 1.5,
            "{t_s}: {counts} for {turned}"
        );
    }
    let given = [&arguments[..], &["--integrate", "backward"]].concat();
    let (done, file) = capture_from(line, &given);
    assert!(
        done.messages.contains("the rule backward that is given"),
        "{}",
        done.messages
    );
    let file = file.expect("a file");
    let how = file.header["text_position"].as_str();
    assert_eq!(how, Some("integrated from rpm, backward"));
}

#[test]
fn the_handouts_supply_and_counts_are_never_assumed_silently() {
    let line = |k: u32| format!("{},{k},128\n", k * 5);
    let columns = ["--columns", "t_ms,counts,pwm", "--duration", "0.3"];
    let (done, _) = capture_from(line, &columns);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    for word in ["--counts-per-rev", "720", "--supply", "4.5 V"] {
        assert!(done.messages.contains(word), "{word}: {}", done.messages);
    }
    let said = [
        columns.as_slice(),
        &["--supply", "12", "--counts-per-rev", "360"],
    ]
    .concat();
    let (done, _) = capture_from(line, &said);
    assert!(!done.messages.contains("handout"), "{}", done.messages);
}
