//! Reader of diagnosis documents as far as tables and pages need them: `motorlab-diagnosis/3`, and the earlier `/2`.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};
use time::format_description::well_known::Rfc3339;
use time::{OffsetDateTime, Time};

use super::date::{DATE_LENGTH, date_in};
use super::determined::Identifiable;
use crate::diagnose::SHAPE;
use crate::plain::clipped;

const EARLIER_SHAPE: &str = "motorlab-diagnosis/2";
/// Longest document read, in bytes: some hundred times the longest that a diagnosis writes.
pub const MOST_BYTES: u64 = 1 << 26;
/// Characters of another program's message that are quoted.
const MOST_CHARACTERS: usize = 300;
const DAY_S: f64 = 86_400.0;

/// A document that is not a valid diagnosis.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Damaged {
    /// The file.
    pub document: String,
    /// The error in it.
    pub why: String,
}

/// The parts of a diagnosis that are read; unknown keys are ignored.
#[derive(Debug, Clone, Deserialize)]
pub struct Document {
    /// The file.
    #[serde(skip)]
    pub document: String,
    /// Its shape.
    pub shape: String,
    /// The verdict, as stated in the document.
    pub verdict: String,
    /// Probability of the verdict.
    pub probability: f64,
    /// Identified effects.
    pub effects: Vec<String>,
    /// The verdict in words.
    pub sentence: String,
    /// Notes.
    #[serde(default)]
    pub note: String,
    /// Causes, most probable first.
    pub causes: Vec<Cause>,
    /// Sets of effects with their posterior probabilities.
    #[serde(default)]
    pub(super) sets: Vec<EffectSet>,
    /// The error budget; empty for the earlier shape.
    #[serde(default)]
    pub budget: Vec<BudgetStep>,
    /// Unexplained error; `None` for the earlier shape and for an unusable recording.
    pub unexplained: Option<Unexplained>,
    #[serde(rename = "where")]
    place: Option<Place>,
    /// Errors of the nested models.
    pub gap: Option<Gap>,
    /// Base parameters relative to the motor file's.
    #[serde(default)]
    pub base: BTreeMap<String, Interval>,
    /// Findings about the recordings.
    #[serde(default)]
    pub data: Vec<Finding>,
    /// Next experiment.
    pub next_experiment: Option<Next>,
    /// Computing time in s.
    pub elapsed_s: f64,
    pub(super) nominal_source: Option<String>,
    pub(super) identifiable: Option<Identifiable>,
    /// Path of its page relative to the fleet page, if it has one.
    #[serde(skip)]
    pub page: Option<String>,
    /// The recordings.
    #[serde(default)]
    pub runs: Vec<RunFacts>,
}

/// One cause.
#[derive(Debug, Clone, Deserialize)]
pub struct Cause {
    /// An effect; in the earlier shape several joined by `+`, `none` or `unknown`.
    pub effect: String,
    /// Stage of the chain.
    pub stage: Option<String>,
    /// Probability of exactly this set, in the earlier shape.
    pub(super) probability: Option<f64>,
    /// Inclusion probability.
    pub inclusion: f64,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, Interval>,
    /// Causes that the runs do not separate from it, in the earlier shape.
    #[serde(default)]
    pub indistinguishable_from: Vec<String>,
    /// Class of effects that it belongs to.
    pub class: Option<String>,
    /// Probability of the class.
    pub class_probability: Option<f64>,
    /// Whether one of its parameters is at a bound.
    pub at_bound: Option<bool>,
    /// Held-out evidence, in the earlier shape.
    pub evidence: Option<Evidence>,
}

/// A set of effects.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct EffectSet {
    pub(super) effects: Vec<String>,
    pub(super) probability: f64,
}

/// One step of the error budget.
#[derive(Debug, Clone, Deserialize)]
pub struct BudgetStep {
    /// `nominal`, `parameters`, an effect or `unexplained`.
    pub step: String,
    /// Share of the nominal reducible squared error.
    pub share: Option<f64>,
    /// Lower end of its 95 % interval.
    pub lo95: Option<f64>,
    /// Upper end.
    pub hi95: Option<f64>,
}

/// Unexplained error.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Unexplained {
    /// Held-out RMS error in counts beyond the noise floor.
    pub rms_counts: Option<f64>,
    /// Share of the nominal reducible squared error.
    pub share: Option<f64>,
    /// Lower end of its 95 % interval.
    pub lo95: Option<f64>,
    /// Upper end.
    pub hi95: Option<f64>,
    /// The random load torque of equal effect, as a share of the stall torque.
    pub equivalent_torque_share: Option<f64>,
}

/// Gain of a cause on held-out data.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Evidence {
    /// Gain in nats.
    pub gain_nats: Option<f64>,
    /// Its standard error.
    pub error_nats: Option<f64>,
    /// Segments with a gain.
    #[serde(rename = "gaining_pieces")]
    pub gaining_segments: i64,
    /// Number of segments.
    #[serde(rename = "pieces")]
    pub segments: i64,
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Interval {
    /// Estimate.
    #[serde(deserialize_with = "finite_or_nan")]
    pub value: f64,
    /// Lower end.
    #[serde(deserialize_with = "finite_or_nan")]
    pub lo95: f64,
    /// Upper end.
    #[serde(deserialize_with = "finite_or_nan")]
    pub hi95: f64,
    /// Unit; empty for a dimensionless value.
    pub unit: String,
    /// The same in units of the command, where the resistance or the torque constant is assumed.
    pub(super) in_command: Option<Box<Interval>>,
}

/// A number; JSON `null` is a value that is not finite.
fn finite_or_nan<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

#[derive(Debug, Clone, Deserialize)]
struct Place {
    stage: Option<String>,
}

/// Held-out errors of the nested models in counts RMS.
#[derive(Debug, Clone, Deserialize)]
pub struct Gap {
    /// Prediction horizon in s.
    pub horizon_s: Option<f64>,
    /// Noise floor.
    pub floor: Option<f64>,
    /// Contribution of a random load torque, in the earlier shape.
    #[serde(rename = "wander")]
    pub random_load: Option<f64>,
    /// Travel within a segment.
    pub travel: Option<f64>,
    /// The nominal model.
    pub before: Option<f64>,
    /// With re-identified parameters.
    pub after_parameters: Option<f64>,
    /// With the effects.
    pub after_effect: Option<f64>,
    /// Share of the squared error that is removed.
    pub closed: Option<f64>,
    /// Lower end.
    pub closed_lo95: Option<f64>,
    /// Upper end.
    pub closed_hi95: Option<f64>,
    /// Errors of the same models on the training data.
    pub fitted: Fitted,
}

/// Errors on the training data, in counts RMS.
#[derive(Debug, Clone, Deserialize)]
pub struct Fitted {
    /// The nominal model.
    pub before: Option<f64>,
    /// With re-identified parameters.
    pub after_parameters: Option<f64>,
    /// With the effects.
    pub after_effect: Option<f64>,
}

/// A finding about a recording.
#[derive(Debug, Clone, Deserialize)]
pub struct Finding {
    /// Its id.
    pub id: String,
    /// fatal, warning or note.
    pub severity: String,
}

/// Next experiment.
#[derive(Debug, Clone, Deserialize)]
pub struct Next {
    /// The profile.
    pub profile: String,
    /// Expected separation in standard deviations.
    pub expected_separation: Option<f64>,
}

/// One recording.
#[derive(Debug, Clone, Deserialize)]
pub struct RunFacts {
    /// `diagnosed`, `hold_out` or `reference`.
    pub role: String,
    /// Motor of the recording.
    pub unit: Option<String>,
    /// Start time.
    pub started: Option<String>,
    /// Number of samples.
    pub samples: i64,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Length in s.
    pub duration_s: f64,
}

impl Document {
    /// Reads a document.
    ///
    /// # Errors
    /// The file cannot be read or holds no diagnosis.
    pub fn read(path: &Path) -> Result<Self, Damaged> {
        let document = path.display().to_string();
        let damaged = |why: String| Damaged {
            document: document.clone(),
            why,
        };
        let mut text = String::new();
        let read =
            File::open(path).and_then(|file| file.take(MOST_BYTES + 1).read_to_string(&mut text));
        read.map_err(|error| damaged(error.to_string()))?;
        if text.len() as u64 > MOST_BYTES {
            return Err(damaged(format!("is longer than {MOST_BYTES} bytes")));
        }
        let mut found = Self::of(&text).map_err(damaged)?;
        found.document = document;
        Ok(found)
    }

    fn of(text: &str) -> Result<Self, String> {
        let found: Result<Self, _> = serde_json::from_str(text);
        let found = found.map_err(|error| no_diagnosis(text, &error))?;
        if !is_read(&found.shape) {
            return Err(wrong_shape(&found.shape));
        }
        if !(0.0..=1.0).contains(&found.probability) {
            return Err(format!("its probability is {}", found.probability));
        }
        Ok(found.determined())
    }

    /// Identity of the motor: from the first run's header, else the file name without its date.
    pub fn unit(&self) -> String {
        let said = self.diagnosed().find_map(|run| run.unit.clone());
        said.unwrap_or_else(|| {
            let stem = Path::new(&self.document).file_stem().unwrap_or_default();
            let stem = stem.to_string_lossy();
            match date_in(&stem) {
                Some((at, _)) => {
                    let rest = format!("{}{}", &stem[..at], &stem[at + DATE_LENGTH..]);
                    let rest = rest.trim_matches(['-', '_', '.', ' ', 'T']);
                    if rest.is_empty() {
                        stem.into_owned()
                    } else {
                        rest.to_owned()
                    }
                }
                None => stem.into_owned(),
            }
        })
    }

    /// File name without extension.
    pub fn name(&self) -> String {
        let stem = Path::new(&self.document).file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// Start of the first run: from its header, else the date in the file name.
    pub fn started(&self) -> Option<String> {
        let said = self.diagnosed().find_map(|run| run.started.clone());
        said.or_else(|| {
            let stem = Path::new(&self.document).file_stem()?.to_string_lossy();
            date_in(&stem).map(|(at, _)| stem[at..at + DATE_LENGTH].to_owned())
        })
    }

    /// The same in days since 1970, if it is a time or a date.
    pub fn started_days(&self) -> Option<f64> {
        let text = self.started()?;
        let at = OffsetDateTime::parse(&text, &Rfc3339).ok().or_else(|| {
            let (_, date) = date_in(&text)?;
            Some(date.with_time(Time::MIDNIGHT).assume_utc())
        })?;
        Some(at.unix_timestamp() as f64 / DAY_S)
    }

    /// The diagnosed runs.
    pub fn diagnosed(&self) -> impl Iterator<Item = &RunFacts> {
        self.runs.iter().filter(|run| run.role == "diagnosed")
    }

    /// Stage of the chain of the verdict.
    pub fn stage(&self) -> Option<&str> {
        self.place.as_ref()?.stage.as_deref()
    }

    /// Whether the recording has a fatal finding.
    pub fn is_bad(&self) -> bool {
        self.verdict == "bad_recording"
    }
}

fn is_read(shape: &str) -> bool {
    [SHAPE, EARLIER_SHAPE].contains(&shape)
}

fn wrong_shape(shape: &str) -> String {
    let shape = clipped(shape, MOST_CHARACTERS);
    format!("its shape is '{shape}', not '{SHAPE}' or '{EARLIER_SHAPE}'")
}

fn no_diagnosis(text: &str, error: &serde_json::Error) -> String {
    let value: Option<serde_json::Value> = serde_json::from_str(text).ok();
    let said = value
        .as_ref()
        .and_then(|value| value["error"]["message"].as_str());
    if let Some(said) = said {
        return format!(
            "holds an error, no diagnosis: {}",
            clipped(said, MOST_CHARACTERS)
        );
    }
    let shape = (value.as_ref()).and_then(|value| value["shape"].as_str());
    match shape {
        Some(shape) if !is_read(shape) => wrong_shape(shape),
        _ if text.trim().is_empty() => "is empty".to_owned(),
        _ => format!("is no diagnosis: {error}"),
    }
}
