//! Claimed error, compared with a held-out run.
//!
//! `closed = 1 - (after - floor)/(before - floor)`: before with the nominal motor file, after with the one
//! that the diagnosis wrote, floor what rounding to counts leaves (0.289), all RMS in counts of the whole
//! run simulated in open loop from rest. As a diagnosis says it: 1 where no more is left than the floor, -1 at least.

use std::path::Path;

use serde::Serialize;

use super::{BlindError, OpenedCase};
use crate::compare::{FLOOR_COUNTS, compare};
use crate::motor::{Model, Motor, read_motor};
use crate::recording::{Run, read_run};

/// Error as claimed and as measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GapCheck {
    /// Share of the gap said to close.
    pub claimed: Option<f64>,
    /// Its 95 % interval.
    pub claimed_interval: Option<(f64, f64)>,
    /// Share that closed on the unseen run; none where the nominal motor is at the floor already.
    pub unseen: Option<f64>,
    /// Error of the nominal motor on the unseen run in counts RMS.
    pub before_counts: f64,
    /// Error of the diagnosed motor on the unseen run in counts RMS.
    pub after_counts: f64,
}

/// A gap smaller than this many counts RMS is none: its share says nothing.
const LEAST_GAP_COUNTS: f64 = 0.1;

/// Simulates the unseen run with both motor files; none where there is no unseen run or no motor file.
///
/// # Errors
/// The unseen run or the nominal motor cannot be read; a motor file of the diagnosis that is no motor
/// file counts as none.
pub fn measure_gap(directory: &Path, case: &OpenedCase) -> Result<Option<GapCheck>, BlindError> {
    let (Some(unseen), Some(model)) = (&case.sealed.unseen, &case.verdict.model) else {
        return Ok(None);
    };
    let path = directory.join(unseen);
    let (run, _) = read_run(&path).map_err(|error| BlindError::content(&path, error))?;
    let motor_path = directory.join(&case.sealed.motor);
    let nominal =
        read_motor(&motor_path).map_err(|error| BlindError::content(&motor_path, error))?;
    let Ok(diagnosed) = Motor::from_toml(model) else {
        return Ok(None);
    };
    let (Some(before_counts), Some(after_counts)) =
        (error_counts(&run, &nominal), error_counts(&run, &diagnosed))
    else {
        return Ok(None);
    };
    Ok(Some(GapCheck {
        claimed: None,
        claimed_interval: None,
        unseen: closed(before_counts, after_counts),
        before_counts,
        after_counts,
    }))
}

/// Share of the gap above the floor that is gone.
pub(super) fn closed(before_counts: f64, after_counts: f64) -> Option<f64> {
    let gap = before_counts - FLOOR_COUNTS;
    let left = (after_counts - FLOOR_COUNTS).max(0.0);
    (gap >= LEAST_GAP_COUNTS).then(|| (1.0 - left / gap).max(-1.0))
}

fn error_counts(run: &Run, motor: &Motor) -> Option<f64> {
    let overlay = compare(run, motor, Model::SecondOrder).ok()?;
    Some(overlay.figures.position_rmse_counts).filter(|error| error.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error below the noise floor counts as removed, and a larger error does not.
    #[test]
    fn a_share_lies_where_a_diagnosis_may_say_it() {
        assert_eq!(closed(10.0, 0.9 * FLOOR_COUNTS), Some(1.0));
        assert_eq!(closed(10.0, 10.0), Some(0.0));
        assert_eq!(closed(10.0, 100.0), Some(-1.0));
        assert_eq!(closed(1.01 * FLOOR_COUNTS, 0.0), None);
    }
}
