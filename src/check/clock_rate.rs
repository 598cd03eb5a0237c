//! The board's clock runs at another rate than the host's.

use super::finding::{Finding, Kind, Severity};
use super::host_clock::host_clock;
use super::subject::Subject;

/// A ceramic resonator, as on an Arduino Uno, is off by at most this share (the usual data sheet's tolerance).
const RESONATOR: f64 = 0.005;
/// The earliest arrivals scatter by so much in s: a USB bridge flushes every 1 to 16 ms, and the earliest come just before.
const ARRIVALS_S: f64 = 0.004;
/// Further off than this share it is no clock that is off: the catalogue's `clock_error` ends at 0.1. A simulated board may
/// be in a hurry.
pub(super) const WIDEST: f64 = 0.12;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let Some((error, span_s)) = host_clock(subject.run) else {
        return Vec::new();
    };
    let least = RESONATOR.max(ARRIVALS_S / span_s);
    if error.abs() <= least || error.abs() > WIDEST {
        return Vec::new();
    }
    vec![subject.finding(
        Kind::ClockRate,
        Severity::Warning,
        subject.whole(),
        format!(
            "the host's clock says that a second of the board lasts {:.4} s",
            1.0 + error
        ),
        [
            ("board_second_s", 1.0 + error),
            ("least_error", least),
            ("span_s", span_s),
        ],
        "the board's crystal, its clock setting or a timer's divider is off: correct it, or speeds and times have the same relative error",
    )]
}
