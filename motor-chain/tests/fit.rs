//! Simulations for fits compared with single simulations: non-uniform samples, resets, omitted intervals, several
//! encoders.
//!
//! A separate binary: it alone needs the derivatives of every machine, which take a minute to compile.

use motor_chain::catalogue::catalogue;
use motor_chain::fit::{Reset, Simulator, Skipped, Workspace};
use motor_chain::{
    ActiveEffect, CommandKind, Drive, Model, Motor, ParameterId, SimulationOptions, simulate,
};

/// Fits take steps of four sample times and interpolate non-uniform samples; single simulations take shorter steps
/// with a smaller error.
#[test]
fn fits_and_simulation_agree_at_uneven_samples() {
    const LEVELS_V: [f64; 7] = [4.5, -1.0, 0.35, -4.0, 2.0, -0.6, 0.0];
    let t_s: Vec<f64> = (0..2000_u32)
        .map(|k| f64::from(k) * 0.003 + f64::from(k * 7919 % 7) * 1e-6)
        .collect();
    let command: Vec<f64> = (0..2000).map(|k| LEVELS_V[k / 90 % 7]).collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let options = SimulationOptions::default();
    let simulator = Simulator::new(&drive, options.model).expect("a drive");
    let mut workspace = Workspace::default();
    let mut apart = |id: &str, values: &[(&str, f64)]| {
        let mut motor = Motor::default();
        let values = values.iter().copied();
        let effect = ActiveEffect::from_keys(id, values, &motor.parameters);
        motor.effects.set(effect.expect("in the catalogue"));
        let exact = simulate(&motor, &drive, &options).expect("a motor");
        let mut angles = vec![0.0; t_s.len()];
        (simulator.angles(&motor, &mut workspace, &mut angles)).expect("a motor");
        let counts = motor.parameters.counts_per_rev / std::f64::consts::TAU;
        let gap = |(a, b): (&f64, &f64)| ((a - b) * counts).abs();
        let gaps: Vec<f64> = (angles.iter().zip(&exact.measured_angle_rad))
            .map(gap)
            .collect();
        let largest = gaps.iter().copied().fold(0.0, f64::max);
        let rms = (gaps.iter().map(|x| x * x).sum::<f64>() / gaps.len() as f64).sqrt();
        (largest, rms)
    };
    for kind in catalogue() {
        let (largest, rms) = apart(kind.id, &[]);
        assert!(largest < 0.01, "{}: {largest} counts", kind.id);
        assert!(rms < 0.002, "{}: {rms} counts RMS", kind.id);
    }
    // The strongest plausible values of the effects that are nonlinear within a step.
    let strong: [(&str, &[(&str, f64)]); 4] = [
        (
            "torque_ripple",
            &[("amplitude", 0.25), ("cycles_per_rev", 30.0)],
        ),
        (
            "torque_ripple",
            &[("amplitude", 0.25), ("cycles_per_rev", 8.0)],
        ),
        ("cogging", &[("torque_nm", 0.02), ("cycles_per_rev", 24.0)]),
        (
            "stribeck",
            &[("extra_torque_nm", 0.1), ("stribeck_speed_rad_s", 0.1)],
        ),
    ];
    for (id, values) in strong {
        let (largest, rms) = apart(id, values);
        assert!(largest < 0.01, "{id} {values:?}: {largest} counts");
        assert!(rms < 0.004, "{id} {values:?}: {rms} counts RMS");
    }
}

/// Angle of a shaft at an encoder's reading, by bisection, and its speed.
fn shaft(effect: Option<(&str, &[f64])>, reset: &Reset) -> (f64, f64) {
    let (said_rad, said_rad_s) = (reset.angle_rad, reset.speed_rad_s);
    match effect {
        Some(("resolution_error", [counts])) => {
            let times = Motor::default().parameters.counts_per_rev / counts;
            (times * said_rad, times * said_rad_s)
        }
        Some(("encoder_eccentricity", [amplitude_rad, phase_rad])) => {
            let (mut low, mut high) = (said_rad - amplitude_rad, said_rad + amplitude_rad);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let says = middle + amplitude_rad * (middle + phase_rad).sin();
                *(if says > said_rad { &mut high } else { &mut low }) = middle;
            }
            let slope = 1.0 + amplitude_rad * (low + phase_rad).cos();
            (low, said_rad_s / slope)
        }
        _ => (said_rad, said_rad_s),
    }
}

/// A segment from the measured state at its first sample equals a run that starts there, if no state is hidden; also
/// with an encoder error, and for times between the ends of steps.
#[test]
fn a_counter_reset_starts_a_new_initial_state() {
    for late_s in [0.0, 1e-4] {
        let t_s: Vec<f64> = (0..900)
            .map(|k| f64::from(k) * 0.003 + late_s * f64::from(k * 7919 % 7) / 7.0)
            .collect();
        let command: Vec<f64> = (0..900)
            .map(|k| [4.5, -1.0, 0.35, -4.0][k / 70 % 4])
            .collect();
        let drive = |from: usize, to: usize| Drive {
            t_s: &t_s[from..to],
            command: &command[from..to],
            kind: CommandKind::Voltage,
        };
        let whole = Simulator::new(&drive(0, 900), Model::FirstOrder).expect("a drive");
        let effects: [Option<(&str, &[f64])>; 4] = [
            None,
            Some(("resolution_error", &[500.0])),
            Some(("cogging", &[0.03, 12.0, 1.1])),
            Some(("encoder_eccentricity", &[0.03, 1.0])),
        ];
        for effect in effects {
            let mut motor = Motor::default();
            if let Some((id, values)) = effect {
                motor
                    .effects
                    .set(ActiveEffect::new(id, values).expect("in the catalogue"));
            }
            let resets = vec![
                Reset {
                    sample: 300,
                    angle_rad: 7.0,
                    speed_rad_s: 2.5,
                },
                Reset {
                    sample: 551,
                    angle_rad: -1.0,
                    speed_rad_s: 0.0,
                },
            ];
            let wanted: Vec<ParameterId> = (0..4).map(ParameterId::Nominal).collect();
            let mut workspace = Workspace::default();
            let (mut all, mut slopes) = (vec![0.0; 900], vec![0.0; 3600]);
            (whole.clone().with_resets(resets.clone()))
                .sensitivities(&motor, &wanted, &mut workspace, &mut all, &mut slopes)
                .expect("a motor");
            for (reset, to) in resets.iter().zip([551, 900]) {
                let n = to - reset.sample;
                let (mut alone, mut alone_slopes) = (vec![0.0; n], vec![0.0; 4 * n]);
                let (angle_rad, speed_rad_s) = shaft(effect, reset);
                (Simulator::new(&drive(reset.sample, to), Model::FirstOrder).expect("a drive"))
                    .with_start(angle_rad, speed_rad_s)
                    .sensitivities(
                        &motor,
                        &wanted,
                        &mut workspace,
                        &mut alone,
                        &mut alone_slopes,
                    )
                    .expect("a motor");
                // The encoder reads the reset's angle, whatever the shaft's angle is.
                assert!((alone[0] - reset.angle_rad).abs() < 1e-9, "{effect:?}");
                let count = std::f64::consts::TAU / motor.parameters.counts_per_rev;
                for (a, b) in all[reset.sample..to].iter().zip(&alone) {
                    assert!((a - b).abs() < 0.02 * count, "{effect:?} {late_s}: {a} {b}");
                }
                for j in 0..4 {
                    let largest = alone_slopes[j * n..(j + 1) * n]
                        .iter()
                        .fold(1e-9_f64, |m, x| m.max(x.abs()));
                    let part = &slopes[j * 900 + reset.sample..j * 900 + to];
                    for (a, b) in part.iter().zip(&alone_slopes[j * n..(j + 1) * n]) {
                        assert!(
                            (a - b).abs() < 0.02 * largest,
                            "{effect:?} {late_s} slope {j}: {a} {b}"
                        );
                    }
                }
            }
        }
    }
}

/// Omitted intervals warm the winding as simulated ones.
#[test]
fn the_winding_temperature_continues_through_omitted_intervals() {
    let mut motor = Motor::default();
    let values = [("resistance_rise_per_w", 0.5), ("time_constant_s", 8.0)];
    let heating = ActiveEffect::from_keys("winding_heating", values, &motor.parameters);
    motor.effects.set(heating.expect("in the catalogue"));
    let t_s: Vec<f64> = (0..8000).map(|k| f64::from(k) * 0.003).collect();
    let command: Vec<f64> = (0..8000).map(|k| [4.5, 1.5, -4.0][k / 90 % 3]).collect();
    let drive = |range: std::ops::Range<usize>| Drive {
        t_s: &t_s[range.clone()],
        command: &command[range],
        kind: CommandKind::Voltage,
    };
    let whole = simulate(&motor, &drive(0..8000), &SimulationOptions::default());
    let whole = whole.expect("a motor");
    // Only the last segment is simulated, after 24 samples before the omitted interval.
    let (until, from) = (24, 7290);
    let shorter: Vec<f64> = (0..until + 8000 - from).map(|k| t_s[k]).collect();
    let their_command = [&command[..until], &command[from..]].concat();
    let reset = Reset {
        sample: until,
        angle_rad: whole.angle_rad[from],
        speed_rad_s: whole.speed_rad_s[from],
    };
    let blocks = (until..from).step_by(300).map(|k| {
        let block = k..(k + 300).min(from);
        let n = block.len() as f64;
        let mean = |of: &dyn Fn(usize) -> f64| block.clone().map(of).sum::<f64>() / n;
        let (u, w) = (&command, &whole.speed_rad_s);
        Skipped {
            before: until,
            span_s: 0.003 * n,
            means: [
                mean(&|k| u[k] * u[k]),
                mean(&|k| u[k] * w[k]),
                mean(&|k| w[k] * w[k]),
            ],
        }
    });
    let blocks: Vec<Skipped> = blocks.collect();
    let apart = |skipped: Vec<Skipped>| {
        let drive = Drive {
            t_s: &shorter,
            command: &their_command,
            kind: CommandKind::Voltage,
        };
        let simulator = Simulator::new(&drive, Model::SecondOrder).expect("a drive");
        let simulator = simulator.with_resets(vec![reset]).with_skipped(skipped);
        let mut angles = vec![0.0; shorter.len()];
        (simulator.angles(&motor, &mut Workspace::default(), &mut angles)).expect("a motor");
        let apart = (angles[until..].iter().zip(&whole.angle_rad[from..]))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        apart * motor.parameters.counts_per_rev / std::f64::consts::TAU
    };
    let (cold, warm) = (apart(Vec::new()), apart(blocks));
    assert!(cold > 10.0 * warm && warm < 0.5, "{cold} {warm}");
}

/// The estimate of computing time counts the matrices of every duty cycle: with a supply that sags under a ramp each sample has its own.
#[test]
fn work_counts_the_matrices_of_every_command() {
    let t_s: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.005).collect();
    let work = |command: &dyn Fn(u32) -> f64, effect: Option<&str>| {
        let command: Vec<f64> = (0..600).map(command).collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let simulator = Simulator::new(&drive, Model::SecondOrder).expect("a drive");
        let mut motor = Motor::default();
        if let Some(id) = effect {
            let effect = ActiveEffect::from_keys(id, [], &motor.parameters);
            motor.effects.set(effect.expect("in the catalogue"));
        }
        let (mut workspace, mut angles) = (Workspace::default(), vec![0.0; t_s.len()]);
        (simulator.angles(&motor, &mut workspace, &mut angles)).expect("a motor");
        workspace.take_work()
    };
    let ramp = |k: u32| f64::from(k) * 0.01;
    let step = |_: u32| 4.5;
    assert!(work(&ramp, Some("supply_sag")) > 5 * work(&ramp, None));
    assert!(work(&ramp, Some("supply_sag")) > 5 * work(&step, Some("supply_sag")));
    assert!(work(&ramp, None) > work(&step, None));
}

/// A filter with one update per sample is exponential smoothing of the reading without it (by recursion), with the
/// derivative by its time constant, and settled to the speed at the start of a segment.
#[test]
fn a_filter_by_samples_is_exponential_smoothing() {
    const TS: f64 = 0.02;
    const TAU_S: f64 = 0.05;
    let t_s: Vec<f64> = (0..300).map(|k| f64::from(k) * TS).collect();
    let command: Vec<f64> = (0..300).map(|k| [0.0, 4.0, -2.0][k / 100]).collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let angles = |motor: &Motor| {
        let simulator = Simulator::new(&drive, Model::SecondOrder).expect("a drive");
        let mut angles = vec![0.0; t_s.len()];
        (simulator.with_sample_filter(true))
            .angles(motor, &mut Workspace::default(), &mut angles)
            .expect("a motor");
        angles
    };
    let filtering = |tau_s: f64| {
        let mut motor = Motor::default();
        let effect = ActiveEffect::new("speed_filter", &[tau_s]);
        motor.effects.set(effect.expect("in the catalogue"));
        motor
    };
    let plain = angles(&Motor::default());
    let found = angles(&filtering(TAU_S));
    let kept = (-TS / TAU_S).exp();
    let mut smoothed = plain[0];
    for (k, (x, y)) in plain.iter().zip(&found).enumerate() {
        smoothed = kept * smoothed + (1.0 - kept) * x;
        assert!((smoothed - y).abs() < 1e-6, "{k}: {smoothed} {y}");
    }
    let id = ParameterId::effect("speed_filter", "time_constant_s").expect("a number");
    let mut column = vec![0.0; t_s.len()];
    let simulator = Simulator::new(&drive, Model::SecondOrder).expect("a drive");
    (simulator.with_sample_filter(true))
        .sensitivities(
            &filtering(TAU_S),
            &[id],
            &mut Workspace::default(),
            &mut vec![0.0; t_s.len()],
            &mut column,
        )
        .expect("a motor");
    let (less, more) = (
        angles(&filtering(TAU_S - 1e-4)),
        angles(&filtering(TAU_S + 1e-4)),
    );
    for k in 0..t_s.len() {
        let difference = (more[k] - less[k]) / 2e-4;
        assert!(
            (column[k] - difference).abs() < 1e-3,
            "{k}: {} {difference}",
            column[k]
        );
    }
}
