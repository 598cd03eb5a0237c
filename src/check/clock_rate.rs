//! Rate error of the board's clock relative to the host's.

use super::finding::{Finding, Kind, Severity};
use super::host_clock::host_clock;
use super::subject::Subject;

/// Tolerance of a ceramic resonator, as on an Arduino Uno (data sheet value).
const RESONATOR: f64 = 0.005;
/// Scatter of the earliest arrivals in s: a USB bridge flushes every 1 to 16 ms.
const ARRIVALS_S: f64 = 0.004;
/// Largest rate error that is a clock error: the catalogue's `clock_error` ends at 0.1. Beyond it a simulated board
/// may run faster than real time.
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
