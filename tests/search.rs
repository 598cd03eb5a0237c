//! The rebuilt search names what the independent generator hid, and nothing where it hid nothing.

use case_generator::breadth::{Hides, generate_bench};
use case_generator::{Kind, generate};
use motorlab::diagnosis::{Found, search};
use motorlab::motor::{Motor, read_motor};
use motorlab::recording::{Run, read_run_from};

fn motor(text: &str) -> Motor {
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    std::fs::write(file.path(), text).expect("written");
    read_motor(file.path()).expect("a motor file")
}

fn run(csv: &str) -> Run {
    read_run_from(csv.as_bytes(), "run").expect("a run").0
}

/// The set that is named first with the three runs of the handout's kind of motor.
fn named(id: &str, seed: u64) -> Vec<&'static str> {
    let kind: Kind = id.parse().expect("a kind");
    let case = generate(seed, &kind);
    let runs: Vec<Run> = case.runs.iter().map(|case| run(&case.to_csv())).collect();
    let found = search(&runs, &motor(&case.nominal.to_toml())).expect("a search");
    println!("{id}: {found}");
    found.sets.first().cloned().unwrap_or_default()
}

#[test]
fn what_the_generator_hid_is_named_first() {
    for id in [
        "dead_zone",
        "transport_delay",
        "gravity_load",
        "backlash",
        "clock_error",
    ] {
        assert_eq!(named(id, 5), [id], "{id}");
    }
}

/// Motors that are as near to their files as the files say: one that is farther off shows more than its file allows.
#[test]
fn nothing_is_found_in_a_perfect_motors_plain_step() {
    let benches = (0..).map(|seed| generate_bench(seed, Hides::Nothing, Some("step")));
    for bench in benches.filter(|bench| bench.bench.is_stated).take(6) {
        let runs: Vec<Run> = (bench.case.runs.iter())
            .map(|case| run(&case.to_csv()))
            .collect();
        let found = search(&runs, &motor(&bench.motor_file)).expect("a search");
        println!("{:?}: {found}", bench.bench);
        assert_eq!(found.found, Found::Nothing, "{:?}", bench.bench);
        // Few pieces say nothing with certainty.
        assert!(found.pieces >= 8 || found.probability <= 0.9);
    }
}

#[test]
fn what_cannot_be_searched_is_said() {
    let nothing = search(&[], &Motor::default()).expect_err("no run");
    assert!(nothing.to_string().contains("no run"), "{nothing}");
    let short = Run {
        sample_time_s: 0.01,
        counts_per_rev: 720.0,
        t_s: vec![0.0, 0.01],
        command: vec![1.0; 2],
        counts: vec![0, 1],
        ..Run::default()
    };
    let short = search(&[short], &Motor::default()).expect_err("too short");
    assert!(short.to_string().contains("2 samples"), "{short}");
}
