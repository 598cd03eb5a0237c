//! Range checks: runs that the readers refuse are not written.

use super::error::RowProblem;
use crate::motor::plausible;

/// Range of times before the first row is subtracted: since 1970 in microseconds, a run's range in seconds.
pub(super) const ANY_TIME: plausible::Range = plausible::Range {
    lo: -1e15,
    hi: 1e15,
    ..plausible::TIME_S
};

/// A value that a run file can have.
pub(super) fn within(
    what: &'static str,
    value: f64,
    range: plausible::Range,
) -> Result<f64, RowProblem> {
    if range.holds(value) {
        Ok(value)
    } else {
        Err(RowProblem::Implausible {
            what,
            value: plausible::Shown(value).to_string(),
            range: range.to_string(),
        })
    }
}

/// Time rounded to nanoseconds, which removes errors of the subtraction.
pub(super) fn nanoseconds(t_s: f64) -> f64 {
    (t_s * 1e9).round() / 1e9
}
