//! The withheld part: the true cause of a case, as far as it is known.

use std::collections::BTreeMap;

use case_generator::{Case, OUTSIDE};
use serde::{Deserialize, Serialize};

use crate::motor::catalogue::{catalogue, find};
use crate::motor::nearest_name;

/// The truth of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// True cause.
    pub kind: TruthKind,
    /// The hidden effects; an id outside the catalogue if `kind` is `outside`.
    pub effects: Vec<TrueEffect>,
    /// Strength of each effect, if known: its change of the position in counts RMS over the runs.
    #[serde(default)]
    pub strength_counts: BTreeMap<String, f64>,
    /// Residual of all effects together after the parameters are re-identified within their tolerances, in
    /// counts RMS (linear estimate).
    #[serde(default)]
    pub beyond_refit_counts: Option<f64>,
    /// Error of the true motor on the held-out run, because its random load is unknown, in counts RMS.
    #[serde(default)]
    pub unseen_floor_counts: Option<f64>,
    /// Standard deviation of the random load torque as a share of the stall torque, if known; 0 without one.
    #[serde(default)]
    pub random_load_share: Option<f64>,
    /// Whether one plain step is all that is recorded, if known.
    #[serde(default)]
    pub one_step: Option<bool>,
}

/// True cause of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TruthKind {
    /// Nothing beyond the tolerances.
    None,
    /// One effect of the catalogue.
    Single,
    /// Two or more effects of the catalogue.
    Pair,
    /// A cause outside the catalogue.
    Outside,
}

/// An effect with its known parameters, under the names of a motor file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrueEffect {
    /// Its id.
    pub id: String,
    /// True values in SI.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
}

/// An invalid label.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadLabel {
    /// An unknown effect.
    #[error(
        "'{name}' is no effect of the catalogue\nhint: {}give 'none', an effect's id, several joined by '+', or \
         'outside:WORDS' for something that the catalogue does not have",
        nearest.map_or(String::new(), |id| format!("did you mean '{id}'? "))
    )]
    Unknown {
        /// The name given.
        name: String,
        /// The nearest id.
        nearest: Option<&'static str>,
    },
    /// An effect twice.
    #[error("'{0}' is named twice\nhint: name each effect once")]
    Twice(String),
}

impl Truth {
    /// Parses `none`, ids of the catalogue joined by `+`, or `outside:WORDS`.
    ///
    /// # Errors
    /// A name that the catalogue does not have: a typing error must not become an outside effect.
    pub fn from_words(words: &str) -> Result<Self, BadLabel> {
        let effect = |id: &str| TrueEffect {
            id: id.to_owned(),
            parameters: BTreeMap::new(),
        };
        let (kind, effects) = if words == "none" {
            (TruthKind::None, Vec::new())
        } else if let Some(outside) = words.strip_prefix("outside:") {
            (TruthKind::Outside, vec![effect(outside.trim())])
        } else {
            let mut effects: Vec<TrueEffect> = Vec::new();
            for id in words.split('+').map(str::trim) {
                if find(id).is_none() {
                    return Err(BadLabel::Unknown {
                        name: id.to_owned(),
                        nearest: nearest_name(id, catalogue().iter().map(|kind| kind.id)),
                    });
                }
                if effects.iter().any(|known| known.id == id) {
                    return Err(BadLabel::Twice(id.to_owned()));
                }
                effects.push(effect(id));
            }
            let kind = if effects.len() == 1 {
                TruthKind::Single
            } else {
                TruthKind::Pair
            };
            (kind, effects)
        };
        Ok(Self {
            kind,
            effects,
            strength_counts: BTreeMap::new(),
            beyond_refit_counts: None,
            unseen_floor_counts: None,
            random_load_share: None,
            one_step: None,
        })
    }

    /// Ids of the hidden effects in alphabetical order.
    pub fn ids(&self) -> Vec<&str> {
        let mut ids: Vec<&str> = self.effects.iter().map(|e| e.id.as_str()).collect();
        ids.sort_unstable();
        ids
    }

    /// The truth as text, as [`Truth::from_words`] parses it.
    pub fn words(&self) -> String {
        match self.kind {
            TruthKind::None => "none".to_owned(),
            TruthKind::Outside => format!("outside:{}", self.ids().join("+")),
            TruthKind::Single | TruthKind::Pair => self.ids().join("+"),
        }
    }

    /// Strength of the weakest effect in counts RMS, if known.
    pub fn weakest_counts(&self) -> Option<f64> {
        self.strength_counts.values().copied().reduce(f64::min)
    }
}

impl From<Case> for Truth {
    fn from(case: Case) -> Self {
        let label = case.label;
        let random_load_share = label.random_load_share();
        let outside = label
            .effects
            .iter()
            .any(|e| OUTSIDE.contains(&e.id.as_str()));
        let kind = match label.effects.len() {
            _ if outside => TruthKind::Outside,
            0 => TruthKind::None,
            1 => TruthKind::Single,
            _ => TruthKind::Pair,
        };
        Self {
            kind,
            effects: label
                .effects
                .into_iter()
                .map(|effect| TrueEffect {
                    id: effect.id,
                    parameters: effect.parameters,
                })
                .collect(),
            strength_counts: label.strength_counts,
            beyond_refit_counts: Some(label.beyond_refit_counts),
            unseen_floor_counts: Some(label.unseen_floor_counts),
            random_load_share: Some(random_load_share),
            one_step: Some(matches!(&case.runs[..], [run] if run.profile.name == "step")),
        }
    }
}
