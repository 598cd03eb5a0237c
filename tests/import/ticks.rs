//! Clocks that count ticks: the unit that no name says, and whole numbers that no float holds.

use crate::support::foreign_logs::{Truth, asked, counts, imported, log, near};

const COUNTS: [&str; 2] = ["--counts-per-rev", "720"];
/// Ticks of 100 ns in a millisecond.
const PER_MS: u64 = 10_000;

/// A log with these columns before a command in V and counts.
fn with(truth: &Truth, names: &str, columns: &[&dyn Fn(usize) -> String]) -> String {
    let volts = |k: usize| format!("{:.6}", truth.volts(k));
    let turned = |k: usize| truth.counts[k].to_string();
    let mut cells = columns.to_vec();
    cells.push(&volts);
    cells.push(&turned);
    log(&format!("{names},voltage,encoder"), truth.rows(), &cells)
}

/// 100 ns at 10 ms, which as us were 100 ms: a time constant of ten times the motor's.
#[test]
fn a_clock_that_may_have_two_units_is_asked_about() {
    for (sample_time_s, us, of_100_ns) in [(0.005, "0.05", "0.005"), (0.01, "0.1", "0.01")] {
        let truth = Truth::steps(sample_time_s, 300);
        let ticks = |k: usize| (77_777 + PER_MS * truth.ms(k)).to_string();
        for name in ["qpc", "timestamp", "ticks", "StopwatchTicks", "t"] {
            let said = asked("log.csv", &with(&truth, name, &[&ticks]), &COUNTS);
            assert!(said.contains(&format!("--time {name}:")), "{said}");
            let both = format!("in us a row every {us} s, in 100ns a row every {of_100_ns} s");
            assert!(said.contains(&both), "{said}");
            assert!(!said.contains("--position"), "{said}");
            // One that the name says, or a flag, is not.
            let time = format!("{name}:100ns");
            let flags = [&COUNTS[..], &["--time", &time]].concat();
            let (file, _) = imported("log.csv", &with(&truth, name, &[&ticks]), &flags);
            near(&file.column("t_s"), &truth.times(), 1e-9);
            assert_eq!(counts(&file), truth.counts);
        }
        let us = |k: usize| (1000 * truth.ms(k)).to_string();
        let (file, _) = imported("log.csv", &with(&truth, "t_us", &[&us]), &COUNTS);
        near(&file.column("t_s"), &truth.times(), 1e-9);
    }
    // Cycles of a processor have no unit.
    let truth = Truth::steps(0.01, 300);
    let cycles = |k: usize| (168_000 * truth.ms(k)).to_string();
    let said = asked("log.csv", &with(&truth, "cycles", &[&cycles]), &COUNTS);
    assert!(said.contains("--time SAMPLETIME"), "{said}");
}

#[test]
fn another_clock_of_the_log_tells_the_unit() {
    let truth = Truth::steps(0.01, 300);
    let ticks = |k: usize| (PER_MS * truth.ms(k)).to_string();
    let host = |k: usize| (truth.ms(k) + (k % 3) as u64).to_string();
    let ten = |_: usize| "10".to_owned();
    let stamped = |k: usize| {
        let s = truth.t_s(k);
        format!("12:00:{:02}.{:03}", s as u64, truth.ms(k) % 1000)
    };
    type Cell<'a> = &'a dyn Fn(usize) -> String;
    let cases: [(&str, Cell<'_>); 3] = [
        ("timestamp,host_ms", &host),
        ("ticks,dt_ms", &ten),
        ("time,received", &stamped),
    ];
    for (names, other) in cases {
        let (file, said) = imported("log.csv", &with(&truth, names, &[&ticks, other]), &COUNTS);
        let (name, other) = names.split_once(',').expect("two names");
        let words = format!("`{name}` in 100ns, as `{other}` tells, a row every 0.01 s");
        assert!(said.contains(&words), "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-9);
        assert_eq!(counts(&file), truth.counts, "{said}");
    }
    let text = format!("# fs = 100 Hz\n{}", with(&truth, "qpc", &[&ticks]));
    let (file, said) = imported("log.csv", &text, &COUNTS);
    assert!(said.contains("in 100ns, as `fs = 100 Hz` tells"), "{said}");
    near(&file.column("t_s"), &truth.times(), 1e-9);
}

/// Floats of them are 12.8 us apart: an eighth of a row's jitter here.
#[test]
fn ticks_beyond_the_floats_are_exact() {
    let truth = Truth::steps(0.001, 3000);
    let jitter = |k: usize| (k * 7919 % 1009) as u64;
    let since = |k: usize| PER_MS * truth.ms(k) + jitter(k);
    let ticks = |k: usize| (638_800_000_001_234_567 + since(k)).to_string();
    let (file, said) = imported("log.csv", &with(&truth, "Ticks", &[&ticks]), &COUNTS);
    assert!(said.contains("`Ticks` in 100ns"), "{said}");
    let expected: Vec<f64> = truth.rows().map(|k| since(k) as f64 * 1e-7).collect();
    near(&file.column("t_s"), &expected, 1e-9);
    // Nanoseconds since 1970 are 256 ns apart.
    let ns = |k: usize| (1_776_106_992_000_000_123 + 100 * since(k)).to_string();
    let (file, _) = imported("log.csv", &with(&truth, "stamp_ns", &[&ns]), &COUNTS);
    near(&file.column("t_s"), &expected, 1e-9);
}

#[test]
fn more_names_of_a_time_since_the_row_before() {
    let truth = Truth::steps(0.01, 300);
    for (name, step) in [("Δt [ms]", "10"), ("elapsed_since_last_us", "10000")] {
        let text = with(&truth, name, &[&|_| step.to_owned()]);
        let (file, said) = imported("log.csv", &text, &COUNTS);
        assert!(said.contains("the time since the row before"), "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-9);
    }
}
