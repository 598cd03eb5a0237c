//! Nothing is said to be there of motors that have nothing but their own friction: benches of the independent generator, of four
//! families, seven protocols, 1 to 30 ms, 12 to 8,192 counts a turn, whose loads are still and whose tolerances are stated.

use std::fmt::Write as _;

use case_generator::breadth::{Bench, Hides, generate_bench};
use motorlab::diagnose::{Options, Verdict, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::{Run, read_run_from};

/// Seed of the first bench.
const FIRST_SEED: u64 = 410_000;
/// Said with so much, a thing is said surely.
const SURE: f64 = 0.9;

/// Of so many benches from the first seed on, those that are still and stated: how many there are, how many are said to have
/// something, how many of these surely, and which.
fn alarms(benches: u64, is_asked: fn(&Bench) -> bool) -> (u64, u64, u64, String) {
    let (mut asked, mut said, mut sure, mut words) = (0, 0, 0, String::new());
    for seed in FIRST_SEED..FIRST_SEED + benches {
        let made = generate_bench(seed, Hides::Nothing, None);
        if !is_asked(&made.bench) {
            continue;
        }
        asked += 1;
        let runs: Vec<Run> = (made.case.runs.iter())
            .map(|run| {
                let text = run.to_csv();
                read_run_from(text.as_bytes(), "run").expect("a run").0
            })
            .collect();
        let motor = Motor::from_toml(&made.motor_file).expect("a motor file");
        let found = diagnose(&runs, &motor, &Options::default()).expect("a diagnosis");
        if matches!(
            found.verdict,
            Verdict::Effect | Verdict::Partial | Verdict::OutsideCatalogue | Verdict::Ambiguous
        ) {
            said += 1;
            sure += u64::from(found.probability >= SURE);
            writeln!(words, "{seed} {:?}: {}", made.bench, found.sentence).expect("room");
        }
    }
    (asked, said, sure, words)
}

fn is_still(bench: &Bench) -> bool {
    !bench.wanders && bench.is_stated
}

#[test]
fn no_alarm_without_a_gap() {
    let (asked, said, sure, words) = alarms(48, is_still);
    println!("{said} of {asked}, {sure} surely\n{words}");
    assert!(asked >= 20, "{asked}");
    assert!(20 * said <= asked && sure == 0, "{words}");
}

/// With a load that wanders, and tolerances that nobody states, there are alarms: docs/decisions/0005 has the figures.
/// `cargo test --test diagnosis perfect_motors:: -- --ignored --nocapture` counts them, half an hour.
#[test]
#[ignore = "half an hour, and a count"]
fn alarms_of_three_hundred_benches_are_counted() {
    let (asked, said, sure, words) = alarms(300, |_| true);
    println!("{said} of {asked}, {sure} surely\n{words}");
    let (asked, said, sure, words) = alarms(300, is_still);
    assert!(20 * said <= asked && 100 * sure <= asked, "{words}");
}
