//! `diagnose --reference`: changes between two sets of runs of one motor, and none without a change.

use crate::recorded::driven;
use crate::support::command::run;
use case_generator::{Chosen, Effect, Motor as TrueMotor, generate, record_chosen};
use motorlab::diagnose::{Diagnosis, Options, Verdict, diagnose};
use motorlab::motor::{ActiveEffect, Motor};
use motorlab::recording::{Run, read_run_from};

const SAMPLE_TIME_S: f64 = 0.01;
const SAMPLES: usize = 1000;

/// Two recordings of one motor of the independent generator under different profiles, with random friction and load.
fn pair(seed: u64, kind: &str) -> ([Run; 2], Motor) {
    let case = generate(seed, &kind.parse().expect("a kind"));
    let run = |k: usize| {
        let text = case.runs[k].to_csv();
        read_run_from(text.as_bytes(), "case").expect("a run").0
    };
    let motor = Motor::from_toml(&case.nominal.to_toml()).expect("a motor");
    ([run(1), run(2)], motor)
}

fn since(now: &Run, then: &Run, motor: &Motor) -> Diagnosis {
    let options = Options {
        reference: std::slice::from_ref(then),
        ..Options::default()
    };
    let found = diagnose(std::slice::from_ref(now), motor, &options).expect("a diagnosis");
    println!("{}", found.sentence);
    found
}

/// A motor under levels of 0.1 to 0.35 s, which depend on the seed.
fn recorded(motor: &Motor, seed: u32) -> Run {
    // A linear congruential generator.
    let mut state = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let mut next = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    let mut command: Vec<f64> = Vec::new();
    while command.len() < SAMPLES {
        let level = (9.0 * next() - 4.5).clamp(-4.5, 4.5);
        let hold = 10.0 + 25.0 * next();
        command.extend(std::iter::repeat_n(level, hold as usize));
    }
    command.truncate(SAMPLES);
    driven(motor, command, SAMPLE_TIME_S)
}

/// The handout's motor with parameter mismatch within a tolerance of 5 %.
fn motor() -> Motor {
    let mut motor = Motor::default();
    motor.parameters.inertia_kg_m2 *= 1.06;
    motor.parameters.back_emf_v_s_per_rad *= 0.97;
    motor.parameters.coulomb_friction_nm *= 0.93;
    motor.parameters.viscous_friction_nm_s_per_rad *= 1.08;
    motor
}

fn with(mut motor: Motor, id: &str, values: &[f64]) -> Motor {
    let effect = ActiveEffect::new(id, values).expect("an effect of the catalogue");
    motor.effects.set(effect);
    motor
}

/// The same motor twice, under different profiles, also with effects that the motor file lacks.
#[test]
fn the_same_motor_twice_is_no_change() {
    for (seed, kind) in [(40, "none"), (43, "dead_zone")] {
        let ([then, now], motor) = pair(seed, kind);
        let found = since(&now, &then, &motor);
        assert_eq!(
            found.verdict,
            Verdict::NoChange,
            "{kind}: {}",
            found.sentence
        );
    }
}

/// A change is named, with an interval that contains its value, and with the value before.
#[test]
fn one_change_is_named_with_both_values() {
    let changed = |change: &dyn Fn(&mut Motor)| {
        let mut motor = motor();
        change(&mut motor);
        motor
    };
    let then = motor();
    let p = &then.parameters;
    let viscous = 3.0 * p.viscous_friction_nm_s_per_rad;
    let coulomb = 2.0 * p.coulomb_friction_nm;
    let inertia = 1.5 * p.inertia_kg_m2;
    // Effect, its parameter, motor before, motor after, the value before and after.
    let cases = [
        (
            "viscous_friction",
            "coefficient_nm_s_per_rad",
            motor(),
            changed(&|m| m.parameters.viscous_friction_nm_s_per_rad = viscous),
            p.viscous_friction_nm_s_per_rad,
            viscous,
        ),
        (
            "coulomb_friction",
            "torque_nm",
            motor(),
            changed(&|m| m.parameters.coulomb_friction_nm = coulomb),
            p.coulomb_friction_nm,
            coulomb,
        ),
        (
            "inertia",
            "inertia_kg_m2",
            motor(),
            changed(&|m| m.parameters.inertia_kg_m2 = inertia),
            p.inertia_kg_m2,
            inertia,
        ),
        (
            "dead_zone",
            "threshold_v",
            with(motor(), "dead_zone", &[0.5]),
            with(motor(), "dead_zone", &[1.5]),
            0.5,
            1.5,
        ),
        (
            "supply_error",
            "gain",
            motor(),
            with(motor(), "supply_error", &[0.85]),
            1.0,
            0.85,
        ),
    ];
    for (id, key, then, now, was, is) in cases {
        let found = since(&recorded(&now, 2), &recorded(&then, 1), &Motor::default());
        assert_eq!(found.verdict, Verdict::Effect, "{id}: {}", found.sentence);
        assert_eq!(found.effects, [id], "{}", found.sentence);
        let number = found.causes[0].parameters[key];
        assert!(number.lo95 <= is && is <= number.hi95, "{id}: {number:?}");
        let reference = number.reference.expect("what it was");
        // A threshold is known between two levels only.
        assert!(
            (reference - was).abs() < (reference - is).abs(),
            "{id}: {number:?}"
        );
        assert!(
            found.sentence.contains("in the reference"),
            "{}",
            found.sentence
        );
    }
}

#[test]
fn the_command_prints_both_values_in_every_format() {
    let directory = tempfile::tempdir().expect("a directory");
    let case = generate(43, &"none".parse().expect("a kind"));
    for (name, k) in [("then.csv", 1), ("now.csv", 2)] {
        std::fs::write(directory.path().join(name), case.runs[k].to_csv()).expect("room");
    }
    std::fs::write(directory.path().join("motor.toml"), case.nominal.to_toml()).expect("room");
    let arguments = |more: &[&'static str]| {
        let own = [
            "diagnose",
            "now.csv",
            "--reference",
            "then.csv",
            "--motor",
            "motor.toml",
        ];
        [&own[..], more].concat()
    };
    let done = run(
        directory.path(),
        &arguments(&["--json", "--html", "why.html"]),
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let json: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
    assert_eq!(json["verdict"], "no_change", "{}", json["sentence"]);
    assert_eq!(json["reference"]["runs"][0], "then.csv");
    let page = std::fs::read_to_string(directory.path().join("why.html")).expect("a page");
    for part in [
        "fitted to the reference (then.csv)",
        "in the reference",
        "agree with the reference",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // A missing run is an error.
    let done = run(
        directory.path(),
        &arguments(&["--repeats", "now.csv,then.csv"]),
    );
    assert_eq!(done.status, Some(2), "{}", done.messages);
    assert!(
        done.messages
            .contains("--repeats then.csv: not among the runs"),
        "{}",
        done.messages
    );
    let done = run(directory.path(), &arguments(&["--repeats", "now.csv"]));
    assert_eq!(done.status, Some(2), "{}", done.messages);
    assert!(
        done.messages.contains("expected two runs or more"),
        "{}",
        done.messages
    );
}

/// An effect that the reference cannot show is no change: a step does not determine a dead zone.
#[test]
fn undetermined_parameters_are_not_reported_as_changed() {
    let motor = with(motor(), "dead_zone", &[1.1]);
    let step = driven(&motor, vec![4.5; SAMPLES], SAMPLE_TIME_S);
    let found = since(&recorded(&motor, 2), &step, &Motor::default());
    assert_eq!(found.verdict, Verdict::NoChange, "{}", found.sentence);
    // Effects of these runs are shared with the reference.
    let effects = found.reference.expect("reference runs").effects;
    assert_eq!(effects, ["dead_zone"]);
}

/// Backlash is invisible in a staircase in one direction: that later runs in both directions show it is no change.
#[test]
fn an_effect_that_the_reference_does_not_show_is_no_change() {
    let motor = with(motor(), "backlash", &[0.05, 0.5, 0.0]);
    let levels = [1.0, 2.0, 3.0, 3.5, 4.0, 4.5];
    let command = (0..SAMPLES).map(|k| levels[k * levels.len() / SAMPLES]);
    let then = driven(&motor, command.collect(), SAMPLE_TIME_S);
    let found = since(&recorded(&motor, 2), &then, &Motor::default());
    assert_eq!(found.verdict, Verdict::NoChange, "{}", found.sentence);
    let effects = found.reference.expect("reference runs").effects;
    assert_eq!(effects, ["backlash"]);
}

/// A recording of 12 s in both directions under a random load of 0.5 % of stall, by the independent generator.
fn loaded(effects: &[(&str, &[(&str, f64)])], first: usize, seed: u64) -> Run {
    let levels = [3.0, -3.0, 4.5, -4.5, 1.5, -1.5, 2.0, -4.0, 0.8, -2.0];
    let effect = |(id, values): &(&str, &[(&str, f64)])| Effect {
        id: (*id).to_owned(),
        parameters: (values.iter())
            .map(|(key, value)| ((*key).to_owned(), *value))
            .collect(),
    };
    let chosen = Chosen {
        motor: TrueMotor::HANDOUT,
        effects: effects.iter().map(effect).collect(),
        protocol: "staircase".to_owned(),
        sample_time_s: SAMPLE_TIME_S,
        levels: (0..24)
            .map(|k| (levels[(k + first) % levels.len()], 0.5))
            .collect(),
        load_share: 0.005,
        load_time_s: 1.0,
        seed,
    };
    let text = record_chosen(&chosen).expect("a recording").run.to_csv();
    read_run_from(text.as_bytes(), "case").expect("a run").0
}

/// A change under a random load of a bench is named, and no change is none.
#[test]
fn a_change_under_a_random_load_is_named() {
    let then = loaded(&[], 0, 11);
    let same = since(&loaded(&[], 3, 12), &then, &Motor::default());
    assert_eq!(same.verdict, Verdict::NoChange, "{}", same.sentence);
    let load = [("constant_load", &[("torque_nm", 0.03)][..])];
    let found = since(&loaded(&load, 3, 13), &then, &Motor::default());
    assert_eq!(found.effects, ["constant_load"], "{}", found.sentence);
    assert!(found.reference.expect("reference runs").effects.is_empty());
}
