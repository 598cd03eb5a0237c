//! Raw logs of the real firmware on an emulated board: the run has the true counts and times, to a count and a
//! microsecond.

use std::path::{Path, PathBuf};

use crate::support::command::{RunFile, run};

/// Name, samples taken, samples lost on a slow line.
const FIXTURES: [(&str, usize, i64); 4] = [
    ("uno_step3", 667, 0),
    ("mega_step30", 67, 0),
    ("uno_reversing3", 667, 0),
    ("mega_overrun", 1000, 908),
];

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(name)
}

/// `(time in s, counts)` of every tick of the board.
fn truth(name: &str) -> Vec<(f64, i64)> {
    let text = std::fs::read_to_string(fixture(&format!("{name}.truth.csv"))).expect("the truth");
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("tick,due_s,entered_s,count,angle_counts,motor_v")
    );
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            (
                cells[2].parse().expect("seconds"),
                cells[3].parse().expect("counts"),
            )
        })
        .collect()
}

#[test]
fn logs_of_the_firmware_replay_to_the_true_samples() {
    for (name, taken, lost) in FIXTURES {
        let directory = tempfile::tempdir().expect("a directory");
        let log = fixture(&format!("{name}.log")).display().to_string();
        let done = run(directory.path(), &["replay", &log]);
        assert_eq!(done.status, Some(i32::from(lost > 0)), "{}", done.messages);
        let file = RunFile::read(&directory.path().join("run.csv"));
        assert_eq!(file.summary("lost"), lost, "{name}");
        let truth = truth(name);
        assert_eq!(truth.len(), taken, "{name}");
        let (sequence, counts) = (file.column("seq"), file.column("counts"));
        assert_eq!(counts.len() + lost as usize, taken, "{name}");
        let t_s = file.column("t_s");
        let first_s = truth[sequence[0] as usize].0;
        for row in 0..counts.len() {
            let (instant_s, count) = truth[sequence[row] as usize];
            assert_eq!(counts[row] as i64, count, "{name}, row {row}");
            // micros() has a resolution of 4 us and is read some us after the tick.
            assert!(
                (t_s[row] - (instant_s - first_s)).abs() <= 12e-6,
                "{name}, row {row}"
            );
        }
    }
}

#[test]
fn overruns_of_the_firmware_are_in_the_run() {
    let directory = tempfile::tempdir().expect("a directory");
    let log = fixture("mega_overrun.log").display().to_string();
    run(directory.path(), &["replay", &log]);
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert!(file.summary("overruns") > 50);
}
