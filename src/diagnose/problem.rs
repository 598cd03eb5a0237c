//! What does not change while hypotheses are fitted (`fit.rs`): the runs, the nominal motor, the noise that all share, and what
//! is made once for all fits.

use std::sync::Arc;

use super::data::RunData;
use super::disturbance::Disturbance;
use super::effort::Effort;
use super::hypothesis::Hypothesis;
use super::kept::Kept;
use super::kept_filters::{Filters, KeptFilters};
use super::noise::{NoiseLevel, Whitener};
use super::periodic::KeptWaves;
use super::response::Response;
use super::rivals::catalogue;
use super::rungs::Refits;
use super::setting::Setting;
use super::shapes::Dependence;
use crate::motor::Motor;
use crate::recording::CommandKind;

/// Numbers of each sample, run by run or all runs end to end.
pub(super) type Columns = Vec<Vec<f64>>;

/// What does not change while hypotheses are fitted.
#[derive(Debug)]
pub(super) struct Problem<'a> {
    /// The nominal motor.
    pub nominal: &'a Motor,
    /// The runs.
    pub runs: &'a [RunData],
    /// Rate at which a speed error dies away, 1/s.
    pub damping: f64,
    /// How the runs answer to an acceleration.
    pub responses: Arc<[Response]>,
    /// Levels of the wander in counts/s^2, strongest first.
    pub levels: Vec<f64>,
    /// What plausible values depend on besides the motor.
    pub setting: Setting,
    /// Standard deviation of the acceleration in rad/s^2 for each volt commanded: the supply differs by run.
    pub supply: f64,
    /// Variance of rounding as a share of 1/12, beside its tones.
    pub rounding: f64,
    /// What disturbs rough recordings.
    pub rough: Disturbance,
    /// Filters, made when first asked for.
    filters: KeptFilters,
    /// Whitened waves, made when first asked for.
    pub waves: KeptWaves,
    /// Whitened shapes of the unknown, by the wander's level: their size, the largest acceleration, is the same throughout.
    pub shapes: Kept<(u64, Dependence), Columns>,
    /// Fits refitted to parts of the runs.
    pub refits: Refits,
    /// What was simulated, together with other problems of the diagnosis.
    pub effort: Arc<Effort>,
}

/// Runs of more samples than this, all together, have what is the same for every fit made again each time that it is needed: all
/// orders of one effect are 1.8 kB a sample.
const KEPT_SAMPLES: usize = 10_000;

impl<'a> Problem<'a> {
    /// The problem of these runs and this motor.
    pub fn new(
        nominal: &'a Motor,
        runs: &'a [RunData],
        damping: f64,
        levels: Vec<f64>,
        rough: Disturbance,
    ) -> Self {
        Self {
            nominal,
            runs,
            damping,
            responses: runs.iter().map(|run| Response::of(run, damping)).collect(),
            levels,
            setting: Setting::new(nominal, runs),
            supply: supply(nominal, runs),
            rounding: 1.0,
            rough,
            filters: KeptFilters::default(),
            waves: KeptWaves::default(),
            shapes: Kept::default(),
            refits: Refits::default(),
            effort: Arc::default(),
        }
    }

    /// The same as part of a diagnosis that has done so much and may do so much.
    pub fn with_effort(mut self, effort: &Arc<Effort>) -> Self {
        self.effort = effort.clone();
        self
    }

    /// Forgets what the noise is part of.
    fn forget(&mut self) {
        self.filters = KeptFilters::default();
        self.waves = KeptWaves::default();
        self.shapes = Kept::default();
        self.refits = Refits::default();
    }

    /// Takes up another estimate of what disturbs the recordings.
    pub fn set_rough(&mut self, rough: Disturbance) {
        self.rough = rough;
        self.forget();
    }

    /// Whether the runs are so short that what is the same for every fit is kept.
    pub fn keeps_columns(&self) -> bool {
        self.runs.iter().map(RunData::len).sum::<usize>() <= KEPT_SAMPLES
    }

    /// Whether something disturbs the recordings that rounding and a slow wander do not.
    pub fn is_rough(&self) -> bool {
        self.rough != Disturbance::default()
    }

    /// The same problem with another estimate of what disturbs the recordings.
    pub fn beside(&self, rough: Disturbance) -> Self {
        Self {
            responses: self.responses.clone(),
            levels: self.levels.clone(),
            rough,
            filters: KeptFilters::default(),
            waves: KeptWaves::default(),
            shapes: Kept::default(),
            refits: Refits::default(),
            effort: self.effort.clone(),
            ..*self
        }
    }

    /// The same with another variance of rounding, as a share of 1/12.
    pub fn with_rounding(mut self, share: f64) -> Self {
        self.rounding = share;
        self.forget();
        self
    }

    /// The same of an axis that is held by its controller, or not.
    pub fn holding(mut self, is_held: bool) -> Self {
        self.setting.is_held = is_held;
        self
    }

    /// The noise that goes with a hypothesis' numbers: lost edges and late samples are noise of their own.
    pub fn noise(&self, hypothesis: &Hypothesis, p: &[f64], wander: f64) -> NoiseLevel {
        let value = |id: &str| {
            let m = hypothesis
                .members
                .iter()
                .position(|m| catalogue()[m.index].id == id)?;
            hypothesis.values(m, p).first().copied()
        };
        NoiseLevel {
            wander,
            lost_share: value("missed_counts").unwrap_or(0.0).clamp(0.0, 0.5),
            late_s: value("sample_jitter").unwrap_or(0.0),
            supply: self.supply,
            rounding: self.rounding,
            rough: self.rough,
            goes_on: self.setting.is_held,
        }
    }

    /// The filters of all runs.
    pub fn whiteners(&self, level: &NoiseLevel) -> Filters {
        let make = || Whitener::all(self.runs, &self.responses, level);
        self.filters.of(level, make)
    }

    /// The commanded levels next to a threshold: between them it makes no difference.
    pub fn levels_around(&self, threshold: f64) -> (f64, f64) {
        let commands = self.runs.iter().flat_map(|run| &run.command);
        commands.fold((0.0, f64::INFINITY), |(lo, hi), u| {
            let u = u.abs();
            if u <= threshold {
                (f64::max(lo, u), hi)
            } else {
                (lo, f64::min(hi, u))
            }
        })
    }
}

/// How the acceleration for each volt varies where the motor file says how surely the supply is known.
fn supply(nominal: &Motor, runs: &[RunData]) -> f64 {
    let voltage = runs.first().map(|run| run.kind) == Some(CommandKind::Voltage);
    let tolerance = nominal.tolerance.get("supply_v").filter(|_| voltage);
    let p = &nominal.parameters;
    let gain = p.torque_constant_nm_per_a / (p.resistance_ohm * p.inertia_kg_m2);
    tolerance.map_or(0.0, |tolerance| tolerance * gain)
}
