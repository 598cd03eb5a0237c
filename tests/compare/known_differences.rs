//! Runs are simulated with their known differences: several configurations of one axis are one fit.

use motorlab::compare::compare;
use motorlab::diagnose::{Options, Settings, diagnose, nominal_fit};
use motorlab::motor::{
    ActiveEffect, CommandKind, Drive, Model, Motor, SimulationOptions, simulate,
};
use motorlab::recording::{Run, read_run, write_run};

/// A run of this motor, counts as the encoder says them.
fn run_of(motor: &Motor, command: &[f64]) -> Run {
    let t_s: Vec<f64> = (0..command.len()).map(|k| 0.003 * k as f64).collect();
    let drive = Drive {
        t_s: &t_s,
        command,
        kind: CommandKind::Voltage,
    };
    let trajectory =
        simulate(motor, &drive, &SimulationOptions::default()).expect("it can be simulated");
    Run {
        sample_time_s: 0.003,
        counts_per_rev: motor.parameters.counts_per_rev,
        supply_v: Some(4.5),
        t_s: t_s.clone(),
        command: command.to_vec(),
        counts: trajectory.counts,
        complete: true,
        ..Run::default()
    }
}

fn reversing() -> Vec<f64> {
    (0..1500)
        .map(|k| if (k / 250) % 2 == 0 { 4.5 } else { -4.5 })
        .collect()
}

fn left(run: &Run, motor: &Motor) -> f64 {
    let laid = compare(run, motor, Model::SecondOrder).expect("it can be compared");
    laid.figures.position_rmse_counts
}

/// Quantization error, and a margin for the initial fraction of a count.
const FLOOR_COUNTS: f64 = 0.31;

#[test]
fn stated_differences_are_no_model_error() {
    let motor = Motor::default();
    let mut heavier = motor.clone();
    heavier.parameters.inertia_kg_m2 += 0.003;
    let mut hung = motor.clone();
    hung.effects
        .set(ActiveEffect::new("gravity_load", &[0.1, 0.0]).expect("a load"));
    let mut wound = motor.clone();
    wound.parameters.resistance_ohm = 13.0;
    for (other, key, value) in [
        (heavier, "inertia_added_kg_m2", 0.003),
        (hung, "gravity_torque_nm", 0.1),
        (wound, "resistance_ohm", 13.0),
    ] {
        let mut run = run_of(&other, &reversing());
        let before = left(&run, &motor);
        run.known.set(key, value).expect("it can differ");
        let after = left(&run, &motor);
        assert!(
            before > 2.0 && after < FLOOR_COUNTS,
            "{key}: {before} {after}"
        );
    }
}

#[test]
fn a_measured_battery_drift_is_no_gap() {
    let motor = Motor::default();
    let volts = |k: usize| 4.5 - 0.9 * k as f64 / 1500.0;
    let command = reversing();
    let driven: Vec<f64> = (0..1500).map(|k| command[k] * volts(k + 1) / 4.5).collect();
    let mut run = run_of(&motor, &driven);
    run.command = command;
    let before = left(&run, &motor);
    run.measured_supply_v = Some((0..1500).map(volts).collect());
    let after = left(&run, &motor);
    assert!(before > 10.0 * FLOOR_COUNTS, "{before}");
    // The last interval has no reading at its end.
    assert!(after < FLOOR_COUNTS, "{after}");
}

/// Voltage and counts alone determine no torque. A known load does: `R/Kt` is found from a motor file that is wrong
/// by half, with a disc as well, and in a fit without a motor file.
#[test]
fn a_known_load_or_disc_identifies_the_torque_constant() {
    let mut strong = Motor::default();
    strong.parameters.torque_constant_nm_per_a *= 1.5;
    let volts_per_nm =
        |motor: &Motor| motor.parameters.resistance_ohm / motor.parameters.torque_constant_nm_per_a;
    for (key, values) in [
        ("gravity_torque_nm", [0.08, 0.2]),
        ("inertia_added_kg_m2", [0.0, 0.004]),
    ] {
        let runs = values.map(|value| {
            let mut run = run_of(&strong, &reversing());
            run.known.set(key, value).expect("it can differ");
            let with = run.known.applied_to(&strong);
            run.counts = run_of(&with, &reversing()).counts;
            run
        });
        let fitted = nominal_fit(&runs, &Motor::default(), &Settings::default()).expect("a fit");
        let found = volts_per_nm(&fitted.motor) / volts_per_nm(&strong);
        assert!((found - 1.0).abs() < 0.02, "{key}: {found} in a fit");
        // Without it the torque constant and its interval are not reported.
        let bare = run_of(&strong, &reversing());
        let untold = nominal_fit(&[bare], &Motor::default(), &Settings::default())
            .expect("a fit")
            .motor;
        let [default, found] =
            [&Motor::default(), &untold].map(|motor| motor.parameters.torque_constant_nm_per_a);
        assert!((default - found).abs() < 1e-12, "{found}");
        assert!(!untold.tolerance.contains_key("torque_constant_nm_per_a"));
        let said = diagnose(&runs, &Motor::default(), &Options::default()).expect("a diagnosis");
        let found = volts_per_nm(&said.model) / volts_per_nm(&strong);
        assert!((found - 1.0).abs() < 0.02, "{key}: {found} in {said}");
        assert!(said.effects.is_empty(), "{key}: {said}");
    }
}

#[test]
fn differences_are_kept_in_the_file_and_unknown_keys_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = run_of(&Motor::default(), &reversing());
    run.header = "[differs]\ninertia_added_kg_m2 = 0.003"
        .parse()
        .expect("TOML");
    let path = write_run(&run, &folder.path().join("disc.csv")).expect("written");
    let (read, _) = read_run(&path).expect("read");
    let with_disc = read.known.applied_to(&Motor::default());
    assert!((with_disc.parameters.inertia_kg_m2 - 0.005).abs() < 1e-12);
    run.header = "differs = 3".parse().expect("TOML");
    let path = write_run(&run, &folder.path().join("value.csv")).expect("written");
    assert!(read_run(&path).is_err());
    run.header = "[differs]\ninertia_kg = 0.003".parse().expect("TOML");
    let path = write_run(&run, &folder.path().join("wrong.csv")).expect("written");
    let error = read_run(&path).expect_err("no such key").to_string();
    assert!(
        error.contains("inertia_kg") && error.contains("inertia_kg_m2"),
        "{error}"
    );
}

#[test]
fn the_command_line_states_the_differences_of_each_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut heavier = Motor::default();
    heavier.parameters.inertia_kg_m2 += 0.003;
    write_run(
        &run_of(&heavier, &reversing()),
        &folder.path().join("disc.csv"),
    )
    .expect("written");
    let compared = |with: &str| {
        std::process::Command::new(env!("CARGO_BIN_EXE_motorlab"))
            .args(["compare", "disc.csv", "--json", "--with", with])
            .current_dir(folder.path())
            .output()
            .expect("it runs")
    };
    let said = compared("disc.csv:inertia_added_kg_m2=0.003");
    let document: serde_json::Value = serde_json::from_slice(&said.stdout).expect("JSON");
    let counts = document["runs"][0]["position_rmse_counts"].as_f64();
    assert!(
        counts.is_some_and(|counts| counts < FLOOR_COUNTS),
        "{counts:?}"
    );
    for (with, named) in [
        ("other.csv:inertia_added_kg_m2=0.003", "other.csv"),
        ("disc.csv:inertia_aded_kg_m2=0.003", "inertia_added_kg_m2"),
        ("disc.csv:inertia_added_kg_m2=heavy", "heavy"),
        ("disc.csv:resistance_ohm=0", "1e-6 .. "),
    ] {
        let refused = compared(with);
        assert_eq!(refused.status.code(), Some(2), "{with}");
        let text = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(text.contains(named), "{text}");
    }
}
