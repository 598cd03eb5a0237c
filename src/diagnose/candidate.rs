//! A hypothesis that was fitted, and what it weighs: evidence, prior, and what speaks against it besides.
//!
//! `ln w = ln Z + ln p(set) - excess wander - too small to matter + what the host's clock showed`. A quarter
//! of the motors that somebody asks about have no effect beyond their tolerances, more than one effect is rarer than one,
//! all sets of a size are alike.

use super::fit::Fit;
use super::matter;
use super::problem::Problem;
use super::rivals;
use super::rivals::catalogue;

/// Prior probability that there is no effect.
const PRIOR_NONE: f64 = 0.25;
/// That there is exactly one effect.
const PRIOR_SINGLE: f64 = 0.45;
/// That there are two.
const PRIOR_PAIR: f64 = 0.15;
/// That there are three.
const PRIOR_TRIPLE: f64 = 0.05;
/// A wander up to this share of the largest acceleration is ordinary; more speaks for the unknown.
pub(super) const ORDINARY_WANDER: f64 = 0.003;

/// A hypothesis that was fitted.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    /// Indices of its effects in the catalogue; none for the null.
    pub effects: Vec<usize>,
    /// Its fit.
    pub fit: Fit,
    /// Evidence and prior together, in nats.
    pub log_weight: f64,
    /// Its probability.
    pub probability: f64,
}

/// A fit of these effects with its weight; `scale` is the largest acceleration in counts/s^2.
pub(super) fn candidate(
    problem: &Problem<'_>,
    effects: Vec<usize>,
    fit: Fit,
    scale: f64,
) -> Candidate {
    let n = rivals::COUNT as f64;
    let log_prior = match effects.len() {
        0 => PRIOR_NONE.ln(),
        1 => (PRIOR_SINGLE / n).ln(),
        2 => (PRIOR_PAIR / (n * (n - 1.0) / 2.0)).ln(),
        _ => (PRIOR_TRIPLE / (n * (n - 1.0) * (n - 2.0) / 6.0)).ln(),
    };
    let is_off = effects.iter().any(|&e| catalogue()[e].id == "clock_error");
    Candidate {
        log_weight: fit.log_evidence + log_prior
            - excess_wander(problem, fit.wander, scale)
            - matter::discount(problem, &fit)
            + problem.setting.log_density_of_clock(is_off),
        effects,
        fit,
        probability: 0.0,
    }
}

/// How implausible a wander of this size is in an ordinary motor, in nats; none where its controller holds the axis,
/// since the command is as large as what disturbs it.
pub(super) fn excess_wander(problem: &Problem<'_>, wander: f64, scale: f64) -> f64 {
    if problem.setting.is_held {
        return 0.0;
    }
    2.0 * (wander / scale / ORDINARY_WANDER - 1.0).max(0.0)
}

/// A set of effects in the catalogue's order.
pub(super) fn sorted(effects: &[usize]) -> Vec<usize> {
    let mut set = effects.to_vec();
    set.sort_unstable();
    set
}

/// Heaviest first.
pub(super) fn by_weight(a: &Candidate, b: &Candidate) -> std::cmp::Ordering {
    b.log_weight.total_cmp(&a.log_weight)
}

/// Keeps the best fit of every set of effects.
pub(super) fn dedup(candidates: &mut Vec<Candidate>) {
    candidates.sort_by(by_weight);
    let mut seen: Vec<Vec<usize>> = Vec::new();
    candidates.retain(|c| {
        let set = sorted(&c.effects);
        let new = !seen.contains(&set);
        if new {
            seen.push(set);
        }
        new
    });
}
