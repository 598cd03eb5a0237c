//! The error of the nested models and its noise floor.

use serde::Serialize;

/// An error that the user accepts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GoodEnough {
    /// A position error in counts RMS.
    Counts(f64),
    /// A position error as a share of the travel of a segment, the median over segments: 0.01 is 1 %.
    Share(f64),
}

/// How the error is held out where runs are.
pub(crate) const HELD_OUT_RUNS: &str = "held-out runs";

/// Multi-step prediction error over segments in counts RMS, held out unless said otherwise.
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
    /// Travel of a segment in counts, the median.
    pub travel: f64,
    /// The nominal model.
    pub before: f64,
    /// With re-identified parameters.
    pub after_parameters: f64,
    /// With the effects of the verdict, or of the most probable set where none is identified.
    pub after_effect: f64,
    /// Share of the nominal reducible squared error that the model of the verdict removes.
    pub closed: f64,
    /// Lower end of its 95 % interval.
    pub closed_lo95: f64,
    /// Upper end.
    pub closed_hi95: f64,
    /// The same models on the data that they were fitted to.
    pub fitted: Fitted,
    /// How the data behind these figures was held out.
    pub held_out: String,
}

/// Parts of the noise floor, in counts RMS.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FloorParts {
    /// Error on simulated recordings of the re-identified motor: quantization.
    pub rounding: f64,
    /// Error of a perfect model on recordings with the random effects of the model (lost edges, late samples); none where it has none.
    pub random: Option<f64>,
    /// Difference between runs with the same commands, as one run's share; none where no commands repeat.
    pub repeats: Option<f64>,
    /// Error accepted by the user; none where none is stated.
    pub good_enough: Option<f64>,
}

impl FloorParts {
    /// The largest.
    pub fn largest(&self) -> f64 {
        let others = [self.random, self.repeats, self.good_enough];
        others.into_iter().flatten().fold(self.rounding, f64::max)
    }
}

/// Residual RMS in counts on the data that was fitted; it never rises from one to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fitted {
    /// The nominal model.
    pub before: f64,
    /// With re-identified parameters.
    pub after_parameters: f64,
    /// With the effects.
    pub after_effect: f64,
}
