//! The claims of a document `motorlab-diagnosis/1`, `/2` or `/3`: none of a bad recording, and with `partial` its named effects and something
//! unknown beside them.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::diagnosis_document::{DIAGNOSIS_SHAPE, DiagnosisDocument};

/// The parts of a diagnosis that can be right or wrong.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Claim {
    /// `no_gap`, `parameters`, `effect`, `partial`, `ambiguous` or `outside_catalogue`.
    pub verdict: Word,
    /// Probability of what the verdict says.
    #[serde(default, rename = "probability")]
    pub of_verdict: Option<f64>,
    /// Ids of the named set.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Best first; probabilities add to 1.
    #[serde(default)]
    pub causes: Vec<Cause>,
    /// Whether a named effect stands for its class where it has one, as from the third shape on. Before, only `ambiguous` had ties.
    #[serde(skip)]
    pub stands_for_class: bool,
    /// Whole sets with their probabilities, where the document lists them. Where it does, an effect's
    /// probability among the causes is its share: of a set of two, half the set's.
    #[serde(default)]
    pub sets: Vec<EffectSet>,
    /// How far the gap is said to close.
    #[serde(default)]
    pub gap: ClaimedGap,
    /// Seconds that it says it took.
    #[serde(default)]
    pub elapsed_s: Option<f64>,
}

/// The verdict in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Word {
    /// The nominal model explains the runs.
    NoGap,
    /// The same model inside its tolerances does.
    Parameters,
    /// One or several named effects do.
    Effect,
    /// One or several named effects are there, and something more that no known effect explains.
    Partial,
    /// Several do, and the runs cannot tell which.
    Ambiguous,
    /// Something is there that no known effect explains.
    OutsideCatalogue,
    /// There is no diagnosis: none was made, or the recording has a fatal finding.
    Failed,
}

/// One cause.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Cause {
    /// An id, several joined by `+`, `none` or `unknown`.
    pub effect: String,
    /// Its probability.
    pub probability: f64,
    /// Its parameters as estimated.
    #[serde(default)]
    pub parameters: BTreeMap<String, Estimate>,
    /// Names in the form of `effect` that these runs cannot tell from it.
    #[serde(default)]
    pub indistinguishable_from: Vec<String>,
    /// The class of effects that one recording seldom separates, where these runs do not separate its members.
    #[serde(default)]
    pub class: Option<String>,
}

/// A set of effects as weighed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EffectSet {
    /// Ids; none for the model without effects.
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

/// The gap as claimed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(default)]
pub struct ClaimedGap {
    /// Share of the gap that closes.
    pub closed: Option<f64>,
    /// Lower end of its 95 % interval.
    pub closed_lo95: Option<f64>,
    /// Upper end of its 95 % interval.
    pub closed_hi95: Option<f64>,
}

/// A set of effects: what a name such as `stribeck+inertia` stands for.
pub(super) type Names = BTreeSet<String>;

/// The set that a name stands for; `none` (and `parameters`) is the empty one.
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
    /// In words: what the document lacks.
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

    /// Every set that the verdict leaves standing: the one named, and those stated to be a tie with it.
    pub(super) fn standing(&self) -> Vec<Names> {
        let leading = self.leading();
        let mut standing = vec![leading.clone()];
        let mut add = |set: Names| {
            if !standing.contains(&set) {
                standing.push(set);
            }
        };
        // Up to the second shape "effect" is decided, whatever else the document states about that cause.
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
            // One member changed for a name that it cannot be told from.
            for member in &leading {
                for tied in self.ties(&names(member)) {
                    let mut other = leading.clone();
                    other.remove(member);
                    // A member that cannot be told from none may be absent.
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

    /// Whether it says that nothing is there, and of this set that these runs cannot tell it from nothing.
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

    /// The cause that is this set.
    pub(super) fn cause(&self, of: &Names) -> Option<&Cause> {
        self.causes.iter().find(|cause| names(&cause.effect) == *of)
    }

    /// Every set with its probability, likeliest first. `unknown` is always among the causes.
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

    /// Probability given to exactly a set.
    pub(super) fn probability(&self, of: &Names) -> f64 {
        if self.verdict == Word::Partial && *of == self.leading() {
            return self.of_verdict.unwrap_or(0.0);
        }
        let weighed = self.weighed();
        let of_it = weighed.iter().filter(|(set, _)| set == of);
        of_it.fold(0.0, |sum, (_, p)| sum + p).min(1.0)
    }

    /// The estimate of a parameter of an effect, in the fit of the set named first.
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
