//! `motorlab import LOG` without a mapping: labelled numbers, directions in a separate column, commands that are
//! sums.

use std::fmt::Write as _;

use crate::support::command::{RunFile, run};
use crate::support::foreign_logs::{Truth, asked, counts, import, imported, log, near};

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
        // Neither has a sign: the direction applies to both.
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
fn a_direction_in_words_signs_the_command() {
    let truth = Truth::steps(0.02, 400);
    let ms = |k: usize| truth.ms(k).to_string();
    let pwm = |k: usize| truth.pwm[k].abs().to_string();
    let n = |k: usize| truth.counts[k].to_string();
    let unsigned = |k: usize| (truth.counts[k] - truth.counts[k.saturating_sub(1)]).abs();
    let rpm = |k: usize| format!("{:.2}", unsigned(k) as f64 / 720.0 / 0.02 * 60.0);
    for (forwards, backwards) in [("CW", "CCW"), ("F", "R"), ("fwd", "rev"), ("+", "-")] {
        let way = |k: usize| {
            if truth.pwm[k] < 0 {
                backwards
            } else {
                forwards
            }
            .to_owned()
        };
        let signed = log(
            "time_ms,pwm,dir,counts",
            truth.rows(),
            &[&ms, &pwm, &way, &n],
        );
        let (file, said) = imported("log.csv", &signed, &BOTH);
        assert!(
            said.contains(&format!("{backwards} is backwards, as the motion shows")),
            "{said}"
        );
        near(&file.column("command_v"), &truth.commands(), 1e-9);
        assert_eq!(counts(&file), truth.counts);
        // Without a sign of the motion only the words show it.
        let text = log(
            "time_ms,pwm,dir,rpm",
            truth.rows(),
            &[&ms, &pwm, &way, &rpm],
        );
        let (file, said) = imported("log.csv", &text, &BOTH);
        assert!(said.contains("by the word"), "{said}");
        near(&file.column("command_v"), &truth.commands(), 1e-9);
        let turned = format!("dir:{forwards}");
        let other = [&BOTH[..], &["--direction", &turned]].concat();
        let (file, _) = imported("log.csv", &text, &other);
        let turned: Vec<f64> = truth.commands().iter().map(|u| -u).collect();
        near(&file.column("command_v"), &turned, 1e-9);
    }
    let way = |k: usize| if truth.pwm[k] < 0 { "up" } else { "down" }.to_owned();
    let text = log(
        "time_ms,pwm,dir,rpm",
        truth.rows(),
        &[&ms, &pwm, &way, &rpm],
    );
    let said = asked("log.csv", &text, &BOTH);
    assert!(
        said.contains("--direction dir:WORD") && said.contains("down, up"),
        "{said}"
    );
    let flags = [
        &BOTH[..],
        &["--direction", "dir:up", "--save-map", "map.toml"],
    ]
    .concat();
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "log.csv", &text, &flags);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let arguments = ["import", "log.csv", "--map", "map.toml", "-o", "again.csv"];
    assert_eq!(run(directory.path(), &arguments).status, Some(0));
    for name in ["run.csv", "again.csv"] {
        let file = RunFile::read(&directory.path().join(name));
        near(&file.column("command_v"), &truth.commands(), 1e-9);
    }
}

#[test]
fn labels_may_have_units_behind_their_numbers() {
    let truth = Truth::steps(0.01, 300);
    let logs = [
        lines(&truth, "", |k| {
            let (ms, pwm, n) = (truth.ms(k), truth.pwm[k], truth.counts[k]);
            format!("Time: {ms} ms, PWM: {pwm}, Encoder: {n}")
        }),
        lines(&truth, "Kp: 2\n", |k| {
            let (ms, pwm) = (truth.ms(k), truth.pwm[k]);
            format!("Time={ms}ms PWM={pwm} RPM={}rpm", truth.rpm(k))
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
fn a_board_that_restarts_starts_a_new_run() {
    let truth = Truth::steps(0.005, 400);
    let row = |k: usize| format!("{},{},{}\n", truth.ms(k), truth.pwm[k], truth.counts[k]);
    let rows = |to: usize| (0..to).map(row).collect::<String>();
    let text = format!("time_ms,pwm,counts\n{}{}", rows(400), rows(300));
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "log.csv", &text, &BOTH);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    for (name, samples) in [("run.csv", 400), ("run-2.csv", 300)] {
        let file = RunFile::read(&directory.path().join(name));
        assert_eq!(counts(&file), truth.counts[..samples], "{name}");
        near(&file.column("t_s"), &truth.times()[..samples], 1e-9);
    }
    // A single row with a wrong time is a bad row, in the middle and at the end.
    for at in [200, 399] {
        let broken = |k: usize| match k {
            k if k == at => "3,0,0\n".to_owned(),
            k => row(k),
        };
        let text: String = (0..400).map(broken).collect();
        let directory = tempfile::tempdir().expect("a directory");
        let text = format!("time_ms,pwm,counts\n{text}");
        let finished = import(directory.path(), "log.csv", &text, &BOTH);
        assert_eq!(finished.status, Some(1), "{}", finished.messages);
        let said = format!("line {}: time goes from", at + 2);
        assert!(finished.messages.contains(&said), "{}", finished.messages);
        let file = RunFile::read(&directory.path().join("run.csv"));
        assert_eq!(counts(&file).len(), 399);
    }
}

#[test]
fn a_saved_mapping_reads_logs_with_other_banners() {
    let truth = Truth::steps(0.01, 300);
    let plain = truth.counts_log();
    let directory = tempfile::tempdir().expect("a directory");
    let flags = [&BOTH[..], &["--save-map", "map.toml"]].concat();
    let text = format!("rst:0x1 (POWERON_RESET),boot:0x13\n2,34\n{plain}");
    let finished = import(directory.path(), "log.csv", &text, &flags);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    for banner in ["", "rst:0x1\n", "a\nb\nc,d\n\n1,2,3\nready\n"] {
        std::fs::write(
            directory.path().join("next.csv"),
            format!("{banner}{plain}"),
        )
        .expect("written");
        let finished = run(
            directory.path(),
            &["import", "next.csv", "--map", "map.toml"],
        );
        assert_eq!(finished.status, Some(0), "{}", finished.messages);
        let path = directory.path().join("next.run.csv");
        assert_eq!(counts(&RunFile::read(&path)), truth.counts, "{banner}");
        std::fs::remove_file(path).expect("removed");
    }
}

#[test]
fn a_command_may_be_a_limited_sum_of_columns() {
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
    assert!(
        refused.contains("--command is no sum of columns"),
        "{refused}"
    );
}
