//! Motors without effects are not accused: benches of the independent generator, of all its families, protocols,
//! sample times, encoders, loads and tolerances, stated or not, in the proportions of its draws.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use case_generator::breadth::{FAMILIES, HiddenEffects, PROTOCOLS, generate_bench};
use motorlab::diagnose::{Options, Settings, Verdict, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::{Run, read_run_from};

/// Seed of the first bench, on which no setting of the method was chosen.
const FIRST_SEED: u64 = 410_000;
const BENCHES: u64 = 40;
/// Most of [`BENCHES`] with an effect that is identified with 0.5 or more. The aim is 3 %.
const ACCUSED: usize = 4;
/// Most of them with [`Settings::confident`] or more.
const SURELY_ACCUSED: usize = 2;

#[test]
fn motors_without_an_effect_have_no_false_alarm() {
    let settings = Settings::default();
    let (mut accused, mut surely, mut words) = (0, 0, String::new());
    let (mut families, mut protocols) = (BTreeSet::new(), BTreeSet::new());
    let (mut with_random_load, mut unstated) = (0, 0);
    for seed in FIRST_SEED..FIRST_SEED + BENCHES {
        let made = generate_bench(seed, HiddenEffects::Nothing, None);
        families.insert(made.bench.family);
        protocols.insert(made.bench.protocol);
        with_random_load += usize::from(made.bench.has_random_torque);
        unstated += usize::from(!made.bench.is_stated);
        let runs: Vec<Run> = (made.case.runs.iter())
            .map(|run| {
                let text = run.to_csv();
                read_run_from(text.as_bytes(), "run").expect("a run").0
            })
            .collect();
        let motor = Motor::from_toml(&made.motor_file).expect("a motor file");
        let found = diagnose(&runs, &motor, &Options::default()).expect("a diagnosis");
        let has_effect = |p: f64| {
            let alone = found.causes.iter().filter(|cause| !cause.at_bound);
            alone
                .map(|cause| cause.class_probability.unwrap_or(cause.inclusion))
                .any(|probability| probability >= p)
        };
        // A random load is no effect: it is a part of the noise floor.
        let quiet = matches!(found.verdict, Verdict::NoGap | Verdict::Parameters);
        if !quiet || has_effect(settings.identified) {
            accused += 1;
            surely += usize::from(has_effect(settings.confident));
            writeln!(words, "{seed} {:?}: {}", made.bench, found.sentence).expect("room");
        }
    }
    println!(
        "{accused} of {BENCHES}, {surely} with {} or more\n{words}",
        settings.confident
    );
    // All families occur.
    assert_eq!(families.len(), FAMILIES.len(), "{families:?}");
    assert!(protocols.len() + 1 >= PROTOCOLS.len(), "{protocols:?}");
    assert!(
        with_random_load >= 5 && unstated >= 5,
        "{with_random_load} {unstated}"
    );
    assert!(accused <= ACCUSED, "{accused} of {BENCHES}:\n{words}");
    assert!(surely <= SURELY_ACCUSED, "{surely} of {BENCHES}:\n{words}");
}
