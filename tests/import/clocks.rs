//! Clocks in logs of other programs: in two columns, coarse, as the time since the previous row, and columns that are
//! no clock.

use std::fs;

use crate::support::command::{RunFile, run};
use crate::support::foreign_logs::{Truth, asked, counts, import, imported, log, near, proposed};

const COUNTS: [&str; 2] = ["--counts-per-rev", "720"];

fn volts(truth: &Truth) -> impl Fn(usize) -> String {
    |k| format!("{:.6}", truth.volts(k))
}

fn turned(truth: &Truth) -> impl Fn(usize) -> String {
    |k| truth.counts[k].to_string()
}

/// A log of these clocks before a command in V and counts.
fn clocked(truth: &Truth, names: &str, clocks: &[&dyn Fn(usize) -> String]) -> String {
    let (volts, turned) = (volts(truth), turned(truth));
    let mut cells = clocks.to_vec();
    cells.push(&volts);
    cells.push(&turned);
    log(&format!("{names},voltage,encoder"), truth.rows(), &cells)
}

#[test]
fn a_column_that_does_not_rise_is_no_clock() {
    let truth = Truth::steps(0.01, 300);
    let seconds = |k: usize| format!("{:.2}", truth.t_s(k));
    let servo = |_: usize| "1500".to_owned();
    // The servo's pulse width follows the throttle.
    let throttle = |k: usize| (1000 + 2 * truth.pwm[k].max(0)).to_string();
    let names = "Time (s),Servo 3 (µs),ESC (µs)";
    let text = clocked(&truth, names, &[&seconds, &servo, &throttle]);
    let (file, said) = imported("log.csv", &text, &COUNTS);
    assert!(
        said.contains("`Time (s)` in s, a row every 0.01 s"),
        "{said}"
    );
    near(&file.column("t_s"), &truth.times(), 1e-9);
    // Alone it is an open question, with the existing columns.
    let text = clocked(&truth, "time_us", &[&servo]);
    let said = asked("log.csv", &text, &COUNTS);
    assert!(said.contains("--time COLUMN:UNIT"), "{said}");
    assert!(!said.contains("a row every 0 s"), "{said}");
}

#[test]
fn seconds_and_their_fraction_in_two_columns_are_one_clock() {
    let truth = Truth::steps(0.01, 300);
    let ns = |k: usize| truth.ms(k) * 1_000_000 + 123_000_000;
    let second = 1_000_000_000;
    let whole = |k: usize| (17_690_000 + ns(k) / second).to_string();
    let nanosec = |k: usize| (ns(k) % second).to_string();
    let micros = |k: usize| (ns(k) % second / 1000).to_string();
    let millis = |k: usize| (ns(k) % second / 1_000_000).to_string();
    type Cell<'a> = &'a dyn Fn(usize) -> String;
    let cases: [(&str, Cell<'_>); 6] = [
        ("sec,nanosec", &nanosec),
        ("secs,nsecs", &nanosec),
        ("header.stamp.sec,header.stamp.nanosec", &nanosec),
        ("tv_sec,tv_usec", &micros),
        ("time_s,time_ms", &millis),
        ("x,y", &nanosec),
    ];
    for (names, rest) in cases {
        let text = clocked(&truth, names, &[&whole, rest]);
        let (file, said) = imported("log.csv", &text, &COUNTS);
        near(&file.column("t_s"), &truth.times(), 1e-8);
        assert_eq!(counts(&file), truth.counts, "{names}: {said}");
        assert!(said.contains("a row every 0.01 s"), "{names}: {said}");
    }
    // The same by the saved mapping.
    let directory = tempfile::tempdir().expect("a directory");
    let text = clocked(&truth, "sec,nanosec", &[&whole, &nanosec]);
    let flags = [&COUNTS[..], &["--save-map", "map.toml"]].concat();
    let finished = import(directory.path(), "log.csv", &text, &flags);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let flags = ["import", "log.csv", "--map", "map.toml", "-o", "again.csv"];
    let finished = run(directory.path(), &flags);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let file = RunFile::read(&directory.path().join("again.csv"));
    near(&file.column("t_s"), &truth.times(), 1e-8);
}

#[test]
fn nanoseconds_are_recognized_by_their_steps() {
    let truth = Truth::steps(0.01, 300);
    let ns = |k: usize| (truth.ms(k) * 1_000_000).to_string();
    for name in ["timestamp", "t_ns", "time [ns]"] {
        let text = clocked(&truth, name, &[&ns]);
        let (file, said) = imported("log.csv", &text, &COUNTS);
        assert!(said.contains("in ns, a row every 0.01 s"), "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-9);
    }
}

#[test]
fn rows_that_share_a_reading_are_spread() {
    for (sample_time_s, shared) in [(0.0005, "2 rows"), (0.0003125, "3.2 rows")] {
        let truth = Truth::steps(sample_time_s, 4000);
        let ms = |k: usize| ((1000.0 * truth.t_s(k) + 1e-9).floor() as i64).to_string();
        let text = clocked(&truth, "time_ms", &[&ms]);
        let (file, said) = imported("log.csv", &text, &COUNTS);
        assert!(
            said.contains("a coarse clock") && said.contains(shared),
            "{said}"
        );
        assert!(!said.contains("a row every 0 s"), "{said}");
        near(&file.column("t_s"), &truth.times(), 0.5 * sample_time_s);
        assert_eq!(counts(&file), truth.counts);
        let sample_time = file.header["sample_time_s"].as_float().expect("a number");
        assert!(
            (sample_time / sample_time_s - 1.0).abs() < 2e-3,
            "{sample_time}"
        );
    }
}

#[test]
fn a_pause_is_kept_at_its_place_in_a_coarse_clock() {
    let truth = Truth::steps(0.0005, 2000);
    let pause_ms = |k: usize| if k < 1000 { 0 } else { 400 };
    let ms = |k: usize| (k / 2 + pause_ms(k)).to_string();
    let (file, said) = imported("log.csv", &clocked(&truth, "millis", &[&ms]), &COUNTS);
    let t_s = file.column("t_s");
    assert!((t_s[1000] - 0.9).abs() < 1e-6, "{said}: {}", t_s[1000]);
    assert!((t_s[999] - 0.4995).abs() < 1e-6, "{said}: {}", t_s[999]);
}

#[test]
fn a_log_that_starts_within_a_clock_reading_has_no_gap_after_it() {
    let truth = Truth::steps(0.01, 600);
    // 12:00:00 to 12:00:07: the first reading has 37 rows.
    let stamp = |k: usize| format!("12:00:{:02}", (k + 63) / 100);
    let elapsed = |k: usize| format!("0:{:02}", (k + 63) / 100);
    for (name, clock) in [
        ("Zeit", &stamp as &dyn Fn(usize) -> String),
        ("time", &elapsed),
    ] {
        let (file, said) = imported("log.csv", &clocked(&truth, name, &[clock]), &COUNTS);
        assert!(said.contains("100 rows share each reading"), "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-6);
    }
}

#[test]
fn minutes_and_seconds_without_a_fraction() {
    let truth = Truth::steps(1.0, 200);
    let minutes = |k: usize| format!("{}:{:02}", (k + 3570) / 60, (k + 3570) % 60);
    let hours = |k: usize| format!("0:{:02}:{:02}", (k + 5) / 60, (k + 5) % 60);
    for clock in [&minutes as &dyn Fn(usize) -> String, &hours] {
        let (file, said) = imported("log.csv", &clocked(&truth, "time", &[clock]), &COUNTS);
        assert!(said.contains("time stamps, a row every 1 s"), "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-9);
    }
    // From a spreadsheet without seconds: hours and minutes, or minutes and seconds.
    let truth = Truth::steps(0.01, 600);
    let either = |k: usize| format!("12:{:02}", 34 + k / 150);
    let said = asked("log.csv", &clocked(&truth, "time", &[&either]), &COUNTS);
    assert!(
        said.contains("minutes and seconds or hours and minutes"),
        "{said}"
    );
    // A ratio is no clock.
    let ratio = |_: usize| "1:50".to_owned();
    let seconds = |k: usize| format!("{:.2}", truth.t_s(k));
    let text = clocked(&truth, "gear,x", &[&ratio, &seconds]);
    let (file, _) = imported("log.csv", &text, &COUNTS);
    near(&file.column("t_s"), &truth.times(), 1e-9);
}

#[test]
fn rows_that_arrive_in_bunches_are_asked_about() {
    let truth = Truth::steps(0.002, 1000);
    // The host's clock, with rows in bursts of three to eleven.
    let bunch = |k: usize| (k / 14) * 14 + if k % 14 < 3 { 0 } else { 3 };
    let ms = |k: usize| (2 * bunch(k)).to_string();
    let said = asked("log.csv", &clocked(&truth, "host_ms", &[&ms]), &COUNTS);
    assert!(said.contains("arrive in bunches"), "{said}");
    let flags = proposed(&said, &[]);
    let at = flags
        .iter()
        .position(|flag| flag == "--time")
        .expect("--time");
    let proposed_ms: f64 = flags[at + 1].trim_end_matches("ms").parse().expect("ms");
    assert!((proposed_ms - 2.0).abs() < 0.02, "{said}");
}

#[test]
fn a_time_since_the_row_before_is_summed() {
    let truth = Truth::steps(0.01, 300);
    // Jitter with a mean of zero.
    let us = |k: usize| 10_000 + [0, 4, -8, 4][k % 4];
    let dt = |k: usize| us(k).to_string();
    let constant = |_: usize| "10000".to_owned();
    let ms = |k: usize| format!("{:.3}", us(k) as f64 / 1000.0);
    type Cell<'a> = &'a dyn Fn(usize) -> String;
    let cases: [(&str, Cell<'_>, &[&str]); 8] = [
        ("dt_us", &dt, &[]),
        ("dt_us", &constant, &[]),
        ("delta_ms", &ms, &[]),
        ("dT (ms)", &ms, &[]),
        ("loop_us", &dt, &[]),
        ("dt", &dt, &[]),
        ("delta", &dt, &[]),
        ("x", &dt, &["--time", "x:us"]),
    ];
    for (name, cell, flags) in cases {
        let text = clocked(&truth, name, &[cell]);
        let (file, said) = imported("log.csv", &text, &[&COUNTS[..], flags].concat());
        assert!(
            said.contains("the time since the row before, summed up"),
            "{said}"
        );
        near(&file.column("t_s"), &truth.times(), 1e-5);
        assert_eq!(counts(&file), truth.counts, "{name}: {said}");
    }
    // With another clock it is none.
    let seconds = |k: usize| format!("{:.2}", truth.t_s(k));
    let text = clocked(&truth, "dt_us,time_s", &[&dt, &seconds]);
    let (_, said) = imported("log.csv", &text, &COUNTS);
    assert!(said.contains("`time_s` in s, a row every 0.01 s"), "{said}");
}

#[test]
fn a_sample_time_that_contradicts_the_clock_is_reported() {
    let truth = Truth::steps(0.004, 300);
    let seconds = |k: usize| format!("{:.4}", truth.t_s(k));
    let text = clocked(&truth, "time_s", &[&seconds]);
    let (_, said) = imported(
        "log.csv",
        &text,
        &[&COUNTS[..], &["--time", "50ms"]].concat(),
    );
    assert!(
        said.contains("`time_s` says that the rows are 0.004 s apart, not 0.05 s"),
        "{said}"
    );
    let (_, said) = imported(
        "log.csv",
        &text,
        &[&COUNTS[..], &["--time", "4ms"]].concat(),
    );
    assert!(!said.contains("apart, not"), "{said}");
}

#[test]
fn a_clock_that_decreases_too_often_ends_the_import_without_a_file() {
    let truth = Truth::steps(0.01, 400);
    let ms = |k: usize| (10 * (k % 20)).to_string();
    let text = clocked(&truth, "time_ms", &[&ms]);
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "log.csv", &text, &COUNTS);
    assert_eq!(finished.status, Some(2), "{}", finished.messages);
    for words in ["line 242: the clock begins anew", "run 13", "--runs 1000"] {
        assert!(finished.messages.contains(words), "{}", finished.messages);
    }
    let left = fs::read_dir(directory.path()).expect("a folder").count();
    assert_eq!(left, 1, "nothing is written");
    let flags = [&COUNTS[..], &["--runs", "1000"]].concat();
    let finished = import(directory.path(), "log.csv", &text, &flags);
    assert_eq!(finished.output.lines().count(), 20, "{}", finished.messages);
}

#[test]
fn minutes_and_seconds_are_one_clock() {
    let truth = Truth::steps(0.01, 400);
    // The minute ends within the log.
    let at_s = |k: usize| truth.t_s(k) + 58.0;
    let minutes = |k: usize| ((at_s(k) + 1e-9) / 60.0).floor().to_string();
    let seconds = |k: usize| format!("{:.2}", (at_s(k) + 1e-9) % 60.0);
    for names in ["min,sec", "minute,s", "Minutes,Seconds"] {
        let text = clocked(&truth, names, &[&minutes, &seconds]);
        let (file, said) = imported("log.csv", &text, &COUNTS);
        assert!(said.contains("in min plus"), "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-6);
    }
}

/// Arrivals at a host are late and in bursts.
#[test]
fn the_devices_clock_takes_precedence_over_the_hosts() {
    let truth = Truth::steps(0.01, 300);
    let host = |k: usize| format!("{:.4}", 1.7e9 + truth.t_s(k) + 0.004 * (k % 3) as f64);
    let us = |k: usize| (1000 * truth.ms(k)).to_string();
    for names in [
        "host_time,time_us",
        "pc_time_s,device_us",
        "t_received,micros",
    ] {
        let text = clocked(&truth, names, &[&host, &us]);
        let (file, said) = imported("log.csv", &text, &COUNTS);
        near(&file.column("t_s"), &truth.times(), 1e-6);
        assert!(said.contains("in us"), "{said}");
    }
}
