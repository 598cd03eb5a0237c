//! Jumps of the angle that no noise of the model makes: a board that stands still, edges that were none, a belt's tooth.
//!
//! The innovations of a right model are normal, of the variance `S_k` that the filter states. A jump of unknown size at one
//! sample of `n` makes the recording likelier by `b^2/2S(1 + 1/m)`, where `b` is by how much the innovation there differs from the mean
//! of the `m` just before (what drifts off slowly does not jump); that it may be any sample costs `ln n`, that it may have any
//! size [`ANY_SIZE`]. Where more than nothing is left the jump is taken off the residual from there on. The sum over
//! all jumps speaks for a cause that is not in the catalogue: nothing in it jumps.

use super::data::RunData;
use super::disturbance::Disturbance;
use super::fit::Fit;
use super::noise::Whitener;
use super::problem::Problem;

/// What the freedom of a jump's size costs in nats: the logarithm of how many times the noise it may be.
const ANY_SIZE: f64 = 3.0;
/// A jump of fewer counts is a matter of rounding and of contacts that give way.
const LEAST_COUNTS: f64 = 2.0;
/// How many innovations before it a jump is measured against.
const BEFORE: usize = 8;
/// How much wider than an innovation its distance from their mean spreads.
const SPREAD: f64 = 1.0 + 1.0 / BEFORE as f64;
/// More jumps of a run are not looked for.
const MOST_JUMPS: usize = 64;

/// By how many nats jumps make likelier what a fit leaves. Of a rough recording (see `disturbance`) nothing is said: its
/// noise is not that of the model.
pub(super) fn jumps(problem: &Problem<'_>, fit: &Fit) -> f64 {
    if problem.rough != Disturbance::default() {
        return 0.0;
    }
    let samples: usize = problem.runs.iter().map(RunData::len).sum();
    let cost = (samples.max(1) as f64).ln() + ANY_SIZE;
    let whiteners = problem.whiteners(&problem.noise(&fit.hypothesis, &fit.p, fit.wander));
    let runs = problem.runs.iter().zip(&fit.predictions);
    let gains = runs.zip(whiteners.iter()).map(|((run, x), whitener)| {
        let residual = run.counts.iter().zip(x).map(|(n, x)| n - x - 0.5);
        in_run(residual.collect(), whitener, cost)
    });
    gains.sum()
}

/// The same in the residual of one run, in counts.
fn in_run(mut residual: Vec<f64>, whitener: &Whitener, cost: f64) -> f64 {
    let variances: Vec<f64> = whitener.variances().collect();
    let (mut gain, mut from) = (0.0, BEFORE);
    for _ in 0..MOST_JUMPS {
        let mut innovations = residual.clone();
        whitener.whiten(&mut innovations);
        for (e, variance) in innovations.iter_mut().zip(&variances) {
            *e *= variance.sqrt();
        }
        let size = |k: usize| {
            let before = &innovations[k - BEFORE..k];
            innovations[k] - before.iter().sum::<f64>() / BEFORE as f64
        };
        let worth = |k: usize| 0.5 * size(k).powi(2) / (SPREAD * variances[k]) - cost;
        let is_jump = |k: &usize| size(*k).abs() >= LEAST_COUNTS && worth(*k) > 0.0;
        let Some(k) = (from..innovations.len()).find(is_jump) else {
            break;
        };
        gain += worth(k);
        let size = size(k);
        for r in &mut residual[k..] {
            *r -= size;
        }
        from = k + 1;
    }
    gain
}

#[cfg(test)]
mod tests {
    use super::super::noise::Whitener;
    use super::super::samples::{held_at, motor_with, problem, ready, recording};
    use super::*;

    /// A motor as it is stated, then with a jump: `1/2 size^2/S(1 + 1/m)` less the two costs, with the variance `S` of the
    /// innovation that the filter states there; beside it the innovation's own rounding, of some standard deviations.
    #[test]
    fn a_jump_counts_by_its_size_and_rounding_counts_nothing() {
        let motor = motor_with(&[]);
        let mut run = recording(&motor);
        let runs = ready(&run);
        let as_stated = problem(&motor, &runs);
        let found = held_at(&as_stated, &[]);
        assert_eq!(jumps(&as_stated, &found), 0.0);

        const SIZE: i64 = 12;
        // Where the shaft turns, so that each sample is a look of its own.
        let turns = |k: &usize| runs[0].weight[*k] == 1.0;
        let at = (2000..4000).find(turns).expect("it turns");
        for counts in &mut run.counts[at..] {
            *counts += SIZE;
        }
        let jumped = ready(&run);
        let with_jump = problem(&motor, &jumped);
        let level = with_jump.noise(&found.hypothesis, &found.p, found.wander);
        let filter = Whitener::new(&jumped[0], &with_jump.responses[0], &level);
        let variance = filter.variances().nth(at).expect("a sample");
        let deviations = SIZE as f64 / variance.sqrt();
        let cost = (run.counts.len() as f64).ln() + ANY_SIZE;
        let expected = |away: f64| 0.5 * (deviations + away).powi(2) / SPREAD - cost;
        let gain = jumps(&with_jump, &found);
        assert!(
            (expected(-3.0)..expected(3.0)).contains(&gain),
            "{gain}, expected about {}",
            expected(0.0)
        );
    }
}
