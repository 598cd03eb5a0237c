//! The board's clock compared with the host's: rate, and gaps in its time stamps.
//!
//! Arrivals are late by a random delay and never early, so that the earliest ones determine the offset. With the
//! offsets `o_k = host_k - board_k` the rate error is the slope of a line through the earliest of the first and of
//! the last tenth. A gap in the board's time stamps shifts all later offsets: a step between the earliest of
//! [`BEFORE_S`] before a sample and the earliest of [`AFTER_S`] after it, which no late arrival causes. Such steps
//! are removed before the slope is estimated.
//!
//! A host that does not read for a while (a suspended program, a machine under load) gets the waiting samples at
//! once: a burst. Bursts carry no information about the board, nor does the clock of a virtual board, whose speed is
//! a setting.

use crate::recording::Run;

/// Windows before and after a step of the offset in s, and the fewest samples in each.
const BEFORE_S: f64 = 0.15;
const AFTER_S: f64 = 1.0;
const LEAST_SAMPLES: usize = 6;
/// Shortest gap that is distinguished from scatter, in s, and as a multiple of the scatter.
const LEAST_S: f64 = 0.004;
const SCATTER_FACTOR: f64 = 4.0;

/// Shortest pause of the host in s: a bridge and a busy host cause 40 ms.
const HOST_PAUSE_S: f64 = 0.1;
/// Arrivals within less than this share of the board's time are a burst.
const BURST: f64 = 0.5;

/// A gap in the board's time stamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TimeGap {
    /// Number of the first sample after it.
    pub sample: usize,
    /// For how long, in s.
    pub lost_s: f64,
}

/// Rate error of the board's clock relative to the host's, and the interval in s over which it is measured; `None`
/// with one clock only.
pub(crate) fn host_clock(run: &Run) -> Option<(f64, f64)> {
    let offsets = offsets(run)?;
    let time_gaps = time_gaps_in(&run.t_s, &offsets);
    slope(run, &without(offsets, &time_gaps))
}

/// Gaps in the board's time stamps by the host's clock; none with one clock only.
pub(crate) fn time_gaps(run: &Run) -> Vec<TimeGap> {
    offsets(run).map_or_else(Vec::new, |offsets| time_gaps_in(&run.t_s, &offsets))
}

/// A pause of the host, after which it read the waiting samples at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HostPause {
    /// Number of the first sample read after the pause.
    pub sample: usize,
    /// Length in s.
    pub lasts_s: f64,
}

pub(crate) fn host_pauses(run: &Run) -> Vec<HostPause> {
    let Some(host) = run.host_t_s.as_ref().filter(|_| !run.is_host_timed()) else {
        return Vec::new();
    };
    let t_s = &run.t_s;
    (1..host.len())
        .filter(|&k| host[k] - host[k - 1] >= HOST_PAUSE_S + (t_s[k] - t_s[k - 1]))
        .filter(|&k| is_burst(host, t_s, k, (k + LEAST_SAMPLES).min(host.len() - 1)))
        .map(|k| HostPause {
            sample: k,
            lasts_s: host[k] - host[k - 1],
        })
        .collect()
}

/// Whether these samples arrived in far less time than the board took for them.
fn is_burst(host: &[f64], t_s: &[f64], from: usize, to: usize) -> bool {
    host[to] - host[from] < BURST * (t_s[to] - t_s[from])
}

/// Whether the board is virtual: its time is computed.
fn is_virtual(run: &Run) -> bool {
    let word = |key: &str| run.header.get(key).and_then(toml::Value::as_str);
    word("port").is_some_and(|port| port.starts_with("virtual:"))
        || word("device") == Some("virtual")
}

fn offsets(run: &Run) -> Option<Vec<f64>> {
    if run.is_host_timed() || is_virtual(run) {
        return None;
    }
    let host = run.host_t_s.as_ref()?;
    Some(host.iter().zip(&run.t_s).map(|(h, t)| h - t).collect())
}

fn without(mut offsets: Vec<f64>, time_gaps: &[TimeGap]) -> Vec<f64> {
    for gap in time_gaps {
        for offset in &mut offsets[gap.sample..] {
            *offset -= gap.lost_s;
        }
    }
    offsets
}

/// Slope through the earliest arrivals of the first and the last tenth, and the time between them.
fn slope(run: &Run, offsets: &[f64]) -> Option<(f64, f64)> {
    let (t_s, host) = (&run.t_s, run.host_t_s.as_ref()?);
    let n = offsets.len();
    let tenth = (n / 10).max(1);
    let is_late = |from: usize, to: usize| to > from && is_burst(host, t_s, from, to);
    if is_late(0, tenth.min(n - 1)) || is_late(n - tenth.min(n), n - 1) {
        return None;
    }
    let earliest = |range: std::ops::Range<usize>| {
        let late = range.map(|k| (offsets[k], t_s[k]));
        late.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (first, last) = (earliest(0..tenth)?, earliest(n.saturating_sub(tenth)..n)?);
    let span_s = last.1 - first.1;
    let error = (last.0 - first.0) / span_s;
    (error.is_finite() && span_s > 0.0).then_some((error, span_s))
}

fn time_gaps_in(t_s: &[f64], offsets: &[f64]) -> Vec<TimeGap> {
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
    // The earliest of each block, the median slope over pairs of blocks, and the median delay.
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
    let late = even.chunks_exact(before).flat_map(|block| {
        let earliest = earliest(block);
        block.iter().map(move |offset| offset - earliest)
    });
    let least_s = LEAST_S.max(SCATTER_FACTOR * middle(late.collect()));
    let mut time_gaps: Vec<TimeGap> = Vec::new();
    let mut from = 0;
    let mut k = LEAST_SAMPLES;
    while k + LEAST_SAMPLES <= n {
        let earlier = earliest(&even[from.max(k.saturating_sub(before))..k]);
        let later = earliest(&even[k..(k + after).min(n)]);
        let end = (k + after).min(n) - 1;
        let passed_s = offsets[end] + t_s[end] - offsets[k] - t_s[k];
        let has_waited = passed_s < BURST * (t_s[end] - t_s[k]);
        if later - earlier > least_s && !has_waited {
            time_gaps.push(TimeGap {
                sample: k,
                lost_s: later - earlier,
            });
            from = k;
            k += LEAST_SAMPLES;
        } else {
            k += 1;
        }
    }
    time_gaps
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_TIME_S: f64 = 0.003;

    /// A board with this rate error and these gaps in its time stamps; the host receives samples up to 3 ms late, a
    /// few of them 40 ms late together with the following ones.
    fn seen(rate: f64, time_gaps: &[(usize, f64)]) -> Run {
        let mut stood_s = 0.0;
        let mut host = Vec::new();
        let t_s: Vec<f64> = (0..5000).map(|k| f64::from(k) * SAMPLE_TIME_S).collect();
        for (k, t) in t_s.iter().enumerate() {
            stood_s += (time_gaps.iter())
                .filter(|(sample, _)| *sample == k)
                .map(|(_, lost_s)| lost_s)
                .sum::<f64>();
            let scatter = 0.003 * ((k * k) as f64 * std::f64::consts::PI).fract();
            let host_pauses = 0.04 - SAMPLE_TIME_S * (k % 1700) as f64;
            host.push(7.0 + t * (1.0 + rate) + stood_s + scatter.max(host_pauses));
        }
        Run {
            sample_time_s: SAMPLE_TIME_S,
            t_s,
            host_t_s: Some(host),
            ..Run::default()
        }
    }

    #[test]
    fn a_clock_rate_error_and_late_arrivals_are_no_time_gaps() {
        for rate in [0.0, 0.03, -0.1] {
            let run = seen(rate, &[]);
            assert_eq!(time_gaps(&run), [], "{rate}");
            let (error, _) = host_clock(&run).expect("two clocks");
            assert!((error - rate).abs() < 1e-3, "{error}, not {rate}");
        }
    }

    #[test]
    fn time_gaps_are_located_and_are_no_clock_rate_error() {
        let stood = [(700, 0.02), (760, 0.05), (2000, 0.008), (4300, 0.031)];
        let run = seen(0.001, &stood);
        let found = time_gaps(&run);
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
