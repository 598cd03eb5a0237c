//! Facts about a log by flags or a mapping, and their results.

use std::fs;

use crate::support::command::{RunFile, run};
use crate::support::foreign_logs::{Truth, asked, counts, import, imported, log, near};

#[test]
fn a_pwm_beyond_full_scale_is_full_drive_and_reported() {
    let truth = Truth::of(0.01, (0..300).map(|k| if k < 20 { 0 } else { 312 }));
    let text = truth.counts_log();
    let flags = ["--supply", "12", "--counts-per-rev", "720"];
    let said = asked("log.csv", &text, &flags);
    assert!(said.contains("the largest of the log is 312"), "{said}");
    let (file, said) = imported(
        "log.csv",
        &text,
        &[&flags[..], &["--pwm-full", "255"]].concat(),
    );
    assert!(
        said.contains("280 of 300 rows command more than full drive, up to 1.224"),
        "{said}"
    );
    assert_eq!(file.column("command_v")[299], 12.0);
    assert_eq!(file.summary("beyond_full_drive"), 280);
}

#[test]
fn a_number_before_a_colon_is_a_column_and_not_a_time() {
    let text: String = (0..300_u32)
        .map(|k| format!("{},{}\n", k * k / 100, k * 2000))
        .collect();
    let flags = [
        "--position",
        "1:counts",
        "--time",
        "2:us",
        "--command",
        "7V@0.1s",
        "--counts-per-rev",
        "720",
    ];
    let (file, said) = imported("log.csv", &text, &flags);
    assert!(said.contains("column 2 in us"), "{said}");
    near(&file.column("t_s")[299..], &[0.598], 1e-9);
}

#[test]
fn counters_that_wrap_increments_and_one_channel() {
    let truth = Truth::of(
        0.01,
        (0..600).map(|k| {
            if k < 20 {
                0
            } else if k < 400 {
                250
            } else {
                -250
            }
        }),
    );
    let ms = |k: usize| truth.ms(k).to_string();
    let pwm = |k: usize| truth.pwm[k].to_string();
    let flags = ["--supply", "12", "--counts-per-rev", "720"];
    let signed = |k: usize| (truth.counts[k] * 50 + 30_000) as i16;
    let (file, said) = imported(
        "log.csv",
        &log(
            "time_ms,pwm,counts",
            truth.rows(),
            &[&ms, &pwm, &|k| signed(k).to_string()],
        ),
        &flags,
    );
    assert!(said.contains("begins anew after 65536"), "{said}");
    let fifty: Vec<i64> = truth.counts.iter().map(|n| 50 * n + 30_000).collect();
    assert_eq!(counts(&file), fifty);
    let change = |k: usize| truth.counts[k] - truth.counts[k.saturating_sub(1)];
    let text = log(
        "time_ms,pwm,enc",
        truth.rows(),
        &[&ms, &pwm, &|k| change(k).to_string()],
    );
    let (file, _) = imported("log.csv", &text, &[&flags[..], &["--increments"]].concat());
    assert_eq!(counts(&file), truth.counts);
    // One channel: the sign is the command's, so that forward motion after the command has changed is counted
    // backwards.
    let text = log(
        "time_ms,pwm,pulses",
        truth.rows(),
        &[&ms, &pwm, &|k| change(k).abs().to_string()],
    );
    let said = asked("log.csv", &text, &[&flags[..], &["--increments"]].concat());
    assert!(
        said.contains("--unsigned") && said.contains("never goes backwards"),
        "{said}"
    );
    let (file, _) = imported(
        "log.csv",
        &text,
        &[&flags[..], &["--increments", "--unsigned"]].concat(),
    );
    let found = counts(&file);
    assert_eq!(found[..401], truth.counts[..401]);
    let expected: Vec<i64> = (401..600).map(|k| -change(k).abs()).collect();
    let changes: Vec<i64> = found[400..]
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    assert_eq!(changes, expected);
    assert_eq!(
        file.header["imported"]["sign"].as_str(),
        Some("the command's")
    );
}

#[test]
fn a_speed_is_integrated_by_the_stated_rule() {
    let truth = Truth::steps(0.01, 400);
    let text = truth.rpm_log("time_ms,pwm,rpm");
    let flags = ["--supply", "12", "--counts-per-rev", "720"];
    let (backward, said) = imported("log.csv", &text, &flags);
    assert!(said.contains("a position (backward)"), "{said}");
    assert_eq!(counts(&backward), truth.counts);
    let flags = [&flags[..], &["--integrate", "trapezoid"]].concat();
    let (trapezoid, said) = imported("log.csv", &text, &flags);
    assert!(said.contains("a position (trapezoid)"), "{said}");
    // Half of the first and of the last step are missing from an integral of means.
    let half = |k: usize| (truth.counts[k] - truth.counts[k - 1]) as f64 / 2.0;
    let expected: Vec<f64> = (1..400)
        .map(|k| truth.counts[k] as f64 - truth.counts[0] as f64 - half(k))
        .collect();
    near(&trapezoid.column("counts")[1..], &expected, 0.75);
    assert_eq!(
        trapezoid.header["imported"]["position"].as_str(),
        Some("integrated from speed, trapezoid")
    );
}

#[test]
fn a_filtered_speed_is_found_by_its_missing_steps() {
    let truth = Truth::steps(0.01, 400);
    let mut filtered = vec![0.0];
    for k in 1..400 {
        let rpm = truth.rpm(k).parse::<f64>().expect("rpm");
        let before = filtered[k - 1];
        filtered.push(before + 0.15 * (rpm - before));
    }
    let text = log(
        "time_ms,pwm,rpm",
        truth.rows(),
        &[
            &|k| truth.ms(k).to_string(),
            &|k| truth.pwm[k].to_string(),
            &|k| format!("{:.3}", filtered[k]),
        ],
    );
    let (_, said) = imported(
        "log.csv",
        &text,
        &["--supply", "12", "--counts-per-rev", "720"],
    );
    assert!(said.contains("speed_filter"), "{said}");
    let (_, said) = imported(
        "log.csv",
        &truth.rpm_log("time_ms,pwm,rpm"),
        &["--supply", "12"],
    );
    assert!(!said.contains("speed_filter"), "{said}");
}

#[test]
fn keeping_one_row_of_many_keeps_the_volt_seconds() {
    let truth = Truth::steps(0.002, 1000);
    let text = truth.counts_log();
    let flags = ["--supply", "12", "--counts-per-rev", "720", "--every", "7"];
    let (file, _) = imported("log.csv", &text, &flags);
    let seventh: Vec<i64> = truth.counts.iter().copied().step_by(7).collect();
    assert_eq!(counts(&file), seventh);
    let t_s = file.column("t_s");
    let found: f64 = (file.column("command_v").iter().zip(t_s.windows(2)))
        .map(|(u, pair)| u * (pair[1] - pair[0]))
        .sum();
    let last = 7 * (seventh.len() - 1);
    let wanted: f64 = truth.commands()[..last].iter().map(|u| u * 0.002).sum();
    assert!((found - wanted).abs() < 1e-6, "{found} for {wanted}");
    assert_eq!(file.header["sample_time_s"].as_float(), Some(0.014));
}

#[test]
fn a_command_of_columns_is_their_sum_within_its_limit() {
    let map = "counts_per_rev = 4096\nsupply_v = 12\n[time]\ncolumn = \"t\"\nunit = \"s\"\n\
        [command]\nsum = [{ column = \"goal\", factor = 2.0 }, { column = \"pos\", factor = -2.0 }]\nlimit = 1.0\nunit = \"share\"\n\
        [position]\ncolumn = \"pos\"\nunit = \"rad\"\n";
    let directory = tempfile::tempdir().expect("a directory");
    fs::write(directory.path().join("map.toml"), map).expect("written");
    let text = "t,goal,pos\n0,0,0\n0.01,0.1,0\n0.02,2,0\n0.03,-2,0.5\n";
    let finished = import(directory.path(), "log.csv", text, &["--map", "map.toml"]);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    near(&file.column("command_v"), &[0.0, 2.4, 12.0, -12.0], 1e-12);
    assert_eq!(
        file.header["imported"]["command"].as_str(),
        Some("sum of columns")
    );
}

#[test]
fn a_saved_mapping_imports_the_same() {
    let truth = Truth::steps(0.02, 200);
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path();
    let text = truth.rpm_log("time_ms,pwm,rpm");
    let finished = import(
        path,
        "log.csv",
        &text,
        &["--supply", "12", "--save-map", "map.toml"],
    );
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let again = run(
        path,
        &["import", "log.csv", "--map", "map.toml", "-o", "again.csv"],
    );
    assert_eq!(again.status, Some(0), "{}", again.messages);
    let read = |name: &str| fs::read_to_string(path.join(name)).expect("a run");
    assert_eq!(read("run.csv"), read("again.csv"));
    // A flag replaces the mapping's entry.
    let flags = [
        "import", "log.csv", "--map", "map.toml", "--supply", "6", "-o", "six.csv",
    ];
    assert_eq!(run(path, &flags).status, Some(0));
    let half: Vec<f64> = truth.commands().iter().map(|u| u / 2.0).collect();
    near(
        &RunFile::read(&path.join("six.csv")).column("command_v"),
        &half,
        1e-9,
    );
    // A file that this command did not write is not replaced.
    fs::write(path.join("mine.toml"), "a = 1\n").expect("written");
    let flags = [
        "import",
        "log.csv",
        "--supply",
        "12",
        "--save-map",
        "mine.toml",
        "-o",
        "seven.csv",
    ];
    assert_eq!(run(path, &flags).status, Some(2));
    assert!(!path.join("seven.csv").exists());
}

#[test]
fn other_commands_hint_at_the_import_of_a_foreign_log() {
    let truth = Truth::steps(0.02, 100);
    let directory = tempfile::tempdir().expect("a directory");
    let text = truth.rpm_log("time_ms,pwm,rpm");
    fs::write(directory.path().join("log.csv"), text).expect("written");
    let finished = run(directory.path(), &["lab", "--run", "log.csv"]);
    assert_eq!(finished.status, Some(2));
    for words in ["motorlab import log.csv --supply VOLTS", "log.run.csv"] {
        assert!(finished.messages.contains(words), "{}", finished.messages);
    }
    // A letter is no log, and a run without its header no foreign one.
    for other in [
        "Dear reader,\nno log\n",
        "t_s,command_v,counts\n0,0,0\n0.01,0,0\n0.02,1,1\n",
    ] {
        fs::write(directory.path().join("other.csv"), other).expect("written");
        let finished = run(directory.path(), &["check", "other.csv"]);
        assert_eq!(finished.status, Some(2));
        assert!(
            !finished.messages.contains("motorlab import other.csv"),
            "{}",
            finished.messages
        );
    }
    // Other columns are reported.
    for (other, what) in [
        (&b""[..], "it is empty"),
        (b"PK\x03\x04xl/workbook.xml", "which is not read"),
        (b"{\"a\": [1, 2]}", "it is nested JSON, which is not read"),
        (b"hello,world\n", "no table of numbers"),
    ] {
        fs::write(directory.path().join("other.csv"), other).expect("written");
        for command in ["diagnose", "compare", "check"] {
            let finished = run(directory.path(), &[command, "other.csv"]);
            assert_eq!(finished.status, Some(2));
            let said = finished.messages;
            assert!(
                said.contains("other.csv: it is no run file") && said.contains(what),
                "{said}"
            );
            assert!(!said.contains("counts_per_rev"), "{said}");
        }
    }
}

#[test]
fn flags_without_a_match_are_refused_with_the_choices() {
    let truth = Truth::steps(0.02, 100);
    let text = truth.rpm_log("time_ms,pwm,rpm");
    for (flags, wanted) in [
        (&["--speed", "rmp"][..], "there is no such column"),
        (&["--speed", "rpm:furlong"], "`furlong` is no unit"),
        (
            &["--speed", "rpm", "--position", "pwm:counts"],
            "exclude each other",
        ),
        (
            &["--integrate", "simpson"],
            "backward, trapezoid or forward",
        ),
        (
            &[
                "--position",
                "rpm:counts",
                "--integrate",
                "trapezoid",
                "--supply",
                "12",
                "--counts-per-rev",
                "720",
            ],
            "no speed is read",
        ),
        (&["--command", "7V@"], "7V@0.95s"),
        (&["--every", "0"], "0"),
        (&["--pwm-full", "0"], "above 0"),
    ] {
        let said = asked("log.csv", &text, flags);
        assert!(said.contains(wanted), "{flags:?}: {said}");
    }
    let said = asked("letter.txt", "Dear reader,\nthis is no log\n", &[]);
    assert!(
        said.contains("no table of numbers") && said.contains("Dear reader"),
        "{said}"
    );
    let holes = "time_ms,counts\n0,\n10,0\n20,0\n30,5\n40,9\n";
    let said = asked("step_12V.csv", holes, &[]);
    assert!(said.contains("--command 12V@0.02s"), "{said}");
    let said = asked("table.xlsx", "PK\u{3}\u{4} and more", &[]);
    assert!(said.contains("ZIP archive"), "{said}");
    let _ = asked("empty.csv", "", &[]);
}

#[test]
fn a_bare_number_is_volts_in_a_log_of_many_columns() {
    let truth = Truth::steps(0.01, 200);
    let ms = |k: usize| truth.ms(k).to_string();
    let pwm = |k: usize| truth.pwm[k].to_string();
    let rest = |k: usize| vec!["9"; 13].join(",") + &format!(",{}", truth.counts[k]);
    let names: Vec<String> = (1..=13).map(|k| format!("x{k}")).collect();
    let names = format!("time_ms,pwm,{},counts", names.join(","));
    let text = log(&names, truth.rows(), &[&ms, &pwm, &rest]);
    let flags = ["--supply", "12", "--counts-per-rev", "720"];
    let (file, said) = imported("log.csv", &text, &flags);
    assert!(said.contains("a share of 12 V"), "{said}");
    assert_eq!(counts(&file), truth.counts);
    near(&file.column("command_v"), &truth.commands(), 1e-9);
}
