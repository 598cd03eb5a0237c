//! Location of the error, as plain data: stage of the chain, and time intervals of the runs with their regimes.

use std::collections::BTreeMap;

use serde::Serialize;

/// Location of the error.
#[derive(Debug, Clone, Serialize)]
pub struct Place {
    /// Stage of the named effects, joined by `+`; `None` without any.
    pub stage: Option<String>,
    /// Probability of each stage, given that a named effect is present.
    pub stage_probabilities: BTreeMap<&'static str, f64>,
    /// Time intervals with the largest shares of the error; others are not listed.
    pub regions: Vec<Region>,
}

/// A time interval of a run with one regime.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Region {
    /// Path of the run, or its number from 1.
    pub run: String,
    /// Begin in s.
    pub from_s: f64,
    /// End in s.
    pub to_s: f64,
    /// Its regime.
    pub regime: Regime,
    /// Its share of the squared error, 0 to 1.
    pub share: f64,
}

/// Regime of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Regime {
    /// At rest.
    Standstill,
    /// Leaving rest.
    Breakaway,
    /// Slow motion.
    LowSpeed,
    /// Steady motion.
    Steady,
    /// Increasing speed.
    Accelerating,
    /// Decreasing speed while driven.
    Braking,
    /// Reversing direction.
    Reversal,
    /// Motion without a command.
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
