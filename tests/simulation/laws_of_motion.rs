//! The simulator against properties that hold for any method: closed forms, conserved energy, exact rest.

use std::f64::consts::TAU;

use motorlab::motor::catalogue::catalogue;
use motorlab::motor::{ActiveEffect, Drive, Model, Motor, SimulationOptions, Trajectory, simulate};
use motorlab::recording::CommandKind;

fn motor(effects: &[(&str, &[f64])]) -> Motor {
    let mut motor = Motor::default();
    for (id, values) in effects {
        motor.effects.set(ActiveEffect::new(id, values).unwrap());
    }
    motor
}

fn run(motor: &Motor, kind: CommandKind, sample_time_s: f64, command: &[f64]) -> Trajectory {
    let t_s: Vec<f64> = (0..command.len())
        .map(|k| k as f64 * sample_time_s)
        .collect();
    let drive = Drive {
        t_s: &t_s,
        command,
        kind,
    };
    simulate(motor, &drive, &SimulationOptions::default()).unwrap()
}

#[test]
fn torque_and_current_driven_axes_follow_their_closed_form() {
    // J w' = tau - b w - Tf from rest: w = w1 (1 - e^(-b t / J)), w1 = (tau - Tf) / b
    let (torque, n, ts) = (0.03, 400, 0.003);
    let p = Motor::default().parameters;
    let (b, j) = (p.viscous_friction_nm_s_per_rad, p.inertia_kg_m2);
    let final_speed = (torque - p.coulomb_friction_nm) / b;
    let by_torque = run(&Motor::default(), CommandKind::Torque, ts, &vec![torque; n]);
    let current = torque / p.torque_constant_nm_per_a;
    let by_current = run(
        &Motor::default(),
        CommandKind::Current,
        ts,
        &vec![current; n],
    );
    for k in 0..n {
        let t = k as f64 * ts;
        let speed = final_speed * (1.0 - (-b * t / j).exp());
        let angle = final_speed * (t + j / b * ((-b * t / j).exp() - 1.0));
        for run in [&by_torque, &by_current] {
            assert!((run.speed_rad_s[k] - speed).abs() < 1e-10);
            assert!((run.angle_rad[k] - angle).abs() < 1e-10);
            assert!((run.current_a[k] - current).abs() < 1e-15);
        }
    }
}

#[test]
fn time_constants_three_decades_apart_follow_the_closed_form() {
    // L/R from 34 ms down to 34 ns with a mechanical time constant of 34 ms: two modes of w'' + (R/L + b/J) w' + (R b
    // + Kt Kb)/(L J) w
    for inductance in [0.1, 3.4e-3, 3.4e-4, 3.4e-7] {
        let mut motor = Motor::default();
        motor.parameters.coulomb_friction_nm = 0.0;
        motor.parameters.inductance_h = inductance;
        let p = motor.parameters;
        let (r, k, b, j) = (
            p.resistance_ohm,
            p.torque_constant_nm_per_a,
            p.viscous_friction_nm_s_per_rad,
            p.inertia_kg_m2,
        );
        let (sum, product) = (r / inductance + b / j, (r * b + k * k) / (inductance * j));
        let discriminant = sum * sum - 4.0 * product;
        let run = run(&motor, CommandKind::Voltage, 0.003, &[4.5; 200]);
        let steady = k * 4.5 / (r * b + k * k);
        for (n, speed) in run.speed_rad_s.iter().enumerate() {
            let t = n as f64 * 0.003;
            let expected = if discriminant > 0.0 {
                let fast = -0.5 * (sum + discriminant.sqrt());
                let slow = product / fast;
                steady * (1.0 + (fast * (slow * t).exp() - slow * (fast * t).exp()) / (slow - fast))
            } else {
                let (rate, turn) = (0.5 * sum, 0.5 * (-discriminant).sqrt());
                steady
                    * (1.0
                        - (-rate * t).exp() * ((turn * t).cos() + rate / turn * (turn * t).sin()))
            };
            assert!(
                (speed - expected).abs() < 1e-8,
                "L = {inductance}, t = {t}: {speed} {expected}"
            );
        }
    }
}

#[test]
fn a_free_pendulum_conserves_its_energy() {
    // No friction, open circuit, released at rest: J w^2 / 2 - T cos(theta + phi) is conserved.
    let mut motor = motor(&[("coast_at_zero", &[]), ("gravity_load", &[0.05, 2.5])]);
    motor.parameters.coulomb_friction_nm = 0.0;
    motor.parameters.viscous_friction_nm_s_per_rad = 0.0;
    let run = run(&motor, CommandKind::Voltage, 0.003, &[0.0; 5000]);
    let energy = |k: usize| {
        let w = run.speed_rad_s[k];
        0.5 * 0.002 * w * w - 0.05 * (run.angle_rad[k] + 2.5).cos()
    };
    let swing = run.speed_rad_s.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
    assert!(swing > 9.0, "it swings: {swing}");
    for k in 0..5000 {
        assert!(
            (energy(k) - energy(0)).abs() < 1e-6 * 0.05,
            "{k}: {}",
            energy(k) - energy(0)
        );
    }
}

#[test]
fn a_sticking_shaft_does_not_creep() {
    // 0.28 V is just below breakaway (0.2857 V); gravity below Tf causes no motion.
    let still = run(
        &Motor::default(),
        CommandKind::Voltage,
        0.003,
        &[0.28; 3000],
    );
    assert!(still.angle_rad.iter().all(|x| *x == 0.0));
    let held = run(
        &motor(&[("gravity_load", &[0.019, 1.5])]),
        CommandKind::Voltage,
        0.003,
        &[0.0; 3000],
    );
    assert!(held.angle_rad.iter().all(|x| *x == 0.0));
    // After a stop the angle is bitwise constant, and the current is that of the blocked rotor.
    let mut command = vec![3.0; 300];
    command.extend([0.2; 600]);
    let stopped = run(&Motor::default(), CommandKind::Voltage, 0.003, &command);
    assert!(stopped.angle_rad[500] > 1.0);
    assert!(
        stopped.angle_rad[500..]
            .iter()
            .all(|x| *x == stopped.angle_rad[500])
    );
    assert!((stopped.current_a[899] - 0.02).abs() < 1e-12);
}

#[test]
fn the_current_limit_is_never_exceeded() {
    let command: Vec<f64> = (0..2000)
        .map(|k| [4.5, -4.5, 2.0, 0.0][k / 37 % 4])
        .collect();
    for effects in [
        &[("current_limit", &[0.15][..])][..],
        &[
            ("current_limit", &[0.15]),
            ("cogging", &[0.03, 9.0, 0.2]),
            ("voltage_drop", &[0.3]),
        ],
    ] {
        let run = run(&motor(effects), CommandKind::Voltage, 0.003, &command);
        let largest = run.current_a.iter().fold(0.0_f64, |m, i| m.max(i.abs()));
        assert!((0.1499..=0.15 + 1e-9).contains(&largest), "{largest}");
    }
}

#[test]
fn the_load_stays_within_the_backlash() {
    let gap = 0.05;
    let command: Vec<f64> = (0..2000)
        .map(|k| [2.0, -1.0, 0.6, -3.0, 0.0][k / 61 % 5])
        .collect();
    let side = |encoder: f64| {
        run(
            &motor(&[("backlash", &[gap, 0.4, encoder])]),
            CommandKind::Voltage,
            0.003,
            &command,
        )
        .angle_rad
    };
    let (at_motor, at_load) = (side(0.0), side(1.0));
    let (mut widest, mut narrowest) = (0.0_f64, 0.0_f64);
    for (a, b) in at_motor.iter().zip(&at_load) {
        widest = widest.max(a - b);
        narrowest = narrowest.min(a - b);
    }
    assert!((widest - gap / 2.0).abs() < 1e-9 && (narrowest + gap / 2.0).abs() < 1e-9);
}

#[test]
fn any_two_effects_can_be_combined() {
    let command: Vec<f64> = (0..300)
        .map(|k| [4.5, -2.0, 0.0, 0.5, -0.4][k / 31 % 5])
        .collect();
    let t_s: Vec<f64> = (0..300).map(|k| k as f64 * 0.003).collect();
    for kind in [
        CommandKind::Voltage,
        CommandKind::Current,
        CommandKind::Torque,
    ] {
        let scale = match kind {
            CommandKind::Voltage => 1.0,
            CommandKind::Current => 0.1,
            CommandKind::Torque => 0.07,
        };
        let command: Vec<f64> = command.iter().map(|u| u * scale).collect();
        for (k, first) in catalogue().iter().enumerate() {
            for second in &catalogue()[k..] {
                let mut motor = Motor::default();
                for id in [first.id, second.id] {
                    motor
                        .effects
                        .set(ActiveEffect::from_keys(id, [], &motor.parameters).unwrap());
                }
                for model in [Model::FirstOrder, Model::SecondOrder] {
                    let drive = Drive {
                        t_s: &t_s,
                        command: &command,
                        kind,
                    };
                    let options = SimulationOptions {
                        model,
                        ..SimulationOptions::default()
                    };
                    let run = simulate(&motor, &drive, &options).unwrap();
                    // A dead zone in volts exceeds every command in amperes or newton metres.
                    let moves = kind == CommandKind::Voltage;
                    let travel = run.angle_rad.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                    assert!(
                        (travel > 0.01 || !moves) && travel < 100.0,
                        "{} and {}: {travel}",
                        first.id,
                        second.id
                    );
                }
            }
        }
    }
}

#[test]
fn uneven_sample_times_sample_the_same_motion() {
    // Device times have a jitter of microseconds: the angle at an instant is independent of other samples.
    for effects in [
        &[][..],
        &[("cogging", &[0.03, 12.0, 1.1][..])],
        &[("backlash", &[0.05, 0.4, 1.0])],
        &[("transport_delay", &[0.0047])],
    ] {
        let motor = motor(effects);
        let n = 600;
        let command: Vec<f64> = (0..n).map(|k| [4.5, -1.0, 0.0, 0.7][k / 50 % 4]).collect();
        let even = run(&motor, CommandKind::Voltage, 0.003, &command);
        // The same commands at the same instants, with samples in between.
        let mut t_s = Vec::new();
        let mut dense = Vec::new();
        for (k, level) in command.iter().enumerate() {
            let t = k as f64 * 0.003;
            t_s.extend([t, t + 0.000_7 + 1e-5 * (k % 7) as f64, t + 0.002_1]);
            dense.extend([*level; 3]);
        }
        let drive = Drive {
            t_s: &t_s,
            command: &dense,
            kind: CommandKind::Voltage,
        };
        let uneven = simulate(&motor, &drive, &SimulationOptions::default()).unwrap();
        for (k, even_rad) in even.angle_rad.iter().enumerate() {
            let off = (uneven.angle_rad[3 * k] - even_rad).abs() * 114.6;
            assert!(off < 0.001, "{effects:?} at {k}: {off} counts");
        }
    }
}

#[test]
fn any_set_of_effects_has_the_same_motion_at_any_step() {
    // Random sets of all effects, and all at once; half the sample time halves every step of the engine.
    let n = 500;
    let command: Vec<f64> = (0..n)
        .map(|k| [4.5, -2.0, 0.0, 1.5, -0.9, 3.0][k / 43 % 6])
        .collect();
    let dense: Vec<f64> = command.iter().flat_map(|u| [*u; 2]).collect();
    let all = (1_u64 << catalogue().len()) - 1;
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let sets = std::iter::repeat_with(|| {
        // xorshift
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state & all
    });
    let mut wrong = Vec::new();
    for set in std::iter::once(all).chain(sets.take(120)) {
        let mut motor = Motor::default();
        let mut ids = Vec::new();
        for (k, kind) in catalogue().iter().enumerate() {
            if set >> k & 1 == 1 {
                let effect = ActiveEffect::from_keys(kind.id, [], &motor.parameters).unwrap();
                motor.effects.set(effect);
                ids.push(kind.id);
            }
        }
        let coarse = run(&motor, CommandKind::Voltage, 0.003, &command);
        let fine = run(&motor, CommandKind::Voltage, 0.0015, &dense);
        let worst = (0..n)
            .map(|k| (coarse.angle_rad[k] - fine.angle_rad[2 * k]).abs() * 720.0 / TAU)
            .fold(0.0, f64::max);
        if worst.is_nan() || worst > 0.01 {
            wrong.push(format!("{worst:.1e} counts: {ids:?}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_pair_of_effects_acts_together() {
    let command: Vec<f64> = (0..600)
        .map(|k| [4.5, -2.0, 0.0, 1.5, -0.3][k / 31 % 5])
        .collect();
    let t_s: Vec<f64> = (0..600).map(|k| k as f64 * 0.003).collect();
    let counts_and_angle = |ids: &[&str]| {
        let mut motor = Motor::default();
        for id in ids {
            // Where the usual value has no effect.
            let given = match *id {
                "supply_error" => Some(("gain", 1.1)),
                "missed_counts" => Some(("probability", 0.02)),
                // With a dead zone: one that is larger forward.
                "asymmetric_dead_zone" => Some(("positive_v", 1.6)),
                _ => None,
            };
            let effect = ActiveEffect::from_keys(id, given, &motor.parameters).unwrap();
            motor.effects.set(effect);
        }
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let options = SimulationOptions {
            model: Model::SecondOrder,
            ..SimulationOptions::default()
        };
        let run = simulate(&motor, &drive, &options).unwrap();
        (run.counts, run.angle_rad)
    };
    for (k, first) in catalogue().iter().enumerate() {
        for second in &catalogue()[k + 1..] {
            let pair = [first.id, second.id];
            // Presliding friction has no breakaway. Of two dead zones the larger one in each direction applies. A
            // clutch in addition to play or a spring transmits all torque; freewheeling pulses coast at 0.
            let alike = [
                ["presliding", "static_friction"],
                ["dead_zone", "asymmetric_dead_zone"],
                ["backlash", "slipping_clutch"],
                ["compliance", "slipping_clutch"],
                ["coast_at_zero", "pwm_freewheel"],
            ];
            if alike
                .iter()
                .any(|two| two.iter().all(|id| pair.contains(id)))
            {
                continue;
            }
            let both = counts_and_angle(&pair);
            for (alone, other) in [(first, second), (second, first)] {
                let without = counts_and_angle(&[alone.id]);
                assert!(
                    both != without,
                    "{} does nothing beside {}",
                    other.id,
                    alone.id
                );
            }
        }
    }
}
