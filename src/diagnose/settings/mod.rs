//! Settings of the method: one struct with documented defaults, passed in by [`Options`](super::Options).
//!
//! Tests and the sensitivity program (`tests/thorough/sensitivity`) change its fields. Limits of the solvers
//! ([`solver`]) and conventions ([`conventions`]) are separate; no other file of this module defines a constant.

pub(crate) mod conventions;
pub(crate) mod solver;

use serde::{Deserialize, Serialize};

/// Settings of the method. Defaults are conventions unless a data set is named.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Uncertainty in s of the board's clock at either end of a run, as seen by the host: earliest arrivals of a
    /// tenth of the samples.
    pub clock_reading_s: f64,
    /// Past samples from which the innovations of command and motion are computed.
    pub feedback_samples: usize,
    /// Least share of a command's innovation in closed loop: 0.97 and more, other recordings 0.15 and less.
    pub feedback_share: f64,
    /// Shortest segment in s: long against a gear motor's time constant, short against drift.
    pub segment_s: f64,
    /// Shortest segment in mechanical time constants, each at most one shortest segment: after three, 95 % of an
    /// initial state has decayed.
    pub segment_time_constants: f64,
    /// Fewest samples of a segment.
    pub segment_samples: usize,
    /// Most samples that are searched; longer recordings are represented by a stratified subset of segments.
    pub searched_samples: usize,
    /// Share of these samples that a quick answer searches.
    pub quick_share: f64,
    /// Most samples on which candidates are screened.
    pub screened_samples: usize,
    /// Fewest segments on which candidates are screened.
    pub screened_segments: usize,
    /// Simulated lead in s before a segment with an omitted past.
    pub lead_s: f64,
    /// Parts of the command range in either direction for the stratification of the subset.
    pub command_levels: f64,
    /// Half width in s of the regression for the initial speed of a segment; three times this for the detection of
    /// motion.
    pub start_window_s: f64,
    /// Standard deviation of an initial speed in addition to quantization, as a share of the top speed.
    pub start_speed_share: f64,
    /// Folds of the cross-validation (Hastie, Tibshirani, Friedman 2009, section 7.10); from this number of runs on
    /// the bootstrap draws runs.
    pub folds: usize,
    /// Relative standard deviation of a parameter for which the motor file states no tolerance.
    pub default_tolerance: f64,
    /// The same for a nominal motor that was fitted to the runs.
    pub fitted_tolerance: f64,
    /// Largest ratio between a base parameter and the motor file's value.
    pub largest_factor: f64,
    /// Relative standard deviation of base parameters between recordings of one axis: 3 K of winding temperature.
    pub same_axis: f64,
    /// Share of a range by which a bound may be exceeded if the range scales with the motor's parameters.
    pub beyond_range: f64,
    /// Least edge rate at which edges are lost, as a share of the edge rate at top speed: a slower decoder would not
    /// be used.
    pub least_rate_share: f64,
    /// Usual random load torque (one sigma, share of stall): benches have 0.3 to 1 %.
    pub usual_load: f64,
    /// Largest random load torque, as a share of stall, for the likelihood as score.
    pub credible_load: f64,
    /// Largest ratio of whitened squares to their expectation for the likelihood as score.
    pub credible_squares: f64,
    /// Steepness of the transition between the two scores.
    pub passage: usize,
    /// Screened sets fitted in the first round; later rounds, and all rounds within the noise floor, fit a third as many.
    pub fitted_sets: usize,
    /// Largest size of a set.
    pub most_effects: usize,
    /// Largest distance in nats from the best score of sets that the search fits, fits anew, simplifies and exchanges.
    pub near_best: f64,
    /// Exponent of the score in the posterior (learning rate; Wu and Martin 2020). Calibrated on tuning benches.
    pub learning_rate: f64,
    /// Prior log odds per effect in addition to `ln(catalogue)` with the likelihood as score. Calibrated on tuning
    /// benches.
    pub effect_log_odds: f64,
    /// Least inclusion probability of an effect or class that is identified (contract).
    pub identified: f64,
    /// Least share of the reducible error removed by re-identified parameters, and largest remaining share, for the
    /// verdict `parameters`; with a larger remaining share the verdict is `outside_catalogue` (contract).
    pub parameters_share: f64,
    /// Largest unexplained share in the verdict `effect` (contract); smaller shares are immaterial throughout.
    pub unexplained_share: f64,
    /// Least probability of a statement without reservation.
    pub confident: f64,
    /// Standard deviations within which a parameter agrees with the motor file, and two models are not separable.
    pub separable: f64,
    /// Longest proposed recording in s.
    pub longest_experiment_s: f64,
    /// Alternative supply of a proposed experiment, as a share of the usual one.
    pub other_supply: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            clock_reading_s: 0.5e-3,
            feedback_samples: 3,
            feedback_share: 0.5,
            segment_s: 1.0,
            segment_time_constants: 3.0,
            segment_samples: 40,
            searched_samples: 16_000,
            quick_share: 0.1,
            screened_samples: 2_000,
            screened_segments: 8,
            lead_s: 0.3,
            command_levels: 4.0,
            start_window_s: 0.015,
            start_speed_share: 0.02,
            folds: 5,
            default_tolerance: 0.05,
            fitted_tolerance: 0.5,
            largest_factor: 100.0,
            same_axis: 0.01,
            beyond_range: 1.5,
            least_rate_share: 0.2,
            usual_load: 0.01,
            credible_load: 0.02,
            credible_squares: 1.3,
            passage: 8,
            fitted_sets: 15,
            most_effects: 4,
            near_best: 12.0,
            learning_rate: 0.35,
            effect_log_odds: -1.0,
            identified: 0.5,
            parameters_share: 0.5,
            unexplained_share: 0.1,
            confident: 0.9,
            separable: 3.0,
            longest_experiment_s: 20.0,
            other_supply: 0.5,
        }
    }
}

impl Settings {
    /// Half width in s of the window for the detection of motion.
    pub(crate) fn speed_window_s(&self) -> f64 {
        3.0 * self.start_window_s
    }
}
