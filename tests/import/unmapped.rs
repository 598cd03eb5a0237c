//! `motorlab import LOG` without a mapping: generated logs of a motor with known counts, times and commands.

use crate::support::command::RunFile;
use crate::support::foreign_logs::{
    COUNTS_PER_REV, Truth, asked, counts, import, imported, log, near, proposed,
};

#[test]
fn a_log_of_counts_is_read_by_any_column_names() {
    let truth = Truth::steps(0.01, 300);
    let ms = |k: usize| format!("{}", truth.ms(k));
    let us = |k: usize| format!("{}", truth.ms(k) * 1000);
    let s = |k: usize| format!("{:.3}", truth.t_s(k));
    let pwm = |k: usize| truth.pwm[k].to_string();
    let volts = |k: usize| format!("{:.6}", truth.volts(k));
    let n = |k: usize| truth.counts[k].to_string();
    let deg = |k: usize| format!("{:.2}", truth.turns(k) * 360.0);
    let rad = |k: usize| format!("{:.6}", truth.turns(k) * std::f64::consts::TAU);
    let supply = ["--supply", "12"].as_slice();
    let both = ["--supply", "12", "--counts-per-rev", "720"].as_slice();
    type Cell<'a> = &'a dyn Fn(usize) -> String;
    let cases: [(&str, [Cell<'_>; 3], &[&str]); 9] = [
        ("time_ms,pwm,counts", [&ms, &pwm, &n], both),
        ("millis;PWM;encoder", [&ms, &pwm, &n], both),
        (
            "t_us,cmd [V],Encoder Count",
            [&us, &volts, &n],
            &["--counts-per-rev", "720"],
        ),
        (
            "t\tu (V)\ttheta (rad)",
            [&s, &volts, &rad],
            &["--counts-per-rev", "720"],
        ),
        ("Time (s),duty_255,angle_deg", [&s, &pwm, &deg], both),
        (
            "time voltage angle_deg",
            [&s, &volts, &deg],
            &["--counts-per-rev", "720"],
        ),
        (
            "micros,pwm,position_counts_720_per_rev",
            [&us, &pwm, &n],
            supply,
        ),
        ("time,pwm,enc", [&ms, &pwm, &n], both),
        ("x,pwm,enc", [&us, &pwm, &n], both),
    ];
    for (names, cells, flags) in cases {
        let (file, said) = imported("log.csv", &log(names, truth.rows(), &cells), flags);
        assert_eq!(counts(&file), truth.counts, "{names}\n{said}");
        near(&file.column("t_s"), &truth.times(), 1e-9);
        near(&file.column("command_v"), &truth.commands(), 1e-4);
        assert_eq!(
            file.header["counts_per_rev"].as_float(),
            Some(720.0),
            "{names}"
        );
    }
}

#[test]
fn the_most_common_log_is_read_and_its_counts_are_reconstructed() {
    let truth = Truth::steps(0.02, 400);
    let text = truth.rpm_log("time_ms,pwm,rpm");
    let (file, said) = imported("log.csv", &text, &["--supply", "12"]);
    assert_eq!(counts(&file), truth.counts, "{said}");
    assert_eq!(
        file.header["counts_per_rev"].as_float(),
        Some(COUNTS_PER_REV)
    );
    near(&file.column("command_v"), &truth.commands(), 1e-9);
    for words in [
        "720 counts per revolution, read off",
        "255 is full drive",
        "`time_ms` in ms, a row every 0.02 s",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn missing_facts_are_one_message_with_a_command_line() {
    let truth = Truth::steps(0.01, 200);
    let text = truth.counts_log();
    let said = asked("my log.csv", &text, &[]);
    for words in [
        "this log lacks 2 facts",
        "--supply VOLTS",
        "--counts-per-rev COUNTS",
        "motorlab import 'my log.csv' -o run.csv",
        "`pwm` in pwm",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let said = asked("log.csv", &text, &[]);
    let words = proposed(&said, &[("VOLTS", "12"), ("COUNTS", "720")]);
    let flags: Vec<&str> = words.iter().map(String::as_str).collect();
    let (file, _) = imported("log.csv", &text, &flags);
    assert_eq!(counts(&file), truth.counts);
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(
        directory.path(),
        "log.csv",
        &text,
        &[&flags[..], &["--json"]].concat(),
    );
    let document: serde_json::Value = serde_json::from_str(&finished.output).expect("JSON");
    let understood = &document["understood"];
    assert_eq!(understood[0]["what"], "time");
    assert_eq!(understood[0]["column"], "time_ms");
    assert_eq!(understood[0]["unit"], "ms");
    // The same as a document.
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "log.csv", &text, &["--json"]);
    let document: serde_json::Value = serde_json::from_str(&finished.output).expect("JSON");
    let message = document["error"]["message"].as_str().expect("words");
    assert!(message.contains("motorlab import log.csv"), "{message}");
}

#[test]
fn ambiguous_names_and_numbers_are_asked_and_not_guessed() {
    let truth = Truth::steps(0.01, 200);
    let n = |k: usize| truth.counts[k].to_string();
    let pwm = |k: usize| truth.pwm[k].to_string();
    let ms = |k: usize| truth.ms(k).to_string();
    let deg = |k: usize| format!("{:.2}", truth.turns(k) * 360.0);
    let supply = ["--supply", "12", "--counts-per-rev", "720"];
    // Degrees or radians.
    let said = asked(
        "log.csv",
        &log("time_ms,pwm,angle", truth.rows(), &[&ms, &pwm, &deg]),
        &supply,
    );
    assert!(
        said.contains("`angle` names no unit") && said.contains("--position angle:deg"),
        "{said}"
    );
    // A clock with steps of 500 counts us or ms.
    let half = |k: usize| (500 * k).to_string();
    let said = asked(
        "log.csv",
        &log("time,pwm,counts", truth.rows(), &[&half, &pwm, &n]),
        &supply,
    );
    assert!(
        said.contains("`time` goes on by 500") && said.contains("--time time:ms"),
        "{said}"
    );
    // Volts or PWM.
    let few = |k: usize| (truth.pwm[k] / 20).to_string();
    let said = asked(
        "log.csv",
        &log("time_ms,u,counts", truth.rows(), &[&ms, &few, &n]),
        &supply,
    );
    assert!(said.contains("`u` names no unit"), "{said}");
    // Up to 100: percent or of 255.
    let low = |k: usize| (truth.pwm[k] / 3).to_string();
    let said = asked(
        "log.csv",
        &log("time_ms,pwm,counts", truth.rows(), &[&ms, &low, &n]),
        &supply,
    );
    assert!(said.contains("--pwm-full 255"), "{said}");
    // No command.
    let said = asked(
        "log.csv",
        &log("time_ms,counts", truth.rows(), &[&ms, &n]),
        &supply,
    );
    assert!(
        said.contains("no column is named as a command") && said.contains("6V@0.5s"),
        "{said}"
    );
}

#[test]
fn a_choice_of_two_motors_is_asked() {
    let truth = Truth::steps(0.02, 400);
    let rpm = |k: usize| truth.rpm(k);
    let other = |k: usize| format!("{:.2}", 0.5 * truth.rpm(k).parse::<f64>().expect("rpm"));
    let text = log(
        "time_ms,pwm_left,pwm_right,rpm_left,rpm_right",
        truth.rows(),
        &[
            &|k| truth.ms(k).to_string(),
            &|k| truth.pwm[k].to_string(),
            &|k| (-truth.pwm[k]).to_string(),
            &rpm,
            &other,
        ],
    );
    let said = asked("log.csv", &text, &["--supply", "12"]);
    assert!(
        said.contains("`rpm_left`, `rpm_right`") && said.contains("or --speed rpm_right"),
        "{said}"
    );
    // With the speed its own command is used.
    let (file, _) = imported("log.csv", &text, &["--supply", "12", "--speed", "rpm_left"]);
    assert_eq!(counts(&file), truth.counts);
    near(&file.column("command_v"), &truth.commands(), 1e-9);
}

#[test]
fn blocks_separated_by_names_and_comments_are_runs() {
    let truth = Truth::steps(0.02, 200);
    let (first, second) = (
        truth.rpm_log("time_ms,pwm,rpm"),
        truth.rpm_log("time_ms,pwm,rpm"),
    );
    let text =
        format!("Motor test v2\n# Step 1/2 | PWM = 200\n{first}# Step 2/2 | PWM = 200\n{second}");
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "log.csv", &text, &["--supply", "12"]);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    for name in ["run.csv", "run-2.csv"] {
        let file = RunFile::read(&directory.path().join(name));
        assert_eq!(counts(&file), truth.counts, "{name}");
    }
    // Without a column, the command is taken from the comment lines.
    let truth = Truth::of(0.02, (0..200).map(|k| if k < 100 { 200 } else { -120 }));
    let block = |pwm: i64, from: usize| {
        let rows = log(
            "time_ms,rpm",
            from..from + 100,
            &[&|k| truth.ms(k).to_string(), &|k| truth.rpm(k)],
        );
        format!("# Step | PWM = {pwm}\n{rows}")
    };
    let text = block(200, 0) + &block(-120, 100);
    let (file, said) = imported("log.csv", &text, &["--supply", "12"]);
    assert!(
        said.contains("the number after `pwm` in comment lines"),
        "{said}"
    );
    assert_eq!(counts(&file), truth.counts);
    let commands = file.column("command_v");
    near(&commands[..100], &[200.0 / 255.0 * 12.0; 100], 1e-9);
    near(&commands[100..], &[-120.0 / 255.0 * 12.0; 100], 1e-9);
}

#[test]
fn two_columns_without_names_and_the_voltage_in_the_files_name() {
    let truth = Truth::of(0.01, (0..300).map(|k| if k < 100 { 0 } else { 255 }));
    let text: String = (truth.rows())
        .map(|k| format!("{:.3},{}\n", truth.t_s(k), truth.rpm(k)))
        .collect();
    let said = asked("first_12V.csv", &text, &[]);
    assert!(
        said.contains("--speed 2:rpm") && said.contains("--command 12V@1s"),
        "{said}"
    );
    let words = proposed(&said, &[]);
    let flags: Vec<&str> = words.iter().map(String::as_str).collect();
    let (file, _) = imported("first_12V.csv", &text, &flags);
    assert_eq!(counts(&file), truth.counts);
    near(&file.column("command_v"), &truth.commands(), 1e-9);
}

#[test]
fn decimal_commas_time_stamps_and_a_row_of_units() {
    let truth = Truth::steps(0.01, 200);
    let comma = |text: String| text.replace('.', ",");
    let rows = |line: &dyn Fn(usize) -> String| -> String {
        truth.rows().map(|k| line(k) + "\n").collect()
    };
    let flags = ["--counts-per-rev", "720"];
    let german = rows(&|k| {
        comma(format!(
            "{:.3};{:.6};{:.2}",
            truth.t_s(k),
            truth.volts(k),
            truth.turns(k) * 360.0
        ))
    });
    let (file, said) = imported(
        "log.csv",
        &format!("Messung 3\nZeit;Spannung;Winkel\ns;V;°\n{german}"),
        &flags,
    );
    assert_eq!(counts(&file), truth.counts, "{said}");
    near(&file.column("command_v"), &truth.commands(), 1e-5);
    let stamp = |k: usize| {
        let ms = 45_296_000 + truth.ms(k);
        format!(
            "{:02}:{:02}:{:02}.{:03}",
            ms / 3_600_000,
            ms / 60_000 % 60,
            ms / 1000 % 60,
            ms % 1000
        )
    };
    let monitor = rows(&|k| format!("{} -> {},{}", stamp(k), truth.pwm[k], truth.counts[k]));
    let flags = ["--supply", "12", "--counts-per-rev", "720"];
    let (file, _) = imported(
        "log.txt",
        &format!("{} -> pwm,counts\n{monitor}", stamp(0)),
        &flags,
    );
    assert_eq!(counts(&file), truth.counts);
    near(&file.column("t_s"), &truth.times(), 1e-9);
}

#[test]
fn cells_of_a_slower_column_hold_their_last_value() {
    let truth = Truth::steps(0.01, 200);
    let text: String = truth
        .rows()
        .map(|k| {
            let is_new = k == 0 || truth.pwm[k] != truth.pwm[k - 1];
            let command = if is_new {
                format!("{:.3},{:.6},\n", truth.t_s(k), truth.volts(k))
            } else {
                String::new()
            };
            format!("{command}{:.3},,{}\n", truth.t_s(k), truth.counts[k])
        })
        .collect();
    let (file, said) = imported(
        "log.csv",
        &format!("__time,/motor/voltage,/encoder/counts\n{text}"),
        &["--counts-per-rev", "720"],
    );
    assert!(said.contains("the command holds its last value"), "{said}");
    assert_eq!(counts(&file), truth.counts);
    near(&file.column("command_v"), &truth.commands(), 1e-5);
}
