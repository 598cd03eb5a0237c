//! Result types: plain data.

mod asked;
mod bad_recording;
mod budget;
mod display;
mod document;
mod gap;
mod identifiable;
mod next;
mod nominal;
mod place;
mod predicted;
mod step;

pub(crate) use asked::asked;
pub use bad_recording::BadRecording;
pub use budget::{Alternative, BudgetStep, Unexplained};
pub(crate) use document::without_assumed_unit;
pub use document::{
    Cause, CommandInterval, Diagnosis, EffectClass, EffectSet, Interval, Quick, ReferenceRuns,
    SHAPE, Scoring, Verdict,
};
pub(crate) use gap::{CROSS_VALIDATION, HELD_OUT_RUNS};
pub use gap::{Fitted, FloorParts, Gap, GoodEnough};
pub use identifiable::{Identifiable, KnownTorque, MotorFileValues};
pub use next::{KnownChange, NextExperiment};
pub use nominal::NominalSource;
pub use place::{Place, Regime, Region};
pub use predicted::PredictedRun;
pub use step::SearchStep;
