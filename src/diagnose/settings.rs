//! Every number of the method: one struct with documented defaults, passed in by [`Options`](super::Options).
//!
//! A test or the sensitivity program changes a field; nothing else in this module defines a number of the method.

use serde::{Deserialize, Serialize};

/// Numbers of the method. Defaults are conventions where no data set is named.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Lowest rate above which edges are lost, as a share of the edge rate at top speed: a slower decoder would not be used.
    pub least_rate_share: f64,
    /// Shortest segment in s: long against a gear motor's time constant, short against drift.
    pub segment_s: f64,
    /// Shortest segment in mechanical time constants: after three, 95 % of a start is forgotten.
    pub segment_time_constants: f64,
    /// Longest time constant in s that lengthens segments.
    pub longest_time_constant_s: f64,
    /// Fewest samples of a segment.
    pub segment_samples: usize,
    /// Most samples that are searched; longer recordings are represented by a stratified subset of segments.
    pub searched_samples: usize,
    /// Most samples on which candidates are screened.
    pub screened_samples: usize,
    /// Fewest segments on which candidates are screened.
    pub screened_segments: usize,
    /// Simulated time in s before a segment whose past is left out.
    pub lead_s: f64,
    /// Parts of the command range, in either direction, that the subset is stratified by.
    pub command_levels: f64,
    /// Half width in s of the window that decides whether the shaft moves.
    pub speed_window_s: f64,
    /// Half width in s of the regression that gives the initial speed of a segment.
    pub start_window_s: f64,
    /// Standard deviation of an initial speed beside quantization, as a share of the top speed.
    pub start_speed_share: f64,
    /// Folds of the cross-validation (Hastie, Tibshirani, Friedman 2009, section 7.10).
    pub folds: usize,
    /// Relative standard deviation of a parameter for which the motor file states no tolerance.
    pub default_tolerance: f64,
    /// The same of a nominal motor that was fitted to the runs.
    pub fitted_tolerance: f64,
    /// Largest factor between a base parameter and the motor file's value.
    pub largest_factor: f64,
    /// Relative standard deviation of base parameters between recordings of one axis: 3 K of winding temperature.
    pub same_axis: f64,
    /// Share of a range by which a bound may be exceeded where the range scales with the motor's parameters.
    pub beyond_range: f64,
    /// A base parameter within so many tolerances agrees with the motor file.
    pub within_tolerances: f64,
    /// Usual random load torque (one sigma, share of stall): benches show 0.3 to 1 %.
    pub usual_load: f64,
    /// Largest random load torque, as a share of stall, under which the likelihood is used as the score.
    pub credible_load: f64,
    /// Largest ratio of whitened squares to their expectation under which it is used.
    pub credible_squares: f64,
    /// Screened sets that are fitted in the first round; later rounds fit a third as many.
    pub fitted_sets: usize,
    /// Most effects of a set.
    pub most_effects: usize,
    /// Sets within so many units of the score of the best are simplified and exchanged by the search.
    pub near_best: f64,
    /// Exponent of the score in the posterior (learning rate; Wu and Martin 2020). Calibrated on tuning benches.
    pub learning_rate: f64,
    /// Prior log odds per effect beside `ln(catalogue)` where the likelihood is the score. Calibrated on tuning benches.
    pub effect_log_odds: f64,
    /// Least inclusion probability of an effect or class that is identified (contract).
    pub identified: f64,
    /// Least share of the reducible error that re-identified parameters remove in the verdict `parameters` (contract).
    pub parameters_share: f64,
    /// Largest unexplained share in the verdict `effect` (contract).
    pub unexplained_share: f64,
    /// Least unexplained share in the verdict `outside_catalogue` (contract).
    pub outside_share: f64,
    /// Probability from which a statement is made without reservation.
    pub confident: f64,
    /// Draws of the bootstrap.
    pub draws: usize,
    /// From so many runs on the bootstrap draws runs, not segments.
    pub clustered_runs: usize,
    /// Separation in standard deviations below which two models are not separable.
    pub separable: f64,
    /// Most sets that a next experiment is to separate.
    pub sets_to_separate: usize,
    /// Longest proposed recording in s.
    pub longest_experiment_s: f64,
    /// Most samples of a planned recording that is simulated.
    pub planned_samples: usize,
    /// Another supply that is proposed, as a share of the usual one.
    pub other_supply: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            least_rate_share: 0.2,
            segment_s: 1.0,
            segment_time_constants: 3.0,
            longest_time_constant_s: 1.0,
            segment_samples: 40,
            searched_samples: 16_000,
            screened_samples: 2_000,
            screened_segments: 8,
            lead_s: 0.3,
            command_levels: 4.0,
            speed_window_s: 0.045,
            start_window_s: 0.015,
            start_speed_share: 0.02,
            folds: 5,
            default_tolerance: 0.05,
            fitted_tolerance: 0.5,
            largest_factor: 100.0,
            same_axis: 0.01,
            beyond_range: 1.5,
            within_tolerances: 3.0,
            usual_load: 0.01,
            credible_load: 0.02,
            credible_squares: 1.3,
            fitted_sets: 15,
            most_effects: 4,
            near_best: 6.0,
            learning_rate: 0.35,
            effect_log_odds: -1.0,
            identified: 0.5,
            parameters_share: 0.5,
            unexplained_share: 0.1,
            outside_share: 0.5,
            confident: 0.9,
            draws: 1000,
            clustered_runs: 5,
            separable: 3.0,
            sets_to_separate: 6,
            longest_experiment_s: 20.0,
            planned_samples: 1_500,
            other_supply: 0.5,
        }
    }
}
