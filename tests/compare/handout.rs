//! The simulator against the lab handout's closed forms and SciPy, and `compare` on runs made from them.

use motorlab::compare::{FLOOR_COUNTS, compare};
use motorlab::motor::{Drive, Model, Motor, SimulationOptions, simulate};
use motorlab::recording::{CommandKind, Run};

/// Columns t_s, speed_rad_s, angle_rad of a reference made by `tests/reference/handout.py`.
fn reference(name: &str) -> [Vec<f64>; 3] {
    let path = format!("tests/reference/handout/{name}.csv");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let mut columns = [const { Vec::new() }; 3];
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.parse().expect("a number"));
        }
    }
    columns
}

fn motor(coulomb: bool, viscous: bool) -> Motor {
    let mut motor = Motor::default();
    if !coulomb {
        motor.parameters.coulomb_friction_nm = 0.0;
    }
    if !viscous {
        motor.parameters.viscous_friction_nm_s_per_rad = 0.0;
    }
    motor
}

#[test]
fn the_handouts_five_curves_equal_the_references() {
    for (name, model, coulomb, viscous) in [
        ("first_order_viscous", Model::FirstOrder, false, true),
        ("second_order_viscous", Model::SecondOrder, false, true),
        ("first_order_coulomb", Model::FirstOrder, true, true),
        ("first_order_frictionless", Model::FirstOrder, false, false),
        (
            "second_order_frictionless",
            Model::SecondOrder,
            false,
            false,
        ),
    ] {
        let [t_s, speed, angle] = reference(name);
        let command = vec![4.5; t_s.len()];
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let options = SimulationOptions {
            model,
            ..SimulationOptions::default()
        };
        let found = simulate(&motor(coulomb, viscous), &drive, &options).unwrap();
        let top = speed.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        for k in 0..t_s.len() {
            let (dw, da) = (
                found.speed_rad_s[k] - speed[k],
                found.angle_rad[k] - angle[k],
            );
            assert!(
                dw.abs() < 1e-8 * top,
                "{name} at {} s: speed off by {dw}",
                t_s[k]
            );
            assert!(da.abs() < 1e-8, "{name} at {} s: angle off by {da}", t_s[k]);
        }
    }
}

/// A run with the counts of a SciPy trajectory, read by an encoder of 720 counts.
fn recorded(start_fraction: f64) -> Run {
    let [t_s, _, angle] = reference("first_order_coulomb");
    let rows = (0..t_s.len()).step_by(30);
    let counts_per_rad = 720.0 / std::f64::consts::TAU;
    Run {
        sample_time_s: 0.003,
        counts_per_rev: 720.0,
        t_s: rows.clone().map(|k| t_s[k]).collect(),
        command: rows.clone().map(|_| 4.5).collect(),
        counts: rows
            .map(|k| (angle[k] * counts_per_rad + start_fraction).floor() as i64)
            .collect(),
        ..Run::default()
    }
}

#[test]
fn residuals_of_the_same_motor_are_the_quantization() {
    for start in [0.1, 0.5, 0.9] {
        let overlay = compare(&recorded(start), &Motor::default(), Model::FirstOrder).unwrap();
        let error = overlay.figures.position_rmse_counts;
        assert!((error / FLOOR_COUNTS - 1.0).abs() < 0.1, "{start}: {error}");
        // If the two encoders are in phase, their speeds are identical.
        let same = overlay
            .recorded_speed_rad_s
            .iter()
            .zip(&overlay.simulated_speed_rad_s)
            .filter(|(a, b)| a == b)
            .count();
        assert!(same > overlay.recorded_speed_rad_s.len() * 8 / 10);
    }
}

#[test]
fn a_motor_without_its_friction_has_a_gap() {
    let overlay = compare(&recorded(0.5), &motor(false, true), Model::FirstOrder).unwrap();
    assert!(
        overlay.figures.position_rmse_counts > 2.0,
        "{:?}",
        overlay.figures
    );
}

#[test]
fn recorder_and_simulator_give_the_same_speed_for_the_same_counts() {
    // The writer's column and the comparison's are computed by one function: a run compared with itself agrees
    // bitwise.
    let mut run = recorded(0.5);
    run.header.insert("sample_time_s".into(), 0.003.into());
    run.header.insert("counts_per_rev".into(), 720.into());
    let folder = tempfile::tempdir().unwrap();
    let path = motorlab::recording::write_run(&run, &folder.path().join("run.csv")).unwrap();
    let (read, _) = motorlab::recording::read_run(&path).unwrap();
    let overlay = compare(&read, &Motor::default(), Model::FirstOrder).unwrap();
    assert_eq!(read.velocity_rad_s, Some(overlay.recorded_speed_rad_s));
}
