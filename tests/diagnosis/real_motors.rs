//! What the diagnosis says of recordings of real motors: nothing surely that is documented otherwise, and no gap where repeats
//! differ by as much.

use std::path::Path;

use crate::support;
use motorlab::diagnose::{DiagnoseError, Diagnosis, Options, Verdict, diagnose, nominal_fit};
use motorlab::import::{Map, import};
use motorlab::motor::{Motor, read_motor};
use motorlab::recording::{Run, read_run};

/// Said with so much, a cause is asserted.
const SURE: f64 = 0.9;

fn run_of(folder: &Path, log: &str, map: &Map) -> Run {
    let scratch = tempfile::tempdir().expect("a directory");
    let source = std::fs::File::open(folder.join(log)).expect("the log");
    let imported = import(source, "log", map, &scratch.path().join("run.csv")).expect("a run");
    read_run(&imported.runs[0].path).expect("it reads back").0
}

fn map(name: &str) -> Map {
    Map::read(&Path::new("tests/real/maps").join(name)).expect("a mapping")
}

fn motor(name: &str) -> Motor {
    read_motor(Path::new("tests/real/motors").join(name)).expect("a motor file")
}

fn diagnosis(runs: &[Run], motor: &Motor) -> Diagnosis {
    let found = diagnose(runs, motor, &Options::default()).expect("a diagnosis");
    println!("{}", found.sentence);
    found
}

/// Effects that the verdict asserts.
fn asserted(found: &Diagnosis) -> &[&'static str] {
    if found.probability >= SURE {
        &found.effects
    } else {
        &[]
    }
}

/// Whether one of these effects is in the likeliest set, or in one that is not told from it.
fn is_said(found: &Diagnosis, ids: &[&str]) -> bool {
    let mut causes = found.causes.iter();
    let likeliest = causes.find(|cause| !["none", "unknown"].contains(&&*cause.effect));
    likeliest.is_some_and(|cause| {
        let sets = std::iter::once(&cause.effect).chain(&cause.indistinguishable_from);
        sets.flat_map(|set| set.split('+'))
            .any(|id| ids.contains(&id))
    })
}

/// A plain good motor, two repeats each of three levels: what they differ by is more than what a first-order motor leaves.
#[test]
fn three_levels_have_no_gap_beyond_their_repeats() {
    let Some(folder) = support::real_recordings("three_levels_have_no_gap_beyond_their_repeats")
    else {
        return;
    };
    let mut runs = Vec::new();
    for repeat in ["first", "second"] {
        for volts in [6, 12, 24] {
            let text = format!(
                "counts_per_rev = 32000\nsupply_v = 24\n[file]\nnames = false\n[time]\ncolumn = 1\nunit = \"s\"\n[speed]\ncolumn = 2\n\
                 unit = \"rpm\"\nintegrate = \"backward\"\n[command]\nunit = \"V\"\npoints = [[0.0, 0.0], [2.0, {volts}.0]]\n"
            );
            let map = Map::from_toml(&text).expect("a mapping");
            let log = format!("three_levels/{repeat}_{volts}V.csv");
            runs.push(run_of(&folder, &log, &map));
        }
    }
    let nominal = nominal_fit(&runs, &Motor::default()).expect("a first-order motor");
    let found = diagnosis(&runs, &nominal.motor);
    assert!(
        matches!(found.verdict, Verdict::NoGap | Verdict::Parameters),
        "{}",
        found.sentence
    );
    let repeats = found.gap.floor_parts.repeats.expect("commands repeat");
    assert!(repeats > 10.0 * found.gap.floor_parts.rounding, "{repeats}");
}

/// Janot, Gautier and Brunot: friction differs by direction. Rhoban: a load is lifted. In closed loop little can be told by simulation:
/// the inverse form names the cause, and nothing else is asserted.
#[test]
fn of_axes_in_closed_loop_the_documented_cause_is_named() {
    let Some(folder) =
        support::real_recordings("of_axes_in_closed_loop_the_documented_cause_is_named")
    else {
        return;
    };
    let lift = |log: &str| {
        let log = format!("xl330/xl330_m490g_l100mm_{log}.csv");
        run_of(&folder, &log, &map("xl330.toml"))
    };
    let found = diagnosis(
        &[lift("kp100_sin_sin"), lift("kp400_sin_sin")],
        &motor("xl330.toml"),
    );
    let documented = ["gravity_load", "load_friction", "supply_sag"];
    let other = asserted(&found).iter().find(|id| !documented.contains(id));
    assert_eq!(other, None, "{}", found.sentence);
    assert!(is_said(&found, &["gravity_load"]), "{}", found.sentence);
    let whole = run_of(&folder, "emps/DATA_EMPS.csv", &map("emps.toml"));
    let found = diagnosis(&[whole], &motor("emps.toml"));
    let documented = ["asymmetric_friction", "asymmetric_viscous", "constant_load"];
    let other = asserted(&found).iter().find(|id| !documented.contains(id));
    assert_eq!(other, None, "{}", found.sentence);
    assert!(is_said(&found, &documented), "{}", found.sentence);
}

/// Steps of twenty duties both ways: closed-form step responses with a gain by direction leave a third of what symmetric ones leave (SciPy).
#[test]
fn steps_both_ways_differ_by_direction() {
    let Some(folder) = support::real_recordings("steps_both_ways_differ_by_direction") else {
        return;
    };
    let runs: Vec<Run> = [6, 8, 10, 15, 20, 30, 40, 60, 80, 100]
        .into_iter()
        .flat_map(|duty| [duty, -duty])
        .map(|duty| {
            let text = format!(
                "counts_per_rev = 360\nsupply_v = 7.5\n[time]\ncolumn = \"time\"\nunit = \"s\"\n[position]\ncolumn = \"angle\"\n\
                 unit = \"deg\"\n[command]\nunit = \"percent\"\npoints = [[0.0, {duty}.0]]\n"
            );
            let map = Map::from_toml(&text).expect("a mapping");
            run_of(&folder, &format!("ev3/duty_{duty}.txt"), &map)
        })
        .collect();
    let nominal = nominal_fit(&runs, &Motor::default()).expect("a first-order motor");
    let found = diagnosis(&runs, &nominal.motor);
    let by_direction = [
        "asymmetric_gain",
        "asymmetric_viscous",
        "asymmetric_friction",
    ];
    let other = asserted(&found)
        .iter()
        .find(|id| !by_direction.contains(id));
    assert_eq!(other, None, "{}", found.sentence);
    assert!(is_said(&found, &by_direction), "{}", found.sentence);
    assert!(
        found.gap.after_effect < 0.75 * found.gap.after_parameters,
        "{:?}",
        found.gap
    );
}

/// The wheel turns faster than the mean of its PWM allows with the data sheet's back EMF; its dead zone is documented.
#[test]
fn of_the_micromouse_no_other_cause_is_asserted() {
    let Some(folder) = support::real_recordings("of_the_micromouse_no_other_cause_is_asserted")
    else {
        return;
    };
    let runs: Vec<Run> = (1..=4)
        .map(|k| {
            let log = format!("micromouse/encoders{k}.csv");
            run_of(&folder, &log, &map(&format!("micromouse_encoders{k}.toml")))
        })
        .collect();
    let found = diagnosis(&runs, &motor("micromouse.toml"));
    let documented = ["dead_zone", "pwm_freewheel", "supply_sag", "voltage_drop"];
    let other = asserted(&found).iter().find(|id| !documented.contains(id));
    assert_eq!(other, None, "{}", found.sentence);
    // The data sheet's back EMF is half too large: its figure is said, or that of a gain that stands for it.
    let gains = ["supply_error", "resolution_error"];
    let first = found.causes.iter().find(|cause| cause.effect != "unknown");
    let is_a_gain =
        first.is_some_and(|cause| gains.contains(&&*cause.effect) && !cause.parameters.is_empty());
    let is_said = is_a_gain || found.note.contains("back EMF");
    assert!(is_said, "{} {}", found.sentence, found.note);
}

/// The batteries' logs have no position: nothing is diagnosed, and what there is said.
/// A servo that lifts known loads at three gains. Its command is computed from the duty law that its source states, and a regression of
/// that voltage has 1.2 V per N m of load, 1.06 to 1.3 over all loads and gains. Said to be known, the loads tell the same.
#[test]
fn known_loads_tell_what_a_newton_metre_takes() {
    let name = "known_loads_tell_what_a_newton_metre_takes";
    let Some(folder) = support::real_recordings(name) else {
        return;
    };
    let runs_of = |load: &str, torque_nm: f64| -> Vec<Run> {
        let gains = [4, 12, 24].map(|gain| {
            let log = format!("sts3250/{load}_kp{gain}_sin_sin_1.csv.gz");
            let mut run = run_of(&folder, &log, &map(&format!("sts3250_kp{gain}.toml")));
            (run.known.set("gravity_torque_nm", torque_nm)).expect("a known load");
            run
        });
        gains.into()
    };
    let volts_per_nm = |runs: &[Run]| {
        let found = nominal_fit(runs, &Motor::default()).expect("a fit").motor;
        found.parameters.resistance_ohm / found.parameters.torque_constant_nm_per_a
    };
    let mut all = Vec::new();
    for (load, torque_nm) in [
        ("m535g_l100mm", 0.525),
        ("m535g_l150mm", 0.787),
        ("m969g_l100mm", 0.951),
        ("m969g_l150mm", 1.426),
    ] {
        let runs = runs_of(load, torque_nm);
        let found = volts_per_nm(&runs);
        assert!((1.06..1.3).contains(&found), "{load}: {found}");
        all.extend(runs);
    }
    let found = volts_per_nm(&all);
    assert!((1.06..1.3).contains(&found), "all: {found}");
}

#[test]
fn a_log_without_position_is_refused() {
    let Some(folder) = support::real_recordings("a_log_without_position_is_refused") else {
        return;
    };
    let log = "micromouse/batteryVoltage1.csv";
    let run = run_of(&folder, log, &map("micromouse_battery_aaa.toml"));
    let refused = diagnose(&[run], &motor("micromouse.toml"), &Options::default());
    let refused = refused.expect_err("nothing to judge");
    assert!(matches!(
        refused,
        DiagnoseError::NotRecorded {
            what: "position",
            ..
        }
    ));
}
