//! The verdict in plain sentences, of four parts whatever it is.
//!
//! ```text
//! how large the gap is, and against what floor -> what causes it, and how sure -> how far it shrinks on data kept back -> what next
//! ```

mod cause;
mod note;
mod shrinks;
mod size;
#[cfg(test)]
mod tests;
mod what_next;

use super::since::Since;
use crate::diagnose::report::Diagnosis;

pub(crate) use note::note;

/// What a sentence says that is not in the document's own figures.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beside {
    /// Sets that are not told apart.
    pub tied: Vec<Vec<&'static str>>,
    /// Whether the same by direction is not told from one of them.
    pub is_by_direction: bool,
    /// Base numbers beyond their tolerances: key, times the file's.
    pub bent: Vec<(&'static str, f64)>,
    /// Strength of a load that wanders, one sigma as a share of the stall torque.
    pub wander_share: f64,
    /// Pieces that were searched, and all.
    pub pieces: usize,
    pub all_pieces: usize,
    /// Whether the floor says so, with something significant below it.
    pub is_by_floor: bool,
    /// Whether the predicted rungs are those of runs held out.
    pub is_held_out: bool,
    /// Whether something fatal was found in the recordings.
    pub is_doubtful: bool,
    /// Probability of something unknown.
    pub unknown: f64,
    /// What is said of the reference, where the runs are held against one.
    pub since: Option<Since>,
    /// The command that asked.
    pub asked: String,
    /// Share of what a plain motor leaves that the cause takes in the inverse form, where that decides.
    pub inverse_gain: Option<f64>,
}

/// The four parts.
pub(crate) fn parts(said: &Diagnosis, beside: &Beside) -> [String; 4] {
    [
        size::size(said, beside).join(" "),
        cause::cause(said, beside).join(" "),
        shrinks::shrinks(said, beside).join(" "),
        what_next::what_next(said, beside),
    ]
}
