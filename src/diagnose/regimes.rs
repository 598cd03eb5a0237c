//! What the motor does when: every sample of a run gets a regime, and every stretch its share of the gap.
//!
//! A stretch's share is what it adds to the likelihood's sum of squares beyond the weight of its samples, which a
//! right model leaves, with innovations on short horizons, so that an error at breakaway is not counted
//! again in every position after it.

use super::data::RunData;
use super::verdict::{Regime, Region};

/// Seconds over which a change of speed is looked for.
const SPAN_S: f64 = 0.06;
/// Breakaway lasts this long in s from the last look at a shaft that rests.
const BREAKAWAY_S: f64 = 0.12;
/// Turning below this share of the run's top speed is slow.
const SLOW: f64 = 0.15;
/// A change of speed by this share of the top speed within the span is acceleration.
const CHANGE: f64 = 0.06;
/// Regions with less than this share are left out.
const LEAST_SHARE: f64 = 0.02;
/// Most regions that are listed.
const MOST: usize = 16;

/// The regime of each sample.
pub(super) fn regimes(run: &RunData) -> Vec<Regime> {
    let half = ((SPAN_S / run.sample_time_s).round() as usize).max(1);
    let last = run.len().saturating_sub(1);
    let top = run.top_speed_counts_s;
    let mut rested_s = f64::NEG_INFINITY;
    (0..run.len())
        .map(|k| {
            if !run.moving[k] {
                rested_s = run.t_s[k];
            }
            let (from, to) = (k.saturating_sub(half), (k + half).min(last));
            let (before, now, after) = (
                run.speed_counts_s[from],
                run.speed_counts_s[k],
                run.speed_counts_s[to],
            );
            if !run.moving[k] {
                return Regime::Standstill;
            }
            if before * after < 0.0 && run.moving[from] && run.moving[to] {
                return Regime::Reversal;
            }
            if run.command[k] == 0.0 {
                return Regime::Coasting;
            }
            if run.t_s[k] - rested_s < BREAKAWAY_S {
                return Regime::Breakaway;
            }
            let change = after.abs() - before.abs();
            if change.abs() > CHANGE * top {
                if change > 0.0 {
                    Regime::Accelerating
                } else {
                    Regime::Braking
                }
            } else if now.abs() < SLOW * top {
                Regime::LowSpeed
            } else {
                Regime::Steady
            }
        })
        .collect()
}

/// The stretches with the largest shares of the gap, given each run's whitened innovations.
pub(super) fn regions(runs: &[(String, &RunData)], innovations: &[Vec<f64>]) -> Vec<Region> {
    let mut found = Vec::new();
    for ((name, run), e) in runs.iter().zip(innovations) {
        let regimes = regimes(run);
        let mut from = 0;
        for k in 1..=run.len() {
            if k < run.len() && regimes[k] == regimes[from] {
                continue;
            }
            let noise: f64 = run.weight[from..k].iter().sum();
            let excess = e[from..k].iter().map(|x| x * x).sum::<f64>() - noise;
            found.push(Region {
                run: name.clone(),
                from_s: run.t_s[from],
                to_s: run.t_s[k - 1],
                regime: regimes[from],
                share: excess.max(0.0),
            });
            from = k;
        }
    }
    let total: f64 = found.iter().map(|region| region.share).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    for region in &mut found {
        region.share /= total;
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found.retain(|region| region.share >= LEAST_SHARE);
    found.truncate(MOST);
    found
}
