//! Published logs of real motors, imported without a mapping and read here independently in the simplest way.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::support;
use crate::support::command::{Finished, RunFile, run};

/// Imports a log with these flags; the run, and the messages.
fn import(log: &Path, flags: &[&str]) -> (Finished, Option<RunFile>) {
    let directory = tempfile::tempdir().expect("a directory");
    let log = log.to_str().expect("a name");
    let done = run(
        directory.path(),
        &[&["import", log, "-o", "run.csv"], flags].concat(),
    );
    let path = directory.path().join("run.csv");
    let file = path.exists().then(|| RunFile::read(&path));
    (done, file)
}

fn imported(log: &Path, flags: &[&str]) -> (RunFile, String) {
    let (done, file) = import(log, flags);
    let file = file.unwrap_or_else(|| panic!("{}: {}", log.display(), done.messages));
    (file, done.messages)
}

/// Columns of numbers, from the first numeric row on.
fn columns(log: &Path, separator: char) -> Vec<Vec<f64>> {
    let bytes = fs::read(log).expect("the log");
    let mut text = String::new();
    match log.extension().is_some_and(|extension| extension == "gz") {
        true => flate2::read::GzDecoder::new(bytes.as_slice()).read_to_string(&mut text),
        false => bytes.as_slice().read_to_string(&mut text),
    }
    .expect("text");
    let rows: Vec<Vec<f64>> = (text.lines())
        .filter_map(|line| {
            line.split(separator)
                .map(|cell| cell.trim().parse().ok())
                .collect()
        })
        .collect();
    (0..rows[0].len())
        .map(|at| rows.iter().map(|row| row[at]).collect())
        .collect()
}

fn real(test: &str) -> Option<PathBuf> {
    support::real_recordings(test)
}

#[test]
fn counts_are_reconstructed_from_a_speed_in_steps() {
    let Some(folder) = real("counts_are_reconstructed_from_a_speed_in_steps") else {
        return;
    };
    let log = folder.join("three_levels/first_12V.csv");
    let (done, _) = import(&log, &[]);
    assert!(
        done.messages.contains("--speed 2:rpm --command 12V@2s"),
        "{}",
        done.messages
    );
    let (file, said) = imported(&log, &["--speed", "2:rpm", "--command", "12V@2s"]);
    assert!(
        said.contains("32000 counts per revolution, read off"),
        "{said}"
    );
    let mut sum = 0.0;
    let counts: Vec<f64> = (columns(&log, ',')[1].iter())
        .enumerate()
        .map(|(k, rpm)| {
            sum += if k > 0 { (rpm / 0.1875).round() } else { 0.0 };
            sum
        })
        .collect();
    assert_eq!(file.column("counts"), counts);
    let commands = file.column("command_v");
    for (t_s, command) in file.column("t_s").iter().zip(commands) {
        assert_eq!(command, if *t_s < 2.0 - 1e-9 { 0.0 } else { 12.0 }, "{t_s}");
    }
}

#[test]
fn angles_counts_and_pulse_widths_need_few_flags() {
    let Some(folder) = real("angles_counts_and_pulse_widths_need_few_flags") else {
        return;
    };
    let log = folder.join("ev3/duty_-10.txt");
    let (file, said) = imported(
        &log,
        &[
            "--position",
            "angle:deg",
            "--command",
            "-10%@0s",
            "--supply",
            "7.5",
        ],
    );
    assert!(
        said.contains("360 counts per revolution, read off"),
        "{said}"
    );
    assert_eq!(file.column("counts"), columns(&log, ' ')[1]);
    assert!(
        file.column("command_v")
            .iter()
            .all(|command| *command == -0.75)
    );
    let log = folder.join("arm_lost_edges/step_response_v8_7V.txt.gz");
    let flags = [
        "--position",
        "1:counts",
        "--command",
        "7V@0.95s",
        "--counts-per-rev",
        "1000",
    ];
    let (file, said) = imported(&log, &flags);
    assert!(said.contains("column 2 in us"), "{said}");
    assert_eq!(file.column("counts"), columns(&log, ',')[0]);
    for (t_s, command) in file.column("t_s").iter().zip(file.column("command_v")) {
        assert_eq!(command, if *t_s < 0.95 { 0.0 } else { 7.0 });
    }
    // Names, units, full scale and steps determine everything.
    let log = folder.join("xl330/xl330_m490g_l100mm_kp100_sin_sin.csv");
    let (file, said) = imported(&log, &[]);
    assert!(
        said.contains("4096 counts per revolution") && said.contains("885 is full drive"),
        "{said}"
    );
    let turns = std::f64::consts::TAU / 4096.0;
    for (count, angle) in file.column("counts").iter().zip(&columns(&log, ',')[2]) {
        assert!((count - angle / turns).abs() < 0.51, "{count}");
    }
}

#[test]
fn a_mean_of_samples_is_recognized_where_the_encoder_is_stated() {
    let Some(folder) = real("a_mean_of_samples_is_recognized_where_the_encoder_is_stated") else {
        return;
    };
    let log = folder.join("l298n/run_minimal.csv");
    let (_, said) = imported(&log, &["--counts-per-rev", "2400"]);
    assert!(
        said.contains("the mean of 5 samples") && said.contains("speed_filter"),
        "{said}"
    );
}

#[test]
fn a_servo_is_driven_by_the_sum_in_its_control_law() {
    let Some(folder) = real("a_servo_is_driven_by_the_sum_in_its_control_law") else {
        return;
    };
    let log = folder.join("sts3250/m535g_l100mm_kp12_sin_sin_1.csv.gz");
    let gain = 12.0 * 0.16383;
    let map = format!(
        "counts_per_rev = 4096\nsupply_v = 12.0\n[time]\ncolumn = \"timestamp\"\nunit = \"s\"\n[command]\n\
         sum = [{{ column = \"goal_position\", factor = {gain} }}, {{ column = \"position\", factor = -{gain} }}]\n\
         limit = 1.0\nunit = \"share\"\nsupply = \"measured\"\n[position]\ncolumn = \"position\"\nunit = \"rad\"\n\
         [supply]\ncolumn = \"input_volts\"\nunit = \"V\"\n"
    );
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("map.toml");
    fs::write(&path, map).expect("written");
    let (file, _) = imported(&log, &["--map", path.to_str().expect("a name")]);
    let columns = columns(&log, ',');
    let commands = file.column("command_v");
    assert_eq!(commands.len(), columns[0].len());
    for (k, command) in commands.iter().enumerate() {
        let duty = (gain * (columns[1][k] - columns[2][k])).clamp(-1.0, 1.0);
        assert!((command - duty * columns[4][k]).abs() < 1e-6, "row {k}");
    }
}

#[test]
fn open_questions_of_real_logs_are_one_message() {
    let Some(folder) = real("open_questions_of_real_logs_are_one_message") else {
        return;
    };
    for (log, flags, asked) in [
        (
            "micromouse/encoders1.csv",
            &[][..],
            &[
                "--position left_counts",
                "or --position right_counts",
                "--counts-per-rev COUNTS",
            ][..],
        ),
        (
            "micromouse/controllerDelayImpact5ms.csv",
            &[],
            &["--speed left_rpm", "--supply VOLTS"],
        ),
        (
            "emps/DATA_EMPS.csv",
            &[],
            &["--position qm_m:m", "--m-per-rev METRES"],
        ),
        ("odrive/spinup_4_nocomp.csv", &[], &["iq_measured_A:A"]),
        (
            "sts3250/m535g_l100mm_kp12_sin_sin_1.csv.gz",
            &[],
            &["`input_volts` may be what was commanded or the supply"],
        ),
    ] {
        let (done, file) = import(&folder.join(log), flags);
        assert_eq!(done.status, Some(2), "{log}: {}", done.messages);
        assert!(file.is_none(), "{log}");
        for words in asked {
            assert!(
                done.messages.contains(words),
                "{log}: {words}: {}",
                done.messages
            );
        }
    }
}
