//! `motorlab import LOG` without a mapping: facts inferred from the numbers and the file name, and questions about
//! the others.

use crate::support::command::run;
use crate::support::foreign_logs::{Truth, asked, counts, import, imported, log, near, proposed};

const BOTH: [&str; 4] = ["--supply", "12", "--counts-per-rev", "720"];

#[test]
fn an_inferred_number_may_be_a_multiple_where_rows_are_averaged() {
    let truth = Truth::steps(0.02, 400);
    let mean = |k: usize| {
        let counts = truth.counts[k] - truth.counts[k.saturating_sub(3)];
        format!("{:.3}", counts as f64 / 3.0 / 720.0 / 0.02 * 60.0)
    };
    let text = log(
        "time_ms,pwm,rpm",
        truth.rows(),
        &[
            &|k| truth.ms(k).to_string(),
            &|k| truth.pwm[k].to_string(),
            &mean,
        ],
    );
    let (file, said) = imported("log.csv", &text, &["--supply", "12"]);
    assert_eq!(file.header["counts_per_rev"].as_float(), Some(3.0 * 720.0));
    assert!(
        said.contains("or a multiple of it where the sketch averages"),
        "{said}"
    );
}

#[test]
fn a_row_number_is_no_clock() {
    let truth = Truth::steps(0.02, 300);
    let number = |k: usize| k.to_string();
    let pwm = |k: usize| truth.pwm[k].to_string();
    let rpm = |k: usize| truth.rpm(k);
    let ms = |k: usize| truth.ms(k).to_string();
    for name in ["sample", "n", "index", "Sample", "i", ""] {
        let text = log(
            &format!("{name},pwm,rpm"),
            truth.rows(),
            &[&number, &pwm, &rpm],
        );
        let said = asked("log.csv", &text, &["--supply", "12"]);
        assert!(said.contains("counts the rows and is no clock"), "{said}");
        let words = proposed(&said, &[("SAMPLETIME", "20ms")]);
        let flags: Vec<&str> = words.iter().map(String::as_str).collect();
        let (file, _) = imported("log.csv", &text, &flags);
        assert_eq!(counts(&file), truth.counts);
        near(&file.column("t_s"), &truth.times(), 1e-9);
        // With a clock it is no question, as in files of pandas.
        let text = log(
            &format!("{name},time_ms,pwm,rpm"),
            truth.rows(),
            &[&number, &ms, &pwm, &rpm],
        );
        let (file, _) = imported("log.csv", &text, &["--supply", "12"]);
        assert_eq!(counts(&file), truth.counts);
        near(&file.column("t_s"), &truth.times(), 1e-9);
    }
}

/// A ramp of a second in some forty counts: the position increases with the command, and its speed does within
/// quantization.
#[test]
fn a_coarse_position_under_a_ramp_is_recognized() {
    let text: String = (0..100)
        .map(|k| {
            let t = 0.01 * f64::from(k);
            let counts = (100.0 * (1.0 - t.cos())).round();
            format!("{},{:.4},{counts}\n", 10 * k, t.sin())
        })
        .collect();
    let (file, _) = imported("log.csv", &format!("time_ms,u_v,counts\n{text}"), &BOTH);
    assert_eq!(counts(&file).last(), Some(&45));
}

#[test]
fn counts_per_row_are_separated_from_a_position() {
    let truth = Truth::steps(0.02, 400);
    let ms = |k: usize| truth.ms(k).to_string();
    let pwm = |k: usize| truth.pwm[k].to_string();
    let change = |k: usize| truth.counts[k] - truth.counts[k.saturating_sub(1)];
    let both = ["--supply", "12", "--counts-per-rev", "720"];
    for name in ["counts", "encoder", "readAndReset"] {
        let text = log(
            &format!("time_ms,pwm,{name}"),
            truth.rows(),
            &[&ms, &pwm, &|k| change(k).to_string()],
        );
        let flags: Vec<String> = match name {
            "readAndReset" => both.map(str::to_owned).to_vec(),
            _ => {
                let said = asked("log.csv", &text, &both);
                assert!(said.contains("follows the command"), "{said}");
                proposed(&said, &[])
            }
        };
        let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        let (file, said) = imported("log.csv", &text, &flags);
        assert_eq!(counts(&file), truth.counts, "{said}");
        // A position nevertheless, as stated.
        let position = format!("{name}:counts");
        let said_so = [&both[..], &["--position", &position]].concat();
        let (file, said) = imported("log.csv", &text, &said_so);
        if name != "readAndReset" {
            assert!(said.contains("--increments sums them up"), "{said}");
            assert_eq!(counts(&file), truth.rows().map(change).collect::<Vec<_>>());
        }
    }
}

#[test]
fn the_voltage_in_a_file_name_is_read_in_every_notation() {
    let truth = Truth::of(0.01, (0..300).map(|k| if k < 100 { 0 } else { 255 }));
    let text: String = (truth.rows())
        .map(|k| format!("{:.3},{}\n", truth.t_s(k), truth.rpm(k)))
        .collect();
    for (name, command) in [
        ("9.5V.csv", "9.5V@1s"),
        ("motor_9,5_V.csv", "COLUMN:UNIT"),
        ("test-12V.csv", "12V@1s"),
        ("data(6V).csv", "6V@1s"),
        ("pwm120.csv", "120pwm@1s"),
        ("9_5V.csv", "COLUMN:UNIT"),
        ("9V_24V.csv", "COLUMN:UNIT"),
    ] {
        let said = asked(name, &text, &[]);
        assert!(
            said.contains(&format!("--command {command}")),
            "{name}: {said}"
        );
    }
    let said = asked("9_5V.csv", &text, &[]);
    assert!(
        said.contains("the file's name may say 5V or 9.5V"),
        "{said}"
    );
    // The duty cycle in a comment.
    let text = format!(
        "# Duty = 25 %\n{}",
        truth.rpm_log("time_ms,x,rpm").replace("x", "ignored")
    );
    let (file, _) = imported("log.csv", &text, &["--supply", "12"]);
    near(&file.column("command_v"), &[3.0; 300], 1e-9);
}

#[test]
fn an_angle_within_one_turn_is_proposed_with_its_unit_and_wrap() {
    let truth = Truth::steps(0.1, 300);
    let ms = |k: usize| truth.ms(k).to_string();
    let pwm = |k: usize| truth.pwm[k].to_string();
    // So fast that only the range shows it.
    let degrees = |k: usize| (truth.turns(k) * 360.0 + 180.0).rem_euclid(360.0) - 180.0;
    let raw = |k: usize| (truth.turns(k) * 4096.0).round().rem_euclid(4096.0);
    for (names, cell, says) in [
        (
            "time_ms,pwm,angle",
            &(|k| format!("{:.1}", degrees(k))) as &dyn Fn(usize) -> String,
            ["--position angle:deg", "--wrap 360"],
        ),
        (
            "time_ms,pwm,raw_angle",
            &|k| raw(k).to_string(),
            ["--position raw_angle:counts", "--wrap 4096"],
        ),
    ] {
        let text = log(names, truth.rows(), &[&ms, &pwm, cell]);
        let said = asked("log.csv", &text, &BOTH[..2]);
        assert!(says.iter().all(|says| said.contains(says)), "{said}");
        let flags = [&says[0][..10], &says[0][11..], "--wrap", &says[1][7..]];
        let counts_per_rev = ["--supply", "12", "--counts-per-rev", "4096"];
        let (file, _) = imported("log.csv", &text, &[flags, counts_per_rev].concat());
        let turned: Vec<f64> = truth.rows().map(|k| truth.turns(k) * 4096.0).collect();
        near(&file.column("counts"), &turned, 1.2);
    }
}

#[test]
fn swapped_wires_are_reversed_by_a_flag() {
    let truth = Truth::steps(0.01, 300);
    let ms = |k: usize| truth.ms(k).to_string();
    let pwm = |k: usize| truth.pwm[k].to_string();
    let n = |k: usize| (-truth.counts[k]).to_string();
    let text = log("time_ms,pwm,counts", truth.rows(), &[&ms, &pwm, &n]);
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "log.csv", &text, &BOTH);
    assert_eq!(finished.status, Some(1));
    assert!(finished.messages.contains("--reverse of the import"));
    let flags = [&BOTH[..], &["--reverse"]].concat();
    let (file, _) = imported("log.csv", &text, &flags);
    assert_eq!(counts(&file), truth.counts);
    let rpm = |k: usize| truth.rpm(k).parse::<f64>().expect("rpm");
    let back = |k: usize| format!("{:.2}", -rpm(k));
    let text = log("time_ms,pwm,rpm", truth.rows(), &[&ms, &pwm, &back]);
    let (file, _) = imported("log.csv", &text, &flags);
    assert_eq!(counts(&file), truth.counts);
}

#[test]
fn the_proposed_line_keeps_force_and_names_that_begin_with_a_dash() {
    let truth = Truth::steps(0.01, 300);
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("-log.csv"), truth.counts_log()).expect("written");
    let finished = run(directory.path(), &["import", "--force", "--", "-log.csv"]);
    let line = "motorlab import ./-log.csv --force --counts-per-rev COUNTS --supply VOLTS";
    assert!(finished.messages.contains(line), "{}", finished.messages);
    let arguments = ["import", "./-log.csv", "--force"];
    let done = run(directory.path(), &[&arguments[..], &BOTH].concat());
    assert_eq!(done.status, Some(0), "{}", done.messages);
}
