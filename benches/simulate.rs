//! Throughput of the simulator on one core: 6,300 samples at TS = 0.003 s of a reversing run.
//!
//! `cargo bench --bench simulate`; `items/s` is samples per second. `benches/peers.py` simulates the same drive with
//! SciPy and python-control.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use motorlab::motor::catalogue::catalogue;
use motorlab::motor::fit::{ParameterId, Simulator, Workspace};
use motorlab::motor::scalar::Scalar;
use motorlab::motor::{ActiveEffect, Drive, Model, Motor, Parameters};
use motorlab::recording::CommandKind;

fn main() {
    divan::main();
}

const SAMPLE_TIME_S: f64 = 0.003;
const SAMPLES: usize = 6300;
/// Levels held for 150 samples (0.45 s) each.
const LEVELS_V: [f64; 12] = [
    4.5, 0.0, -4.5, 1.5, -0.6, 3.0, -3.0, 0.3, 2.0, 0.9, -1.2, -2.2,
];

fn simulator(kind: CommandKind, model: Model) -> Simulator {
    let t_s: Vec<f64> = (0..SAMPLES).map(|k| k as f64 * SAMPLE_TIME_S).collect();
    let command: Vec<f64> = (0..SAMPLES).map(|k| LEVELS_V[k / 150 % 12]).collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind,
    };
    Simulator::new(&drive, model).expect("the drive is sound")
}

fn with_effects(ids: &[&str]) -> Motor {
    let mut motor = Motor::default();
    for id in ids {
        let effect = ActiveEffect::from_keys(id, [], &motor.parameters).expect("in the catalogue");
        motor.effects.set(effect);
    }
    motor
}

fn run(bencher: Bencher<'_, '_>, motor: &Motor, model: Model) {
    let simulator = simulator(CommandKind::Voltage, model);
    let mut workspace = Workspace::default();
    let mut angles = vec![0.0; SAMPLES];
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let outcome = simulator.angles(black_box(motor), &mut workspace, &mut angles);
        black_box((outcome.is_ok(), angles[SAMPLES - 1]))
    });
}

fn without_friction() -> Motor {
    let mut motor = Motor::default();
    motor.parameters.coulomb_friction_nm = 0.0;
    motor
}

/// Lower bound: the recurrence `y = E y + P n` for three states alone.
#[divan::bench]
fn bare_recurrence(bencher: Bencher<'_, '_>) {
    let matrix = [[1.0, 0.0029, 0.0003], [0.0, 0.95, 0.3], [0.0, -0.07, 0.001]];
    let forcing = [1e-5, 0.01, 0.3];
    let mut angles = vec![0.0; SAMPLES];
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let (e, p) = (black_box(&matrix), black_box(&matrix));
        let mut y = [0.0; 3];
        for angle in &mut angles {
            let n = black_box(&forcing);
            let mut next = [0.0; 3];
            for (k, slot) in next.iter_mut().enumerate() {
                let free = e[k][0] * y[0] + e[k][1] * y[1] + e[k][2] * y[2];
                *slot = free + p[k][0] * n[0] + p[k][1] * n[1] + p[k][2] * n[2];
            }
            y = next;
            *angle = y[0];
        }
        black_box(angles[SAMPLES - 1])
    });
}

/// Sine and cosine of angles in a dependency chain; `items/s` is calls per second.
fn angles_one_after_the_other(bencher: Bencher<'_, '_>, sin_cos: impl Fn(f64) -> (f64, f64)) {
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut angle = black_box(0.3);
        for _ in 0..SAMPLES {
            let (s, c) = sin_cos(angle);
            angle += 0.01 + 1e-3 * (s - c);
        }
        black_box(angle)
    });
}

#[divan::bench]
fn sine_and_cosine(bencher: Bencher<'_, '_>) {
    angles_one_after_the_other(bencher, Scalar::sin_cos);
}

#[divan::bench]
fn sine_and_cosine_of_the_standard_library(bencher: Bencher<'_, '_>) {
    angles_one_after_the_other(bencher, f64::sin_cos);
}

#[divan::bench]
fn linear_first_order(bencher: Bencher<'_, '_>) {
    run(bencher, &without_friction(), Model::FirstOrder);
}

#[divan::bench]
fn linear_second_order(bencher: Bencher<'_, '_>) {
    run(bencher, &without_friction(), Model::SecondOrder);
}

#[divan::bench]
fn coulomb_first_order(bencher: Bencher<'_, '_>) {
    run(bencher, &Motor::default(), Model::FirstOrder);
}

#[divan::bench]
fn coulomb_second_order(bencher: Bencher<'_, '_>) {
    run(bencher, &Motor::default(), Model::SecondOrder);
}

fn effect_ids() -> impl Iterator<Item = &'static str> {
    catalogue().iter().map(|kind| kind.id)
}

#[divan::bench(args = effect_ids())]
fn effect(bencher: Bencher<'_, '_>, id: &str) {
    run(bencher, &with_effects(&[id]), Model::SecondOrder);
}

#[divan::bench]
fn three_effects(bencher: Bencher<'_, '_>) {
    let motor = with_effects(&["voltage_drop", "stribeck", "cogging"]);
    run(bencher, &motor, Model::SecondOrder);
}

#[divan::bench]
fn nine_sensitivities_of_coulomb(bencher: Bencher<'_, '_>) {
    let simulator = simulator(CommandKind::Voltage, Model::SecondOrder);
    let motor = Motor::default();
    let ids: Vec<ParameterId> = (0..Parameters::KEYS.len())
        .map(ParameterId::Nominal)
        .collect();
    let mut workspace = Workspace::default();
    let mut angles = vec![0.0; SAMPLES];
    let mut columns = vec![0.0; SAMPLES * ids.len()];
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let outcome =
            simulator.sensitivities(&motor, &ids, &mut workspace, &mut angles, &mut columns);
        black_box((outcome.is_ok(), angles[SAMPLES - 1]))
    });
}

#[divan::bench]
fn batch_of_64_on_all_cores(bencher: Bencher<'_, '_>) {
    let simulator = simulator(CommandKind::Voltage, Model::SecondOrder);
    let motors = vec![Motor::default(); 64];
    let mut angles = vec![0.0; SAMPLES * motors.len()];
    bencher
        .counter(ItemsCount::new(SAMPLES * motors.len()))
        .bench_local(|| black_box(simulator.batch(&motors, &mut angles).is_ok()));
}
