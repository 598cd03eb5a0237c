//! What the diagnosis finds on recordings of real motors, by the commands that docs/real.md tells of: the findings,
//! not their digits.

use std::path::{Path, PathBuf};

use motorlab::diagnose::{Diagnosis, diagnose_holding_out};
use motorlab::import::{Map, import};
use motorlab::motor::read_motor;
use motorlab::recording::{Run, read_run};

mod support;

/// Where the recordings are, or the test is skipped.
fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("MOTORLAB_REAL").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/real"),
        PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    support::skip(test, "no recordings in ../shared/real (or MOTORLAB_REAL)");
    None
}

fn run_of(folder: &Path, log: &str, map: &str) -> Run {
    let scratch = tempfile::tempdir().expect("a directory");
    let map = Map::read(&Path::new("tests/real/maps").join(map)).expect("a mapping");
    let source = std::fs::File::open(folder.join(log)).expect("the log");
    let imported = import(source, "log", &map, &scratch.path().join("run.csv")).expect("a run");
    read_run(&imported.runs[0].path).expect("it reads back").0
}

fn part(run: &Run, samples: std::ops::Range<usize>) -> Run {
    Run {
        path: None,
        sample_time_s: run.sample_time_s,
        counts_per_rev: run.counts_per_rev,
        supply_v: run.supply_v,
        command_kind: run.command_kind,
        complete: true,
        t_s: run.t_s[samples.clone()].to_vec(),
        command: run.command[samples.clone()].to_vec(),
        counts: run.counts[samples].to_vec(),
        ..Run::default()
    }
}

fn diagnosis(runs: &[Run], held_out: &[Run], motor: &str) -> Diagnosis {
    let motor = read_motor(Path::new("tests/real/motors").join(motor)).expect("a motor file");
    diagnose_holding_out(runs, held_out, &motor, &|_| {}).expect("a diagnosis")
}

/// The likeliest set, named or not beside something unknown.
fn likeliest(found: &Diagnosis) -> &[&'static str] {
    &found.sets[0].effects
}

/// Janot, Gautier and Brunot: friction differs by direction, by 3.2 N of 20.5 N in their model.
#[test]
fn friction_of_the_positioning_system_differs_by_direction() {
    let Some(folder) = folder("friction_of_the_positioning_system_differs_by_direction") else {
        return;
    };
    let whole = run_of(&folder, "emps/DATA_EMPS.csv", "emps.toml");
    let half = whole.len() / 2;
    let (first, second) = (part(&whole, 0..half), part(&whole, half..whole.len()));
    let found = diagnosis(&[first], &[second], "emps.toml");
    let set = likeliest(&found);
    assert!(set.contains(&"asymmetric_friction"), "{set:?}");
    assert!(!set.contains(&"stribeck"), "{set:?}");
    let cause = |id: &str| found.causes.iter().find(|cause| cause.effect == id);
    let ratio = cause("asymmetric_friction").expect("weighed").parameters["ratio"].value;
    assert!((-0.35..-0.05).contains(&ratio), "{ratio}");
    let gap = &found.gap;
    assert!(gap.after_effect < 0.7 * gap.after_parameters, "{gap:?}");
}

/// Rhoban's BAM: a load of 0.49 kg at 0.1 m has a moment of 0.48 N m where it is horizontal.
#[test]
fn the_servo_lifts_a_load() {
    let Some(folder) = folder("the_servo_lifts_a_load") else {
        return;
    };
    let lift = |gain: &str| {
        let log = format!("xl330/xl330_m490g_l100mm_{gain}_sin_sin.csv");
        run_of(&folder, &log, "xl330.toml")
    };
    let found = diagnosis(&[lift("kp400")], &[lift("kp100")], "xl330.toml");
    let cause = |id: &str| found.causes.iter().find(|cause| cause.effect == id);
    let gravity = cause("gravity_load").expect("weighed");
    assert!(gravity.inclusion > 0.5, "{}", found.sentence);
    let torque_nm = gravity.parameters["torque_nm"].value;
    assert!((0.24..0.72).contains(&torque_nm), "{torque_nm}");
    assert!(found.gap.closed_lo95 > 0.8, "{:?}", found.gap);
}

/// PWM with coasting pauses drives a light motor faster than its mean voltage: no effect of the catalogue does that.
#[test]
fn what_the_catalogue_does_not_have_is_not_blamed_on_it() {
    let Some(folder) = folder("what_the_catalogue_does_not_have_is_not_blamed_on_it") else {
        return;
    };
    let mouse = |k: u32| {
        let log = format!("micromouse/encoders{k}.csv");
        run_of(&folder, &log, &format!("micromouse_encoders{k}.toml"))
    };
    let found = diagnosis(
        &[mouse(1), mouse(3)],
        &[mouse(2), mouse(4)],
        "micromouse.toml",
    );
    assert!(found.effects.is_empty(), "{}", found.sentence);
    assert_eq!(found.causes[0].effect, "unknown", "{}", found.sentence);
}
