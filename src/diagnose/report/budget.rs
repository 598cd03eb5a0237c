//! The error budget: held-out squared error by step.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Regime, Region};

/// One step of the budget.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BudgetStep {
    /// `nominal`, `parameters`, the id of an effect, or `unexplained`.
    pub step: &'static str,
    /// Held-out RMS error in counts after the step.
    pub rms_counts: f64,
    /// Share of the nominal reducible squared error that the step removes; all of it for `nominal`, the remaining one
    /// for `unexplained`.
    pub share: f64,
    /// Lower end of its 95 % interval.
    pub lo95: f64,
    /// Upper end.
    pub hi95: f64,
    /// Effects that would remove as much in its place: members of its class, and rivals of other classes.
    pub alternatives: Vec<Alternative>,
}

/// An equivalent effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Alternative {
    /// Its id.
    pub effect: &'static str,
    /// Its inclusion probability.
    pub probability: f64,
}

/// Unexplained error.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Unexplained {
    /// Held-out RMS error in counts beyond the noise floor.
    pub rms_counts: f64,
    /// Share of the nominal reducible squared error.
    pub share: f64,
    /// Lower end of its 95 % interval.
    pub lo95: f64,
    /// Upper end.
    pub hi95: f64,
    /// The random load torque of equal effect, one sigma as a share of stall.
    pub equivalent_torque_share: f64,
    /// Its location: the share of each regime, whose sum is 1.
    pub regimes: BTreeMap<Regime, f64>,
    /// Time intervals with the largest shares; others are not listed.
    pub regions: Vec<Region>,
}
