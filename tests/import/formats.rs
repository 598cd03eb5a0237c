//! `motorlab import FILE` of formats other than text columns. The samples in fixtures/formats were written by the
//! usual libraries (named in make.py there); truth.csv beside them has their content.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::support::command::{Finished, RunFile, run};
use motorlab::import::Form;
use proptest::prelude::*;

/// A damaged sample is read or refused within this time: valid ones take milliseconds.
const MOST_TIME: Duration = Duration::from_secs(2);

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats")
}

/// A column of truth.csv.
fn truth(name: &str) -> Vec<f64> {
    let text = fs::read_to_string(folder().join("truth.csv")).expect("there");
    let mut lines = text.lines();
    let at = lines
        .next()
        .and_then(|names| names.split(',').position(|column| column == name));
    let at = at.expect("a column of the truth");
    lines
        .map(|line| {
            line.split(',')
                .nth(at)
                .and_then(|cell| cell.parse().ok())
                .expect("a number")
        })
        .collect()
}

fn import(directory: &Path, sample: &str, flags: &[&str]) -> Finished {
    let path = folder().join(sample).display().to_string();
    let mut arguments = vec!["import", path.as_str(), "-o", "run.csv"];
    arguments.extend(flags);
    run(directory, &arguments)
}

/// The run of a sample agrees with truth.csv.
fn says_the_truth(sample: &str, flags: &[&str]) -> String {
    let directory = tempfile::tempdir().expect("a directory");
    let mut flags = flags.to_vec();
    flags.extend(["--counts-per-rev", "720"]);
    let finished = import(directory.path(), sample, &flags);
    assert_eq!(finished.status, Some(0), "{sample}: {}", finished.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    agrees(&file, 0..truth("t_s").len(), sample);
    finished.messages
}

fn agrees(file: &RunFile, rows: std::ops::Range<usize>, sample: &str) {
    let wanted = |name: &str| truth(name)[rows.clone()].to_vec();
    assert_eq!(file.column("counts"), wanted("counts"), "{sample}");
    assert_eq!(file.column("command_v"), wanted("command_v"), "{sample}");
    let times = wanted("t_s");
    for (found, wanted) in file.column("t_s").iter().zip(&times) {
        assert!(
            (found - (wanted - times[0])).abs() < 2e-9,
            "{sample}: {found} for {wanted}"
        );
    }
}

#[test]
fn robot_logs_and_workspaces_list_their_content() {
    for sample in [
        "robot.wpilog",
        "vectors.mat",
        "simulink.mat",
        "timeseries.mat",
    ] {
        says_the_truth(sample, &[]);
    }
}

#[test]
fn signals_of_a_simulation_keep_their_own_times() {
    let mut samples = vec!["simulation_output.mat"];
    if cfg!(feature = "formats") {
        samples.push("simulation_output73.mat");
    }
    for sample in samples {
        let said = says_the_truth(sample, &[]);
        for wanted in [
            "2 different times",
            "gain (an object of class zpk)",
            "save log.mat",
        ] {
            assert!(said.contains(wanted), "{sample}: {wanted}: {said}");
        }
    }
}

#[test]
#[cfg(feature = "formats")]
fn tables_bags_and_hdf5_list_their_content() {
    for compression in ["snappy", "zstd", "gzip", "lz4"] {
        let said = says_the_truth(&format!("{compression}.parquet"), &[]);
        assert!(said.contains("left out: state"), "{said}");
    }
    for sample in [
        "v73.mat",
        "simulink73.mat",
        "timeseries73.mat",
        "timetable73.mat",
    ] {
        says_the_truth(sample, &[]);
    }
    says_the_truth("json.mcap", &[]);
    let flags = [
        "--position",
        "/joint_states.position[0]",
        "--command",
        "/motor_voltage.data:V",
    ];
    for bag in ["ros2.mcap", "bag.mcap", "bag.db3", "old_bag.db3"] {
        let said = says_the_truth(bag, &flags);
        assert!(said.contains("[0] wheel, [1] idler"), "{said}");
        assert!(said.contains("in rad"), "{said}");
    }
}

#[test]
fn each_test_of_a_sysid_log_is_a_run() {
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "sysid.json", &["--counts-per-rev", "720"]);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let half = truth("t_s").len() / 2;
    for (test, rows) in [("fast-forward", 0..half), ("fast-backward", half..2 * half)] {
        let file = RunFile::read(&directory.path().join(format!("run-{test}.csv")));
        let counts = file.column("counts");
        assert_eq!(counts.len(), half);
        agrees(&file, rows, test);
    }
}

#[test]
fn a_mapping_file_applies_to_tables_and_text() {
    let directory = tempfile::tempdir().expect("a directory");
    let flags = ["--counts-per-rev", "720", "--save-map", "map.toml"];
    let finished = import(directory.path(), "vectors.mat", &flags);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let finished = import(directory.path(), "vectors.mat", &["--map", "map.toml"]);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let again = RunFile::read(&directory.path().join("run-2.csv"));
    agrees(&again, 0..truth("t_s").len(), "with its mapping");
}

#[test]
fn a_choice_of_two_joints_is_asked_with_the_completed_command_line() {
    if cfg!(not(feature = "formats")) {
        return;
    }
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), "ros2.mcap", &[]);
    assert_eq!(finished.status, Some(2), "{}", finished.messages);
    for wanted in [
        "/joint_states.position[0]",
        "/joint_states.position[1]",
        "--counts-per-rev",
        "motorlab import ",
    ] {
        assert!(
            finished.messages.contains(wanted),
            "{wanted}: {}",
            finished.messages
        );
    }
}

#[test]
fn known_formats_that_are_not_read_have_a_hint_to_csv() {
    let directory = tempfile::tempdir().expect("a directory");
    let xlsx = b"PK\x03\x04\x14\x00\x06\x00\x08\x00\x00\x00!\x00[Content_Types].xml".as_slice();
    for (bytes, wanted) in [
        (xlsx, "Save As"),
        (
            b"PK\x03\x04\x14\x00\x00\x00\x00\x00\x00\x00!\x00t.npy",
            "numpy.savetxt",
        ),
        (b"\x93NUMPY\x01\x00v\x00", "numpy.savetxt"),
        (b"ARROW1\0\0", "to_parquet"),
        (b"#ROSBAG V2.0\n", "rosbags-convert"),
        (b"{\"a\": {\"rpm\": 2}}\n", "pandas.json_normalize"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "Save As"),
        (b"\x28\xb5\x2f\xfd", "unzstd"),
    ] {
        fs::write(directory.path().join("log.bin"), bytes).expect("written");
        let finished = run(directory.path(), &["import", "log.bin", "--supply", "12"]);
        assert_eq!(finished.status, Some(2), "{}", finished.messages);
        assert!(
            finished.messages.contains(wanted),
            "{wanted}: {}",
            finished.messages
        );
        let lines: Vec<&str> = finished.messages.lines().collect();
        assert!(
            matches!(lines[..], [what, way] if what.starts_with("error: ") && way.starts_with("hint: ")),
            "{}",
            finished.messages
        );
    }
}

#[test]
fn a_format_is_recognized_by_its_bytes_and_text_is_none() {
    for text in [
        "t,pwm\n0,1\n",
        "[12:00:01.5] 1,2\n",
        "PARAMETERS\n",
        "{ 1 2\n",
        "WPI\n",
        "",
    ] {
        assert_eq!(Form::of(text.as_bytes()), None, "{text}");
    }
    let directory = tempfile::tempdir().expect("a directory");
    fs::copy(
        folder().join("vectors.mat"),
        directory.path().join("log.csv"),
    )
    .expect("copied");
    let finished = run(
        directory.path(),
        &["import", "log.csv", "--counts-per-rev", "720"],
    );
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let finished = run(directory.path(), &["compare", "log.csv"]);
    assert!(
        (finished.messages).contains("motorlab compare log.csv --counts-per-rev COUNTS"),
        "{}",
        finished.messages
    );
}

/// Reads possibly damaged bytes: no panic, no hang, no endless table.
fn survives(bytes: &[u8], what: &str) {
    let begun = Instant::now();
    if let Some(form) = Form::of(&bytes[..bytes.len().min(1024)])
        && let Ok(table) = form.read(bytes)
    {
        let read = std::io::copy(&mut table.text(), &mut std::io::sink()).expect("text");
        assert!(read < 1 << 26, "{what}: {read} bytes");
    }
    assert!(begun.elapsed() < MOST_TIME, "{what}: {:?}", begun.elapsed());
}

fn samples() -> Vec<(String, Vec<u8>)> {
    let files = fs::read_dir(folder()).expect("there");
    let mut found: Vec<(String, Vec<u8>)> = files
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            !path
                .extension()
                .is_some_and(|end| end == "py" || end == "csv")
        })
        .map(|path| {
            (
                path.display().to_string(),
                fs::read(&path).expect("readable"),
            )
        })
        .collect();
    found.sort();
    found
}

#[test]
fn a_file_truncated_anywhere_is_read_or_refused() {
    for (name, bytes) in samples() {
        let cuts = (0..bytes.len()).step_by(bytes.len() / 60 + 1);
        for end in cuts.chain(bytes.len().saturating_sub(40)..bytes.len()) {
            survives(&bytes[..end], &name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_file_is_read_or_refused(
        which in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_usize), 1..6),
    ) {
        let samples = samples();
        let (name, mut bytes) = which.get(&samples).clone();
        for (at, value, kind) in flips {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = value,
                1 => bytes[at] ^= 1 << (value & 7),
                // Sizes are more frequent at the beginning.
                2 => bytes[at % 256] = value,
                _ => bytes[at..].iter_mut().take(8).for_each(|byte| *byte = 0xff),
            }
        }
        survives(&bytes, &name);
    }
}
