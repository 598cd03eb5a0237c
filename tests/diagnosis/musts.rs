//! Invariants of every diagnosis: figures agree, probabilities and shares add up, errors of nested models are
//! non-increasing.

use std::sync::LazyLock;

use case_generator::generate;
use motorlab::diagnose::{Diagnosis, Options, Settings, Verdict, diagnose, nominal_fit};
use motorlab::least_squares::fit_runs;
use motorlab::motor::{CommandKind, Motor, read_motor};
use motorlab::recording::{Run, read_run_from, write_run};
use serde_json::Value;

use crate::figures::{printable, unknown_figures};
use crate::recorded::{Effects, LEVELS, recorded, with};
use crate::support::command::run;

/// The levels of [`LEVELS`] in another order.
const OTHER_LEVELS: [f64; 10] = [-4.5, 0.5, -2.0, 2.0, -1.0, 1.0, -4.5, 4.5, -3.0, 3.0];
const STEP: [f64; 1] = [4.5];

/// One recording, the motor that it is compared with, and the diagnosis.
struct Diagnosed {
    name: String,
    runs: Vec<Run>,
    motor: Motor,
    found: Diagnosis,
}

impl Diagnosed {
    fn new(name: &str, runs: Vec<Run>, motor: Motor, reference: &[Run]) -> Self {
        let options = Options {
            reference,
            ..Options::default()
        };
        let found = diagnose(&runs, &motor, &options).expect("a diagnosis");
        Self {
            name: name.to_owned(),
            runs,
            motor,
            found,
        }
    }

    fn document(&self) -> Value {
        serde_json::to_value(&self.found).expect("JSON")
    }
}

/// Twelve recordings: no effect, parameter mismatch, single effects, two effects, little data, outside the catalogue,
/// a reference.
static ALL: LazyLock<Vec<Diagnosed>> = LazyLock::new(|| {
    let levels = |motor: &Motor| vec![recorded(motor, &LEVELS, 0.01, 8.0)];
    let simulated = |name: &str, effects: Effects<'_>| {
        Diagnosed::new(name, levels(&with(effects)), Motor::default(), &[])
    };
    let generated = |seed: u64, kind: &str| {
        let case = generate(seed, &kind.parse().expect("a kind"));
        let text = case.runs[2].to_csv();
        let run = read_run_from(text.as_bytes(), "case").expect("a run").0;
        let motor = Motor::from_toml(&case.nominal.to_toml()).expect("a motor");
        Diagnosed::new(kind, vec![run], motor, &[])
    };
    let mut heavy = Motor::default();
    heavy.parameters.inertia_kg_m2 *= 1.2;
    heavy.parameters.back_emf_v_s_per_rad *= 0.9;
    let dead_zone = with(&[("dead_zone", &[0.8])]);
    let step = vec![recorded(
        &with(&[("voltage_drop", &[0.5])]),
        &STEP,
        0.03,
        2.0,
    )];
    let reference = [recorded(&dead_zone, &OTHER_LEVELS, 0.01, 8.0)];
    vec![
        simulated("nothing", &[]),
        Diagnosed::new("other parameters", levels(&heavy), Motor::default(), &[]),
        simulated("dead zone", &[("dead_zone", &[0.8])]),
        simulated("backlash", &[("backlash", &[0.05, 0.5, 0.0])]),
        simulated("gravity load", &[("gravity_load", &[0.03, 0.4])]),
        simulated("voltage drop", &[("voltage_drop", &[0.5])]),
        simulated(
            "dead zone and friction",
            &[("dead_zone", &[0.8]), ("viscous_friction", &[0.02])],
        ),
        Diagnosed::new("one step", step, Motor::default(), &[]),
        generated(5, "stribeck"),
        generated(31, "clock_stall"),
        generated(23, "sample_jitter"),
        Diagnosed::new(
            "the same twice",
            levels(&dead_zone),
            Motor::default(),
            &reference,
        ),
    ]
});

/// In one test, since a runner with one process per test would diagnose all of them for each.
#[test]
fn invariants_of_every_diagnosis() {
    the_cases_have_different_verdicts();
    every_figure_of_a_sentence_is_one_of_the_document();
    the_written_motor_is_the_documents();
    the_fitted_error_never_rises_from_one_nested_model_to_the_next();
    re_identified_parameters_leave_no_more_than_plain_least_squares();
    probabilities_and_shares_add_up();
    what_is_identified_is_probable_and_not_at_a_bound();
    a_search_ends_at_its_limit();
}

/// No round is begun after the limit of simulation time.
fn a_search_ends_at_its_limit() {
    for one in ALL.iter() {
        let mut before = one.found.steps.iter().rev().skip(1);
        assert!(before.all(|step| !step.limited), "{}", one.name);
    }
}

fn the_cases_have_different_verdicts() {
    let mut verdicts: Vec<String> = (ALL.iter())
        .map(|one| format!("{:?}", one.found.verdict))
        .collect();
    for (one, verdict) in ALL.iter().zip(&verdicts) {
        println!("{}: {verdict}: {}", one.name, one.found.sentence);
    }
    verdicts.sort();
    verdicts.dedup();
    assert!(verdicts.len() >= 4, "{verdicts:?}");
}

fn every_figure_of_a_sentence_is_one_of_the_document() {
    let mut figures = 0;
    for one in ALL.iter() {
        let known = printable(&one.document());
        let unknown = unknown_figures(&one.found.sentence, &known);
        assert!(
            unknown.is_empty(),
            "{}: {unknown:?} in {}",
            one.name,
            one.found.sentence
        );
        // The note is read with the sentence.
        let unknown = unknown_figures(&one.found.note, &known);
        let outside: Vec<f64> = one.found.base.values().map(|number| number.value).collect();
        assert!(
            unknown.is_empty(),
            "{}: {unknown:?} in {} ({outside:?})",
            one.name,
            one.found.note
        );
        figures += one
            .found
            .sentence
            .split_whitespace()
            .filter(|w| w.parse::<f64>().is_ok())
            .count();
        // A figure without a source is detected.
        let made_up = one
            .found
            .sentence
            .replacen("RMS error: ", "RMS error: 7", 1);
        assert!(!unknown_figures(&made_up, &known).is_empty(), "{made_up}");
    }
    assert!(figures >= 5 * ALL.len(), "{figures}");
}

/// `--model-out` writes the motor of the verdict, with the parameters of the JSON document.
fn the_written_motor_is_the_documents() {
    for name in ["dead zone", "dead zone and friction", "other parameters"] {
        let one = ALL.iter().find(|one| one.name == name).expect("a case");
        let keep = tempfile::tempdir().expect("a directory");
        let here = keep.path();
        write_run(&one.runs[0], &here.join("run.csv")).expect("written");
        std::fs::write(here.join("motor.toml"), "").expect("written");
        let arguments = "diagnose run.csv --motor motor.toml --model-out out.toml --json";
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let done = run(here, &arguments);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let document: Value = serde_json::from_str(&done.output).expect("JSON");
        let written = read_motor(here.join("out.toml")).expect("a motor file");
        // The same call of the library has the same motor.
        let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs()).max(1e-12);
        let (p, q) = (&written.parameters, &one.found.model.parameters);
        for (a, b) in [
            (p.inertia_kg_m2, q.inertia_kg_m2),
            (p.back_emf_v_s_per_rad, q.back_emf_v_s_per_rad),
            (p.coulomb_friction_nm, q.coulomb_friction_nm),
            (
                p.viscous_friction_nm_s_per_rad,
                q.viscous_friction_nm_s_per_rad,
            ),
            (p.inductance_h, q.inductance_h),
        ] {
            assert!(same(a, b), "{name}: {a} written, {b} diagnosed");
        }
        // Each parameter of an identified effect is the same in the file and in the document.
        let file = std::fs::read_to_string(here.join("out.toml")).expect("text");
        let file: toml::Table = file.parse().expect("TOML");
        for id in document["effects"].as_array().expect("a list") {
            let id = id.as_str().expect("an id");
            let causes = document["causes"].as_array().expect("a list").iter();
            let cause = causes
                .clone()
                .find(|cause| cause["effect"] == id)
                .expect("it is weighed");
            for (key, number) in cause["parameters"].as_object().expect("numbers") {
                let value = number["value"].as_f64().expect("a number");
                let own = file
                    .get("effects")
                    .and_then(|effects| effects.get(id)?.get(key));
                // Some effects are other values of the motor's parameters.
                let motors = match id {
                    "inertia" => Some(p.inertia_kg_m2),
                    "viscous_friction" => Some(p.viscous_friction_nm_s_per_rad),
                    "coulomb_friction" => Some(p.coulomb_friction_nm),
                    "inductance" => Some(p.inductance_h),
                    _ => None,
                };
                let in_file = own.and_then(toml::Value::as_float).or(motors);
                let in_file = in_file.unwrap_or_else(|| panic!("{name}: no {id}.{key} in {file}"));
                assert!(
                    same(in_file, value),
                    "{name}: {id}.{key} {in_file} written, {value} stated"
                );
            }
        }
        // Without effects the document states parameters relative to the motor file's.
        for (key, number) in document["base"].as_object().expect("numbers") {
            let (written, own) = match key.as_str() {
                "inertia_kg_m2" => (p.inertia_kg_m2, one.motor.parameters.inertia_kg_m2),
                "back_emf_v_s_per_rad" => (
                    p.back_emf_v_s_per_rad,
                    one.motor.parameters.back_emf_v_s_per_rad,
                ),
                _ => continue,
            };
            let value = number["value"].as_f64().expect("a number");
            assert!(
                same(written / own, value),
                "{name}: {key} {} written, {value} stated",
                written / own
            );
        }
    }
}

/// On the training data each model contains the one before.
fn the_fitted_error_never_rises_from_one_nested_model_to_the_next() {
    for one in ALL.iter() {
        let fitted = one.found.gap.fitted;
        assert!(
            fitted.before >= fitted.after_parameters,
            "{}: {fitted:?}",
            one.name
        );
        assert!(
            fitted.after_parameters >= fitted.after_effect,
            "{}: {fitted:?}",
            one.name
        );
        assert!(fitted.after_effect > 0.0, "{}: {fitted:?}", one.name);
    }
}

/// Largest ratio to the error of plain least squares of a first-order motor, by the same measure: priors may cost a
/// little.
const AS_GOOD: f64 = 1.05;

fn re_identified_parameters_leave_no_more_than_plain_least_squares() {
    let cases = [
        "other parameters",
        "backlash",
        "gravity load",
        "voltage drop",
        "stribeck",
    ];
    for one in ALL.iter().filter(|one| cases.contains(&&*one.name)) {
        let voltage = CommandKind::Voltage;
        let whole = fit_runs(&one.runs, &[]).expect("it turns").motor;
        let plain = whole.in_place_of(&one.motor, voltage);
        let segments = nominal_fit(&one.runs, &one.motor, &Settings::default())
            .expect("a fit")
            .motor;
        let refitted = one.found.gap.fitted.after_parameters;
        for (what, motor) in [("whole runs", plain), ("segments", segments)] {
            let other = diagnose(&one.runs, &motor, &Options::default()).expect("a diagnosis");
            let left = other.gap.fitted.before;
            assert!(
                refitted <= AS_GOOD * left,
                "{}: {refitted} counts re-identified, {left} of least squares over {what}",
                one.name
            );
        }
    }
}

/// Rounding error of sums of some hundred numbers.
const SUM: f64 = 1e-9;

fn probabilities_and_shares_add_up() {
    for one in ALL.iter() {
        let (name, found) = (&one.name, &one.found);
        let sets: f64 = found.sets.iter().map(|set| set.probability).sum();
        assert!((sets - 1.0).abs() < SUM, "{name}: sets add to {sets}");
        // For each stage, the probability that an effect of it is present: sets with two count in both.
        for (stage, probability) in &found.place.stage_probabilities {
            let of_it: f64 = (found.causes.iter().filter(|cause| cause.stage == *stage))
                .map(|cause| cause.inclusion)
                .fold(0.0, f64::max);
            assert!(
                *probability >= of_it - SUM && *probability <= 1.0,
                "{name}, {stage}: {probability} below {of_it}"
            );
        }
        // An inclusion probability is the sum over the sets with the effect.
        for cause in &found.causes {
            let with = found
                .sets
                .iter()
                .filter(|set| set.effects.contains(&cause.effect));
            let sum: f64 = with.map(|set| set.probability).sum();
            assert!(
                (cause.inclusion - sum).abs() < SUM,
                "{name}: {cause:?} {sum}"
            );
        }
        let Some(nominal) = found.budget.first() else {
            assert_eq!(found.verdict, Verdict::NoChange, "{name}");
            continue;
        };
        assert_eq!(nominal.step, "nominal", "{name}");
        if nominal.share == 0.0 {
            // The nominal model has no error above the noise floor to divide.
            assert!(
                matches!(found.verdict, Verdict::NoGap | Verdict::NoChange),
                "{name}"
            );
            continue;
        }
        assert_eq!(nominal.share, 1.0, "{name}");
        let steps = found.budget[1..].iter().map(|step| step.share);
        let total: f64 = steps.sum();
        assert!(
            (total - 1.0).abs() < SUM,
            "{name}: shares add to {total}: {:#?}",
            found.budget
        );
        let last = found.budget.last().expect("a step");
        assert_eq!(last.step, "unexplained", "{name}");
        assert!((last.share - found.unexplained.share).abs() < SUM, "{name}");
        let order: Vec<&str> = found.budget.iter().map(|step| step.step).collect();
        assert_eq!(order.len(), found.effects.len() + 3, "{name}: {order:?}");
        assert_eq!(order[1], "parameters", "{name}");
        assert_eq!(order[2..order.len() - 1], found.effects[..], "{name}");
        for step in &found.budget {
            assert!(step.lo95 <= step.hi95, "{name}: {step:?}");
        }
        let regions: f64 = found
            .unexplained
            .regions
            .iter()
            .map(|region| region.share)
            .sum();
        assert!(regions <= 1.0 + SUM, "{name}: {regions}");
    }
}

fn what_is_identified_is_probable_and_not_at_a_bound() {
    let least = Settings::default().identified;
    let (mut named, mut bounded) = (0, 0);
    for one in ALL.iter() {
        for id in &one.found.effects {
            named += 1;
            let cause = one.found.causes.iter().find(|cause| cause.effect == *id);
            let cause = cause.unwrap_or_else(|| panic!("{}: {id} is no cause", one.name));
            let classes = one.found.classes.iter();
            let class = classes.filter(|class| class.members.contains(id));
            let probable = class
                .map(|class| class.probability)
                .fold(cause.inclusion, f64::max);
            assert!(probable >= least, "{}: {cause:?}", one.name);
            assert!(!cause.at_bound, "{}: {cause:?}", one.name);
        }
        // The listed values are those of the fit that ended at a bound.
        for cause in &one.found.causes {
            let is_listed = cause.parameters.values().any(|value| value.at_bound);
            assert_eq!(cause.at_bound, is_listed, "{}: {cause:?}", one.name);
            bounded += usize::from(cause.at_bound);
        }
        let has_effects = matches!(one.found.verdict, Verdict::Effect | Verdict::Partial);
        assert_eq!(has_effects, !one.found.effects.is_empty(), "{}", one.name);
        let likeliest = one
            .found
            .sets
            .iter()
            .map(|set| set.probability)
            .fold(0.0, f64::max);
        assert!(
            likeliest > 0.0 && one.found.probability <= 1.0,
            "{}",
            one.name
        );
    }
    assert!(named >= 5 && bounded >= 1, "{named} {bounded}");
}
