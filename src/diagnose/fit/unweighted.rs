//! The fit of the position error as it is shown: every sample alike, less what the measured starts of the pieces make, with prior rows
//! only.
//! Beside it a fit of the search in the same measure.

use super::fitted::{Fit, dot, surroundings, whitened};
use super::folds::out_of_fold;
use super::levenberg::{At, minimise};
use super::{Model, Starts, less_start};
use crate::diagnose::noise::{Noise, Whitener};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::ROUNDING;
use crate::motor::{CommandKind, Motor};

/// What a motor leaves of pieces.
#[derive(Debug, Clone)]
pub(crate) struct Left {
    pub motor: Motor,
    /// Its time constant in s.
    pub time_constant_s: f64,
    /// Recorded less predicted, less what the starts make, in counts.
    pub shown: Vec<f64>,
}

impl Left {
    /// What a model with these numbers leaves.
    pub fn new(pieces: &Pieces, model: &Model, kind: CommandKind, x: &[f64]) -> Option<Self> {
        let time_constant_s = surroundings(pieces, model, x, kind).time_constant_s;
        let motor = model.motor(x);
        let shown = Self::of(pieces, &motor, time_constant_s)?;
        Some(Self {
            motor,
            time_constant_s,
            shown,
        })
    }

    /// What a motor leaves.
    pub fn of(pieces: &Pieces, motor: &Motor, time_constant_s: f64) -> Option<Vec<f64>> {
        let (_, residual) = Starts::of(pieces, motor, time_constant_s)?;
        Some(less_start(pieces, time_constant_s, &residual))
    }

    pub fn sum(&self) -> f64 {
        dot(&self.shown, &self.shown)
    }
}

/// A model fitted so.
#[derive(Debug, Clone)]
pub(crate) struct Unweighted {
    pub left: Left,
    /// The same of each piece predicted by a fit on the other folds.
    pub predicted: Vec<f64>,
}

impl Unweighted {
    /// Sum of the squares as fitted, in counts^2.
    pub fn sum(&self) -> f64 {
        self.left.sum()
    }

    /// The same of what is predicted.
    pub fn predicted_sum(&self) -> f64 {
        dot(&self.predicted, &self.predicted)
    }
}

/// Fits a model from each of some starts. What is returned leaves no more than any start, nor than any fit.
pub(crate) fn unweighted(
    pieces: &Pieces,
    model: &Model,
    kind: CommandKind,
    starts: &[Vec<f64>],
) -> Option<Unweighted> {
    let mut tried: Vec<(Vec<f64>, Left)> = Vec::new();
    for start in starts {
        let mut x = start.clone();
        model.clamp(&mut x);
        let Some(left) = Left::new(pieces, model, kind, &x) else {
            continue;
        };
        let whitener = evenly(pieces, model, kind, &x, &left);
        tried.push((x.clone(), left));
        let mut minimised = |at: Option<At>| {
            let At { x, .. } = minimise(pieces, model, &whitener, at?, &|_| 0.0)?;
            let left = Left::new(pieces, model, kind, &x)?;
            tried.push((x.clone(), left));
            Some(x)
        };
        if let Some(x) = minimised(At::measured(pieces, model, x)) {
            minimised(At::about_its_own(pieces, model, kind, x));
        }
    }
    let (x, left) = (tried.into_iter()).min_by(|a, b| a.1.sum().total_cmp(&b.1.sum()))?;
    let whitener = evenly(pieces, model, kind, &x, &left);
    shown_by_folds(pieces, (model, &x), kind, (Noise::NONE, &whitener), left)
}

/// A fit of the search, whose noise weighs the samples, in the same measure.
pub(crate) fn as_weighed(pieces: &Pieces, kind: CommandKind, fit: &Fit) -> Option<Unweighted> {
    let left = Left::new(pieces, &fit.model, kind, &fit.x)?;
    let whitener = Whitener::new(pieces, &fit.around, fit.noise);
    shown_by_folds(
        pieces,
        (&fit.model, &fit.x),
        kind,
        (fit.noise, &whitener),
        left,
    )
}

/// What a fit with this noise leaves, and leaves of each piece where it is predicted from the others.
fn shown_by_folds(
    pieces: &Pieces,
    (model, x): (&Model, &[f64]),
    kind: CommandKind,
    (noise, whitener): (Noise, &Whitener),
    left: Left,
) -> Option<Unweighted> {
    let around = surroundings(pieces, model, x, kind);
    let (starts, _) = Starts::of(pieces, &left.motor, around.time_constant_s)?;
    let fit = whitened(pieces, model, x.to_vec(), (noise, around, starts), whitener)?;
    let shown = |residual: &[f64]| less_start(pieces, left.time_constant_s, residual);
    Some(Unweighted {
        predicted: out_of_fold(pieces, &fit, whitener, &shown),
        left,
    })
}

/// Weighs every sample alike, in units of what is left.
fn evenly(pieces: &Pieces, model: &Model, kind: CommandKind, x: &[f64], left: &Left) -> Whitener {
    let mean_square = left.sum() / left.shown.len().max(1) as f64;
    let around = surroundings(pieces, model, x, kind);
    Whitener::even(pieces, &around, mean_square.max(ROUNDING))
}
