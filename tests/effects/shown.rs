//! The experiment named by `motorlab effects ID` shows the effect at its default strength: no motor without the
//! effect makes the same run. An effect that is equal to a parameter change is not identifiable, and is listed as
//! such.
//!
//! The separation is `D^2 = min over parameters of sum (x - x_nominal)^2` in units of one count: for a motor without
//! inductance, voltage and counts determine gain, time constant and friction, which back EMF, inertia and Coulomb
//! friction span. D = 3 is the threshold of a diagnosis.

use std::f64::consts::TAU;

use motorlab::board::Profile;
use motorlab::effects::{Experiment, experiment, not_identifiable};
use motorlab::motor::catalogue::{EffectKind, again, catalogue};
use motorlab::motor::fit::{ParameterId, Simulator, Workspace};
use motorlab::motor::{
    ActiveEffect, CommandKind, Drive, Model, Motor, Parameters, SimulationOptions, Trajectory,
    simulate,
};
use nalgebra::{DMatrix, DVector};

/// Separation from which two models differ.
const SEEN: f64 = 3.0;

/// The base numbers that are refitted.
const BASE: [&str; 3] = [
    "back_emf_v_s_per_rad",
    "inertia_kg_m2",
    "coulomb_friction_nm",
];

/// Factors on them as starts of a refit: near the nominal, and where friction or inertia imitates the effect.
const STARTS: [[f64; 3]; 7] = [
    [1.0, 1.0, 1.0],
    [1.0, 1.0, 0.3],
    [1.0, 1.0, 3.0],
    [1.3, 1.0, 1.0],
    [0.8, 1.0, 1.0],
    [1.0, 2.0, 1.0],
    [1.2, 0.5, 0.5],
];

/// A planned experiment.
struct Bench {
    t_s: Vec<f64>,
    command: Vec<f64>,
    simulator: Simulator,
}

impl Bench {
    fn new(plan: Experiment) -> Self {
        let supply_v = Parameters::default().supply_v;
        let profile = Profile::named(plan.profile, supply_v, plan.duration_s).expect("a profile");
        let samples = (plan.duration_s / plan.sample_time_s).round() as usize;
        let t_s: Vec<f64> = (0..samples)
            .map(|k| k as f64 * plan.sample_time_s)
            .collect();
        let command = profile.commands(plan.sample_time_s, samples);
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let simulator = Simulator::new(&drive, Model::SecondOrder).expect("a drive");
        Self {
            t_s,
            command,
            simulator,
        }
    }

    fn recorded(&self, motor: &Motor) -> Trajectory {
        let drive = Drive {
            t_s: &self.t_s,
            command: &self.command,
            kind: CommandKind::Voltage,
        };
        simulate(motor, &drive, &SimulationOptions::default()).expect("a motion")
    }

    /// Response of the motor: counts before quantization; for a random effect the counts.
    fn shown(&self, motor: &Motor, random: bool) -> Vec<f64> {
        let run = self.recorded(motor);
        if random {
            run.counts.iter().map(|n| *n as f64).collect()
        } else {
            let per_rad = motor.parameters.counts_per_rev / TAU;
            run.measured_angle_rad.iter().map(|a| per_rad * a).collect()
        }
    }

    /// Observed counts minus a motor's; the initial fraction of a count is free for quantized counts.
    fn differences(&self, motor: &Motor, shown: &[f64], rounded: bool) -> Option<Vec<f64>> {
        let mut angles = vec![0.0; shown.len()];
        self.simulator
            .angles(motor, &mut Workspace::default(), &mut angles)
            .ok()?;
        let per_rad = motor.parameters.counts_per_rev / TAU;
        let pairs = shown.iter().zip(&angles);
        let raw: Vec<f64> = pairs.map(|(n, angle)| n - per_rad * angle).collect();
        let mean = raw.iter().sum::<f64>() / raw.len() as f64;
        let start = if rounded { mean.clamp(-0.5, 0.5) } else { 0.0 };
        Some(raw.into_iter().map(|r| r - start).collect())
    }

    /// The least sum of squares over the base parameters from one start, by Levenberg-Marquardt in their logarithms.
    fn refitted_from(&self, start: Motor, shown: &[f64], rounded: bool) -> f64 {
        let ids = BASE.map(|key| ParameterId::nominal(key).expect("a key"));
        let samples = shown.len();
        let mut workspace = Workspace::default();
        let Some(mut left) = self.differences(&start, shown, rounded) else {
            return f64::INFINITY;
        };
        let squares = |r: &[f64]| r.iter().map(|x| x * x).sum::<f64>();
        let (mut motor, mut least, mut damping) = (start, squares(&left), 1e-3);
        for _ in 0..60 {
            let mut angles = vec![0.0; samples];
            let mut columns = vec![0.0; samples * BASE.len()];
            let derived = (self.simulator).sensitivities(
                &motor,
                &ids,
                &mut workspace,
                &mut angles,
                &mut columns,
            );
            if derived.is_err() {
                break;
            }
            let per_rad = motor.parameters.counts_per_rev / TAU;
            let values = ids.map(|id| id.get(&motor).expect("a number"));
            let jacobian = DMatrix::from_fn(samples, BASE.len(), |k, j| {
                per_rad * columns[j * samples + k] * values[j]
            });
            let normal = jacobian.tr_mul(&jacobian);
            let gradient = jacobian.tr_mul(&DVector::from_column_slice(&left));
            let before = least;
            while damping < 1e8 {
                let mut damped = normal.clone();
                for j in 0..BASE.len() {
                    damped[(j, j)] = damped[(j, j)] * (1.0 + damping) + 1e-12;
                }
                let step = damped.lu().solve(&gradient).expect("a regular matrix");
                let mut tried = motor.clone();
                for (j, id) in ids.iter().enumerate() {
                    id.set(&mut tried, values[j] * step[j].clamp(-1.0, 1.0).exp());
                }
                match self.differences(&tried, shown, rounded) {
                    Some(found) if squares(&found) < least => {
                        (motor, least, left) = (tried, squares(&found), found);
                        damping *= 0.3;
                        break;
                    }
                    _ => damping *= 4.0,
                }
            }
            if least > before * (1.0 - 1e-7) {
                break;
            }
        }
        least
    }

    fn refitted(&self, shown: &[f64], rounded: bool) -> f64 {
        let from = |factors: [f64; 3]| {
            let mut motor = Motor::default();
            for (key, factor) in BASE.into_iter().zip(factors) {
                *motor.parameters.get_mut(key).expect("a key") *= factor;
            }
            self.refitted_from(motor, shown, rounded)
        };
        STARTS.into_iter().map(from).fold(f64::INFINITY, f64::min)
    }

    /// Separation of a motor from the nominal one, before and after its base parameters are refitted.
    fn separation(&self, motor: &Motor, random: bool) -> [f64; 2] {
        let shown = self.shown(motor, random);
        let left = self.differences(&Motor::default(), &shown, random);
        let before: f64 = left.expect("a motion").iter().map(|x| x * x).sum();
        // The quantization error of the nominal motor's own counts is no separation.
        let rounding = if random {
            self.refitted(&self.shown(&Motor::default(), true), true)
        } else {
            0.0
        };
        let after = self.refitted(&shown, random);
        [before, after].map(|squares| (squares - rounding).max(0.0).sqrt())
    }
}

fn with(kind: &EffectKind, values: &[f64]) -> Motor {
    let mut motor = Motor::default();
    let effect = ActiveEffect::new(kind.id, values).expect("a plausible strength");
    motor.effects.set(effect);
    motor
}

/// The default strength of `virtual:?effect=ID`.
fn defaults(kind: &EffectKind) -> Vec<f64> {
    let effect = ActiveEffect::from_keys(kind.id, [], &Parameters::default()).expect("its id");
    effect.parameters().map(|(_, value)| value).collect()
}

/// Every effect, and second instances.
fn effects() -> impl Iterator<Item = &'static EffectKind> {
    catalogue().iter().chain(again())
}

#[test]
fn the_default_strength_of_each_effect_is_visible() {
    let mut unseen = Vec::new();
    for kind in effects().filter(|kind| not_identifiable(kind).is_none()) {
        let plan = experiment(kind);
        let motor = with(kind, &defaults(kind));
        let [before, after] = Bench::new(plan).separation(&motor, kind.random);
        println!(
            "{:<24} {:<10} {:>4} s: D {before:8.1}, refitted {after:8.1}",
            kind.id, plan.profile, plan.duration_s
        );
        if after < SEEN {
            unseen.push((kind.id, after));
        }
    }
    assert!(unseen.is_empty(), "{unseen:?}");
}

/// Half way from the default to the largest plausible value, so that it is visible before the refit.
#[test]
fn unidentifiable_effects_are_reproduced_by_base_parameters() {
    for kind in effects().filter(|kind| not_identifiable(kind).is_some()) {
        let plan = experiment(kind);
        let mut values = defaults(kind);
        let (_, largest) = kind.parameters[0].range(&Parameters::default(), plan.sample_time_s);
        values[0] = 0.5 * (values[0] + largest);
        let [before, after] = Bench::new(plan).separation(&with(kind, &values), kind.random);
        assert!(
            before >= SEEN && after < SEEN,
            "{} = {}: D {before}, refitted {after}",
            kind.id,
            values[0]
        );
    }
}
