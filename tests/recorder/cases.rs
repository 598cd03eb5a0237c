//! Files that differ in one number from a valid one: every command returns a clear message or an answer, within a
//! time limit that only ends a hang.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/cases/recorder");
/// Ends a hang: the release program takes seconds for all of them.
const AT_MOST: Duration = Duration::from_secs(60);

/// Exit status and all output.
fn said(arguments: &[&str]) -> (i32, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("said");
    let file = std::fs::File::create(&path).expect("a file");
    let mut child = Command::new(env!("CARGO_BIN_EXE_motorlab"))
        .args(arguments)
        .current_dir(FOLDER)
        .stdin(Stdio::null())
        .stdout(file.try_clone().expect("the same file"))
        .stderr(file)
        .spawn()
        .expect("it runs");
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if begun.elapsed() > AT_MOST {
            child.kill().expect("it ends");
            panic!("{arguments:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let text = String::from_utf8_lossy(&std::fs::read(&path).expect("what was said")).into_owned();
    (status.code().unwrap_or(-1), text)
}

#[test]
fn a_sample_time_that_no_board_has_is_refused_by_every_reader() {
    for file in ["sim30_ts_1e-7.csv", "diagnose_abort_rc6.csv", "ts_3e10.csv"] {
        for command in ["compare", "check", "diagnose"] {
            let (status, text) = said(&[command, file]);
            assert_eq!(status, 2, "{command} {file}: {text}");
            assert!(
                text.contains("sample_time_s") && text.contains("1e-6 .. 60 s"),
                "{text}"
            );
        }
    }
}

#[test]
fn times_that_contradict_the_stated_sample_time_are_reported_and_diagnosed() {
    let (status, text) = said(&["check", "sim30_ts_30.csv"]);
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("sample_time_contradicts"), "{text}");
    let (status, text) = said(&["diagnose", "sim30_ts_30.csv"]);
    assert_eq!(status, 0, "{text}");
}

#[test]
fn rows_a_minute_apart_and_a_pause_of_an_hour_are_errors_with_hints() {
    let (status, text) = said(&["diagnose", "slow60.csv"]);
    assert_eq!(status, 1, "{text}");
    assert!(text.contains("as if ms had been read as s"), "{text}");
    let (status, text) = said(&["diagnose", "slow60.csv", "--despite-findings"]);
    assert_eq!(status, 2, "{text}");
    assert!(text.contains("60.000 s apart"), "{text}");
    let (status, text) = said(&["diagnose", "gap3500.csv"]);
    assert_eq!(status, 2, "{text}");
    assert!(text.contains("cut the file at its pauses"), "{text}");
    assert_eq!(said(&["compare", "gap3500.csv"]).0, 0);
}

#[test]
fn an_encoder_of_32_bits_per_revolution_has_a_result() {
    for command in ["compare", "diagnose"] {
        let (status, text) = said(&[command, "hang_cpr_4294967296.csv"]);
        assert!((0..=2).contains(&status), "{command}: {status} {text}");
        assert!(!text.contains("panicked"), "{text}");
    }
}

#[test]
fn a_motor_file_with_a_number_that_no_motor_has_is_refused() {
    for (file, key) in [
        ("cpr_1e-308.toml", "counts_per_rev"),
        ("m_jit.toml", "spread_s"),
    ] {
        for command in [&["compare", "sim30.csv"][..], &["simulate"][..]] {
            let (status, text) = said(&[command, &["--motor", file]].concat());
            assert_eq!(status, 2, "{file}: {text}");
            assert!(text.contains(key) && text.contains(" .. "), "{text}");
            assert!(text.lines().count() < 6, "{text}");
        }
    }
}

#[test]
fn headers_that_contain_header_lines_are_read() {
    for file in ["sim30.csv", "esc_name.csv", "name_toml.csv"] {
        assert_eq!(said(&["compare", file]).0, 0, "{file}");
    }
}

#[test]
fn sample_numbers_up_to_64_bits_and_back_are_counted() {
    let seed = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/instruments/seeds/step3.csv"
    );
    let sound = std::fs::read_to_string(seed).expect("a recording");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("leaps.csv").display().to_string();
    let mut row = 0_u32;
    let leaping: Vec<String> = (sound.lines())
        .map(|line| match line.split_once(',') {
            Some((first, rest)) if first.parse::<u64>().is_ok() => {
                row += 1;
                let number = if row % 20 == 10 {
                    u64::MAX
                } else {
                    u64::from(row)
                };
                format!("{number},{rest}")
            }
            _ => line.to_owned(),
        })
        .collect();
    assert!(row > 60, "{row}");
    std::fs::write(&path, leaping.join("\n") + "\n").expect("a file");
    for command in ["compare", "check"] {
        let (status, text) = said(&[command, &path]);
        assert!((0..=2).contains(&status), "{command}: {status} {text}");
        assert!(!text.contains("panicked"), "{text}");
    }
}

#[test]
fn a_motor_too_stiff_for_a_long_pause_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, effect) in [
        (
            "spring",
            "[effects.compliance]\nfrequency_hz = 1e4\ndamping_ratio = 0.001",
        ),
        (
            "ripple",
            "[effects.torque_ripple]\namplitude = 0.2\ncycles_per_rev = 1e5",
        ),
        (
            "cogging",
            "[effects.cogging]\ntorque_nm = 0.02\ncycles_per_rev = 1e5",
        ),
    ] {
        let motor = folder.path().join(name);
        std::fs::write(&motor, effect).expect("written");
        let motor = motor.to_str().expect("a path");
        let (status, text) = said(&["compare", "gap3500.csv", "--motor", motor]);
        assert_eq!(status, 2, "{name}: {text}");
        assert!(text.contains("too stiff to simulate"), "{name}: {text}");
    }
}
