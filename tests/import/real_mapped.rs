//! Every available recording of a real motor imports with its mapping file, and the run agrees with the log, which is
//! read here independently in the simplest way.

use std::path::{Path, PathBuf};

use crate::support;
use motorlab::import::{Imported, Map, import};
use motorlab::motor::read_motor;
use motorlab::recording::{CommandKind, Run, read_run};
use serde::Deserialize;

/// One entry of `tests/real/recordings.toml`.
#[derive(Debug, Deserialize)]
struct Recording {
    log: PathBuf,
    map: PathBuf,
    motor: PathBuf,
}

#[derive(Debug, Deserialize)]
struct Recordings {
    recording: Vec<Recording>,
}

fn here(path: &Path) -> PathBuf {
    Path::new("tests/real").join(path)
}

fn recordings() -> Vec<Recording> {
    let text = std::fs::read_to_string("tests/real/recordings.toml").expect("the list");
    let list: Recordings = toml::from_str(&text).expect("the list is TOML");
    list.recording
}

/// A column of a log by name, read in the simplest way.
fn column(log: &Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(log).expect("the log");
    let mut lines = text.lines();
    let names = lines.next().expect("names").split(',');
    let at = names.clone().position(|found| found == name);
    let at = at.unwrap_or_else(|| panic!("no {name}"));
    lines
        .map(|line| {
            line.split(',')
                .nth(at)
                .expect("a cell")
                .parse()
                .expect("a number")
        })
        .collect()
}

fn imported(folder: &Path, log: &str, target: &Path) -> (PathBuf, Imported) {
    let recording = recordings()
        .into_iter()
        .find(|recording| recording.log == Path::new(log))
        .unwrap_or_else(|| panic!("{log} is not in the list"));
    let map = Map::read(&here(&recording.map)).expect("a mapping");
    let log = folder.join(log);
    let source = std::fs::File::open(&log).expect("the log");
    let imported = import(source, "log", &map, target).expect("it imports");
    (log, imported)
}

/// The only run of a log.
fn run_of(folder: &Path, log: &str) -> (PathBuf, Run) {
    let scratch = tempfile::tempdir().expect("a directory");
    let (log, imported) = imported(folder, log, &scratch.path().join("run.csv"));
    let [one] = imported.runs.as_slice() else {
        panic!("{} runs", imported.runs.len());
    };
    let (run, notes) = read_run(&one.path).expect("it reads back");
    assert_eq!(notes, [], "{}", log.display());
    (log, run)
}

fn words<'a>(run: &'a Run, key: &str) -> &'a str {
    run.header["imported"][key].as_str().expect("words")
}

#[test]
fn every_recording_imports_without_loss() {
    let Some(folder) = support::real_recordings("every_recording_imports_without_loss") else {
        return;
    };
    let recordings = recordings();
    for recording in &recordings {
        let name = recording.log.to_str().expect("a name");
        let scratch = tempfile::tempdir().expect("a directory");
        let (log, imported) = imported(&folder, name, &scratch.path().join("run.csv"));
        let lines = std::fs::read_to_string(&log)
            .expect("the log")
            .lines()
            .count();
        assert_eq!(imported.rows, lines as u64 - 1, "{name}");
        assert_eq!(
            (imported.bad_rows, &imported.rejected),
            (0, &None),
            "{name}"
        );
        let samples: u64 = imported.runs.iter().map(|run| run.samples).sum();
        assert_eq!(samples, imported.rows, "{name}");
        let motor = read_motor(here(&recording.motor)).expect("a motor file");
        for one in &imported.runs {
            let (run, notes) = read_run(&one.path).expect("it reads back");
            assert_eq!(notes, [], "{name}");
            assert!(run.complete && run.len() as u64 == one.samples, "{name}");
            assert_eq!(
                run.counts_per_rev, motor.parameters.counts_per_rev,
                "{name}"
            );
            if let Some(supply_v) = run.supply_v.filter(|_| !name.contains("battery")) {
                assert_eq!(supply_v, motor.parameters.supply_v, "{name}");
            }
        }
    }
    // No log of the folder is left out.
    for log in ["emps", "micromouse", "odrive", "xl330"]
        .into_iter()
        .flat_map(|part| std::fs::read_dir(folder.join(part)).expect("a folder"))
        .map(|entry| entry.expect("an entry").path())
    {
        let listed = |recording: &Recording| log.ends_with(&recording.log);
        assert!(
            recordings.iter().any(listed),
            "{} is not in the list",
            log.display()
        );
    }
}

#[test]
fn counts_and_times_are_kept_exactly() {
    let Some(folder) = support::real_recordings("counts_and_times_are_kept_exactly") else {
        return;
    };
    let (log, run) = run_of(&folder, "micromouse/encoders1.csv");
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    assert_eq!(counts, column(&log, "left_counts"));
    assert_eq!(run.t_s, column(&log, "t_s"));
    assert_eq!(words(&run, "command"), "profile from the mapping");
    // One second of 100/255 of 7.4 V, and nothing else.
    let full = -7.4 * 100.0 / 255.0;
    let on = run
        .command
        .iter()
        .filter(|&&u| (u - full).abs() < 1e-12)
        .count();
    assert_eq!(
        (on, run.command.iter().filter(|&&u| u != 0.0).count()),
        (200, 200)
    );
    assert!(run.command[365] != 0.0 && run.command[364] == 0.0);
}

#[test]
fn angles_and_travel_are_converted_to_encoder_counts() {
    let Some(folder) =
        support::real_recordings("angles_and_travel_are_converted_to_encoder_counts")
    else {
        return;
    };
    let log = "xl330/xl330_m490g_l100mm_kp400_sin_time_square.csv";
    let (log, run) = run_of(&folder, log);
    let radians = column(&log, "pos_rad");
    for (&counts, radians) in run.counts.iter().zip(&radians) {
        let back = counts as f64 * std::f64::consts::TAU / 4096.0;
        assert!((back - radians).abs() < 2e-6, "{counts} for {radians}");
    }
    let duty = column(&log, "pwm_counts_885max");
    for (command, duty) in run.command.iter().zip(&duty) {
        assert!((command - duty / 885.0 * 7.4).abs() < 1e-12);
    }
    assert_eq!(run.measured_supply_v, Some(column(&log, "vin_V")));

    let (log, run) = run_of(&folder, "emps/DATA_EMPS.csv");
    assert_eq!(run.command_kind, CommandKind::Torque);
    let (metres, volts) = (column(&log, "qm_m"), column(&log, "vir_V"));
    for k in 0..run.len() {
        assert!((run.counts[k] as f64 * 5e-8 - metres[k]).abs() <= 2.5e-8 + 1e-12);
        // Work: force times travel is torque times angle.
        let work = run.command[k] * std::f64::consts::TAU / 0.0025;
        assert!((work - 35.1507 * volts[k]).abs() < 1e-9);
    }
}

#[test]
fn trials_of_one_log_are_separate_runs() {
    let Some(folder) = support::real_recordings("trials_of_one_log_are_separate_runs") else {
        return;
    };
    let scratch = tempfile::tempdir().expect("a directory");
    let target = scratch.path().join("spinup.csv");
    let (log, imported) = imported(&folder, "odrive/spinup_4_nocomp.csv", &target);
    let trials = column(&log, "trial");
    let positions = column(&log, "position_counts_8192_per_rev");
    let currents = column(&log, "iq_measured_A");
    assert_eq!(imported.runs.len(), 50);
    for (trial, one) in imported.runs.iter().enumerate() {
        let name = format!("spinup-{trial}.csv");
        assert_eq!(
            one.path.file_name().and_then(|name| name.to_str()),
            Some(&*name)
        );
        let (run, _) = read_run(&one.path).expect("it reads back");
        assert_eq!(run.command_kind, CommandKind::Current);
        let rows: Vec<usize> = (0..trials.len())
            .filter(|&k| trials[k] == trial as f64)
            .collect();
        assert_eq!(run.len(), rows.len());
        for (k, &row) in rows.iter().enumerate() {
            assert!((run.counts[k] as f64 - positions[row]).abs() <= 0.5);
            assert_eq!(run.command[k], currents[row]);
        }
    }
}

#[test]
fn missing_facts_of_a_log_are_stated_in_its_run() {
    let Some(folder) = support::real_recordings("missing_facts_of_a_log_are_stated_in_its_run")
    else {
        return;
    };
    let (_, run) = run_of(&folder, "micromouse/batteryVoltage3.csv");
    assert_eq!(words(&run, "position"), "not recorded");
    assert!(run.counts.iter().all(|&n| n == 0));
    let (_, run) = run_of(&folder, "micromouse/testSpeedCalibration1.csv");
    assert_eq!(words(&run, "command"), "not recorded");
    let (_, run) = run_of(&folder, "odrive/cogging_map_a_4_interp.csv");
    assert_eq!(words(&run, "time"), "made from the row number");

    let (log, run) = run_of(&folder, "micromouse/controllerDelayImpact1ms.csv");
    assert_eq!(words(&run, "position"), "integrated from speed, backward");
    let (t_s, rpm) = (column(&log, "t_s"), column(&log, "left_rpm"));
    let turns: f64 = (1..t_s.len())
        .map(|k| rpm[k] / 60.0 * (t_s[k] - t_s[k - 1]))
        .sum();
    let last = *run.counts.last().expect("rows") as f64;
    assert!((last - turns * 358.332).abs() <= 0.5 + 1e-6);
}
