//! The stated sample time compared with the times.
//!
//! The median of the file's own steps, which an import and a recorder of text lines write into the header where no
//! sample time was stated, is not a statement.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;
use super::words::time;
use crate::recording::text_capture::MEASURED;
use crate::recording::{Run, Steps};

/// Tolerance: that of a ceramic resonator.
const TOLERANCE: f64 = 0.005;
/// Largest deviation in standard errors.
const STANDARD_ERRORS: f64 = 4.0;
/// Scatter of arrivals at the host in s (USB bridges flush every 16 ms at most, a busy host adds as much again).
const ARRIVALS_S: f64 = 0.04;

pub(super) fn stated_s(run: &Run) -> Option<f64> {
    let stated_s = run.sample_time_s;
    let measured = run.header.get("sample_time").and_then(toml::Value::as_str) == Some(MEASURED);
    if measured || !(run.header.is_empty() || run.header.contains_key("sample_time_s")) {
        return None;
    }
    // A recorder of text lines uses 21 lines, an import 4096 rows, a reader all.
    let own = [21, 4096, run.len()].into_iter().any(|first| {
        let mut steps_s: Vec<f64> = (run.t_s.windows(2).take(first - 1))
            .map(|pair| pair[1] - pair[0])
            .collect();
        let middle = steps_s.len() / 2;
        steps_s.sort_by(f64::total_cmp);
        // An import rounds to nanoseconds.
        (steps_s.get(middle)).is_some_and(|median_s| (median_s - stated_s).abs() < 1e-9)
    });
    (!own && stated_s.is_finite()).then_some(stated_s)
}

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let (Some(stated_s), Some(intervals)) = (stated_s(run), Steps::of(run)) else {
        return Vec::new();
    };
    let n = intervals.len() as f64;
    let median_s = intervals.median_s();
    let longest_s = if run.is_host_timed() {
        f64::INFINITY
    } else {
        intervals.longest_usual_s()
    };
    let mean_s = intervals.mean_s(longest_s);
    // Standard error of the median of a uniform distribution; that of the mean is smaller.
    let scatter_s = if run.is_host_timed() {
        ARRIVALS_S / n
    } else {
        STANDARD_ERRORS * 0.5 * intervals.spread_s() / n.sqrt()
    };
    let off = |step_s: f64| {
        let excess_s = (step_s - stated_s).abs() - TOLERANCE * stated_s - scatter_s;
        excess_s > 0.0
    };
    // Times in whole milliseconds shift the median, late samples the mean: both must deviate in the same direction.
    // Lines that arrive in bursts have no useful median.
    let same_way = (median_s > stated_s) == (mean_s > stated_s);
    let contradicts = if run.is_host_timed() {
        off(mean_s)
    } else {
        off(median_s) && off(mean_s) && same_way
    };
    if !contradicts {
        return Vec::new();
    }
    vec![subject.finding(
        Kind::SampleTimeContradicts,
        Severity::Warning,
        subject.whole(),
        format!(
            "the sample time is stated as {}, and the samples come every {}",
            time(stated_s),
            time(mean_s)
        ),
        [
            ("stated_s", stated_s),
            ("mean_step_s", mean_s),
            ("median_step_s", median_s),
            ("steps", n),
        ],
        "state what the board does: --ts of the capture, sample_time_s of the mapping or of the header; or leave it out, and the times are taken",
    )]
}
