//! `motorlab import` of generated logs with known counts, times and commands.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use crate::support::command::{Finished, RunFile, run};

/// A log in `log.csv`, a mapping in `map.toml`, imported into `run.csv`.
fn import(directory: &Path, log: impl AsRef<[u8]>, map: &str) -> Finished {
    fs::write(directory.join("log.csv"), log).expect("written");
    fs::write(directory.join("map.toml"), map).expect("written");
    let arguments = ["import", "log.csv", "--map", "map.toml", "-o", "run.csv"];
    run(directory, &arguments)
}

/// The run of a successful import.
fn imported(log: impl AsRef<[u8]>, map: &str) -> RunFile {
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), log, map);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    RunFile::read(&directory.path().join("run.csv"))
}

fn words<'a>(file: &'a RunFile, key: &str) -> &'a str {
    file.header["imported"][key].as_str().expect("words")
}

fn counts(file: &RunFile) -> Vec<i64> {
    let column = file.column("counts");
    column.iter().map(|&n| n as i64).collect()
}

/// A log of two columns, `t_ms` and `x`.
fn log_of(values: impl IntoIterator<Item = f64>) -> String {
    let mut log = "t_ms,x\n".to_owned();
    for (k, x) in values.into_iter().enumerate() {
        let _ = writeln!(log, "{},{x:.12}", 3 * k);
    }
    log
}

const TIME: &str = "[time]\ncolumn = \"t_ms\"\nunit = \"ms\"\n";
const NO_COMMAND: &str = "[command]\nrecorded = false\n";

/// Forwards over one turn and back beyond the start, at 720 counts per revolution.
fn turning() -> Vec<i64> {
    let there = (0..1000).step_by(37);
    there.chain((-800..1000).rev().step_by(41)).collect()
}

#[test]
fn every_unit_of_position_gives_the_same_counts() {
    let turning = turning();
    for (unit, per_turn, more) in [
        ("counts", 720.0, ""),
        ("rev", 1.0, ""),
        ("rad", TAU, ""),
        ("mrad", 1000.0 * TAU, ""),
        ("deg", 360.0, ""),
        ("°", 360.0, ""),
        ("m", 0.05, ""),
        ("mm", 50.0, ""),
        ("um", 50_000.0, ""),
        ("counts", 2880.0, "counts_per_rev = 2880"),
        ("deg", -3600.0, "scale = -0.1"),
        ("rad", TAU / 2.0, "scale = 2"),
    ] {
        let map = format!(
            "counts_per_rev = 720\nm_per_rev = 0.05\n{TIME}{NO_COMMAND}\
             [position]\ncolumn = \"x\"\nunit = \"{unit}\"\n{more}"
        );
        let log = log_of(turning.iter().map(|&n| n as f64 / 720.0 * per_turn));
        assert_eq!(counts(&imported(log, &map)), turning, "{unit} {more}");
    }
}

#[test]
fn angles_and_clocks_that_wrap_are_unwrapped() {
    let turning = turning();
    let mut log = "us,x\n".to_owned();
    for (k, &n) in (0_u64..).zip(&turning) {
        // A 16-bit clock that wraps, and an angle within one turn.
        let us = (60_000 + 3000 * k) % 65_536;
        let _ = writeln!(log, "{us},{:.6}", (n as f64 / 2.0).rem_euclid(360.0));
    }
    let map = format!(
        "counts_per_rev = 720\n{NO_COMMAND}[time]\ncolumn = \"us\"\nunit = \"us\"\nwrap = 65536\n\
         [position]\ncolumn = \"x\"\nunit = \"deg\"\nwrap = 360"
    );
    let file = imported(log, &map);
    assert_eq!(counts(&file), turning);
    for (k, t_s) in file.column("t_s").iter().enumerate() {
        assert!((t_s - 0.003 * k as f64).abs() < 1e-9);
    }
}

#[test]
fn every_unit_of_command_gives_the_same_command() {
    let shares = [0.0, 0.25, 1.0, -1.0, -0.4];
    for (column, unit, full, more) in [
        ("command_v", "V", 7.4, ""),
        ("command_v", "mV", 7400.0, ""),
        ("command_v", "pwm", 255.0, "full = 255"),
        ("command_v", "pwm", 885.0, "full = 885"),
        ("command_v", "pwm", 65_535.0, "full = 65535"),
        ("command_v", "percent", 100.0, ""),
        ("command_v", "%", 100.0, ""),
        ("command_v", "share", 1.0, ""),
        ("command_a", "A", 7.4, ""),
        ("command_a", "mA", 7400.0, ""),
        ("command_nm", "N m", 7.4, ""),
        ("command_nm", "mNm", 7400.0, ""),
        // Force times travel is torque times angle.
        ("command_nm", "N", 7.4 * TAU / 0.05, ""),
        ("command_v", "V", -3.7, "scale = -2"),
    ] {
        let map = format!(
            "counts_per_rev = 720\nsupply_v = 7.4\nm_per_rev = 0.05\n{TIME}\
             [command]\ncolumn = \"x\"\nunit = \"{unit}\"\n{more}\n[position]\nrecorded = false"
        );
        let file = imported(log_of(shares.map(|share| share * full)), &map);
        assert_eq!(words(&file, "position"), "not recorded");
        for (found, share) in file.column(column).iter().zip(shares) {
            assert!((found - 7.4 * share).abs() < 1e-9, "{unit} {more}: {found}");
        }
    }
}

/// A staircase of speeds, each measured under the command of its row: a row's speed applies from its time on.
#[test]
fn a_speed_with_the_commands_step_holds_from_its_row_on() {
    for (rule, expected) in [("forward", [0, 10, 30, 60]), ("backward", [0, 20, 50, 90])] {
        let map = format!(
            "counts_per_rev = 720\n{TIME}{NO_COMMAND}\
             [speed]\ncolumn = \"x\"\nunit = \"counts/s\"\nintegrate = \"{rule}\""
        );
        let speeds = (1..=4).map(|k| f64::from(k) * 10.0 / 0.003);
        let file = imported(log_of(speeds), &map);
        assert_eq!(
            words(&file, "position"),
            format!("integrated from speed, {rule}")
        );
        assert_eq!(counts(&file), expected, "{rule}");
    }
}

/// v = a t gives a t^2 / 2, for which the trapezoid rule is exact.
#[test]
fn a_log_of_speeds_is_integrated_and_marked() {
    let acceleration_rad_s2 = 30.0;
    let t_s = |k: usize| 0.003 * k as f64;
    for (unit, per_rad_s) in [
        ("rad/s", 1.0),
        ("rpm", 60.0 / TAU),
        ("rev/s", 1.0 / TAU),
        ("deg/s", 360.0 / TAU),
        ("counts/s", 720.0 / TAU),
        ("m/s", 0.05 / TAU),
        ("mm/s", 50.0 / TAU),
    ] {
        let map = format!(
            "counts_per_rev = 720\nm_per_rev = 0.05\n{TIME}{NO_COMMAND}\
             [speed]\ncolumn = \"x\"\nunit = \"{unit}\""
        );
        let speeds = (0..400).map(|k| acceleration_rad_s2 * t_s(k) * per_rad_s);
        let file = imported(log_of(speeds), &map);
        assert_eq!(words(&file, "position"), "integrated from speed, trapezoid");
        for (k, n) in counts(&file).into_iter().enumerate() {
            let true_counts = acceleration_rad_s2 * t_s(k) * t_s(k) / 2.0 / TAU * 720.0;
            assert!((n as f64 - true_counts).abs() < 0.5 + 1e-6, "{unit} {k}");
        }
    }
}

#[test]
fn irregular_times_are_kept_unchanged() {
    let instants_us = [0, 3000, 6100, 8999, 12_000, 30_000, 33_001, 36_000];
    let mut log = "time;n\n".to_owned();
    for us in instants_us {
        // Another origin: time in the run begins at 0.
        let _ = writeln!(log, "{:.6};{us}", 1_700_000_000.0 + f64::from(us) * 1e-6);
    }
    let map = format!(
        "counts_per_rev = 720\n{NO_COMMAND}[time]\ncolumn = \"time\"\nunit = \"s\"\n\
         [position]\ncolumn = 2\nunit = \"counts\""
    );
    let file = imported(log, &map);
    for (t_s, us) in file.column("t_s").iter().zip(instants_us) {
        // Seconds since 1970 in double precision: 0.24 us.
        assert!((t_s - f64::from(us) * 1e-6).abs() < 5e-7, "{t_s} for {us}");
    }
    let sample_time_s = file.header["sample_time_s"].as_float().expect("seconds");
    assert!((sample_time_s - 0.003).abs() < 2e-6, "{sample_time_s}");
}

#[test]
fn layouts_of_many_kinds_are_read() {
    let map = |file: &str, t: &str, n: &str| {
        format!(
            "counts_per_rev = 720\n{NO_COMMAND}[file]\n{file}\n[time]\ncolumn = {t}\nunit = \"ms\"\n\
             [position]\ncolumn = {n}\nunit = \"counts\""
        )
    };
    let by_name = |file: &str| map(file, "\"t\"", "\"n\"");
    for (log, map) in [
        ("t,n\n0,5\n3,6\n6,9\n", by_name("")),
        ("t\tn\r\n0\t5\r\n3\t6\r\n6\t9\r\n", by_name("")),
        (" t   n\n 0   5\n 3   6\n 6   9\n", by_name("")),
        ("t;n\n0,0;5\n3,0;6\n6,0;9\n", by_name("decimal = \",\"")),
        ("t,n,\n0,5,\n3,6,\n6,9,\n", by_name("")),
        ("t|n\n0|5\n3|6\n6|9", by_name("delimiter = \"|\"")),
        ("\u{feff}t,n\n\n0,5\n# a pause\n3,6\n6,9\n", by_name("")),
        (
            "Scope 3\n\nt,n\nms,-\n0,5\n3,6\n6,9\n",
            by_name("skip_lines = 2\nunit_lines = 1"),
        ),
        ("% a\nt,n\n0,5\n3,6\n6,9\n", by_name("comment = \"%\"")),
        ("0 5\n3 6\n6 9\n", map("names = false", "1", "2")),
        (
            "\"t\",\"n, left\"\n\"0\",\"5\"\n3,6\n6,9\n",
            map("", "\"t\"", "\"n, left\""),
        ),
    ] {
        let file = imported(log, &map);
        assert_eq!(counts(&file), [5, 6, 9], "{log:?}");
        assert_eq!(file.column("t_s"), [0.0, 0.003, 0.006], "{log:?}");
    }
}

#[test]
fn a_gzipped_log_is_the_log() {
    let turning = turning();
    let log = log_of(turning.iter().map(|&n| n as f64));
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(log.as_bytes()).expect("compressed");
    let packed = gzip.finish().expect("compressed");
    let map = format!(
        "counts_per_rev = 720\n{TIME}{NO_COMMAND}[position]\ncolumn = \"x\"\nunit = \"counts\""
    );
    assert_eq!(counts(&imported(&packed, &map)), turning);
    // A truncated one is not accepted as complete.
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), &packed[..packed.len() - 9], &map);
    assert_eq!(finished.status, Some(2), "{}", finished.messages);
    assert!(finished.messages.contains("cannot be read beyond line"));
}

const BAD_ROWS: &str = "t_ms,pwm,n\n\
    0,0,0\n\
    3,255,1\n\
    6,255\n\
    9,255,NaN\n\
    # a comment is no row\n\
    12,255,4\n\
    12,255,5\n\
    15,1e999,6\n\
    18,255,oops \"7\"\n\
    21,255,8\n";

const BAD_ROWS_MAP: &str = "counts_per_rev = 720\nsupply_v = 4.5\n\
    [time]\ncolumn = \"t_ms\"\nunit = \"ms\"\n\
    [command]\ncolumn = \"pwm\"\nunit = \"pwm\"\nfull = 255\n\
    [position]\ncolumn = \"n\"\nunit = \"rev\"\nscale = 1\n";

#[test]
fn bad_rows_are_named_kept_and_counted_as_lost() {
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), BAD_ROWS, BAD_ROWS_MAP);
    assert_eq!(finished.status, Some(1), "{}", finished.messages);
    assert!(finished.messages.contains("5 of 9 rows cannot be used"));
    let expected = [
        (4, "2 cells where the columns are 3"),
        (5, "column `n`: `NaN` is not a finite number"),
        (8, "time goes from 0.012 s to 0.012 s"),
        (9, "column `pwm`: `1e999` is not a finite number"),
        (10, "is not a finite number"),
    ];
    let kept = fs::read_to_string(directory.path().join("run.rejected.csv")).expect("kept");
    let lines: Vec<&str> = kept.lines().collect();
    assert_eq!(lines[0], "line,why,row");
    assert_eq!(lines.len(), 1 + expected.len(), "{kept}");
    for (found, (line, why)) in lines[1..].iter().zip(expected) {
        assert!(found.starts_with(&format!("{line},")), "{found}");
        assert!(found.contains(why), "{found}");
        assert!(finished.messages.contains(&format!("line {line}: ")));
    }
    assert!(lines[5].ends_with(r#""18,255,oops ""7""""#), "{}", lines[5]);
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!(file.column("seq"), [0.0, 1.0, 4.0, 8.0]);
    assert_eq!(counts(&file), [0, 720, 4 * 720, 8 * 720]);
    assert_eq!(file.summary("bad_rows"), 5);

    let json = ["--json", "import", "log.csv", "--map", "map.toml"];
    let finished = run(directory.path(), &json);
    assert_eq!(finished.status, Some(1));
    let document: serde_json::Value = serde_json::from_str(&finished.output).expect("JSON");
    assert_eq!(
        (&document["rows"], &document["bad_rows"]),
        (&9.into(), &5.into())
    );
    assert_eq!(document["first_bad"][0]["line"], 4);
    assert_eq!(document["runs"][0]["samples"], 4);
}

#[test]
fn logs_that_cannot_be_imported_are_errors_with_place_and_hint() {
    let position = "[position]\ncolumn = \"n\"\nunit = \"counts\"\n";
    let head = format!("counts_per_rev = 720\n{TIME}");
    let log = "t_ms,n\n0,1\n3,2\n";
    let utf16: Vec<u8> = log.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let whole = format!("{head}{NO_COMMAND}{position}");
    let cases: [(&[u8], String, &[&str]); 14] = [
        (
            b"T_ms,n\n0,1\n",
            whole.clone(),
            &["line 1 names no column `t_ms`", "did you mean `T_ms`?"],
        ),
        (b"t_ms,n\n", whole.clone(), &["has no rows"]),
        (b"", whole.clone(), &["has no rows"]),
        (
            b"t_ms,n\na,b\n",
            whole.clone(),
            &["none of its 1 rows", "line 2", "`a`"],
        ),
        (&[0; 100], whole.clone(), &["is no text"]),
        (&utf16, whole.clone(), &["UTF-16"]),
        (b"PK\x03\x04 and more", whole.clone(), &["ZIP archive"]),
        (
            log.as_bytes(),
            format!("{head}{position}"),
            &["[command]", "recorded = false"],
        ),
        (
            log.as_bytes(),
            format!("{head}{NO_COMMAND}"),
            &["[position] or [speed]"],
        ),
        (
            log.as_bytes(),
            format!("{head}{NO_COMMAND}[position]\ncolumn = \"n\"\nunit = \"furlong\""),
            &["[position]", "furlong", "counts, rev, rad"],
        ),
        (
            log.as_bytes(),
            format!("{head}{NO_COMMAND}[position]\ncolumn = \"n\"\nunit = \"mm\""),
            &["m_per_rev"],
        ),
        (
            log.as_bytes(),
            format!("{head}{position}[command]\ncolumn = \"n\"\nunit = \"percent\""),
            &["supply_v"],
        ),
        (
            log.as_bytes(),
            format!("{whole}unti = 3\n"),
            &["map.toml: line 10: ", "unti"],
        ),
        (
            log.as_bytes(),
            whole.replace("720", "-1"),
            &["counts_per_rev", "0.01 .. "],
        ),
    ];
    for (log, map, wanted) in cases {
        let directory = tempfile::tempdir().expect("a directory");
        let finished = import(directory.path(), log, &map);
        assert_eq!(finished.status, Some(2), "{map}\n{}", finished.messages);
        for words in wanted {
            assert!(
                finished.messages.contains(words),
                "{words}: {}",
                finished.messages
            );
        }
        let left = fs::read_dir(directory.path()).expect("a folder").count();
        assert_eq!(left, 2, "nothing but the log and the mapping");
    }
}

#[test]
fn endless_files_end_with_a_message() {
    let directory = tempfile::tempdir().expect("a directory");
    let map = format!("counts_per_rev = 720\n{TIME}{NO_COMMAND}[position]\nrecorded = false");
    fs::write(directory.path().join("map.toml"), map).expect("written");
    for endless in ["/dev/zero", "/dev/urandom"] {
        let arguments = ["import", endless, "--map", "map.toml", "-o", "run.csv"];
        let finished = run(directory.path(), &arguments);
        assert_eq!(finished.status, Some(2), "{endless}: {}", finished.messages);
        assert!(
            finished
                .messages
                .contains(endless.trim_start_matches("/dev/"))
        );
    }
}

/// A simulated run in another program's format is recovered.
#[test]
fn a_foreign_log_of_a_simulated_run_is_imported_as_the_run() {
    let directory = tempfile::tempdir().expect("a directory");
    let simulate = [
        "simulate",
        "--profile",
        "reversing",
        "--duration",
        "3",
        "-o",
        "sim.csv",
    ];
    assert_eq!(run(directory.path(), &simulate).status, Some(0));
    let simulated = RunFile::read(&directory.path().join("sim.csv"));
    let (t_s, volts) = (simulated.column("t_s"), simulated.column("command_v"));
    let mut log = "Board 3, run 7\nmillis;duty %;angle\n".to_owned();
    for (k, &n) in counts(&simulated).iter().enumerate() {
        let cells = [
            t_s[k] * 1e3,
            volts[k] / 4.5 * 100.0,
            (n as f64 * 0.5).rem_euclid(360.0),
        ];
        let line = cells
            .map(|cell| format!("{cell:.4}").replace('.', ","))
            .join(";");
        let _ = writeln!(log, "{line}");
    }
    let map = "counts_per_rev = 720\nsupply_v = 4.5\n\
        [file]\nskip_lines = 1\ndecimal = \",\"\n\
        [time]\ncolumn = \"millis\"\nunit = \"ms\"\n\
        [command]\ncolumn = \"duty %\"\nunit = \"percent\"\n\
        [position]\ncolumn = \"angle\"\nunit = \"deg\"\nwrap = 360\n";
    let finished = import(directory.path(), log, map);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!(counts(&file), counts(&simulated));
    assert!(file.complete());
    for (found, wanted) in file.column("command_v").iter().zip(&volts) {
        assert!((found - wanted).abs() < 1e-5);
    }
    // Other commands take it as any run: its difference from the same simulation is 0.
    let finished = run(
        directory.path(),
        &["compare", "run.csv", "--fail-above", "0.6"],
    );
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
}

#[test]
fn values_that_readers_refuse_are_errors_and_not_written() {
    let map = format!(
        "counts_per_rev = 720\n{TIME}{NO_COMMAND}[position]\ncolumn = \"x\"\nunit = \"counts\""
    );
    let log = |rows: u64, pause_ms: u64| {
        let mut log = "t_ms,x\n".to_owned();
        for k in 0..rows {
            let late_ms = if 2 * k < rows { 0 } else { pause_ms };
            let _ = writeln!(log, "{},{k}", 3 * k + late_ms);
        }
        log
    };
    // Before and after the rows from which the sample time is taken.
    for (rows, line) in [(100, 52), (10_000, 5002)] {
        let directory = tempfile::tempdir().expect("a directory");
        let finished = import(directory.path(), log(rows, 3_700_000), &map);
        assert_eq!(finished.status, Some(2), "{}", finished.messages);
        let said = format!("line {line}: time leaps");
        assert!(finished.messages.contains(&said), "{}", finished.messages);
        let left = fs::read_dir(directory.path()).expect("a folder").count();
        assert_eq!(left, 2, "nothing but the log and the mapping");
    }
    // Every 100 s; a command of 2,000,000 V; a position beyond the range of count differences.
    for (log, map, wanted) in [
        (
            log(50, 0),
            map.replace("\"ms\"", "\"min\""),
            "180 s, which lies outside 1e-6 .. 60 s",
        ),
        (
            log(50, 0),
            map.replace(
                "recorded = false",
                "column = \"x\"\nunit = \"V\"\nscale = 1e9",
            ),
            "the command in SI is",
        ),
        (
            log(50, 0),
            format!("{map}\nscale = 1e18\noffset = 1e18"),
            "the position in SI is",
        ),
    ] {
        let directory = tempfile::tempdir().expect("a directory");
        let finished = import(directory.path(), log, &map);
        assert_ne!(finished.status, Some(0), "{}", finished.messages);
        assert!(finished.messages.contains(wanted), "{}", finished.messages);
        if directory.path().join("run.csv").exists() {
            let read = run(directory.path(), &["compare", "run.csv"]);
            assert_eq!(read.status, Some(0), "{}", read.messages);
        }
    }
}
