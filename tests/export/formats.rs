//! Exported runs, opened by independent readers: pyarrow and the mcap package.
#![cfg(all(feature = "parquet", feature = "mcap"))]

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support;
use crate::support::command;
use motorlab::recording::{Flags, Run, difference_velocities, read_run, write_run};
use serde_json::Value;

/// The interpreter of tests/formats/install, or the test is skipped.
fn python(test: &str) -> Option<PathBuf> {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/formats-venv/bin/python");
    if python.exists() && python.with_file_name("../installed.txt").exists() {
        return Some(python);
    }
    support::skip(
        test,
        "pyarrow and mcap are not there (tests/formats/install)",
    );
    None
}

/// Rows of the reader.
fn read(python: &Path, format: &str, file: &Path) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/read.py");
    let output = Command::new(python)
        .args([script.as_path(), Path::new(format), file])
        .output()
        .expect("python starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// A run with every column, a loss, empty cells, and counts beyond the precision of a double.
fn run(folder: &Path) -> (PathBuf, Run) {
    let samples = 5000;
    let seq: Vec<u64> = (0..samples).map(|k| k + 3 * u64::from(k > 100)).collect();
    let counts = |k: u64| i64::MAX / 4 + (k * k / 7) as i64;
    let mut run = Run {
        sample_time_s: 0.003,
        counts_per_rev: 720.0,
        supply_v: Some(4.5),
        t_s: seq.iter().map(|&n| n as f64 * 0.003).collect(),
        command: seq.iter().map(|&n| (n as f64 * 0.01).sin() * 4.5).collect(),
        counts: seq.iter().map(|&n| counts(n)).collect(),
        host_t_s: Some(seq.iter().map(|&n| n as f64 * 0.003 + 0.017).collect()),
        flags: Some(
            seq.iter()
                .map(|&n| Flags {
                    overrun: n % 50 == 0,
                    saturated: n % 75 == 0,
                    ..Flags::default()
                })
                .collect(),
        ),
        measured_supply_v: Some(
            seq.iter()
                .map(|&n| if n % 10 == 0 { f64::NAN } else { 4.4 })
                .collect(),
        ),
        measured_current_a: Some(seq.iter().map(|&n| n as f64 * 1e-4).collect()),
        seq: Some(seq),
        complete: true,
        ..Run::default()
    };
    let put = |run: &mut Run, key: &str, value: toml::Value| {
        run.header.insert(key.to_owned(), value);
    };
    put(&mut run, "started", "2026-03-01T12:00:00Z".into());
    put(&mut run, "profile", "sine \"ü\"".into());
    let path = write_run(&run, &folder.join("run.csv")).expect("writable");
    let (run, notes) = read_run(&path).expect("readable");
    assert_eq!(notes, []);
    (path, run)
}

fn numbers(read: &Value, column: &str) -> Vec<Option<f64>> {
    let values = read["columns"][column].as_array();
    let values = values.unwrap_or_else(|| panic!("no column {column}"));
    values.iter().map(Value::as_f64).collect()
}

fn expected(run: &Run) -> Vec<(&'static str, Vec<Option<f64>>)> {
    let all = |values: &[f64]| -> Vec<Option<f64>> {
        values.iter().map(|&x| (!x.is_nan()).then_some(x)).collect()
    };
    let of = |column: &Option<Vec<f64>>| all(column.as_ref().expect("a column"));
    let seq = run.seq.as_deref();
    vec![
        ("t_s", all(&run.t_s)),
        ("command_v", all(&run.command)),
        ("host_t_s", of(&run.host_t_s)),
        ("supply_v", of(&run.measured_supply_v)),
        ("current_a", of(&run.measured_current_a)),
        (
            "velocity_rad_s",
            difference_velocities(&run.counts, seq, run.counts_per_rev, run.sample_time_s),
        ),
    ]
}

/// Equal numbers in equal places; reading JSON may lose the last bit.
fn agree(found: &[Option<f64>], expected: &[Option<f64>], column: &str) {
    assert_eq!(found.len(), expected.len(), "{column}");
    let same = |found: Option<f64>, expected: Option<f64>| match (found, expected) {
        (Some(found), Some(expected)) => (found - expected).abs() <= f64::EPSILON * expected.abs(),
        (found, expected) => found == expected,
    };
    for (k, (&found, &expected)) in found.iter().zip(expected).enumerate() {
        assert!(
            same(found, expected),
            "{column}, row {k}: {found:?}, not {expected:?}"
        );
    }
}

fn integers(read: &Value, column: &str) -> Vec<i64> {
    let values = read["columns"][column].as_array().expect("a column");
    values.iter().map(|n| n.as_i64().expect("whole")).collect()
}

#[test]
fn pyarrow_reads_every_column_of_a_parquet_file() {
    let Some(python) = python("pyarrow_reads_every_column_of_a_parquet_file") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let (path, run) = run(folder.path());
    let done = command::run(folder.path(), &["export", "parquet", "run.csv"]);
    assert_eq!(
        (done.status, &*done.output),
        (Some(0), "wrote run.parquet\n"),
        "{done:?}"
    );
    let read = read(&python, "parquet", &path.with_extension("parquet"));
    for (column, values) in expected(&run) {
        agree(&numbers(&read, column), &values, column);
        assert_eq!(read["types"][column], "double");
    }
    assert_eq!(integers(&read, "counts"), run.counts);
    let seq: Vec<u64> = integers(&read, "seq").iter().map(|&n| n as u64).collect();
    assert_eq!(Some(seq), run.seq);
    let flags = read["columns"]["flags"].as_array().expect("a column");
    assert_eq!(
        (&flags[0], &flags[1]),
        (&"overrun+saturated".into(), &"".into())
    );
    let header = read["metadata"]["motorlab-run/1"]
        .as_str()
        .expect("the header");
    assert_eq!(header.parse::<toml::Table>().expect("TOML"), run.header);
}

#[test]
fn the_mcap_package_reads_every_sample() {
    let Some(python) = python("the_mcap_package_reads_every_sample") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let (_, run) = run(folder.path());
    let done = command::run(
        folder.path(),
        &["export", "mcap", "run.csv", "-o", "x.mcap"],
    );
    assert_eq!(done.status, Some(0), "{done:?}");
    let read = read(&python, "mcap", &folder.path().join("x.mcap"));
    assert_eq!(read["count"], run.len());
    assert_eq!(read["topics"], serde_json::json!(["/motor"]));
    for (column, values) in expected(&run) {
        agree(&numbers(&read, column), &values, column);
    }
    assert_eq!(integers(&read, "counts"), run.counts);
    // 2026-03-01T12:00:00Z
    let start_ns = 1_772_366_400_000_000_000_i64;
    let log_time = integers(&read, "log_time");
    for (k, &log_time) in log_time.iter().enumerate() {
        assert_eq!(log_time, start_ns + (run.t_s[k] * 1e9).round() as i64);
    }
    let metadata = &read["metadata"]["motorlab-run/1"];
    assert_eq!(metadata["profile"], run.header["profile"].to_string());
}
