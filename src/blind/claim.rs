//! Claims of a document `motorlab-diagnosis/1`, `/2` or `/3`: none for an unusable recording, and for `partial` its
//! named effects plus an unknown one.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::diagnosis_document::{DIAGNOSIS_SHAPE, DiagnosisDocument};

/// The part of a diagnosis that is judged.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Claim {
    /// `no_gap`, `parameters`, `effect`, `partial`, `ambiguous` or `outside_catalogue`.
    pub verdict: Word,
    /// Probability of the verdict.
    #[serde(default, rename = "probability")]
    pub of_verdict: Option<f64>,
    /// Ids of the named set.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Most probable first; the sum is 1.
    #[serde(default)]
    pub causes: Vec<Cause>,
    /// Whether a named effect represents its class, as from the third shape on. Before, only `ambiguous` had ties.
    #[serde(skip)]
    pub stands_for_class: bool,
    /// Sets with their probabilities, if the document lists them. Then an effect's probability among the causes is
    /// its share: half of that of a set of two.
    #[serde(default)]
    pub sets: Vec<EffectSet>,
    /// Claimed error reduction.
    #[serde(default)]
    pub gap: ClaimedGap,
    /// Stated computing time in s.
    #[serde(default)]
    pub elapsed_s: Option<f64>,
}

/// The verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Word {
    /// The nominal model explains the runs.
    NoGap,
    /// The nominal model explains the runs with parameters within their tolerances.
    Parameters,
    /// One or several named effects explain the runs.
    Effect,
    /// One or several named effects are present, and an error that no known effect explains.
    Partial,
    /// Several effects explain the runs equally well.
    Ambiguous,
    /// An error that no known effect explains.
    OutsideCatalogue,
    /// No diagnosis: none was made, or the recording has a fatal finding.
    Failed,
}

/// One cause.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Cause {
    /// An id, several joined by `+`, `none` or `unknown`.
    pub effect: String,
    /// Its probability.
    pub probability: f64,
    /// Its estimated parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, Estimate>,
    /// Sets in the form of `effect` that these runs do not separate from it.
    #[serde(default)]
    pub indistinguishable_from: Vec<String>,
    /// Its class of effects, if these runs do not separate the members.
    #[serde(default)]
    pub class: Option<String>,
}

/// A set of effects with its probability.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EffectSet {
    /// Ids; empty for the model without effects.
    pub effects: Vec<String>,
    /// Probability of exactly this set.
    pub probability: f64,
}

/// An estimate with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Estimate {
    /// The value in SI.
    pub value: Option<f64>,
    /// Lower end of the 95 % interval.
    pub lo95: Option<f64>,
    /// Upper end of the 95 % interval.
    pub hi95: Option<f64>,
}

/// The claimed error reduction.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(default)]
pub struct ClaimedGap {
    /// Share of the squared error that is removed.
    pub closed: Option<f64>,
    /// Lower end of its 95 % interval.
    pub closed_lo95: Option<f64>,
    /// Upper end of its 95 % interval.
    pub closed_hi95: Option<f64>,
}

/// A set of effects, as named by `stribeck+inertia`.
pub(super) type Names = BTreeSet<String>;

/// The set of a name; empty for `none` and `parameters`.
pub(super) fn names(text: &str) -> Names {
    text.split('+')
        .map(str::trim)
        .filter(|name| !matches!(*name, "" | "none" | "parameters"))
        .map(str::to_owned)
        .collect()
}

impl Claim {
    /// Reads a document.
    ///
    /// # Errors
    /// What the document lacks.
    pub fn read(document: &Value) -> Result<Self, String> {
        if document["verdict"] == "bad_recording" {
            return Ok(Self {
                verdict: Word::Failed,
                of_verdict: None,
                effects: Vec::new(),
                causes: Vec::new(),
                stands_for_class: false,
                sets: Vec::new(),
                gap: ClaimedGap::default(),
                elapsed_s: document["elapsed_s"].as_f64(),
            });
        }
        let of_third = document["shape"] == DIAGNOSIS_SHAPE;
        let claim = match of_third {
            true => serde_json::from_value(document.clone()).map(DiagnosisDocument::claim),
            false => serde_json::from_value(document.clone()),
        };
        let claim: Self = claim.map_err(|error| error.to_string())?;
        let causes = claim
            .causes
            .iter()
            .map(|c| (c.effect.clone(), c.probability));
        let sets = claim
            .sets
            .iter()
            .map(|s| (s.effects.join("+"), s.probability));
        let verdict = claim.of_verdict.map(|p| ("the verdict".to_owned(), p));
        match causes
            .chain(sets)
            .chain(verdict)
            .find(|(_, p)| !(0.0..=1.0 + 1e-6).contains(p))
        {
            Some((name, p)) => Err(format!("the probability of '{name}' is {p}")),
            None => Ok(claim),
        }
    }

    /// The set that is named first.
    pub(super) fn leading(&self) -> Names {
        match self.verdict {
            Word::NoGap | Word::Parameters | Word::Failed => Names::new(),
            Word::OutsideCatalogue => names("unknown"),
            Word::Partial => {
                let named = self.effects.iter().cloned();
                named.chain(["unknown".to_owned()]).collect()
            }
            Word::Effect | Word::Ambiguous if !self.effects.is_empty() => {
                self.effects.iter().cloned().collect()
            }
            Word::Effect | Word::Ambiguous => self
                .causes
                .first()
                .map_or(Names::new(), |cause| names(&cause.effect)),
        }
    }

    /// Every set consistent with the verdict: the named one, and those stated as tied with it.
    pub(super) fn standing(&self) -> Vec<Names> {
        let leading = self.leading();
        let mut standing = vec![leading.clone()];
        let mut add = |set: Names| {
            if !standing.contains(&set) {
                standing.push(set);
            }
        };
        // Up to the second shape, "effect" is unambiguous, whatever the document states about that cause.
        let is_open = match self.verdict {
            Word::Ambiguous => true,
            Word::Effect | Word::Partial => self.stands_for_class,
            _ => false,
        };
        if !is_open {
            return standing;
        }
        for tied in self.ties(&leading) {
            add(tied);
        }
        if leading.len() > 1 {
            // One member replaced by an effect that is not separated from it.
            for member in &leading {
                for tied in self.ties(&names(member)) {
                    let mut other = leading.clone();
                    other.remove(member);
                    // A member that is not separated from `none` may be absent.
                    let is_absent = tied.is_empty();
                    other.extend(tied);
                    if is_absent || other.len() == leading.len() {
                        add(other);
                    }
                }
            }
        }
        standing
    }

    /// Whether the verdict is that no effect is present and that this set is not separated from none.
    pub(super) fn hides(&self, set: &Names) -> bool {
        matches!(self.verdict, Word::NoGap | Word::Parameters)
            && self.ties(&Names::new()).contains(set)
    }

    fn ties(&self, of: &Names) -> Vec<Names> {
        let Some(cause) = self.cause(of) else {
            return Vec::new();
        };
        let of_class = self.causes.iter().filter(|other| {
            cause.class.is_some() && other.class == cause.class && other.effect != cause.effect
        });
        let members = of_class.map(|other| names(&other.effect));
        let tied = cause.indistinguishable_from.iter().map(|text| names(text));
        members.chain(tied).collect()
    }

    pub(super) fn cause(&self, of: &Names) -> Option<&Cause> {
        self.causes.iter().find(|cause| names(&cause.effect) == *of)
    }

    /// Every set with its probability, most probable first. `unknown` is always among the causes.
    pub(super) fn weighed(&self) -> Vec<(Names, f64)> {
        let of_cause = |cause: &Cause| (names(&cause.effect), cause.probability);
        let mut weighed: Vec<(Names, f64)> = if self.sets.is_empty() {
            self.causes.iter().map(of_cause).collect()
        } else {
            let unknown = names("unknown");
            let sets = self.sets.iter();
            sets.map(|set| (set.effects.iter().cloned().collect(), set.probability))
                .chain(self.causes.iter().map(of_cause).filter(|c| c.0 == unknown))
                .collect()
        };
        weighed.sort_by(|a, b| b.1.total_cmp(&a.1));
        weighed
    }

    /// Probability of exactly this set.
    pub(super) fn probability(&self, of: &Names) -> f64 {
        if self.verdict == Word::Partial && *of == self.leading() {
            return self.of_verdict.unwrap_or(0.0);
        }
        let weighed = self.weighed();
        let of_it = weighed.iter().filter(|(set, _)| set == of);
        of_it.fold(0.0, |sum, (_, p)| sum + p).min(1.0)
    }

    /// The estimate of a parameter of an effect in the fit of the first set.
    pub(super) fn estimate(&self, effect: &str, parameter: &str) -> Option<Estimate> {
        let of = |cause: &Cause| {
            let full = format!("{effect}.{parameter}");
            let found = cause.parameters.get(&full);
            found.or_else(|| cause.parameters.get(parameter)).copied()
        };
        let whole = self.cause(&self.leading()).and_then(of);
        whole.or_else(|| self.cause(&names(effect)).and_then(of))
    }
}
