//! Logs of speeds without a position, as most sketches print them: each speed is a difference of positions with an
//! error, or smoothed by the sketch. Computed here from the handout's equations in closed form, not by the simulator.

use motorlab::diagnose::{Diagnosis, Options, Settings, diagnose, nominal_fit};
use motorlab::motor::Motor;
use motorlab::recording::Run;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

const COUNTS_PER_REV: f64 = 600.0;

/// A first-order motor with Coulomb friction under levels of both signs: revolutions at each sample, in closed form
/// from level to level; the friction in one direction is `back` times that in the other.
fn turns(ts: f64, samples: usize, back: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    const GAIN_REV_S_V: f64 = 0.6;
    const TAU_S: f64 = 0.15;
    const FRICTION_V: f64 = 0.8;
    const LEVELS_V: [f64; 8] = [4.0, 8.0, 10.0, 0.0, -4.0, -8.0, -10.0, 0.0];
    // At speed 0 the shaft stays at rest: levels of 2 s, and steps so fine that their error is negligible.
    const FINE: usize = 50;
    let (mut turned, mut speed) = (0.0, 0.0_f64);
    let (mut t_s, mut command, mut out) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..samples {
        let t = k as f64 * ts;
        let volts = LEVELS_V[(t / 2.0 + 1e-9) as usize % LEVELS_V.len()];
        t_s.push(t);
        command.push(volts);
        out.push(turned);
        let h = ts / FINE as f64;
        for _ in 0..FINE {
            let way = if speed == 0.0 {
                f64::signum(volts)
            } else {
                speed.signum()
            };
            let friction = FRICTION_V * if way < 0.0 { back } else { 1.0 };
            if speed == 0.0 && volts.abs() <= friction {
                continue;
            }
            let steady = GAIN_REV_S_V * (volts - way * friction);
            let left = (speed - steady) * (-h / TAU_S).exp();
            let then = steady + left;
            if speed * then < 0.0 {
                speed = 0.0;
                continue;
            }
            turned += steady * h + TAU_S * (speed - steady - left);
            speed = then;
        }
    }
    (t_s, command, out)
}

/// The run that `import` makes from logged speeds in rev/s: their integral.
fn integrated(t_s: Vec<f64>, command: Vec<f64>, speeds: &[f64]) -> Run {
    let ts = t_s[1] - t_s[0];
    let mut turned = 0.0;
    let counts = speeds.iter().map(|speed| {
        turned += speed * ts;
        (turned * COUNTS_PER_REV).floor() as i64
    });
    let header = "[imported]\nposition = \"integrated from speed, backward\"";
    Run {
        counts: counts.collect(),
        header: header.parse().expect("a header"),
        sample_time_s: ts,
        counts_per_rev: COUNTS_PER_REV,
        supply_v: Some(12.0),
        t_s,
        command,
        ..Run::default()
    }
}

fn differences(turns: &[f64], ts: f64) -> Vec<f64> {
    let steps = turns.windows(2).map(|pair| (pair[1] - pair[0]) / ts);
    std::iter::once(0.0).chain(steps).collect()
}

fn diagnosed(run: Run) -> Diagnosis {
    let nominal = nominal_fit(
        std::slice::from_ref(&run),
        &Motor::default(),
        &Settings::default(),
    )
    .expect("a motor");
    diagnose(&[run], &nominal.motor, &Options::default()).expect("a diagnosis")
}

/// The same with an independent error of each speed, one sigma in rev/s.
fn scattering(back: f64, ts: f64, sigma: f64, seed: u64) -> Diagnosis {
    let (t_s, command, turns) = turns(ts, (24.0 / ts) as usize, back);
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut speeds = differences(&turns, ts);
    for speed in speeds.iter_mut().filter(|speed| **speed != 0.0) {
        let error: f64 = StandardNormal.sample(&mut random);
        *speed += sigma * error;
    }
    diagnosed(integrated(t_s, command, &speeds))
}

/// Errors of speeds accumulate in a position (a random walk). They are no random load, and no effect.
#[test]
fn noise_of_logged_speeds_is_no_effect() {
    for (ts, sigma, seed) in [(0.01, 0.02, 1), (0.02, 0.03, 2), (0.05, 0.05, 3)] {
        let found = scattering(1.0, ts, sigma, seed);
        assert!(found.effects.is_empty(), "{ts} {sigma}: {found}");
    }
}

/// In addition, asymmetric friction is identified in the class of asymmetric offsets.
#[test]
fn asymmetry_is_found_in_logged_speeds() {
    let offsets = [
        "asymmetric_friction",
        "constant_load",
        "asymmetric_voltage_drop",
    ];
    for (ts, sigma, seed) in [(0.01, 0.02, 4), (0.02, 0.03, 5)] {
        let found = scattering(1.8, ts, sigma, seed);
        assert!(
            found.effects.iter().any(|id| offsets.contains(id)),
            "{ts} {sigma}: {found}"
        );
    }
}

/// Exponential smoothing in the sketch is the effect `speed_filter`: no other effect is named with confidence.
#[test]
fn smoothing_by_a_sketch_is_identified_as_a_filter() {
    for (ts, keeps) in [(0.01, 0.8), (0.02, 0.6)] {
        let (t_s, command, turns) = turns(ts, (24.0 / ts) as usize, 1.0);
        let mut smoothed = 0.0;
        let speeds = differences(&turns, ts).into_iter().map(|speed| {
            smoothed += (1.0 - keeps) * (speed - smoothed);
            smoothed
        });
        let speeds: Vec<f64> = speeds.collect();
        let found = diagnosed(integrated(t_s, command, &speeds));
        // Alone, or as a member of the class that these runs do not separate.
        let is_said = (found.effects.iter().copied())
            .chain(
                found
                    .classes
                    .iter()
                    .flat_map(|class| class.members.iter().copied()),
            )
            .any(|id| id == "speed_filter");
        let is_confident = !found.effects.is_empty() && found.probability >= 0.9;
        assert!(is_said || !is_confident, "{ts} {keeps}: {found}");
    }
}
