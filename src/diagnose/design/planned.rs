//! A profile as its recording would look, and hypotheses seen through it.

use super::super::rivals::catalogue;
use crate::board::Profile;
use crate::diagnose::data::RunData;
use crate::diagnose::effort::Effort;
use crate::diagnose::hypothesis::{Hypothesis, tolerance};
use crate::diagnose::noise::{NoiseLevel, Whitener};
use crate::diagnose::predict::{predict, predict_with_derivatives};
use crate::diagnose::response::Response;
use crate::diagnose::ties::left_after;
use crate::motor::{Drive, KnownDifferences, Motor, SimulationOptions, simulate};
use crate::recording::{CommandKind, Run};

/// Step of the difference along [`unseen_twin`].
const STEP: f64 = 0.01;

/// How a profile is to be sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sampling {
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Samples.
    pub samples: usize,
}

/// A run that was not recorded: a motor's simulated counts on a profile.
#[derive(Debug)]
pub(super) struct Planned {
    /// The run, made ready.
    pub run: RunData,
    /// Whether something is known to differ in it.
    changed: bool,
    response: Response,
    level: NoiseLevel,
    whitener: Whitener,
}

/// A hypothesis with its numbers as it looks on a planned run, whitened.
#[derive(Debug)]
pub(super) struct View {
    prediction: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// How well the number of the last column is known, where it is that of [`unseen_twin`].
    unseen: Option<f64>,
    /// Variances of its innovations where it brings noise of its own.
    variances: Option<Vec<f64>>,
}

impl Planned {
    /// The run that `motor` would make with what is known to differ in it, speed errors dying away at the rate `damping` in
    /// 1/s; `None` where it cannot be simulated.
    pub fn new(
        motor: &Motor,
        profile: &Profile,
        at: Sampling,
        damping: f64,
        level: NoiseLevel,
        known: &KnownDifferences,
    ) -> Option<Self> {
        let Sampling {
            sample_time_s,
            samples,
        } = at;
        let t_s: Vec<f64> = (0..samples).map(|k| k as f64 * sample_time_s).collect();
        let command = profile.commands(sample_time_s, samples);
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let trajectory = simulate(
            &known.applied_to(motor),
            &drive,
            &SimulationOptions::default(),
        )
        .ok()?;
        let run = Run {
            sample_time_s,
            counts_per_rev: motor.parameters.counts_per_rev,
            supply_v: Some(motor.parameters.supply_v),
            command_kind: CommandKind::Voltage,
            counts: trajectory.counts,
            t_s,
            command,
            known: known.clone(),
            ..Run::default()
        };
        let run = RunData::new(&run, 0).ok()?;
        let response = Response::of(&run, damping);
        let whitener = Whitener::new(&run, &response, &level);
        Some(Self {
            run,
            changed: !known.is_empty(),
            response,
            level,
            whitener,
        })
    }

    /// How a hypothesis looks; without derivatives where it is only ever the truth.
    pub fn view(&self, nominal: &Motor, hypothesis: &Hypothesis, p: &[f64]) -> Option<View> {
        let (numbers, effort) = (hypothesis.len(), Effort::default());
        let (mut prediction, mut columns) =
            predict_with_derivatives(hypothesis, nominal, p, numbers, &self.run, &effort)?;
        self.whitener.whiten(&mut prediction);
        let mut unseen = None;
        if self.changed {
            let motor = hypothesis.motor(nominal, p);
            let [less, more] =
                [-STEP, STEP].map(|by| predict(&unseen_twin(&motor, by), &self.run, &effort));
            let pairs = less?.into_iter().zip(more?);
            columns.push(pairs.map(|(a, b)| (b - a) / (2.0 * STEP)).collect());
            let variance = |key: &str| tolerance(nominal, key).powi(2);
            let spread = variance("resistance_ohm") + variance("torque_constant_nm_per_a");
            unseen = Some(1.0 / spread);
        }
        for column in &mut columns {
            self.whitener.whiten(column);
        }
        Some(View {
            prediction,
            columns,
            unseen,
            variances: self.variances(hypothesis, p),
        })
    }

    /// The same without derivatives, for a hypothesis that is only ever the truth.
    pub fn truth(&self, nominal: &Motor, hypothesis: &Hypothesis, p: &[f64]) -> Option<View> {
        let mut prediction = predict(&hypothesis.motor(nominal, p), &self.run, &Effort::default())?;
        self.whitener.whiten(&mut prediction);
        Some(View {
            prediction,
            columns: Vec::new(),
            unseen: None,
            variances: self.variances(hypothesis, p),
        })
    }

    fn variances(&self, hypothesis: &Hypothesis, p: &[f64]) -> Option<Vec<f64>> {
        let mut level = self.level;
        for (m, member) in hypothesis.members.iter().enumerate() {
            let first = hypothesis.values(m, p).first().copied().unwrap_or(0.0);
            match catalogue()[member.index].id {
                "missed_counts" => level.lost_share = first.clamp(0.0, 0.5),
                "sample_jitter" => level.late_s = first,
                _ => {}
            }
        }
        (level != self.level).then(|| {
            Whitener::new(&self.run, &self.response, &level)
                .variances()
                .collect()
        })
    }

    /// The separation of `truth` from `rival`, whose numbers are known to `precision`.
    pub fn separation(
        &self,
        truth: &View,
        rival: &View,
        precision: impl Fn(usize, usize) -> f64,
    ) -> Option<f64> {
        let pairs = truth.prediction.iter().zip(&rival.prediction);
        let difference: Vec<f64> = pairs.map(|(x, y)| x - y).collect();
        let last = rival.columns.len().saturating_sub(1);
        let known = |i: usize, j: usize| match rival.unseen {
            Some(known) if i == last || j == last => f64::from(u8::from(i == j)) * known,
            _ => precision(i, j),
        };
        let left = left_after(&difference, &rival.columns, known)?;
        Some(left.hypot(self.scatter(truth, rival).sqrt()))
    }

    /// What the scatter alone tells: twice the Kullback-Leibler divergence of the innovations.
    fn scatter(&self, truth: &View, rival: &View) -> f64 {
        if truth.variances.is_none() && rival.variances.is_none() {
            return 0.0;
        }
        let plain: Vec<f64> = self.whitener.variances().collect();
        let of = |view: &View| view.variances.clone().unwrap_or_else(|| plain.clone());
        let ratios = of(truth).into_iter().zip(of(rival)).map(|(s, r)| s / r);
        let told = ratios.zip(&self.run.weight);
        told.map(|(rho, weight)| weight * (rho - 1.0 - rho.ln()))
            .sum::<f64>()
            .max(0.0)
    }
}

/// The motor with more resistance and all that is mechanical smaller by the same factor: voltage in and counts out are
/// those of the motor, so that no recording tells how far it is right. With a known inertia or load they are not.
fn unseen_twin(motor: &Motor, by: f64) -> Motor {
    let mut twin = motor.clone();
    twin.parameters.resistance_ohm *= 1.0 + by;
    for key in [
        "inertia_kg_m2",
        "coulomb_friction_nm",
        "viscous_friction_nm_s_per_rad",
    ] {
        if let Some(value) = twin.parameters.get_mut(key) {
            *value /= 1.0 + by;
        }
    }
    for effect in twin.effects.iter_mut() {
        let parameters = effect.kind().parameters;
        for (value, parameter) in effect.values.iter_mut().zip(parameters) {
            let mut units = ["N m", "kg m^2"].iter();
            if units.any(|unit| parameter.unit.starts_with(unit)) {
                *value /= 1.0 + by;
            }
        }
    }
    twin
}
