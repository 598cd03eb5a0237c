//! The error budget: held-out squared error by step.

use serde::Serialize;

use super::Region;

/// One step of the budget.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BudgetStep {
    /// `nominal`, `parameters`, the id of an effect, or `unexplained`.
    pub step: &'static str,
    /// Held-out RMS error in counts after the step.
    pub rms_counts: f64,
    /// Share of the nominal reducible squared error that the step removes; of `nominal` all of it; of `unexplained` what is left.
    pub share: f64,
    /// Lower end of its 95 % interval.
    pub lo95: f64,
    /// Upper end.
    pub hi95: f64,
    /// Effects that would remove as much in its place.
    pub alternatives: Vec<Alternative>,
}

/// An effect that would do as well.
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
    /// The random load torque that would leave as much, one sigma as a share of stall.
    pub equivalent_torque_share: f64,
    /// Where it lies: time intervals with the largest shares.
    pub regions: Vec<Region>,
}
