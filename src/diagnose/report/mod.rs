//! What a diagnosis says and how its search went: plain data that the whole room may use, and that uses nothing of it.

mod asked;
mod bad_recording;
mod document;
mod gap;
mod next;
mod nominal;
mod other_means;
mod place;
mod predicted;
mod step;

pub(crate) use asked::asked;
pub use bad_recording::BadRecording;
pub use document::{
    Cause, Diagnosis, EffectSet, Evidence, Interval, ReferenceRuns, SHAPE, Verdict,
};
pub use gap::{Fitted, FloorParts, Gap, GoodEnough};
pub use next::{KnownChange, NextExperiment};
pub use nominal::{NominalSource, SeenMotor};
pub use other_means::other_means;
pub use place::{Place, Regime, Region};
pub use predicted::PredictedRun;
pub(crate) use step::{INVERSE_FORM, PREDICTION};
pub use step::{Rival, Step, Term};
