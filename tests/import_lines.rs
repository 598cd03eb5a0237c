//! `motorlab import LOG` without a mapping: lines that label their numbers, directions in a column of their own, commands that are sums.

#[path = "support/command.rs"]
mod command;
#[path = "support/foreign_logs.rs"]
mod foreign_logs;

use std::fmt::Write as _;

use command::{RunFile, run};
use foreign_logs::{Truth, asked, counts, import, imported, log, near};

const BOTH: [&str; 4] = ["--supply", "12", "--counts-per-rev", "720"];

/// The log of a motor as lines that a sketch prints.
fn lines(truth: &Truth, banner: &str, line: impl Fn(usize) -> String) -> String {
    let mut text = banner.to_owned();
    for k in truth.rows() {
        let _ = writeln!(text, "{}", line(k));
    }
    text
}

#[test]
fn plotter_lines_name_their_numbers_themselves() {
    let truth = Truth::steps(0.01, 300);
    let (ms, pwm, n) = (
        |k| truth.ms(k),
        |k: usize| truth.pwm[k],
        |k: usize| truth.counts[k],
    );
    let logs = [
        lines(&truth, "", |k| {
            format!("t_ms:{},pwm:{},counts:{}", ms(k), pwm(k), n(k))
        }),
        lines(&truth, "Motor lab v1: ready\n\n", |k| {
            format!("T:{} ENC:{} PWM:{}", ms(k), n(k), pwm(k))
        }),
        lines(&truth, "# first\n", |k| {
            format!(
                "millis: {}; counts: {}; duty_255: {}\r",
                ms(k),
                n(k),
                pwm(k)
            )
        }),
        lines(&truth, "", |k| {
            format!(
                "12:34:56.789 -> t_ms={}\tcounts={}\tpwm={}",
                ms(k),
                n(k),
                pwm(k)
            )
        }),
    ];
    for text in logs {
        let (file, said) = imported("log.txt", &text, &BOTH);
        assert_eq!(counts(&file), truth.counts, "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-9);
        near(&file.column("command_v"), &truth.commands(), 1e-9);
    }
}

#[test]
fn a_line_with_other_labels_is_a_bad_row_and_a_mapping_keeps_the_labels() {
    let truth = Truth::steps(0.01, 300);
    let line = |k: usize| match k {
        150 => "t_ms:1500,kp:2,counts:3".to_owned(),
        _ => format!(
            "t_ms:{},pwm:{},counts:{}",
            truth.ms(k),
            truth.pwm[k],
            truth.counts[k]
        ),
    };
    let text = lines(&truth, "", line);
    let directory = tempfile::tempdir().expect("a directory");
    let flags = [BOTH.as_slice(), &["--save-map", "map.toml"]].concat();
    let finished = import(directory.path(), "log.txt", &text, &flags);
    assert_eq!(finished.status, Some(1), "{}", finished.messages);
    assert!(
        finished.messages.contains("line 151: column `pwm`: `kp:2`"),
        "{}",
        finished.messages
    );
    let again = run(
        directory.path(),
        &["import", "log.txt", "--map", "map.toml", "-o", "again.csv"],
    );
    assert_eq!(again.status, Some(1), "{}", again.messages);
    let [first, again] =
        ["run.csv", "again.csv"].map(|name| RunFile::read(&directory.path().join(name)));
    assert_eq!(counts(&first).len(), truth.counts.len() - 1);
    assert_eq!(counts(&first), counts(&again));
}

#[test]
fn a_direction_in_a_column_of_its_own_signs_the_command() {
    let truth = Truth::steps(0.02, 400);
    let ms = |k: usize| truth.ms(k).to_string();
    let pwm = |k: usize| truth.pwm[k].abs().to_string();
    let rpm = |k: usize| truth.rpm(k).trim_start_matches('-').to_owned();
    let n = |k: usize| truth.counts[k].to_string();
    let forwards = |k: usize| u8::from(truth.pwm[k] >= 0).to_string();
    let backwards = |k: usize| u8::from(truth.pwm[k] < 0).to_string();
    let sign = |k: usize| truth.pwm[k].signum().to_string();
    let flags = BOTH.as_slice();
    let said = [flags, &["--direction", "way:1"]].concat();
    type Cell<'a> = &'a dyn Fn(usize) -> String;
    let cases: [(&str, [Cell; 4], &[&str]); 5] = [
        ("time_ms,pwm,dir,counts", [&ms, &pwm, &forwards, &n], flags),
        ("time_ms,pwm,dir,counts", [&ms, &pwm, &backwards, &n], flags),
        ("time_ms,pwm,sign,counts", [&ms, &pwm, &sign, &n], flags),
        ("time_ms,pwm,way,counts", [&ms, &pwm, &backwards, &n], &said),
        // Neither knows a sign: the direction's is both's.
        (
            "time_ms,pwm,direction,rpm",
            [&ms, &pwm, &forwards, &rpm],
            flags,
        ),
    ];
    for (names, cells, flags) in cases {
        let (file, said) = imported("log.csv", &log(names, truth.rows(), &cells), flags);
        assert!(said.contains("is backwards"), "{names}: {said}");
        near(&file.column("command_v"), &truth.commands(), 1e-9);
        if names.ends_with("counts") {
            assert_eq!(counts(&file), truth.counts, "{names}: {said}");
        } else {
            assert!(said.contains("it is the command's"), "{said}");
        }
    }
    let text = log(
        "time_ms,pwm,dir,counts",
        truth.rows(),
        &[&ms, &pwm, &forwards, &n],
    );
    let refused = asked(
        "log.csv",
        &text,
        &[flags, &["--direction", "dir:left"]].concat(),
    );
    assert!(refused.contains("such as dir:0"), "{refused}");
}

#[test]
fn a_command_may_be_a_sum_of_columns_held_to_a_limit() {
    let truth = Truth::steps(0.01, 300);
    let ms = |k: usize| truth.ms(k).to_string();
    let goal = |k: usize| format!("{}", (k / 60) as f64 * 4.0);
    let angle = |k: usize| format!("{:.6}", truth.turns(k) * std::f64::consts::TAU);
    let text = log(
        "time_ms,goal_rad,pos_rad",
        truth.rows(),
        &[&ms, &goal, &angle],
    );
    let flags = [
        "--command",
        "0.25*goal_rad-0.25*pos_rad:share",
        "--command-limit",
        "1",
        "--position",
        "pos_rad",
        "--supply",
        "12",
        "--counts-per-rev",
        "720",
    ];
    let (file, said) = imported("log.csv", &text, &flags);
    let number = |text: String| text.parse::<f64>().expect("a number");
    let law = |k: usize| (0.25 * (number(goal(k)) - number(angle(k)))).clamp(-1.0, 1.0) * 12.0;
    let wanted: Vec<f64> = truth.rows().map(law).collect();
    assert!(wanted.contains(&12.0) && wanted.iter().any(|u| u.abs() < 12.0));
    near(&file.column("command_v"), &wanted, 1e-9);
    assert_eq!(counts(&file), truth.counts, "{said}");
    let refused = asked(
        "log.csv",
        &text,
        &["--command", "pos_rad:V", "--command-limit", "1"],
    );
    assert!(refused.contains("is a sum of columns"), "{refused}");
}
