//! The document `motorlab-diagnosis/3`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{
    BudgetStep, Gap, Identifiable, NextExperiment, NominalSource, Place, PredictedRun, SearchStep,
    Unexplained,
};
use crate::check::Finding;
use crate::diagnose::sentence::after_warnings;
use crate::diagnose::settings::Settings;
use crate::motor::{CommandKind, Motor};

/// Version of the document.
pub const SHAPE: &str = "motorlab-diagnosis/3";

/// The verdict: a function of the error budget and the posterior.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// A fatal finding about the recording: no statement about the motor.
    BadRecording,
    /// The nominal model is within the noise floor.
    NoGap,
    /// No effect is identified, and re-identified parameters remove more than 90 % of the reducible error, or at least
    /// 50 % with P(no effect is present) at least 0.5.
    Parameters,
    /// The named effects are identified, and less than a tenth of the reducible error is unexplained.
    Effect,
    /// The named effects are identified, and a tenth or more is unexplained.
    Partial,
    /// No effect or class of effects is identified, but P(an effect is present) is above 0.5.
    Ambiguous,
    /// P(no effect of the catalogue is present) is at least 0.5, and re-identified parameters leave more than half of
    /// the reducible error.
    OutsideCatalogue,
    /// With a reference: no difference from the reference runs.
    NoChange,
}

impl Verdict {
    /// Its name in the document.
    pub fn id(self) -> &'static str {
        match self {
            Self::BadRecording => "bad_recording",
            Self::NoGap => "no_gap",
            Self::Parameters => "parameters",
            Self::Effect => "effect",
            Self::Partial => "partial",
            Self::Ambiguous => "ambiguous",
            Self::OutsideCatalogue => "outside_catalogue",
            Self::NoChange => "no_change",
        }
    }

    /// Its meaning as part of a sentence.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::BadRecording => "a finding about the recording is fatal",
            Self::NoGap => {
                "the error of the nominal model is not significantly above the noise floor"
            }
            Self::Parameters => {
                "P(no effect is present) is at least 0.5, and re-identified parameters remove at least half of the squared error"
            }
            Self::Effect => {
                "the named effects or classes are identified, and less than a tenth of the squared error is unexplained"
            }
            Self::Partial => {
                "the named effects or classes are identified, and a tenth or more of the squared error is unexplained"
            }
            Self::Ambiguous => "no effect is identified, but P(an effect is present) is above 0.5",
            Self::OutsideCatalogue => {
                "P(no effect of the catalogue is present) is at least 0.5, and re-identified parameters leave more than half of the squared error"
            }
            Self::NoChange => "these runs agree with the reference",
        }
    }
}

/// A diagnosis of one or several runs of one motor.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// [`SHAPE`].
    pub shape: &'static str,
    /// The verdict.
    pub verdict: Verdict,
    /// The verdict in sentences, with figures of this document.
    pub sentence: String,
    /// Its four parts: the size of the error, its cause, the remaining error, the next step.
    #[serde(skip)]
    pub parts: [String; 4],
    /// Probability that all named effects (or their classes) are present; for `no_gap`, `parameters` and `no_change`,
    /// that none is.
    pub probability: f64,
    /// Ids of the identified effects, in the order of the squared error that they remove; for a class its most
    /// probable member.
    pub effects: Vec<&'static str>,
    /// Classes of identified effects whose members these runs do not separate.
    pub classes: Vec<EffectClass>,
    /// The error budget: `nominal`, `parameters`, each effect in the order of what it removes, `unexplained`.
    pub budget: Vec<BudgetStep>,
    /// Unexplained error.
    pub unexplained: Unexplained,
    /// Effects by inclusion probability, most probable first.
    pub causes: Vec<Cause>,
    /// Sets of effects by posterior probability; the sum is 1.
    pub sets: Vec<EffectSet>,
    /// Parameters that the runs determine.
    pub identifiable: Identifiable,
    /// Location of the error.
    #[serde(rename = "where")]
    pub place: Place,
    /// The error of the nested models and its noise floor.
    pub gap: Gap,
    /// Re-identified base parameters beside the named effects, relative to the motor file's.
    pub base: BTreeMap<&'static str, Interval>,
    /// For a quick answer, the searched and fitted samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quick: Option<Quick>,
    /// Notes; empty without any.
    pub note: String,
    /// Findings about the recordings.
    pub data: Vec<Finding>,
    /// Next experiment, if a recording separates the remaining sets.
    pub next_experiment: Option<NextExperiment>,
    /// The search by rounds.
    pub steps: Vec<SearchStep>,
    /// The score of sets.
    pub scoring: Scoring,
    /// Settings of the method.
    pub settings: Settings,
    /// Computing time in s.
    pub elapsed_s: f64,
    /// Samples simulated, a derivative counted as many again: a machine-independent cost.
    pub simulated_samples: u64,
    /// The reference runs, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceRuns>,
    /// Source of the nominal motor.
    pub nominal_source: NominalSource,
    /// Residuals behind the figures of the budget, by sample.
    #[serde(skip)]
    pub predicted: Vec<PredictedRun>,
    /// Quantity that the command sets.
    #[serde(skip)]
    pub command_kind: CommandKind,
    /// The nominal motor: the motor file's, the fitted one, or the reference's.
    #[serde(skip)]
    pub nominal: Motor,
    /// The motor of the verdict: nominal, with re-identified parameters, or with the named effects.
    #[serde(skip)]
    pub model: Motor,
    /// The motor with re-identified parameters and without effects.
    #[serde(skip)]
    pub refitted: Motor,
}

impl Diagnosis {
    /// Replaces the fourth part of the sentence if `rewrite` returns another one.
    pub fn rewrite_next(&mut self, rewrite: impl FnOnce(&str) -> Option<String>) {
        if let Some(next) = rewrite(&self.parts[3]) {
            self.parts[3] = next;
            let parts = self.parts.iter().filter(|part| !part.is_empty());
            self.sentence = parts.cloned().collect::<Vec<_>>().join(" ");
        }
    }

    /// Replaces the findings; the next step begins with the warnings among them.
    pub fn set_findings(&mut self, findings: Vec<Finding>) {
        self.rewrite_next(|next| after_warnings(next, &findings));
        self.data = findings;
    }

    /// Whether values in N m, kg m^2, ohm and A are determined: by a motor file, the handout or a known load.
    pub fn has_torque(&self) -> bool {
        self.identifiable.si.is_some()
            || self.nominal_source == NominalSource::Handout
            || self.command_kind == CommandKind::Torque
    }
}

/// The data of a quick answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quick {
    /// Searched and fitted samples.
    pub samples: usize,
    /// All samples of the runs.
    pub of_samples: usize,
    /// `samples` as a share of them.
    pub share: f64,
}

impl Quick {
    pub(crate) fn new(samples: usize, of_samples: usize) -> Self {
        Self {
            samples,
            of_samples,
            share: samples as f64 / of_samples.max(1) as f64,
        }
    }

    pub(crate) fn sentence(&self) -> String {
        format!(
            "Quick answer: {} of {} samples ({:.0} %) were used for search and fits; without --quick more are used.",
            self.samples,
            self.of_samples,
            100.0 * self.share
        )
    }
}

/// A class of effects in place of one of its members.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectClass {
    /// Id of the class.
    pub class: &'static str,
    /// Probability that one of its members is present.
    pub probability: f64,
    /// Members that have a posterior probability, most probable first.
    pub members: Vec<&'static str>,
}

/// One effect with its probability.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Id of the effect.
    pub effect: &'static str,
    /// Its stage of the chain.
    pub stage: &'static str,
    /// Inclusion probability: the sum over all sets that contain it.
    pub inclusion: f64,
    /// Its class, if these runs do not separate it from another member.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<&'static str>,
    /// Inclusion probability of that class.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class_probability: Option<f64>,
    /// Whether one of its parameters is at a bound, so that it is not identified.
    pub at_bound: bool,
    /// Whether it removes less than a tenth of the held-out error that is left before it, so that it is not identified.
    pub immaterial: bool,
    /// Its parameters in the most probable set that contains it, by key.
    pub parameters: BTreeMap<&'static str, Interval>,
}

impl Cause {
    /// Why it is not identified although it is probable under the settings of its document.
    pub fn not_identified(&self, settings: &Settings) -> Option<&'static str> {
        let is_probable = self.inclusion >= settings.identified;
        match (self.at_bound && is_probable, self.immaterial) {
            (true, _) => Some("a parameter is at its bound"),
            (false, true) => Some(
                "on held-out data it removes less than a tenth of the error that remains without it",
            ),
            (false, false) => None,
        }
    }
}

/// A set of effects and its posterior probability.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectSet {
    /// Ids; empty for the model without effects.
    pub effects: Vec<&'static str>,
    /// Posterior probability of exactly this set.
    pub probability: f64,
    /// Its score (log evidence) in nats.
    pub score: f64,
    /// Residual RMS of its fit in counts.
    pub rms_counts: f64,
}

/// The score of sets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scoring {
    /// `likelihood` if quantization and a random load torque explain the residual of the best set, else `scale_free`.
    pub score: &'static str,
    /// Effective number of independent observations in the residual of the best set.
    pub effective_observations: f64,
    /// Fitted random load torque for the best set, one sigma as a share of stall.
    pub random_load_share: f64,
    /// Mean square of the whitened residual of the best set over its expectation.
    pub whitened_squares: f64,
    /// The probability of a set is proportional to `exp(learning_rate score)`.
    pub learning_rate: f64,
    /// Whether the command of a run answers to the measured position: segments are short there.
    pub closed_loop: bool,
}

/// Reference runs and their model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceRuns {
    /// Their names.
    pub runs: Vec<String>,
    /// Effects of their model in addition to the motor file's.
    pub effects: Vec<&'static str>,
    /// Residual RMS of their model in counts.
    pub rms_counts: f64,
}

/// A parameter with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Estimate.
    pub value: f64,
    /// Lower end.
    pub lo95: f64,
    /// Upper end.
    pub hi95: f64,
    /// Unit; empty for a dimensionless value.
    pub unit: &'static str,
    /// Whether the fit ended at a bound of its range, so that the value is no estimate.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub at_bound: bool,
    /// The value in the reference runs, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
    /// The same in units of the command, if the resistance or the torque constant is assumed: the value that the runs
    /// determine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub in_command: Option<CommandInterval>,
}

/// A parameter and its 95 % interval in units of the command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CommandInterval {
    /// Estimate.
    pub value: f64,
    /// Lower end.
    pub lo95: f64,
    /// Upper end.
    pub hi95: f64,
    /// Unit.
    pub unit: &'static str,
    /// The value in the reference runs, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
}

/// Ends of keys with a unit that depends on an assumed resistance or torque constant.
const ASSUMED_UNITS: [&str; 8] = [
    "_nm",
    "_nm_s_per_rad",
    "_nm_s2_per_rad2",
    "_kg_m2",
    "_a",
    "_ohm",
    "_h",
    "_per_w",
];

/// A key without a unit that depends on an assumed resistance or torque constant.
pub(crate) fn without_assumed_unit(key: &str) -> &str {
    let mut units = ASSUMED_UNITS.iter();
    units.find_map(|unit| key.strip_suffix(unit)).unwrap_or(key)
}

impl Interval {
    /// The parameter as the runs determine it, with its name: in SI, or in units of the command and without the unit
    /// in the key.
    pub fn determined<'a>(&self, key: &'a str) -> (&'a str, Self) {
        let Some(own) = self.in_command else {
            return (key, *self);
        };
        let determined = Self {
            value: own.value,
            lo95: own.lo95,
            hi95: own.hi95,
            unit: own.unit,
            at_bound: self.at_bound,
            reference: own.reference,
            in_command: None,
        };
        (without_assumed_unit(key), determined)
    }
}
