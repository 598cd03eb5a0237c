//! The error of the nested models and its noise floor.

use serde::Serialize;

/// The error accepted by the user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GoodEnough {
    /// A position error in counts RMS.
    Counts(f64),
    /// A position error relative to the median travel of a segment: 0.01 is 1 %.
    Share(f64),
}

/// Names of the methods with held-out runs, and without.
pub(crate) const HELD_OUT_RUNS: &str = "held-out runs";
pub(crate) const CROSS_VALIDATION: &str = "cross-validation over segments";

/// Multi-step prediction error over segments in counts RMS, held out unless stated otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// Measured quantity.
    pub metric: &'static str,
    /// Prediction horizon in s, the median length of the segments.
    pub horizon_s: f64,
    /// Noise floor in counts RMS: the largest of its parts.
    pub floor: f64,
    /// Its parts.
    pub floor_parts: FloorParts,
    /// Median travel of a segment in counts.
    pub travel: f64,
    /// The nominal model.
    pub before: f64,
    /// With re-identified parameters.
    pub after_parameters: f64,
    /// With the effects of the verdict, or of the most probable set if none is identified.
    pub after_effect: f64,
    /// Share of the nominal reducible squared error that the model of the verdict removes.
    pub closed: f64,
    /// Lower end of its 95 % interval.
    pub closed_lo95: f64,
    /// Upper end.
    pub closed_hi95: f64,
    /// Errors of the same models on the training data.
    pub fitted: Fitted,
    /// Method of holding data out.
    pub held_out: String,
}

/// Parts of the noise floor, in counts RMS.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FloorParts {
    /// Residual for simulated recordings of the re-identified motor: quantization.
    pub rounding: f64,
    /// Residual of a perfect model for recordings with its random effects (lost edges, late samples) and, where no
    /// effect is identified or more probable than none, the estimated random load torque; `None` without either.
    pub random: Option<f64>,
    /// Repeatability: difference between runs with the same commands, as one run's share; `None` if no commands
    /// repeat.
    pub repeats: Option<f64>,
    /// Accepted error; `None` if none is stated.
    pub good_enough: Option<f64>,
}

impl FloorParts {
    /// The largest.
    pub fn largest(&self) -> f64 {
        let others = [self.random, self.repeats, self.good_enough];
        others.into_iter().flatten().fold(self.rounding, f64::max)
    }
}

/// Residual RMS in counts on the training data; non-increasing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fitted {
    /// The nominal model.
    pub before: f64,
    /// With re-identified parameters.
    pub after_parameters: f64,
    /// With the effects.
    pub after_effect: f64,
}
