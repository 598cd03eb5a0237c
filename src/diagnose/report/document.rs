//! What a diagnosis says: the document `motorlab-diagnosis/2`.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use super::{Gap, NextExperiment, NominalSource, Place, PredictedRun, SeenMotor, Step};
use crate::check::Finding;
use crate::motor::{CommandKind, Motor};

/// Version of the document.
pub const SHAPE: &str = "motorlab-diagnosis/2";

/// Causes below this probability are left out of the table of steps.
const SHOWN_FROM: f64 = 1e-3;

/// What it comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// A fatal finding: nothing is asserted about the motor.
    BadRecording,
    /// The nominal model explains the runs down to their floor.
    NoGap,
    /// The same model inside its parameters' tolerances does.
    Parameters,
    /// One or several named effects do, and nothing more is missing.
    Effect,
    /// Named effects are there, and something more that no named effect explains.
    Partial,
    /// Several sets do, and these runs cannot tell which.
    Ambiguous,
    /// Something is there that no known effect explains, not even in part.
    OutsideCatalogue,
    /// These runs do as the reference did.
    NoChange,
}

/// A diagnosis of one or several runs of one motor; displayed it is a table of its steps.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// [`SHAPE`].
    pub shape: &'static str,
    /// What it comes to.
    pub verdict: Verdict,
    /// The same in plain sentences.
    pub sentence: String,
    /// Its four parts: how large the gap is, what causes it, how far it shrinks, what to do next.
    #[serde(skip)]
    pub parts: [String; 4],
    /// Probability of what the verdict says; of `partial`, that the named effects are there.
    pub probability: f64,
    /// Ids of the effects that the verdict names; none where it names none.
    pub effects: Vec<&'static str>,
    /// Every cause, `none` and `unknown`, likeliest first. Their probabilities add to 1.
    pub causes: Vec<Cause>,
    /// Where the gap lies.
    #[serde(rename = "where")]
    pub place: Place,
    /// How far it shrinks.
    pub gap: Gap,
    /// Sets of effects that were weighed, likeliest first.
    pub sets: Vec<EffectSet>,
    /// The base model's numbers as fitted beside the chosen effects, relative to the motor file's.
    pub base: BTreeMap<&'static str, Interval>,
    /// What else is to be known: a load that wanders, base numbers that are far off, few pieces; empty where there is nothing.
    pub note: String,
    /// What is found in the recordings themselves.
    pub data: Vec<Finding>,
    /// What to record next, if something is still in play.
    pub next_experiment: Option<NextExperiment>,
    /// How the search went, a level each.
    pub steps: Vec<Step>,
    /// How long the diagnosis took in s.
    pub elapsed_s: f64,
    /// What it cost on whatever machine: samples simulated to explain the runs, a derivative by a number as many again.
    pub simulated_samples: u64,
    /// The runs that these are held against, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceRuns>,
    /// The nominal motor in what the runs tell, where it was fitted to them because nobody says which motor it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fitted_nominal: Option<SeenMotor>,
    /// Where the nominal motor comes from.
    #[serde(skip)]
    pub nominal_source: NominalSource,
    /// The runs behind the figures of the gap, sample by sample.
    #[serde(skip)]
    pub predicted: Vec<PredictedRun>,
    /// What the command drives: voltage, current or torque.
    #[serde(skip)]
    pub command_kind: CommandKind,
    /// The motor that the runs are held against: the motor file's, or the reference's.
    #[serde(skip)]
    pub nominal: Motor,
    /// The motor that the verdict says: with the named effects in it, with other numbers, or as it is where nothing is missing.
    #[serde(skip)]
    pub model: Motor,
    /// The motor refitted without them.
    #[serde(skip)]
    pub refitted: Motor,
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for step in &self.steps {
            write!(f, "{step}")?;
        }
        writeln!(f, "probabilities")?;
        for cause in self
            .causes
            .iter()
            .filter(|cause| cause.probability >= SHOWN_FROM)
        {
            writeln!(
                f,
                "  {:6.1} %, there at all {:6.1} %  {}",
                100.0 * cause.probability,
                100.0 * cause.inclusion,
                cause.effect
            )?;
        }
        let gap = &self.gap;
        writeln!(
            f,
            "predicted: nominal {:.2}, refitted {:.2}, with effects {:.2} counts; fitted: {:.2}, {:.2}, {:.2}; floor {:.2}, wander {:.2}",
            gap.before,
            gap.after_parameters,
            gap.after_effect,
            gap.fitted.before,
            gap.fitted.after_parameters,
            gap.fitted.after_effect,
            gap.floor,
            gap.wander
        )?;
        writeln!(f, "{}", self.sentence)
    }
}

/// Runs that others are held against, and the motor that they show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceRuns {
    /// What they are called.
    pub runs: Vec<String>,
    /// The effects that explain them beside the motor file's own.
    pub effects: Vec<&'static str>,
    /// Position error that these leave, in counts RMS over pieces.
    pub left_counts: f64,
}

/// One cause and how likely it is.
#[derive(Debug, Clone, Serialize)]
pub struct Cause {
    /// Id of the effect, of several joined by `+`; `none` or `unknown`.
    pub effect: String,
    /// Stage of the chain, of several joined by `+`; none of `none` and `unknown`.
    pub stage: Option<String>,
    /// Probability of exactly this; all causes add to 1.
    pub probability: f64,
    /// Probability that it is there at all: alone, with others or beside something unknown.
    pub inclusion: f64,
    /// Its numbers where it fits best, by `key`, of several effects by `effect.key`.
    pub parameters: BTreeMap<String, Interval>,
    /// Causes that these runs do not tell from it.
    pub indistinguishable_from: Vec<String>,
    /// Class of effects that it belongs to, where the runs do not part its members.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<&'static str>,
    /// Probability of the class.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class_probability: Option<f64>,
    /// What speaks for it; none of what was not fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
}

/// What a cause gains on data that it was not fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Evidence {
    /// Nats that it gains over the model without effects.
    pub gain_nats: f64,
    /// Standard error of that, over pieces.
    pub error_nats: f64,
    /// Pieces that it gains in.
    pub gaining_pieces: usize,
    /// Pieces in all.
    pub pieces: usize,
}

/// A set of effects and how likely it is.
#[derive(Debug, Clone, Serialize)]
pub struct EffectSet {
    /// Ids; none for the model without effects.
    pub effects: Vec<&'static str>,
    /// Its probability.
    pub probability: f64,
    /// By how many nats its score is behind the best.
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
    /// The value in the reference runs, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
}
