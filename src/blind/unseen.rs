//! Claimed error reduction, compared with the held-out run.
//!
//! `closed = 1 - (after - floor)/(before - floor)`: `before` with the nominal motor file, `after` with that of the
//! diagnosis, `floor` the quantization error (0.289), all RMS in counts over the run simulated in open loop from
//! rest. As in a diagnosis, it is clamped to -1 ... 1.

use std::path::Path;

use serde::Serialize;

use super::{BlindError, OpenedCase};
use crate::compare::{FLOOR_COUNTS, compare};
use crate::motor::{Model, Motor, read_motor};
use crate::recording::{Run, read_run};

/// Claimed and measured error reduction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GapCheck {
    /// Claimed reduction.
    pub claimed: Option<f64>,
    /// Its 95 % interval.
    pub claimed_interval: Option<(f64, f64)>,
    /// Reduction on the held-out run; `None` if the nominal motor is at the floor already.
    pub unseen: Option<f64>,
    /// Error of the nominal motor on the held-out run in counts RMS.
    pub before_counts: f64,
    /// Error of the diagnosed motor on the held-out run in counts RMS.
    pub after_counts: f64,
}

/// Least reducible error in counts RMS: below, its reduction is undefined.
const LEAST_GAP_COUNTS: f64 = 0.1;

/// Simulates the held-out run with both motor files; `None` without a held-out run or a motor file.
///
/// # Errors
/// The held-out run or the nominal motor cannot be read; an invalid motor file of the diagnosis counts as none.
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

/// Reduction of the error above the floor.
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
    fn shares_are_within_the_range_of_a_diagnosis() {
        assert_eq!(closed(10.0, 0.9 * FLOOR_COUNTS), Some(1.0));
        assert_eq!(closed(10.0, 10.0), Some(0.0));
        assert_eq!(closed(10.0, 100.0), Some(-1.0));
        assert_eq!(closed(1.01 * FLOOR_COUNTS, 0.0), None);
    }
}
