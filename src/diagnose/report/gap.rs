//! How far the gap shrinks, as plain data: the rungs, the floor with its parts, what a wandering load leaves.

use serde::Serialize;

/// What a user calls good enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GoodEnough {
    /// A position error in counts RMS.
    Counts(f64),
    /// A position error as a share of the travel of a piece, the median of the pieces: 0.01 is 1 %.
    Share(f64),
}

/// The rungs in counts RMS over pieces, each predicted by fits on other pieces, so that they may rise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// What is measured.
    pub metric: &'static str,
    /// How far ahead a piece is predicted, in s; the median of the pieces.
    pub horizon_s: f64,
    /// What is not asked to be explained, in counts: the largest of its parts.
    pub floor: f64,
    /// Its parts.
    pub floor_parts: FloorParts,
    /// What a load that wanders leaves beside the floor, in counts RMS.
    pub wander: f64,
    /// Travel of a piece, in counts; the median of the pieces.
    pub travel: f64,
    /// The nominal model.
    pub before: f64,
    /// The same model refitted.
    pub after_parameters: f64,
    /// The model with the effects.
    pub after_effect: f64,
    /// `1 - (after - floor) / (before - floor)`; 0 where the gap does not exceed the floor by more than its own error.
    pub closed: f64,
    /// Lower end of its 95 % interval.
    pub closed_lo95: f64,
    /// Upper end.
    pub closed_hi95: f64,
    /// The same rungs on the data that was fitted: they never rise.
    pub fitted: Fitted,
    /// How the data behind these figures was kept from every fit.
    pub held_out: String,
    /// 95 % intervals of `before`, `after_parameters` and `after_effect`.
    #[serde(skip)]
    pub rungs95: [(f64, f64); 3],
}

/// Parts of the floor, in counts RMS.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FloorParts {
    /// What the encoder's rounding leaves of a right model.
    pub rounding: f64,
    /// What runs of the same commands differ by, as one run's share; none where no commands repeat.
    pub repeats: Option<f64>,
    /// What the user calls good enough; none where nothing is said.
    pub good_enough: Option<f64>,
}

/// Rungs on the data that was fitted, in counts RMS over pieces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fitted {
    /// The nominal model.
    pub before: f64,
    /// The same model refitted.
    pub after_parameters: f64,
    /// The model with the effects.
    pub after_effect: f64,
}
