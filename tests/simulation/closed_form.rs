//! Every effect against at least one closed form or conserved quantity that is not computed by the simulator.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use motorlab::motor::catalogue::catalogue;
use motorlab::motor::{ActiveEffect, Drive, Model, Motor, SimulationOptions, Trajectory, simulate};
use motorlab::recording::CommandKind;

/// Sample time in s.
const TS: f64 = 0.003;
/// Tolerance of affine modes: rounding.
const EXACT: f64 = 1e-9;
/// Tolerance of the others, in rad, rad/s, A or relative energy.
const CONVERGED: f64 = 1e-6;

const VOLT: CommandKind = CommandKind::Voltage;
const TORQUE: CommandKind = CommandKind::Torque;

/// The handout's motor with an effect, or several.
fn motor(effects: &[(&str, &[f64])]) -> Motor {
    let mut motor = Motor::default();
    for (id, values) in effects {
        motor.effects.set(ActiveEffect::new(id, values).unwrap());
    }
    motor
}

fn frictionless(effects: &[(&str, &[f64])]) -> Motor {
    let mut motor = motor(effects);
    motor.parameters.coulomb_friction_nm = 0.0;
    motor.parameters.viscous_friction_nm_s_per_rad = 0.0;
    motor
}

/// Without inductance.
fn run(motor: &Motor, kind: CommandKind, command: &[f64]) -> Trajectory {
    let t_s: Vec<f64> = (0..command.len()).map(|k| k as f64 * TS).collect();
    let drive = Drive {
        t_s: &t_s,
        command,
        kind,
    };
    let options = SimulationOptions {
        model: Model::FirstOrder,
        ..SimulationOptions::default()
    };
    simulate(motor, &drive, &options).unwrap()
}

/// Levels of 60 samples each.
fn levels(values: &[f64]) -> Vec<f64> {
    values.iter().flat_map(|u| [*u; 60]).collect()
}

/// R, K, b, J and Tf of the first-order motor, to be changed.
#[derive(Clone, Copy)]
struct FirstOrder {
    r: f64,
    k: f64,
    b: f64,
    j: f64,
    tf: f64,
}

const NOMINAL: FirstOrder = FirstOrder {
    r: 10.0,
    k: 0.7,
    b: 0.01,
    j: 0.002,
    tf: 0.02,
};

impl FirstOrder {
    fn rate(&self) -> f64 {
        (self.b + self.k * self.k / self.r) / self.j
    }

    /// Steady speed at `volts` with an additional `torque`.
    fn steady(&self, volts: f64, torque: f64) -> f64 {
        (self.k * volts / self.r + torque - self.tf) / (self.b + self.k * self.k / self.r)
    }

    /// Angle and speed `t` after a step from rest.
    fn step(&self, volts: f64, torque: f64, t: f64) -> (f64, f64) {
        let (a, w) = (self.rate(), self.steady(volts, torque));
        (w * (t + (-a * t).exp_m1() / a), -w * (-a * t).exp_m1())
    }
}

#[track_caller]
fn near(a: f64, b: f64, tolerance: f64) {
    assert!(
        (a - b).abs() < tolerance,
        "{a} is not {b} within {tolerance}"
    );
}

/// A step of 4.5 V from rest follows this first-order motor.
#[track_caller]
fn steps_like(motor: &Motor, expected: FirstOrder) {
    let run = run(motor, VOLT, &[4.5; 400]);
    for k in 0..400 {
        let (angle, speed) = expected.step(4.5, 0.0, k as f64 * TS);
        near(run.angle_rad[k], angle, EXACT);
        near(run.speed_rad_s[k], speed, EXACT);
    }
}

/// `J w^2 / 2` is the work of a torque that depends on the angle alone.
#[track_caller]
fn keeps_energy(run: &Trajectory, work: impl Fn(f64) -> f64) {
    let most = run.speed_rad_s.iter().fold(0.0_f64, |m, w| m.max(w * w)) * 0.001;
    assert!(most > 1e-4, "it moves: {most} J");
    for (angle, speed) in run.angle_rad.iter().zip(&run.speed_rad_s) {
        let off = 0.5 * NOMINAL.j * speed * speed - work(*angle);
        assert!(
            off.abs() < CONVERGED * most,
            "{off} J of {most} J at {angle} rad"
        );
    }
}

#[test]
fn command_effects() {
    let u = levels(&[4.5, -1.0, 0.7, 0.0, -3.0, 0.76, -0.74, 2.0]);
    let nominal = run(&motor(&[]), VOLT, &u);
    // A delay of two samples: the same angles, two samples later.
    let late = run(&motor(&[("transport_delay", &[2.0 * TS])]), VOLT, &u);
    for k in 2..u.len() {
        near(late.angle_rad[k], nominal.angle_rad[k - 2], EXACT);
    }
    // Small commands are equivalent to 0.
    let zone = run(&motor(&[("dead_zone", &[0.75])]), VOLT, &u);
    let cut: Vec<f64> = u
        .iter()
        .map(|u| if u.abs() <= 0.75 { 0.0 } else { *u })
        .collect();
    assert_eq!(zone, run(&motor(&[]), VOLT, &cut));
    // ... with another size in each direction; with the same size it is that dead zone.
    let both = run(&motor(&[("asymmetric_dead_zone", &[0.72, 1.2])]), VOLT, &u);
    let cut: Vec<f64> = u
        .iter()
        .map(|u| if (-1.2..=0.72).contains(u) { 0.0 } else { *u })
        .collect();
    assert_eq!(both, run(&motor(&[]), VOLT, &cut));
    let alike = run(&motor(&[("asymmetric_dead_zone", &[0.75, 0.75])]), VOLT, &u);
    assert_eq!(alike, zone);
}

#[test]
fn driver_effects() {
    // A drop is a lower voltage as long as the current keeps its sign.
    let run_drop = run(&motor(&[("voltage_drop", &[0.6])]), VOLT, &[4.5; 400]);
    for k in 0..400 {
        near(
            run_drop.angle_rad[k],
            NOMINAL.step(3.9, 0.0, k as f64 * TS).0,
            EXACT,
        );
    }
    // ... and a different one backwards.
    let drops = motor(&[("asymmetric_voltage_drop", &[0.6, 1.1])]);
    let (there, back) = (
        run(&drops, VOLT, &[4.5; 400]),
        run(&drops, VOLT, &[-4.5; 400]),
    );
    for k in 0..400 {
        let t = k as f64 * TS;
        near(there.angle_rad[k], NOMINAL.step(3.9, 0.0, t).0, EXACT);
        near(back.angle_rad[k], -NOMINAL.step(3.4, 0.0, t).0, EXACT);
    }
    // Equal drops are one drop, for any current.
    let u = levels(&[4.5, -1.0, 0.7, 0.0, -3.0, 0.5, 0.0, -0.7, 2.0]);
    let alike = run(
        &motor(&[("asymmetric_voltage_drop", &[0.4, 0.4])]),
        VOLT,
        &u,
    );
    assert_eq!(alike, run(&motor(&[("voltage_drop", &[0.4])]), VOLT, &u));
    // An asymmetric gain is an asymmetric command.
    let lame = run(&motor(&[("asymmetric_gain", &[-0.2])]), VOLT, &u);
    let shifted: Vec<f64> = u.iter().map(|u| u - 0.2 * u.abs()).collect();
    let expected = run(&motor(&[]), VOLT, &shifted);
    for (a, b) in lame.angle_rad.iter().zip(&expected.angle_rad) {
        near(*a, *b, EXACT);
    }
    // In an open circuit the motor coasts with its friction: J w' = -b w - Tf.
    let coasting = |w0: f64, t: f64| (w0 + 2.0) * (-NOMINAL.b * t / NOMINAL.j).exp() - 2.0;
    let mut off = vec![4.5; 300];
    off.extend([0.0; 200]);
    let open = run(&motor(&[("coast_at_zero", &[])]), VOLT, &off);
    for k in 300..500 {
        let speed = coasting(open.speed_rad_s[300], (k - 300) as f64 * TS).max(0.0);
        near(open.speed_rad_s[k], speed, 1e-8);
        assert_eq!(open.current_a[k], 0.0);
    }
    assert_eq!(open.speed_rad_s[499], 0.0);
    let r = NOMINAL.r + 4.0 * (4.5_f64 / 4.5).powi(2);
    steps_like(
        &motor(&[("supply_sag", &[4.0])]),
        FirstOrder { r, ..NOMINAL },
    );
    let weak = run(&motor(&[("supply_error", &[0.88])]), VOLT, &[4.5; 400]);
    for k in 0..400 {
        near(
            weak.angle_rad[k],
            NOMINAL.step(0.88 * 4.5, 0.0, k as f64 * TS).0,
            EXACT,
        );
    }
    // At the limit the torque is constant: w = (K I - Tf) / b (1 - e^(-b t / J)), until the back EMF limits the
    // current.
    let limited = run(&motor(&[("current_limit", &[0.2])]), VOLT, &[4.5; 400]);
    let top = (NOMINAL.k * 0.2 - NOMINAL.tf) / NOMINAL.b;
    let over = (4.5 - 0.2 * NOMINAL.r) / NOMINAL.k;
    let end = -NOMINAL.j / NOMINAL.b * (1.0 - over / top).ln();
    let (mut held, a) = (0, NOMINAL.rate());
    for k in 0..400 {
        let t = k as f64 * TS;
        if t < end {
            held += 1;
            near(limited.current_a[k], 0.2, EXACT);
            near(
                limited.speed_rad_s[k],
                top * (1.0 - (-NOMINAL.b * t / NOMINAL.j).exp()),
                EXACT,
            );
        } else {
            let steady = NOMINAL.steady(4.5, 0.0);
            let speed = steady + (over - steady) * (-a * (t - end)).exp();
            near(limited.speed_rad_s[k], speed, 1e-7);
        }
    }
    assert!(held > 10);
}

#[test]
fn electrical_effects() {
    // Blocked rotor: i = u / R (1 - e^(-R t / L)).
    let mut blocked = motor(&[("inductance", &[0.1]), ("coulomb_friction", &[10.0])]);
    let still = run(&blocked, VOLT, &[4.5; 50]);
    for k in 0..50 {
        near(
            still.current_a[k],
            -0.45 * (-100.0 * k as f64 * TS).exp_m1(),
            EXACT,
        );
    }
    // ... and when warm, where R (1 + k i^2 R) i = u.
    blocked.effects.remove("inductance");
    blocked
        .effects
        .set(ActiveEffect::new("winding_heating", &[0.8, 1.0]).unwrap());
    let warm = run(&blocked, VOLT, &[4.5; 7000]);
    let i = warm.current_a[6999];
    near(10.0 * (1.0 + 0.8 * i * i * 10.0) * i, 4.5, CONVERGED);
    near(warm.current_a[0], 0.45, EXACT);
    // At a given current I the loss is I^2 R (1 - e^(-t / tau)), which reduces the torque of a motor without
    // friction.
    let (drop, tau, amperes) = (0.5, 1.0, 0.4);
    let mut weak = frictionless(&[("magnet_weakening", &[drop, tau])]);
    weak.parameters.inertia_kg_m2 = 0.2;
    let weakening = run(&weak, CommandKind::Current, &vec![amperes; 1000]);
    let loss = drop * amperes * amperes * 10.0 / (4.5 * 4.5 / 10.0);
    for k in 0..1000 {
        let t = k as f64 * TS;
        let lost = loss * (t + tau * (-t / tau).exp_m1());
        near(
            weakening.speed_rad_s[k],
            0.7 * amperes / 0.2 * (t - lost),
            CONVERGED,
        );
    }
    // At a given current ripple has a potential: the work depends on the angle alone.
    let (amplitude, n, phase) = (0.12, 11.0, 0.7);
    let ripple = frictionless(&[("torque_ripple", &[amplitude, n, phase])]);
    let turning = run(&ripple, CommandKind::Current, &[0.03; 200]);
    keeps_energy(&turning, |x| {
        0.7 * 0.03 * (x + amplitude / n * (phase.cos() - (n * x + phase).cos()))
    });
}

#[test]
fn friction_and_inertia() {
    steps_like(
        &motor(&[("coulomb_friction", &[0.05])]),
        FirstOrder {
            tf: 0.05,
            ..NOMINAL
        },
    );
    steps_like(
        &motor(&[("viscous_friction", &[0.03])]),
        FirstOrder { b: 0.03, ..NOMINAL },
    );
    steps_like(
        &motor(&[("inertia", &[0.005])]),
        FirstOrder {
            j: 0.005,
            ..NOMINAL
        },
    );
    let r = 0.35;
    let asymmetric = motor(&[("asymmetric_friction", &[r])]);
    steps_like(
        &asymmetric,
        FirstOrder {
            tf: 0.02 * (1.0 + r),
            ..NOMINAL
        },
    );
    let back = run(&asymmetric, VOLT, &[-4.5; 400]);
    let easier = FirstOrder {
        tf: 0.02 * (1.0 - r),
        ..NOMINAL
    };
    near(
        back.angle_rad[399],
        -easier.step(4.5, 0.0, 399.0 * TS).0,
        EXACT,
    );
    // Driving friction takes its share of the motor's torque.
    let loaded = run(
        &motor(&[("load_friction", &[0.2, 0.35])]),
        VOLT,
        &[4.5; 400],
    );
    let (drive, damping) = (0.8 * 0.7 * 4.5 / 10.0 - 0.02, 0.01 + 0.8 * 0.049);
    for (k, speed) in loaded.speed_rad_s.iter().enumerate() {
        let t = k as f64 * TS;
        near(
            *speed,
            -drive / damping * (-damping * t / 0.002).exp_m1(),
            EXACT,
        );
    }
    // A load of 0.14 N m that would drive the motor back meets Tf + 0.35 * 0.14 = 0.069 N m: it holds at rest what
    // would stop it immediately, although driving takes 0.2 only.
    let hung = |torque_nm: f64| {
        let hanging = motor(&[
            ("load_friction", &[0.2, 0.35]),
            ("gravity_load", &[torque_nm, std::f64::consts::FRAC_PI_2]),
        ]);
        run(&hanging, VOLT, &[2.0; 400]).angle_rad
    };
    assert!(hung(0.2089).iter().all(|angle| *angle == 0.0));
    assert!(hung(0.2091)[399] < -1e-6);
    // Breakaway at Tf + dT, to a microvolt, and a steady speed in torque balance.
    let stribeck = motor(&[("stribeck", &[0.03, 0.5])]);
    let breakaway = 0.05 * 10.0 / 0.7;
    assert_eq!(
        run(&stribeck, VOLT, &[breakaway - 1e-6; 500]).angle_rad[499],
        0.0
    );
    assert!(run(&stribeck, VOLT, &[breakaway + 1e-6; 9000]).angle_rad[8999] > 1e-6);
    let w = run(&stribeck, VOLT, &[1.0; 3000]).speed_rad_s[2999];
    let balance =
        0.7 * (1.0 - 0.7 * w) / 10.0 - 0.01 * w - 0.02 - 0.03 * (-(w / 0.5) * (w / 0.5)).exp();
    assert!(w > 0.1);
    near(balance, 0.0, CONVERGED);
}

#[test]
fn torques_of_the_angle_and_the_speed() {
    // A constant torque against Dahl's friction, which is a function of the angle while the shaft keeps its
    // direction.
    let z = 0.035;
    let mut dahl = frictionless(&[("presliding", &[z])]);
    dahl.parameters.coulomb_friction_nm = 0.02;
    keeps_energy(&run(&dahl, TORQUE, &[0.03; 200]), |x| {
        0.03 * x - 0.02 * (x + z * (-x / z).exp_m1())
    });
    // It approaches the sliding friction: more if friction increases with the torque ...
    let mut loaded = frictionless(&[("presliding", &[z]), ("load_friction", &[0.2, 0.4])]);
    loaded.parameters.coulomb_friction_nm = 0.02;
    let (level, longer) = (0.02 + 0.2 * 0.03, z * (1.0 + 0.2 * 0.03 / 0.02));
    keeps_energy(&run(&loaded, TORQUE, &[0.03; 200]), |x| {
        0.03 * x - level * (x + longer * (-x / longer).exp_m1())
    });
    // ... and if it decreases with the speed, that at the steady one.
    let falling = motor(&[("presliding", &[z]), ("stribeck", &[0.03, 0.5])]);
    let w = run(&falling, VOLT, &[1.2; 3000]).speed_rad_s[2999];
    let balance =
        0.7 * (1.2 - 0.7 * w) / 10.0 - 0.01 * w - 0.02 - 0.03 * (-(w / 0.5) * (w / 0.5)).exp();
    assert!(w > 0.1);
    near(balance, 0.0, CONVERGED);
    let (torque, n, phase) = (0.03, 12.0, 1.1);
    let cogging = frictionless(&[("cogging", &[torque, n, phase])]);
    keeps_energy(&run(&cogging, TORQUE, &[0.03; 200]), |x| {
        0.03 * x + torque / n * (f64::cos(phase) - (n * x + phase).cos())
    });
    let gravity = frictionless(&[("gravity_load", &[0.04, 0.6])]);
    keeps_energy(&run(&gravity, TORQUE, &[0.06; 200]), |x| {
        0.06 * x - 0.04 * (f64::cos(0.6) - (x + 0.6).cos())
    });
    // Drag alone: 1 / w increases linearly.
    let mut command = vec![0.02; 100];
    command.extend([0.0; 400]);
    let drag = frictionless(&[("quadratic_drag", &[0.002])]);
    let coasting = run(&drag, TORQUE, &command);
    let w0 = coasting.speed_rad_s[100];
    assert!(w0 > 1.0);
    for k in 100..500 {
        let t = (k - 100) as f64 * TS;
        near(
            coasting.speed_rad_s[k],
            w0 / (1.0 + 0.002 * w0 * t / 0.002),
            CONVERGED,
        );
    }
    // ... and speeding up: w = w1 tanh(t / T).
    let top = (0.02_f64 / 0.002).sqrt();
    for k in 0..100 {
        let t = k as f64 * TS;
        near(
            coasting.speed_rad_s[k],
            top * (t * 0.02 / (0.002 * top)).tanh(),
            CONVERGED,
        );
    }
}

#[test]
fn transmissions() {
    let (torque, j, f) = (0.01, 0.002, 0.4);
    let (j1, j2) = ((1.0 - f) * j, f * j);
    // The motor side alone across half the gap, then both with its momentum.
    for encoder in [0.0, 1.0] {
        let gap = 0.07;
        let run = run(
            &frictionless(&[("backlash", &[gap, f, encoder])]),
            TORQUE,
            &[torque; 150],
        );
        let touch = (gap * j1 / torque).sqrt();
        let slow = torque * touch / j;
        let mut touched = 0;
        for k in 0..150 {
            let t = k as f64 * TS;
            let alone = 0.5 * torque / j1 * t * t;
            let after = t - touch;
            let as_one = slow * after + 0.5 * torque / j * after * after;
            let expected = match (t < touch, encoder == 0.0) {
                (true, true) => alone,
                (true, false) => 0.0,
                (false, true) => gap / 2.0 + as_one,
                (false, false) => as_one,
            };
            touched += usize::from(t >= touch);
            near(run.angle_rad[k], expected, 1e-8);
        }
        assert!((10..140).contains(&touched));
    }
    // On an undamped spring the twist oscillates about its mean, and the centre of mass accelerates uniformly.
    let (frequency, gap) = (10.0, 0.07);
    let omega = TAU * frequency;
    let spring = |motor: &Motor, start: f64, twist0: f64, rate0: f64, (x0, v0): (f64, f64)| {
        let run = run(motor, TORQUE, &[torque; 150]);
        let mean = torque / (j1 * omega * omega);
        for k in 0..150 {
            let t = k as f64 * TS - start;
            if t < 0.0 {
                continue;
            }
            let twist =
                mean + (twist0 - mean) * (omega * t).cos() + rate0 / omega * (omega * t).sin();
            if twist < 0.0 {
                return k;
            }
            let centre = x0 + v0 * t + 0.5 * torque / j * t * t;
            let play = if motor.effects.get("backlash").is_some() {
                gap / 2.0
            } else {
                0.0
            };
            near(run.angle_rad[k], centre + j2 / j * (twist + play), 1e-7);
        }
        150
    };
    let elastic = frictionless(&[("compliance", &[frequency, 0.0, f, 0.0])]);
    assert_eq!(spring(&elastic, 0.0, 0.0, 0.0, (0.0, 0.0)), 150);
    // With play in series the spring is reached at speed, and released when it would have to pull.
    let both = frictionless(&[
        ("backlash", &[gap, f, 0.0]),
        ("compliance", &[frequency, 0.0, f, 0.0]),
    ]);
    let touch = (gap * j1 / torque).sqrt();
    let speed = torque * touch / j1;
    let centre = (j1 * gap / 2.0 / j, j1 * speed / j);
    let parted = spring(&both, touch, 0.0, speed, centre);
    assert!(parted < 150, "it springs back");
}

#[test]
fn sensor_and_timing() {
    let u = levels(&[4.5, -1.0, 0.7, 0.0, -3.0]);
    let nominal = run(&motor(&[]), VOLT, &u);
    let resolution = run(&motor(&[("resolution_error", &[1000.0])]), VOLT, &u);
    let eccentric = run(&motor(&[("encoder_eccentricity", &[0.026, 0.4])]), VOLT, &u);
    let deaf = run(&motor(&[("missed_counts", &[1.0, 0.0])]), VOLT, &u);
    let deafer = run(&motor(&[("missed_counts", &[0.02, 0.0])]), VOLT, &u);
    for (k, x) in nominal.angle_rad.iter().enumerate() {
        near(resolution.measured_angle_rad[k], x * 1000.0 / 720.0, EXACT);
        assert_eq!(
            resolution.counts[k],
            (1000.0 * x / TAU + 0.5).floor() as i64
        );
        near(
            eccentric.measured_angle_rad[k],
            x + 0.026 * (x + 0.4).sin(),
            EXACT,
        );
        assert_eq!(deaf.counts[k], 0);
        near(deafer.measured_angle_rad[k], 0.98 * x, EXACT);
    }
    // Late by half the spread on average.
    let step = run(&motor(&[("sample_jitter", &[0.0012])]), VOLT, &[4.5; 400]);
    let clock = run(&motor(&[("clock_error", &[0.03])]), VOLT, &[4.5; 400]);
    for k in 0..400 {
        let t = k as f64 * TS;
        near(
            step.measured_angle_rad[k],
            NOMINAL.step(4.5, 0.0, t + 0.0006).0,
            1e-8,
        );
        near(
            clock.angle_rad[k],
            NOMINAL.step(4.5, 0.0, 1.03 * t).0,
            EXACT,
        );
    }
}

/// A step from rest in each direction: forward and reverse are two first-order motors.
#[test]
fn direction_dependence_equals_two_motors() {
    let viscous = motor(&[("asymmetric_viscous", &[0.4])]);
    let loaded = motor(&[("constant_load", &[0.015])]);
    for s in [1.0, -1.0] {
        let turns = run(&viscous, VOLT, &[4.5 * s; 400]);
        let carries = run(&loaded, VOLT, &[4.5 * s; 400]);
        let other = FirstOrder {
            b: NOMINAL.b * (1.0 + 0.4 * s),
            ..NOMINAL
        };
        for k in 0..400 {
            let t = k as f64 * TS;
            let (angle, speed) = other.step(4.5, 0.0, t);
            near(turns.angle_rad[k], s * angle, EXACT);
            near(turns.speed_rad_s[k], s * speed, EXACT);
            let (angle, speed) = NOMINAL.step(4.5, -0.015 * s, t);
            near(carries.angle_rad[k], s * angle, EXACT);
            near(carries.speed_rad_s[k], s * speed, EXACT);
        }
    }
    // Friction holds a load below its level only.
    for (torque, moves) in [(0.019, false), (0.021, true)] {
        let hangs = run(&motor(&[("constant_load", &[torque])]), VOLT, &[0.0; 60]);
        assert_eq!(hangs.angle_rad[59] < 0.0, moves, "{torque} N m");
    }
}

#[test]
fn static_friction_holds_more_than_it_brakes() {
    // K u / R: 0.56 V give 0.0392 N m, 0.6 V give 0.042.
    let sticky = motor(&[("static_friction", &[0.04])]);
    let held = run(&sticky, VOLT, &[0.56; 400]);
    assert!(held.angle_rad.iter().all(|x| *x == 0.0));
    let free = run(&sticky, VOLT, &[0.6; 400]);
    for k in 0..400 {
        let (angle, speed) = NOMINAL.step(0.6, 0.0, k as f64 * TS);
        near(free.angle_rad[k], angle, EXACT);
        near(free.speed_rad_s[k], speed, EXACT);
    }
}

#[test]
fn sensors_with_memory() {
    let steady = NOMINAL.steady(4.5, 0.0);
    let top = steady * 720.0 / TAU;
    let deaf = run(
        &motor(&[("edge_rate_loss", &[0.9 * top, 6.0])]),
        VOLT,
        &[4.5; 800],
    );
    // At a steady speed the share is the law's; at low speed the encoder loses nothing.
    let kept = 1.0 / (1.0 + 0.9_f64.powf(-6.0));
    let span = |x: &[f64]| x[799] - x[500];
    near(
        span(&deaf.measured_angle_rad) / span(&deaf.angle_rad),
        kept,
        EXACT,
    );
    let slow = run(
        &motor(&[("edge_rate_loss", &[100.0 * top, 9.0])]),
        VOLT,
        &[4.5; 400],
    );
    near(slow.measured_angle_rad[399], slow.angle_rad[399], EXACT);
    // tau q' = theta - q of a first-order step.
    let tau = 0.05;
    let filtered = run(&motor(&[("speed_filter", &[tau])]), VOLT, &[4.5; 400]);
    let a = NOMINAL.rate();
    let own = 1.0 / (a * (1.0 - a * tau));
    for k in 0..400 {
        let t = k as f64 * TS;
        let fading = own * (-a * t).exp() + (tau + 1.0 / a - own) * (-t / tau).exp();
        let expected = steady * (t - tau - 1.0 / a + fading);
        near(filtered.measured_angle_rad[k], expected, CONVERGED);
        let counts = (720.0 * filtered.measured_angle_rad[k] / TAU + 0.5).floor();
        assert_eq!(filtered.counts[k], counts as i64);
    }
}

#[test]
fn a_late_command_column_is_the_next_command() {
    // Two samples late: the motor follows the commands two samples ahead, from the start.
    let u = levels(&[4.5, -1.0, 0.7, 0.0, -3.0, 0.5, 0.0, -0.7, 2.0]);
    let late = run(&motor(&[("command_offset", &[2.0 * TS])]), VOLT, &u);
    let early = run(&motor(&[]), VOLT, &[&u[2..], &[2.0, 2.0]].concat());
    assert_eq!(late, early);
    // Two and a half late with a delay of half a sample: the same.
    let both = motor(&[
        ("command_offset", &[2.5 * TS]),
        ("transport_delay", &[0.5 * TS]),
    ]);
    for (a, b) in run(&both, VOLT, &u).angle_rad.iter().zip(&early.angle_rad) {
        near(*a, *b, EXACT);
    }
    // Longer than the run: the last command from the start.
    let ahead = run(&motor(&[("command_offset", &[50.0])]), VOLT, &u);
    assert_eq!(ahead, run(&motor(&[]), VOLT, &vec![2.0; u.len()]));
}

/// Resistance times the mean current of pulses, pulse by pulse, until they are periodic. Time in L/R.
fn mean_of_pulses(volts: f64, emf: f64, duty: f64, period: f64, into_supply: bool) -> f64 {
    const STEPS: u32 = 20_000;
    let fade = (-period / f64::from(STEPS)).exp();
    let pulse = (duty * f64::from(STEPS)).round() as u32;
    let (mut current, mut sum) = (0.0_f64, 0.0);
    for _ in 0..(40.0 / period) as u32 + 2 {
        sum = 0.0;
        for k in 0..STEPS {
            let terminals = match k < pulse {
                true => volts,
                false if into_supply => -volts,
                false => 0.0,
            };
            let goal = terminals - emf;
            let next = goal + (current - goal) * fade;
            // Diodes block a reverse current.
            let next = if k < pulse { next } else { next.max(0.0) };
            sum += 0.5 * (current + next);
            current = next;
        }
    }
    sum / f64::from(STEPS)
}

#[test]
fn freewheeling_pulses_have_the_mean_current_of_simulated_pulses() {
    for (period, into_supply) in [(0.5, true), (0.5, false), (6.0, true), (6.0, false)] {
        let kind = f64::from(u8::from(into_supply));
        let pulsed = motor(&[("pwm_freewheel", &[period, kind])]);
        let mut last = 0.0;
        for share in [0.2, 0.4, 0.6, 0.8, 1.0] {
            let turning = run(&pulsed, VOLT, &[share * 4.5; 1500]);
            let speed = turning.speed_rad_s[1499];
            let needed = (NOMINAL.b * speed + NOMINAL.tf) * NOMINAL.r / NOMINAL.k;
            let expected = mean_of_pulses(4.5, NOMINAL.k * speed, share, period, into_supply);
            if speed > 0.0 {
                near(needed, expected, 1e-4);
            } else {
                assert!(expected < needed, "{expected} V hold {needed} V");
            }
            near(NOMINAL.r * turning.current_a[1499], expected, 1e-4);
            // Backwards the same.
            let back = run(&pulsed, VOLT, &[-share * 4.5; 1500]);
            near(back.speed_rad_s[1499], -speed, EXACT);
            assert!(speed > last || last == 0.0);
            last = speed;
        }
        // Full duty cycle has no pulses: it ends as the nominal motor does.
        near(last, NOMINAL.steady(4.5, 0.0), CONVERGED);
    }
    // Switched off, the motor coasts.
    let mut off = vec![4.5; 300];
    off.extend(vec![0.0; 100]);
    let pulsed = run(&motor(&[("pwm_freewheel", &[6.0, 1.0])]), VOLT, &off);
    let coasts = run(&motor(&[("coast_at_zero", &[])]), VOLT, &off);
    near(pulsed.angle_rad[399], coasts.angle_rad[399], CONVERGED);
}

#[test]
fn a_slipping_clutch_conserves_momentum() {
    // 0.1 N m on 0.001 kg m^2 of which 0.02 N m are transmitted to an equal inertia: 80 and 20 rad/s^2.
    let mut slips = frictionless(&[("slipping_clutch", &[0.02, 0.5])]);
    let hard = run(&slips, TORQUE, &levels(&[0.1, 0.0, 0.0, 0.0]));
    let start_s = 60.0 * TS;
    for (k, speed) in hard.speed_rad_s.iter().enumerate() {
        let t = k as f64 * TS;
        let expected = if t <= start_s {
            80.0 * t
        } else {
            (80.0 * start_s - 20.0 * (t - start_s)).max(50.0 * start_s)
        };
        near(*speed, expected, EXACT);
    }
    // With friction: the load's 0.01 N m holds it against a clutch that transmits half of that.
    slips = motor(&[("slipping_clutch", &[0.005, 0.5])]);
    let free = run(&slips, TORQUE, &[0.1; 200]);
    for (k, speed) in free.speed_rad_s.iter().enumerate() {
        let t = k as f64 * TS;
        let steady = (0.1 - 0.005 - 0.01) / 0.005;
        near(*speed, steady * -(-0.005 * t / 0.001).exp_m1(), EXACT);
    }
    // A clutch that never slips has no effect.
    let u = levels(&[4.5, -1.0, 0.7, 0.0, -3.0, 0.5, 0.0, -0.7, 2.0]);
    let holds = run(&motor(&[("slipping_clutch", &[1.0, 0.5])]), VOLT, &u);
    let rigid = run(&motor(&[]), VOLT, &u);
    for (a, b) in holds.angle_rad.iter().zip(&rigid.angle_rad) {
        near(*a, *b, EXACT);
    }
}

#[test]
fn friction_is_divided_by_its_weight() {
    // A gap that is never crossed: the motor side alone, with 0.6 of the inertia and 0.6 / (0.6 + 4.5 * 0.4) = 0.25
    // of the friction.
    let alone = motor(&[("backlash", &[900.0, 0.4, 0.0, 4.5])]);
    let turns = run(&alone, TORQUE, &[0.03; 300]);
    for (k, speed) in turns.speed_rad_s.iter().enumerate() {
        let (b, tf, j) = (0.25 * NOMINAL.b, 0.25 * NOMINAL.tf, 0.6 * NOMINAL.j);
        let t = k as f64 * TS;
        near(*speed, (0.03 - tf) / b * -(-b * t / j).exp_m1(), EXACT);
    }
    // The default is by inertia, bitwise.
    let u = levels(&[4.5, -1.0, 0.7, 0.0, -3.0, 0.5, 0.0, -0.7, 2.0]);
    for (id, values) in [
        ("backlash", &[0.05, 0.4, 1.0, 1.0][..]),
        ("compliance", &[8.0, 0.05, 0.4, 1.0, 1.0]),
    ] {
        let silent = &values[..values.len() - 1];
        let said = run(&motor(&[(id, values)]), VOLT, &u);
        assert_eq!(said, run(&motor(&[(id, silent)]), VOLT, &u));
    }
}

#[test]
fn cogging_of_two_orders_has_one_potential() {
    // Released without friction, the work of both is that of their sum.
    let (small, fine) = ((0.03, 7.0, 1.1), (0.02, 28.0, 0.4));
    let both = frictionless(&[
        ("cogging", &[small.0, small.1, small.2]),
        ("cogging#2", &[fine.0, fine.1, fine.2]),
        ("coast_at_zero", &[]),
    ]);
    let swings = run(&both, VOLT, &[0.0; 300]);
    let work = |angle: f64| {
        [small, fine]
            .iter()
            .map(|(torque, order, phase)| {
                torque / order * (phase.cos() - (order * angle + phase).cos())
            })
            .sum::<f64>()
    };
    keeps_energy(&swings, work);
    // At a given current the work of ripples of both orders adds up.
    let ripples = frictionless(&[
        ("torque_ripple", &[0.12, 11.0, 0.7]),
        ("torque_ripple#2", &[0.06, 22.0, 0.2]),
    ]);
    let turns = run(&ripples, CommandKind::Current, &[0.01; 600]);
    let torque = 0.7 * 0.01;
    keeps_energy(&turns, |angle| {
        torque
            * (angle
                + 0.12 / 11.0 * (0.7_f64.cos() - (11.0 * angle + 0.7).cos())
                + 0.06 / 22.0 * (0.2_f64.cos() - (22.0 * angle + 0.2).cos()))
    });
}

#[test]
fn every_effect_has_a_closed_form() {
    let here = include_str!("closed_form.rs");
    let missing: BTreeSet<_> = catalogue()
        .iter()
        .map(|kind| kind.id)
        .filter(|id| !here.contains(&format!("(\"{id}\", ")))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}
