//! Implausible lines of a text board: damaged in transmission, stamped by a coarse clock, with units or text in them.
//! And a 16-bit counter of a binary board that wraps in a gap.
#![cfg(unix)]

use super::text_boards::capture_from;
use crate::support::command::{RunFile, run};

const GIVEN: [&str; 8] = [
    "--columns",
    "t_us,counts,pwm",
    "--supply",
    "9",
    "--counts-per-rev",
    "720",
    "--duration",
    "1",
];

fn sound(k: u32) -> String {
    let counts = k.saturating_sub(60) * 6;
    format!("{},{counts},{}\r\n", k * 5000, if k < 60 { 0 } else { 200 })
}

#[test]
fn one_damaged_line_ends_no_run() {
    type Damage = fn(String) -> String;
    let damages: [(Damage, u64); 5] = [
        // A digit of the time doubled, lost, changed; an additional digit in the counts.
        (|line| format!("5{line}"), 1),
        (|line| line[1..].to_owned(), 1),
        (|line| format!("9{}", &line[1..]), 1),
        (|line| line.replacen(',', ",7", 1), 1),
        // Another line between two samples.
        (|line| format!("Debug: 1,2,3\r\n{line}"), 0),
    ];
    for (damage, lost) in damages {
        let line = |k: u32| if k == 113 { damage(sound(k)) } else { sound(k) };
        let (done, file) = capture_from(line, &GIVEN);
        let file = file.expect("a file");
        assert_eq!(file.summary("lost"), lost as i64, "{}", done.messages);
        assert_eq!(file.rows.len() as u64, 200 - lost, "{}", done.messages);
        assert!(
            done.messages
                .contains("1 lines did not go with the lines around them"),
            "{}",
            done.messages
        );
        let (t_s, counts) = (file.column("t_s"), file.column("counts"));
        assert!(t_s.windows(2).all(|pair| pair[1] - pair[0] < 0.011));
        assert!(
            counts
                .windows(2)
                .all(|pair| (0.0..=12.0).contains(&(pair[1] - pair[0])))
        );
    }
}

#[test]
fn a_time_of_two_decimals_is_a_coarse_clock() {
    // print(t, 2) every 5 ms: each stamp is repeated.
    let line = |k: u32| format!("{}.{:02} {} 200\n", k / 200, k % 200 / 2, 3 * k);
    let arguments = ["--columns", "t_s,counts,pwm", "--duration", "1.5"];
    let (done, file) = capture_from(line, &arguments);
    let file = file.expect("a file");
    assert!(
        done.messages.contains("a coarse clock"),
        "{}",
        done.messages
    );
    let sample_time_s = file.header["sample_time_s"].as_float().expect("a number");
    assert!((sample_time_s - 0.005).abs() < 5e-5, "{sample_time_s}");
    let t_s = file.column("t_s");
    assert!(
        t_s.windows(2)
            .all(|pair| (pair[1] - pair[0] - 0.005).abs() < 0.001)
    );
    assert!(file.rows.len() >= 295, "{}", file.rows.len());
    assert_eq!(file.summary("lost"), 0);
}

#[test]
fn numbers_may_have_units_and_an_ignored_column_text() {
    let with_units = |k: u32| format!("time:{}ms\tpos:{}\tpwm:255\n", 5 * k, 2 * k);
    let in_json = |k: u32| {
        format!(
            "{{\"t_ms\": {}, \"pos\": {}, \"pwm\": 255}}\n",
            5 * k,
            2 * k
        )
    };
    let esp_idf = |k: u32| format!("I ({}) motor: pos={} duty=100%\n", 5 * k, 2 * k);
    let bracketed = |k: u32| format!("[{:.3}] pos: {}, pwm: 255\n", 0.005 * f64::from(k), 2 * k);
    let teleplot = |k: u32| format!(">pos:{ms}:{}\n>duty_pct:{ms}:100\n", 2 * k, ms = 5 * k);
    let behind_blanks = |k: u32| format!("time:{} ms pos:{} duty:100.0 %\n", 5 * k, 2 * k);
    type Line<'a> = &'a (dyn Fn(u32) -> String + Sync);
    let line: [Line<'_>; 6] = [
        &with_units,
        &in_json,
        &esp_idf,
        &bracketed,
        &teleplot,
        &behind_blanks,
    ];
    for line in line {
        let (done, file) = capture_from(line, &["--columns", "auto", "--duration", "0.5"]);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let file = file.expect("a file");
        assert_eq!(file.header["sample_time_s"].as_float(), Some(0.005));
        assert_eq!(
            (file.rows.len(), file.column("counts")[10]),
            (100, 20.0 + file.column("counts")[0])
        );
        let supply_v = file.header["supply_v"].as_float();
        assert_eq!(Some(file.column("command_v")[50]), supply_v);
    }
    let decimal_commas =
        |k: u32| format!("{:.3};{};4,50\n", 0.005 * f64::from(k), 2 * k).replace('.', ",");
    let columns = ["--columns", "t_s,counts,command_v", "--duration", "0.5"];
    let (done, file) = capture_from(decimal_commas, &columns);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert_eq!(file.expect("a file").column("command_v")[50], 4.5);
    let words = |k: u32| format!("({}, FWD, {}, 255)\n", 5 * k, 2 * k);
    let (done, file) = capture_from(
        words,
        &["--columns", "t_ms,-,counts,pwm", "--duration", "0.5"],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert_eq!(file.expect("a file").rows.len(), 100);
}

/// Of 255 it were 18 mV.
#[test]
fn a_duty_of_1_contradicts_a_scale_of_255() {
    let line = |k: u32| format!("{},{},{}\n", 5 * k, 2 * k, if k < 20 { 0.0 } else { 0.75 });
    let columns = ["--columns", "t_ms,counts,duty", "--duration", "0.5"];
    let (done, _) = capture_from(line, &columns);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    assert!(
        done.messages.contains("pwm never exceeded 0.75 of 255"),
        "{}",
        done.messages
    );
}

#[test]
fn lines_without_a_time_are_timed_by_their_arrivals() {
    let line = |k: u32| format!("{},{}\n", 3 * k, if k < 100 { 0.0 } else { 4.5 });
    let arguments = [
        "--columns",
        "counts,command_v",
        "--duration",
        "1.5",
        "--json",
    ];
    let (done, file) = capture_from(line, &arguments);
    let file = file.expect("a file");
    let sample_time_s = file.header["sample_time_s"].as_float().expect("a number");
    assert!((sample_time_s - 0.005).abs() < 5e-4, "{sample_time_s}");
    assert!(
        !done.output.contains("sample_time_contradicts"),
        "{}",
        done.output
    );
}

#[test]
fn a_decreasing_time_ends_the_run() {
    let line = |k: u32| format!("-{},{},200\r\n", k * 5000, 3 * k);
    let (done, file) = capture_from(line, &GIVEN);
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(done.messages.contains("was reset"), "{}", done.messages);
    assert_eq!(file.expect("a file").rows.len(), 1);
}

/// One byte in 14 is lost, and so three frames of four: in the longest gaps the counter passes half its range. The
/// same board with a 32-bit counter on a good line shows where.
#[test]
fn a_counter_of_16_bits_that_may_wrap_in_a_gap_is_flagged() {
    let directory = tempfile::tempdir().expect("a directory");
    let capture = |faults: &str, name: &str| {
        let board = format!("virtual:?counts_per_rev=700000&speed=max&{faults}");
        let done = run(
            directory.path(),
            &[
                "capture",
                &board,
                "--duration",
                "8",
                "--patience",
                "60",
                "-o",
                name,
            ],
        );
        (done, RunFile::read(&directory.path().join(name)))
    };
    let (_, sound) = capture("counter_bits=32", "sound.csv");
    let (done, file) = capture("counter_bits=16&drop=0.07&seed=8", "run.csv");
    assert!(file.summary("counts_leaps") > 0, "{}", done.messages);
    assert_eq!(done.status, Some(1));
    let (seq, counts, true_counts) = (
        file.column("seq"),
        file.column("counts"),
        sound.column("counts"),
    );
    let flags = file
        .columns
        .iter()
        .position(|name| name == "flags")
        .expect("flags");
    let (mut gone_round, mut not_flagged) = (0, 0);
    for k in 1..seq.len() {
        let moved = true_counts[seq[k] as usize] - true_counts[seq[k - 1] as usize];
        let is_flagged = file.rows[k][flags].contains("counts_leap");
        not_flagged += usize::from(!is_flagged);
        if counts[k] - counts[k - 1] != moved {
            gone_round += 1;
            assert!(is_flagged, "row {k}: {moved} counts in truth");
        }
    }
    assert!(gone_round > 0);
    assert!(
        2 * not_flagged > seq.len(),
        "{not_flagged} of {}",
        seq.len()
    );
}
