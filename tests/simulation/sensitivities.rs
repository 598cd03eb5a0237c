//! The derivatives of the angle for fits, against finite differences of simulated runs, across stops, reversals,
//! contacts and every other event of a reversing run; and against differences of an independent automaton's
//! trajectories at rtol 1e-12 (tests/reference/sensitivities.py).

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::support::table;
use motorlab::motor::catalogue::{again, catalogue};
use motorlab::motor::fit::{ParameterId, Reset, Simulator, Workspace};
use motorlab::motor::{ActiveEffect, Drive, Model, Motor, Parameters};
use motorlab::recording::CommandKind;

const SAMPLE_TIME_S: f64 = 0.003;

/// Levels, reversals with and without a stop, slow motion, small reversals.
fn drive() -> (Vec<f64>, Vec<f64>) {
    let segments: [(usize, f64); 14] = [
        (10, 0.0),
        (150, 4.5),
        (100, 0.0),
        (150, -3.0),
        (60, 3.0),
        (150, 0.6),
        (100, -0.5),
        (20, 1.0),
        (20, -1.0),
        (20, 1.0),
        (20, -1.0),
        (120, 2.0),
        (60, 0.2),
        (120, -1.3),
    ];
    let command: Vec<f64> = segments.iter().flat_map(|&(n, u)| vec![u; n]).collect();
    let t_s = (0..command.len())
        .map(|k| k as f64 * SAMPLE_TIME_S)
        .collect();
    (t_s, command)
}

fn angles(simulator: &Simulator, motor: &Motor) -> Vec<f64> {
    let mut out = vec![0.0; simulator.samples()];
    simulator
        .angles(motor, &mut Workspace::default(), &mut out)
        .unwrap();
    out
}

/// Fourth-order central difference.
fn difference(simulator: &Simulator, motor: &Motor, id: ParameterId, step: f64) -> Vec<f64> {
    let value = id.get(motor).unwrap();
    let at = |k: f64| {
        let mut moved = motor.clone();
        assert!(id.set(&mut moved, value + k * step));
        angles(simulator, &moved)
    };
    let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
    (0..a.len())
        .map(|k| (a[k] - 8.0 * b[k] + 8.0 * c[k] - d[k]) / (12.0 * step))
        .collect()
}

fn check(name: &str, motor: &Motor, model: Model, ids: &[ParameterId]) -> Vec<String> {
    let (t_s, command) = drive();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let simulator = Simulator::new(&drive, model).unwrap();
    // Once as one run, once in segments that start from the encoder's reading.
    let put = |sample, angle_rad, speed_rad_s| Reset {
        sample,
        angle_rad,
        speed_rad_s,
    };
    let segments = vec![put(180, 1.5, 4.0), put(700, -0.4, -0.7)];
    let in_segments = simulator.clone().with_resets(segments);
    let mut wrong = check_run(name, motor, ids, &simulator);
    wrong.extend(check_run(
        &format!("{name} in segments"),
        motor,
        ids,
        &in_segments,
    ));
    wrong
}

fn check_run(name: &str, motor: &Motor, ids: &[ParameterId], simulator: &Simulator) -> Vec<String> {
    let n = simulator.samples();
    let (mut value, mut columns) = (vec![0.0; n], vec![0.0; n * ids.len()]);
    let mut workspace = Workspace::default();
    simulator
        .sensitivities(motor, ids, &mut workspace, &mut value, &mut columns)
        .unwrap();
    assert_eq!(
        value,
        angles(simulator, motor),
        "{name}: the value is the plain simulation's"
    );
    let mut wrong = Vec::new();
    for (id, column) in ids.iter().zip(columns.chunks(n)) {
        let now = id.get(motor).unwrap();
        let scale = if now == 0.0 { 1.0 } else { now.abs() };
        let expected = difference(simulator, motor, *id, 1e-4 * scale);
        let largest = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let off = column
            .iter()
            .zip(&expected)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        // In counts for a change of the parameter by its own size; a twentieth of a count is far below noise.
        let counts = off * scale * 720.0 / std::f64::consts::TAU;
        if off > 2e-3 * largest && counts > 0.05 {
            wrong.push(format!(
                "{name} {}: {off:.2e} of {largest:.2e}, {counts:.2e} counts",
                id.key()
            ));
        }
    }
    wrong
}

#[test]
fn derivatives_of_every_effect_agree_with_differences() {
    let nominal: Vec<ParameterId> = (0..Parameters::KEYS.len())
        .map(ParameterId::Nominal)
        .collect();
    let mut wrong = check("nominal", &Motor::default(), Model::SecondOrder, &nominal);
    wrong.extend(check(
        "first order",
        &Motor::default(),
        Model::FirstOrder,
        &nominal,
    ));
    for (index, kind) in catalogue().iter().chain(again()).enumerate() {
        let mut motor = Motor::default();
        if let Some(first) = kind.id.strip_suffix("#2") {
            // In addition to the first, with another order.
            let orders = [("cycles_per_rev", 7.0)];
            let first = ActiveEffect::from_keys(first, orders, &motor.parameters).unwrap();
            motor.effects.set(first);
        }
        if kind.id == "pwm_freewheel" {
            // The end of pulses at full duty cycle is a kink: no level here reaches it.
            motor.parameters.supply_v = 5.0;
        }
        motor
            .effects
            .set(ActiveEffect::from_keys(kind.id, [], &motor.parameters).unwrap());
        let mut ids = nominal.clone();
        ids.extend(
            kind.parameters
                .iter()
                .enumerate()
                .filter(|(_, p)| {
                    p.smooth && !matches!(p.prior, motorlab::motor::catalogue::Prior::OneOf(_))
                })
                .map(|(k, _)| ParameterId::Effect(index, k)),
        );
        wrong.extend(check(kind.id, &motor, Model::SecondOrder, &ids));
        wrong.extend(check(
            &format!("{} first order", kind.id),
            &motor,
            Model::FirstOrder,
            &ids,
        ));
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// The command of every sample of the references.
fn reference_drive() -> (Vec<f64>, Vec<f64>) {
    let text = fs::read_to_string("tests/reference/effects/drive.csv").unwrap();
    let mut command = vec![0.0; 5000];
    for line in text.lines().skip(2) {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        command[row[0] as usize..].fill(row[2]);
    }
    let t_s = (0..5000).map(|k| k as f64 * SAMPLE_TIME_S).collect();
    (t_s, command)
}

/// The motor in the header of a reference trajectory.
fn reference_motor(case: &str) -> Motor {
    let path = format!("tests/reference/effects/{case}.csv");
    let text = fs::read_to_string(path).unwrap();
    let header = text.lines().filter_map(|line| line.strip_prefix("# "));
    let toml = header.skip(1).collect::<Vec<_>>().join("\n");
    Motor::from_toml(&toml).unwrap()
}

#[test]
fn derivatives_agree_with_differences_of_the_independent_reference() {
    let (t_s, command) = reference_drive();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let simulator = Simulator::new(&drive, Model::SecondOrder).unwrap();
    let n = simulator.samples();
    let per_rad = 720.0 / std::f64::consts::TAU;
    let mut table = String::from(
        "| effect: parameter | p dangle/dp at most, counts | error |\n| --- | --- | --- |\n",
    );
    let mut files: Vec<_> = fs::read_dir(Path::new("tests/reference/sensitivities"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let mut checked = Vec::new();
    for path in files {
        let case = path.file_stem().unwrap().to_str().unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let mut lines = text.lines().skip(1);
        let keys: Vec<&str> = lines.next().unwrap().split(',').skip(1).collect();
        let rows: Vec<Vec<f64>> = lines
            .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
            .collect();
        let motor = reference_motor(case);
        for (j, key) in keys.into_iter().enumerate() {
            // For an effect with two instances, the column names the instance.
            let of_effect = match key.split_once('.') {
                Some((effect, key)) => ParameterId::effect(effect, key),
                None => motor
                    .effects
                    .iter()
                    .find_map(|effect| ParameterId::effect(effect.kind().id, key)),
            };
            let id = of_effect.or_else(|| ParameterId::nominal(key)).unwrap();
            checked.push(id);
            let value = id.get(&motor).unwrap();
            let (mut angles, mut column) = (vec![0.0; n], vec![0.0; n]);
            simulator
                .sensitivities(
                    &motor,
                    &[id],
                    &mut Workspace::default(),
                    &mut angles,
                    &mut column,
                )
                .unwrap();
            let (mut largest, mut off) = (0.0_f64, 0.0_f64);
            for row in &rows {
                let expected = row[j + 1] * per_rad;
                largest = largest.max(expected.abs());
                off = off.max((column[row[0] as usize] * value * per_rad - expected).abs());
            }
            writeln!(
                table,
                "| {case}: {key} | {largest:.1} | {} |",
                table::decade(off)
            )
            .unwrap();
            assert!(
                off < 2e-3 * largest,
                "{case} {key}: {off:.2e} of {largest:.2e} counts"
            );
        }
    }
    // Every continuous parameter of every effect is included, and those of second instances; those of random effects
    // are tested above, by differences of the simulator's mean.
    for (index, kind) in catalogue().iter().chain(again()).enumerate() {
        for (k, p) in kind.parameters.iter().enumerate() {
            assert!(
                kind.random || !p.smooth || checked.contains(&ParameterId::Effect(index, k)),
                "{} {}",
                kind.id,
                p.key
            );
        }
    }
    insta::assert_snapshot!(table);
    table::documented(&table);
}

/// Measured times are some microseconds off the grid: samples at which the command changes have the derivatives of
/// their neighbours.
#[test]
fn measured_times_have_the_derivatives_of_uniform_ones() {
    let (even_s, command) = drive();
    let t_s: Vec<f64> = even_s
        .iter()
        .enumerate()
        .map(|(k, t)| t + 1e-6 * ((k * k) % 7) as f64)
        .collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let simulator = Simulator::new(&drive, Model::SecondOrder).unwrap();
    let mut motor = Motor::default();
    let effect = ActiveEffect::new("clock_error", &[0.03]).unwrap();
    motor.effects.set(effect);
    let index = catalogue().iter().position(|kind| kind.id == "clock_error");
    let id = ParameterId::Effect(index.unwrap(), 0);
    let (mut angles, mut derivatives) = (vec![0.0; t_s.len()], vec![0.0; t_s.len()]);
    simulator
        .sensitivities(
            &motor,
            &[id],
            &mut Workspace::default(),
            &mut angles,
            &mut derivatives,
        )
        .unwrap();
    let differences = difference(&simulator, &motor, id, 1e-5);
    let largest = differences
        .iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    for (k, (found, expected)) in derivatives.iter().zip(&differences).enumerate() {
        assert!(
            (found - expected).abs() < 5e-3 * largest,
            "sample {k}: {found} for {expected}"
        );
    }
}
