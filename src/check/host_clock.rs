//! The board's clock as the host saw it: its rate, and where it stood still.
//!
//! An arrival is late by a scatter, never early: the earliest tell. With the offsets `o_k = host_k - board_k` the rate is
//! off by the slope of a line through the earliest of the first and of the last tenth. Where the board stood still and did
//! not know, all later offsets are larger: between the earliest of the [`BEFORE_S`] before a sample and the earliest of the
//! [`AFTER_S`] from it on there is a step, which no late arrival makes, since what comes late is followed by what does not.
//! Such steps are taken off before the slope is measured.

use crate::recording::Run;

/// How long before and after it a step is looked for, in s, and with how many samples at least.
const BEFORE_S: f64 = 0.15;
const AFTER_S: f64 = 1.0;
const LEAST_SAMPLES: usize = 6;
/// Shortest stand that is told from scatter, in s, and as a multiple of the scatter.
const LEAST_S: f64 = 0.004;
const SCATTERS: f64 = 4.0;

/// Where the board's clock stood still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stand {
    /// Number of the first sample after it.
    pub sample: usize,
    /// For how long, in s.
    pub lost_s: f64,
}

/// By how much the board's clock is off as the host saw it, and the time in s between first and last look;
/// `None` where only one clock was there.
pub(crate) fn host_clock(run: &Run) -> Option<(f64, f64)> {
    let offsets = offsets(run)?;
    let stands = stands_in(&run.t_s, &offsets);
    slope(&run.t_s, &without(offsets, &stands))
}

/// Where the board's clock stood still, by the host's; nowhere where only one clock was there.
pub(crate) fn stands(run: &Run) -> Vec<Stand> {
    offsets(run).map_or_else(Vec::new, |offsets| stands_in(&run.t_s, &offsets))
}

fn offsets(run: &Run) -> Option<Vec<f64>> {
    if run.is_host_timed() {
        return None;
    }
    let host = run.host_t_s.as_ref()?;
    Some(host.iter().zip(&run.t_s).map(|(h, t)| h - t).collect())
}

fn without(mut offsets: Vec<f64>, stands: &[Stand]) -> Vec<f64> {
    for stand in stands {
        for offset in &mut offsets[stand.sample..] {
            *offset -= stand.lost_s;
        }
    }
    offsets
}

/// Slope through the earliest arrivals of the first and the last tenth, and the time between them.
fn slope(t_s: &[f64], offsets: &[f64]) -> Option<(f64, f64)> {
    let n = offsets.len();
    let tenth = (n / 10).max(1);
    let earliest = |range: std::ops::Range<usize>| {
        let late = range.map(|k| (offsets[k], t_s[k]));
        late.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (first, last) = (earliest(0..tenth)?, earliest(n.saturating_sub(tenth)..n)?);
    let span_s = last.1 - first.1;
    let error = (last.0 - first.0) / span_s;
    (error.is_finite() && span_s > 0.0).then_some((error, span_s))
}

fn stands_in(t_s: &[f64], offsets: &[f64]) -> Vec<Stand> {
    let n = offsets.len();
    let (Some(first), Some(last)) = (t_s.first(), t_s.last()) else {
        return Vec::new();
    };
    let interval_s = (last - first) / n.max(2) as f64;
    let samples = |span_s: f64| ((span_s / interval_s) as usize).max(LEAST_SAMPLES);
    let (before, after) = (samples(BEFORE_S), samples(AFTER_S));
    if n / 3 < before {
        return Vec::new();
    }
    // The earliest of each stretch, the rate of the middle pair of stretches, and how far the middle arrival is behind.
    let earliest = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let blocks: Vec<(f64, f64)> = (offsets.chunks_exact(before).zip(t_s.chunks_exact(before)))
        .map(|(offsets, t_s)| (t_s[0], earliest(offsets)))
        .collect();
    let rate = middle(
        (blocks.windows(2))
            .map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0))
            .collect(),
    );
    let even: Vec<f64> = offsets.iter().zip(t_s).map(|(o, t)| o - rate * t).collect();
    let late = even.chunks_exact(before).flat_map(|stretch| {
        let earliest = earliest(stretch);
        stretch.iter().map(move |offset| offset - earliest)
    });
    let least_s = LEAST_S.max(SCATTERS * middle(late.collect()));
    let mut stands: Vec<Stand> = Vec::new();
    let mut from = 0;
    let mut k = LEAST_SAMPLES;
    while k + LEAST_SAMPLES <= n {
        let earlier = earliest(&even[from.max(k.saturating_sub(before))..k]);
        let later = earliest(&even[k..(k + after).min(n)]);
        if later - earlier > least_s {
            stands.push(Stand {
                sample: k,
                lost_s: later - earlier,
            });
            from = k;
            k += LEAST_SAMPLES;
        } else {
            k += 1;
        }
    }
    stands
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_TIME_S: f64 = 0.003;

    /// A board that is off by `rate` and stands still before these samples for so long, seen by a host to which samples
    /// come late by up to 3 ms, a few of them by 40 ms with those behind them.
    fn seen(rate: f64, stands: &[(usize, f64)]) -> Run {
        let mut stood_s = 0.0;
        let mut host = Vec::new();
        let t_s: Vec<f64> = (0..5000).map(|k| f64::from(k) * SAMPLE_TIME_S).collect();
        for (k, t) in t_s.iter().enumerate() {
            stood_s += (stands.iter())
                .filter(|(sample, _)| *sample == k)
                .map(|(_, lost_s)| lost_s)
                .sum::<f64>();
            let scatter = 0.003 * ((k * k) as f64 * std::f64::consts::PI).fract();
            let held_up = 0.04 - SAMPLE_TIME_S * (k % 1700) as f64;
            host.push(7.0 + t * (1.0 + rate) + stood_s + scatter.max(held_up));
        }
        Run {
            sample_time_s: SAMPLE_TIME_S,
            t_s,
            host_t_s: Some(host),
            ..Run::default()
        }
    }

    #[test]
    fn a_clock_that_is_off_does_not_stand_still_and_late_arrivals_are_no_stands() {
        for rate in [0.0, 0.03, -0.1] {
            let run = seen(rate, &[]);
            assert_eq!(stands(&run), [], "{rate}");
            let (error, _) = host_clock(&run).expect("two clocks");
            assert!((error - rate).abs() < 1e-3, "{error}, not {rate}");
        }
    }

    #[test]
    fn stands_are_found_where_they_are_and_do_not_pass_for_a_rate() {
        let stood = [(700, 0.02), (760, 0.05), (2000, 0.008), (4300, 0.031)];
        let run = seen(0.001, &stood);
        let found = stands(&run);
        assert_eq!(found.len(), stood.len(), "{found:?}");
        for (found, (sample, lost_s)) in found.iter().zip(stood) {
            assert!(
                found.sample.abs_diff(sample) <= 10,
                "{found:?}, at {sample}"
            );
            assert!(
                (found.lost_s - lost_s).abs() < 0.002,
                "{found:?}, {lost_s} s"
            );
        }
        let (error, _) = host_clock(&run).expect("two clocks");
        assert!((error - 0.001).abs() < 5e-4, "{error}");
    }
}
