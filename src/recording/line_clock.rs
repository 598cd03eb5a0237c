//! Sample time of a text board's lines, from its clock or from arrival times.
//!
//! A coarse clock repeats its stamps: 0.00, 0.01, 0.01, 0.02 for lines 5 ms apart. The sample time is then the
//! least-squares slope of the stamps over the line number, as for arrival times, which come in bursts. For a fine
//! clock it is the median step.

use crate::board::text_lines::TextSample;
use crate::motor::plausible;

/// Lines needed for the sample time of a fine clock.
const FEW_LINES: usize = 21;
/// Lines needed for a coarse clock or arrival times; or as many as arrive in this time in microseconds.
const MANY_LINES: usize = 201;
const LONG_ENOUGH_US: u64 = 3_000_000;
/// Least share of zero steps of a coarse clock: occasional repeated lines are one in twenty.
const REPEATS: f64 = 0.2;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LineClock {
    /// Sample time in microseconds.
    pub sample_time_us: i64,
    /// Resolution of a coarse clock in microseconds; 0 for a fine one.
    pub coarse_us: i64,
    /// Largest delay of the first line after its stamp, in microseconds.
    pub first_late_us: i64,
    /// The board's time is the time base.
    pub is_boards: bool,
}

/// Whether these lines with their arrival times suffice. `end_us` is the length of the recording, 0 if unlimited.
pub(super) fn are_enough(lines: &[(TextSample, u64)], end_us: u64) -> bool {
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else {
        return false;
    };
    if lines.len() < FEW_LINES {
        return false;
    }
    let times = times(lines);
    let is_fine = times.as_ref().is_some_and(|times| !repeats(times));
    let lasts_us = match &times {
        Some(times) => times[times.len() - 1].abs_diff(times[0]),
        None => last.1.saturating_sub(first.1),
    };
    let passed_us = last.1.saturating_sub(first.1).max(lasts_us);
    is_fine
        || lines.len() >= MANY_LINES
        || passed_us >= LONG_ENOUGH_US
        || (end_us > 0 && passed_us >= end_us)
}

/// Whether these lines suffice if the sample time is given: two of them show that the clock is fine, or there is
/// none.
pub(super) fn told(lines: &[(TextSample, u64)], stated_us: i64) -> bool {
    let Some(times) = times(lines) else {
        return true;
    };
    let is_told = |pair: &[i64]| {
        let step_us = pair[1].saturating_sub(pair[0]);
        2 * step_us > stated_us && 2 * step_us < 3 * stated_us
    };
    times.windows(2).any(is_told) || lines.len() >= FEW_LINES
}

/// The clock of these lines (at least one) with their arrival times.
pub(super) fn line_clock(lines: &[(TextSample, u64)]) -> LineClock {
    let arrivals = || lines.iter().map(|line| line.1 as i64).collect::<Vec<_>>();
    let range = plausible::SAMPLE_TIME_S;
    let (least_us, most_us) = ((1e6 * range.lo) as i64, (1e6 * range.hi) as i64);
    let fine = |sample_time_us: i64, is_boards: bool| LineClock {
        sample_time_us: sample_time_us.clamp(least_us, most_us),
        coarse_us: 0,
        first_late_us: 0,
        is_boards,
    };
    let Some(times) = times(lines) else {
        return fine(slope(&arrivals()), false);
    };
    let mut steps: Vec<i64> = (times.windows(2))
        .map(|pair| pair[1].saturating_sub(pair[0]))
        .collect();
    if !repeats(&times) {
        steps.sort_unstable();
        let median = steps.get(steps.len() / 2).copied().unwrap_or(0);
        // Damaged times give a step that no board samples at.
        return match median <= most_us {
            true => fine(median, true),
            false => fine(slope(&arrivals()), false),
        };
    }
    steps.retain(|step| *step > 0);
    let sample_time_us = slope(&times).max(least_us);
    let coarse_us = steps.iter().copied().min();
    let Some(coarse_us) = coarse_us.filter(|_| sample_time_us <= most_us) else {
        // A column that does not increase is no clock.
        return fine(slope(&arrivals()), false);
    };
    let late = times.iter().enumerate().map(|(k, time)| {
        let even = (k as i64).saturating_mul(sample_time_us);
        time.saturating_sub(times[0]).saturating_sub(even)
    });
    LineClock {
        sample_time_us,
        coarse_us,
        first_late_us: late.max().unwrap_or(0).clamp(0, coarse_us),
        is_boards: true,
    }
}

fn times(lines: &[(TextSample, u64)]) -> Option<Vec<i64>> {
    lines.iter().map(|(sample, _)| sample.time_us).collect()
}

/// Whether stamps repeat as those of a coarse clock.
fn repeats(times: &[i64]) -> bool {
    let steps = times.len().saturating_sub(1);
    let same = times.windows(2).filter(|pair| pair[0] == pair[1]).count();
    steps > 0 && same as f64 >= REPEATS * steps as f64
}

/// The step between lines: the slope of the regression line through these times.
fn slope(times: &[i64]) -> i64 {
    let (Some(&first), n) = (times.first(), times.len() as f64) else {
        return 0;
    };
    let middle = 0.5 * (n - 1.0);
    let (mut over, mut under) = (0.0, 0.0);
    for (k, time) in times.iter().enumerate() {
        let from_middle = k as f64 - middle;
        over += from_middle * time.saturating_sub(first) as f64;
        under += from_middle * from_middle;
    }
    if under > 0.0 {
        (over / under).round() as i64
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(time_us: impl Fn(i64) -> Option<i64>, n: i64) -> Vec<(TextSample, u64)> {
        let line = |k: i64| {
            let sample = TextSample {
                time_us: time_us(k),
                ..TextSample::default()
            };
            // Arrivals in bursts of four.
            (sample, (k / 4 * 4 * 5000) as u64)
        };
        (0..n).map(line).collect()
    }

    #[test]
    fn a_coarse_clock_and_arrivals_are_measured_over_many_lines() {
        let fine = lines(|k| Some(5000 * k), 21);
        assert!(are_enough(&fine, 0));
        assert_eq!(line_clock(&fine).sample_time_us, 5000);
        // Two decimals of a second at 5 ms, and at 4 ms.
        for (step_us, coarse_us) in [(5000, 10_000), (4000, 10_000), (500, 1000)] {
            let coarse = lines(|k| Some(step_us * k / coarse_us * coarse_us), 201);
            assert!(!are_enough(&coarse[..40], 0) && are_enough(&coarse, 0));
            let clock = line_clock(&coarse);
            assert!(
                (clock.sample_time_us - step_us).abs() <= step_us / 100,
                "{clock:?}"
            );
            assert_eq!((clock.coarse_us, clock.is_boards), (coarse_us, true));
        }
        let untimed = lines(|_| None, 201);
        assert!(!are_enough(&untimed[..100], 0) && are_enough(&untimed[..100], 400_000));
        let clock = line_clock(&untimed);
        assert!(
            (clock.sample_time_us - 5000).abs() < 20 && !clock.is_boards,
            "{clock:?}"
        );
        // A column that does not increase is no clock.
        assert!(!line_clock(&lines(|_| Some(7), 201)).is_boards);
        // Nor is one with a step of hours, as of a damaged time.
        let damaged = [412_648, 415_648, 41_864_424_648];
        let clock = line_clock(&lines(|k| Some(damaged[k as usize]), 3));
        assert!(
            !clock.is_boards && clock.sample_time_us <= 60_000_000,
            "{clock:?}"
        );
        assert_eq!(line_clock(&untimed[..1]).sample_time_us, 1);
    }
}
