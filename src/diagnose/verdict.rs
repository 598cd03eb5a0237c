//! What a diagnosis says: the document `motorlab-diagnosis/1`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::motor::Motor;

/// Version of the document.
pub const SHAPE: &str = "motorlab-diagnosis/1";

/// What it comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The nominal model explains the runs down to their noise.
    NoGap,
    /// The same model inside its parameters' tolerances does.
    Parameters,
    /// One or several named effects do.
    Effect,
    /// Several do, and these runs cannot tell which.
    Ambiguous,
    /// Something is there that no known effect explains.
    OutsideCatalogue,
}

/// A diagnosis of one or several runs of one motor.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// [`SHAPE`].
    pub shape: &'static str,
    /// What it comes to.
    pub verdict: Verdict,
    /// The same as a sentence.
    pub sentence: String,
    /// Ids of the chosen effects; none where there are none.
    pub effects: Vec<&'static str>,
    /// Probability of exactly that set.
    pub probability: f64,
    /// Every effect, `none` and `unknown`, likeliest first.
    pub causes: Vec<Cause>,
    /// Sets of effects that were weighed, likeliest first.
    pub sets: Vec<EffectSet>,
    /// The base model's numbers as fitted beside the chosen effects, relative to the motor file.
    pub base: BTreeMap<&'static str, Interval>,
    /// Where the gap lies.
    #[serde(rename = "where")]
    pub place: Place,
    /// How far it shrinks.
    pub gap: Gap,
    /// What is wrong with the recordings themselves.
    pub data: Vec<DataProblem>,
    /// What to record next, if something is still in play.
    pub next_experiment: Option<NextExperiment>,
    /// Whether the search ended at its limit of work, with sets of effects left that were not tried.
    pub cut_short: bool,
    /// How long the diagnosis took in s.
    pub elapsed_s: f64,
    /// The motor with the chosen effects in it.
    #[serde(skip)]
    pub model: Motor,
    /// The motor refitted without them.
    #[serde(skip)]
    pub refitted: Motor,
}

/// One cause and how likely it is.
#[derive(Debug, Clone, Serialize)]
pub struct Cause {
    /// Id of the effect, `none` or `unknown`.
    pub effect: &'static str,
    /// Stage of the chain; none of `none` and `unknown`.
    pub stage: Option<&'static str>,
    /// Probability; of a set of several effects each has an equal share, so that all causes add to 1.
    pub probability: f64,
    /// Probability that the effect is there at all: alone, with others or beside something unknown.
    pub inclusion: f64,
    /// Its numbers where it fits best.
    pub parameters: BTreeMap<&'static str, Interval>,
    /// Effects that these runs cannot tell from it.
    pub indistinguishable_from: Vec<&'static str>,
    /// Smallest separation D from one of those, in standard deviations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separation: Option<f64>,
    /// Whether its fit has settled.
    pub converged: bool,
}

/// A set of effects and how likely it is.
#[derive(Debug, Clone, Serialize)]
pub struct EffectSet {
    /// Ids; none for the model without effects.
    pub effects: Vec<&'static str>,
    /// Its probability.
    pub probability: f64,
    /// By how many nats its evidence and prior are behind the best.
    pub behind_nats: f64,
}

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Best value.
    pub value: f64,
    /// Lower end.
    pub lo95: f64,
    /// Upper end.
    pub hi95: f64,
    /// Unit; empty for a pure number.
    pub unit: &'static str,
}

/// Where the gap lies.
#[derive(Debug, Clone, Serialize)]
pub struct Place {
    /// Likeliest stage; none where there is no gap.
    pub stage: Option<&'static str>,
    /// Probability of each stage, given that there is a gap.
    pub stage_probabilities: BTreeMap<&'static str, f64>,
    /// Parts of the runs and their share of the gap.
    pub regions: Vec<Region>,
    /// Logarithm of the Bayes factor of a gap ordered by each of these against a patternless one.
    pub ordered_by: BTreeMap<&'static str, f64>,
    /// Frequency in Hz at which what is unknown swings, where it does.
    #[serde(skip)]
    pub oscillation_hz: Option<f64>,
}

/// A stretch of a run with one regime.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Region {
    /// Path of the run, or its number from 1.
    pub run: String,
    /// From, in s.
    pub from_s: f64,
    /// To, in s.
    pub to_s: f64,
    /// What the motor does there.
    pub regime: Regime,
    /// Its share of the gap, 0 to 1.
    pub share: f64,
}

/// What a motor does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Regime {
    /// At rest.
    Standstill,
    /// Leaving rest.
    Breakaway,
    /// Turning slowly.
    LowSpeed,
    /// Turning evenly.
    Steady,
    /// Getting faster.
    Accelerating,
    /// Getting slower while driven.
    Braking,
    /// Changing direction.
    Reversal,
    /// Turning without a command.
    Coasting,
}

impl Regime {
    /// Its words in a sentence.
    pub fn words(self) -> &'static str {
        match self {
            Self::Standstill => "at standstill",
            Self::Breakaway => "at breakaway",
            Self::LowSpeed => "at low speed",
            Self::Steady => "in steady turning",
            Self::Accelerating => "while accelerating",
            Self::Braking => "while braking",
            Self::Reversal => "at reversals",
            Self::Coasting => "while coasting",
        }
    }
}

/// How far the gap shrinks: the four rungs, on data kept from the fit.
#[derive(Debug, Clone, Serialize)]
pub struct Gap {
    /// What is measured.
    pub metric: &'static str,
    /// What the encoder's rounding alone leaves.
    pub floor: f64,
    /// The nominal model.
    pub before: f64,
    /// The same model refitted.
    pub after_parameters: f64,
    /// The model with the effects.
    pub after_effect: f64,
    /// `1 - (after - floor) / (before - floor)`.
    pub closed: f64,
    /// Lower end of its 95 % interval.
    pub closed_lo95: f64,
    /// Upper end.
    pub closed_hi95: f64,
    /// How far more than `closed` these runs' own share may be, as one standard deviation of a normal distribution; 1.
    #[serde(skip)]
    pub closed_deviation: f64,
    /// 95 % intervals of `before`, `after_parameters` and `after_effect`.
    #[serde(skip)]
    pub rungs95: [(f64, f64); 3],
    /// How these data were kept from the fit.
    pub held_out: String,
}

/// Something wrong with a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DataProblem {
    /// Path of the run, or its number from 1.
    pub run: String,
    /// What kind of problem.
    pub problem: String,
    /// What was found, and what it means.
    pub detail: String,
}

/// A known change on the bench, as `differs` and `--with` take it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KnownChange {
    /// Its key: `inertia_added_kg_m2`, `gravity_torque_nm` or `supply_v`.
    pub key: String,
    /// Its value in SI.
    pub value: f64,
}

impl KnownChange {
    /// What is to be done on the bench.
    pub fn words(&self) -> String {
        let Self { key, value } = self;
        match key.as_str() {
            "inertia_added_kg_m2" => format!("a disc of {value} kg m^2 on the shaft"),
            "gravity_torque_nm" => format!(
                "a load on an arm that hangs down at the start, {value} N m where it is level"
            ),
            "supply_v" => format!("a supply of {value} V"),
            _ => format!("{key} = {value}"),
        }
    }

    /// What `diagnose` is to be told of the run; nothing where its header says so already.
    pub fn flag(&self, run: &str) -> Option<String> {
        let Self { key, value } = self;
        (key != "supply_v").then(|| format!("--with {run}:{key}={value}"))
    }
}

/// A recording that would tell more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// The profile with its share of the supply and its duration, as `capture --profile` takes it.
    pub profile: String,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// How long in s.
    pub duration_s: f64,
    /// The command that records it; `PORT` is the board's.
    pub command: String,
    /// What is to be changed on the bench before, where no profile alone tells apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<KnownChange>,
    /// What it tells apart.
    pub tells_apart: Vec<String>,
    /// By how many standard deviations, at least.
    pub expected_separation: f64,
}
