//! A speed that falls through 0 and returns between two ends of a step: friction turns round with it.

use motor_chain::{ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, simulate};
use rand::{RngExt, SeedableRng};

/// Sample time in s: each command holds for one sample, seven longest steps.
const TS: f64 = 0.02;
const COMMANDS: usize = 12;
const RUNS: u64 = 60;
/// Step of the integration beside it in s.
const STEP_S: f64 = 0.5e-6;
/// Largest difference in counts. Without looking inside steps it is 0.01.
const COUNTS: f64 = 1e-3;

fn motor() -> Motor {
    let mut motor = Motor::default();
    let load = ActiveEffect::new("constant_load", &[0.01]);
    motor.effects.set(load.expect("an effect"));
    motor
}

/// Angles at the samples by fourth-order Runge-Kutta; where the speed crosses 0 it is put there and friction turns round or holds.
fn integrated(motor: &Motor, command: &[f64]) -> Vec<f64> {
    let p = &motor.parameters;
    let load_nm = 0.01;
    let (mut angle, mut speed, mut current, mut slips) = (0.0, 0.0, 0.0, 0.0_f64);
    let mut angles = Vec::new();
    for &volts in command {
        angles.push(angle);
        for _ in 0..(TS / STEP_S).round() as usize {
            let driving = p.torque_constant_nm_per_a * current - load_nm;
            if slips == 0.0 && driving.abs() > p.coulomb_friction_nm {
                slips = driving.signum();
            }
            let rate = |y: [f64; 3]| {
                let torque =
                    p.torque_constant_nm_per_a * y[2] - load_nm - slips * p.coulomb_friction_nm;
                let turned = (torque - p.viscous_friction_nm_s_per_rad * y[1]) / p.inertia_kg_m2;
                let volts = volts - p.resistance_ohm * y[2] - p.back_emf_v_s_per_rad * y[1];
                let moves = slips.abs();
                [moves * y[1], moves * turned, volts / p.inductance_h]
            };
            let y = [angle, speed, current];
            let plus = |k: [f64; 3], by: f64| [0, 1, 2].map(|n| y[n] + by * k[n]);
            let k1 = rate(y);
            let k2 = rate(plus(k1, 0.5 * STEP_S));
            let k3 = rate(plus(k2, 0.5 * STEP_S));
            let k4 = rate(plus(k3, STEP_S));
            let next =
                [0, 1, 2].map(|n| y[n] + STEP_S / 6.0 * (k1[n] + 2.0 * (k2[n] + k3[n]) + k4[n]));
            (angle, speed, current) = (next[0], next[1], next[2]);
            if speed * slips < 0.0 {
                (speed, slips) = (0.0, 0.0);
            }
        }
    }
    angles
}

#[test]
fn a_speed_that_falls_through_0_within_a_step_is_seen() {
    let motor = motor();
    let per_count = std::f64::consts::TAU / motor.parameters.counts_per_rev;
    let mut largest: f64 = 0.0;
    for seed in 0..RUNS {
        let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
        let command: Vec<f64> = (0..COMMANDS)
            .map(|_| random.random_range(-4.5..4.5))
            .collect();
        let t_s: Vec<f64> = (0..COMMANDS).map(|k| TS * k as f64).collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let found = simulate(&motor, &drive, &SimulationOptions::default()).expect("a motor");
        for (found, expected) in found.angle_rad.iter().zip(integrated(&motor, &command)) {
            largest = largest.max((found - expected).abs() / per_count);
        }
    }
    println!("largest difference: {largest:.1e} counts");
    assert!(largest < COUNTS, "{largest} counts");
}
