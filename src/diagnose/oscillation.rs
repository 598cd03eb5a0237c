//! An acceleration that swings at one frequency of time, whatever the shaft does: a bench that shakes, a neighbour's fan.
//!
//! `a(t) = A_i sin(2 pi f t) + B_i cos(2 pi f t)` in run `i`: the frequency is the same in all runs, amplitude and phase are
//! each run's own. Where the named model is right the whitened residual `r` is white, so that the sum over runs of the
//! periodograms `2 |sum_k r_k exp(-2 pi i f t_k)|^2 / n_i` has its peaks where a tone is (Schuster 1898); the highest are
//! weighed as any other shapes are. That any frequency may be it costs the logarithm of how many can be told apart,
//! `T (f_max - f_min)` in runs of the length `T`.
//!
//! A line of the rounding's tones, or of something that the shaft meets at every turn, is there while it turns at one speed,
//! and a step does that most of the time. An oscillation goes on whatever the shaft does: less must be left in the half of the
//! blocks in which it does least, too.

use std::sync::Arc;

use realfft::RealFftPlanner;

use super::data::RunData;
use super::marginal::{Beside, Named};
use super::noise::NoiseLevel;
use super::problem::{Columns, Problem};
use super::shapes::{FASTEST, Gains, Group, is_told, swinging};

/// Least number of periods in the longest run: slower is a slow wave of time.
const LEAST_PERIODS: f64 = 4.0;
/// By how much finer than its resolution a periodogram is computed.
const FINER: usize = 4;
/// How many peaks are weighed.
const PEAKS: usize = 2;
/// Length in s of the blocks in which an oscillation must be found.
const BLOCK_S: f64 = 0.5;
/// To which share of a peak's half width the frequency is found.
const PRECISE: f64 = 0.02;

/// What the likeliest oscillation gains, where one goes on throughout. Of a rough recording nothing is said: that its speed
/// walks is how it is described.
pub(super) fn oscillation(
    problem: &Problem<'_>,
    level: &NoiseLevel,
    residual: &[f64],
    named: Option<&Named>,
    largest_acceleration: f64,
) -> Option<Gains> {
    if problem.is_rough() || problem.setting.is_held {
        return None;
    }
    let runs = problem.runs;
    let (peaks, price) = frequencies(runs, residual);
    let at = |hz: f64| {
        let columns = Group::Oscillation(hz).columns(problem, level, largest_acceleration);
        let beside = Beside::new(residual, &columns, named);
        let gains = Gains::of(Group::Oscillation(hz), |size| {
            beside.solved(size).map_or(0.0, |found| found.log_gain) - price
        });
        Tried { hz, columns, gains }
    };
    let mut best = peaks.into_iter().map(at).reduce(Tried::or)?;
    if best.gains.log_gain <= 0.0 {
        return None;
    }
    let half_width_hz = half_width_hz(runs);
    let mut step_hz = 0.5 * half_width_hz;
    while step_hz > PRECISE * half_width_hz {
        let beside = [best.hz - step_hz, best.hz + step_hz];
        best = beside.into_iter().map(at).fold(best, Tried::or);
        step_hz *= 0.5;
    }
    let found = Beside::new(residual, &best.columns, named).solved(best.gains.size)?;
    let left = found.left(residual, &best.columns, named);
    goes_on(runs, best.hz, residual, &left).then_some(best.gains)
}

/// A frequency that was weighed.
struct Tried {
    hz: f64,
    columns: Arc<Columns>,
    gains: Gains,
}

impl Tried {
    /// The likelier of two.
    fn or(self, other: Self) -> Self {
        if other.gains.log_gain > self.gains.log_gain {
            other
        } else {
            self
        }
    }
}

/// The frequencies in Hz at which a whitened residual of all runs end to end swings most, and what it costs in nats that it may be
/// any.
fn frequencies(runs: &[RunData], residual: &[f64]) -> (Vec<f64>, f64) {
    let Some((length_s, highest)) = band(runs) else {
        return (Vec::new(), 0.0);
    };
    let lowest = LEAST_PERIODS / length_s;
    let step = 1.0 / (length_s * FINER as f64);
    let count = ((highest - lowest) / step).floor();
    // Far more frequencies than samples: a file whose sample time is not that of its rows.
    if !(3.0..=(FINER * residual.len()) as f64).contains(&count) {
        return (Vec::new(), 0.0);
    }
    let mut power = vec![0.0; count as usize];
    let mut planner = RealFftPlanner::<f64>::new();
    let mut left = residual;
    for run in runs {
        let (own, others) = left.split_at(run.len());
        left = others;
        let n = (own.len() * FINER).next_power_of_two();
        let forward = planner.plan_fft_forward(n);
        let mut padded = own.to_vec();
        padded.resize(n, 0.0);
        let mut spectrum = forward.make_output_vec();
        if forward.process(&mut padded, &mut spectrum).is_err() {
            continue;
        }
        let per_bin = 1.0 / (n as f64 * run.sample_time_s);
        for (k, sum) in power.iter_mut().enumerate() {
            let bin = ((lowest + step * k as f64) / per_bin).round() as usize;
            if is_told(run, lowest + step * k as f64) {
                *sum += 2.0 * spectrum[bin].norm_sqr() / own.len() as f64;
            }
        }
    }
    let mut peaks: Vec<usize> = (1..power.len() - 1)
        .filter(|&k| power[k] >= power[k - 1] && power[k] > power[k + 1])
        .collect();
    peaks.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
    peaks.truncate(PEAKS);
    let found = peaks.into_iter().map(|k| lowest + step * k as f64);
    (found.collect(), (count / FINER as f64).max(1.0).ln())
}

/// Length in s of the longest run, and the highest frequency in Hz that is looked for.
fn band(runs: &[RunData]) -> Option<(f64, f64)> {
    let longest = runs.iter().map(RunData::length_s).fold(0.0, f64::max);
    let finest = runs.iter().map(|run| run.sample_time_s).reduce(f64::min)?;
    (longest > 0.0 && finest > 0.0).then_some((longest, FASTEST / finest))
}

/// Distance in Hz from a peak within which the likeliest frequency lies.
fn half_width_hz(runs: &[RunData]) -> f64 {
    band(runs).map_or(0.0, |(length_s, _)| 0.5 / length_s)
}

/// Whether less is left with an oscillation than without one in the half of the blocks in which it does least, of those in
/// which the shaft moves and the samples tell of it.
fn goes_on(runs: &[RunData], hz: f64, before: &[f64], after: &[f64]) -> bool {
    let swinging = swinging(runs, hz);
    let mut less = Vec::new();
    let mut from = 0;
    for (k, run) in runs.iter().enumerate() {
        let length = ((BLOCK_S / run.sample_time_s).round() as usize).max(1);
        for start in (0..run.len()).step_by(length) {
            let end = (start + length).min(run.len());
            if swinging.contains(&k) && run.moving[start..end].contains(&true) {
                let squares =
                    |r: &[f64]| -> f64 { r[from + start..from + end].iter().map(|x| x * x).sum() };
                less.push(squares(before) - squares(after));
            }
        }
        from += run.len();
    }
    less.sort_by(f64::total_cmp);
    less[..less.len().div_ceil(2)].iter().sum::<f64>() > 0.0
}

#[cfg(test)]
mod tests {
    use super::super::samples::{fit, motor_with, problem, ready, recording};
    use super::super::scales::largest_acceleration;
    use super::super::unknown::flexible;
    use super::*;

    const AMPLITUDE_COUNTS: f64 = 2.0;
    const HZ: f64 = 3.17;

    /// The group that the model without effects would like beside it, of a motor that swings by some counts between two times.
    fn found(from_s: f64, to_s: f64) -> (Group, f64) {
        let nominal = motor_with(&[]);
        let mut run = recording(&nominal);
        for (t_s, n) in run.t_s.iter().zip(&mut run.counts) {
            if (from_s..to_s).contains(t_s) {
                let swing = AMPLITUDE_COUNTS * (std::f64::consts::TAU * HZ * t_s).sin();
                *n += swing.round() as i64;
            }
        }
        let runs = ready(&run);
        let problem = problem(&nominal, &runs);
        let best = fit(&problem, &[]);
        let found = flexible(&problem, &best, largest_acceleration(&nominal, &runs));
        (found.group, found.log_gain)
    }

    /// The variance of the frequency of a tone of amplitude `A` in `n` samples over `T` with errors of variance `s^2` is at least
    /// `6 s^2 / (pi^2 A^2 T^2 n)` (Rife and Boorstyn 1974): here 0.03 mHz, and the filter's noise is not less than rounding's.
    /// A tenth of a resolution cell is asked.
    #[test]
    fn a_motor_that_swings_throughout_is_seen_at_its_frequency() {
        let (group, gain) = found(0.0, 15.0);
        let Group::Oscillation(hz) = group else {
            panic!("{group:?}");
        };
        assert!((hz - HZ).abs() < 0.1 / 15.0, "{hz}");
        assert!(gain > 100.0, "{gain}");
    }

    #[test]
    fn what_swings_for_a_while_is_no_oscillation() {
        let (group, _) = found(3.0, 9.0);
        assert!(!matches!(group, Group::Oscillation(_)), "{group:?}");
    }

    /// Rounding has lines at any frequency; over the price of choosing one nothing is gained.
    #[test]
    fn rounding_swings_at_no_frequency() {
        let (group, gain) = found(0.0, 0.0);
        let is_swing = matches!(group, Group::Oscillation(_));
        assert!(!is_swing || gain < 3.0, "{group:?} {gain}");
    }
}
