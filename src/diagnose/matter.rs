//! Whether an effect matters: by how much it moves the angle.
//!
//! A spring or a ripple of a tenth of a count can follow the tones that rounding leaves in a steady turn, and
//! gain likelihood honestly without being the cause of any gap. So each effect of a set has a prior on what
//! it does, beside the one on its numbers: with `c` the RMS in counts of `x(set) - x(set without it)` in the
//! run where that is largest, all else equal, `ln p = -1/2 (24 (1 - c))^2` below one count, nought above.

use super::fit::Fit;
use super::problem::Problem;
use super::rivals::catalogue;

/// An effect that moves the angle by less, in counts RMS, is no cause of a gap.
const MATTERS_COUNTS: f64 = 1.0;
/// Standard deviations by which an effect that moves nothing is implausible.
const STEEPNESS: f64 = 24.0;

/// How implausible the least of a fit's effects is for moving so little, in nats.
pub(super) fn discount(problem: &Problem<'_>, fit: &Fit) -> f64 {
    let members = &fit.hypothesis.members;
    let least = (0..members.len())
        .filter_map(|m| {
            if catalogue()[members[m].index].id == "sample_jitter" {
                return Some(scatter(problem, fit));
            }
            let without = problem.predictions_without(fit, m)?;
            Some(largest_rms(&fit.predictions, &without))
        })
        .fold(f64::INFINITY, f64::min);
    let short = STEEPNESS * (1.0 - least / MATTERS_COUNTS).max(0.0);
    0.5 * short * short
}

/// Late sampling scatters the counts about the same angle: the width of that where the shaft turns fastest.
fn scatter(problem: &Problem<'_>, fit: &Fit) -> f64 {
    let late_s = problem.noise(&fit.hypothesis, &fit.p, fit.wander).late_s;
    let fastest = problem.runs.iter().map(|run| run.top_speed_counts_s);
    late_s * fastest.fold(0.0, f64::max)
}

fn largest_rms(x: &[Vec<f64>], y: &[Vec<f64>]) -> f64 {
    let runs = x.iter().zip(y).map(|(x, y)| {
        let squares: f64 = x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum();
        (squares / x.len().max(1) as f64).sqrt()
    });
    runs.fold(0.0, f64::max)
}
