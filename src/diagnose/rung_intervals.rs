//! How sure the four rungs are.
//!
//! Three things make them uncertain:
//!
//! - which stretches were kept: blocks of half a second are drawn again with replacement, as many as there are;
//! - how well the rest told the models' numbers: these are drawn from the fit's normal distribution,
//!   `p = p_fit + L z` with the Cholesky factor `L` of its covariance, and what models with them leave scatters about what
//!   the fit leaves. Of one short run, whose kept part is one block, that is all that is known;
//! - and which run it is, for the share closed alone: what one more run may show is judged by how much the runs differ,
//!   `mean +- t s sqrt(1 + 1/n)`.
//!
//! The half-widths of the first two add in squares, on either side apart; the interval spans that of the third as well.

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::fit::Fit;
use super::rungs::{closed, pooled};
use crate::compare::FLOOR_COUNTS;

/// A run whose gap above the floor is smaller, in counts, does not tell which share is closed.
const LEAST_GAP_COUNTS: f64 = 1.0;
/// Bootstrap samples.
const RESAMPLES: usize = 400;
/// Half-width in standard deviations of a normal distribution's middle 95 %.
const NORMAL: f64 = 1.96;
/// How often a fit's numbers are drawn.
const DRAWS: usize = 16;

/// A stretch of a run that a model was not fitted to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// Squared errors in counts^2 under the three models.
    pub squares: [f64; 3],
    /// Its samples.
    pub samples: usize,
    /// Number of its run.
    pub run: usize,
}

/// 95 % intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Intervals {
    /// Of the rungs, in counts RMS.
    pub rungs: [(f64, f64); 3],
    /// Of the share of the gap that is closed.
    pub closed: (f64, f64),
    /// How far more than was found these runs' own share may be, as one standard deviation of a normal distribution.
    pub closed_deviation: f64,
}

/// The numbers of a fit drawn anew, [`DRAWS`] times; none where its covariance is not one.
pub(super) fn with_numbers_drawn(fit: &Fit) -> Vec<Vec<f64>> {
    let Some(cholesky) = fit.covariance.clone().cholesky() else {
        return Vec::new();
    };
    let factor = cholesky.l();
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    (0..DRAWS)
        .map(|_| {
            let z = DVector::from_fn(fit.p.len(), |_, _| rng.sample(StandardNormal));
            let off = &factor * z;
            let mut p: Vec<f64> = fit.p.iter().zip(off.iter()).map(|(p, x)| p + x).collect();
            fit.hypothesis.clamp(&mut p);
            p
        })
        .collect()
}

/// Of the rungs on these blocks; `drawn` is what models leave whose numbers were drawn, in counts RMS.
pub(super) fn intervals(blocks: &[Block], drawn: &[[f64; 3]]) -> Intervals {
    if blocks.is_empty() {
        return Intervals {
            rungs: [(0.0, 0.0); 3],
            closed: (0.0, 0.0),
            closed_deviation: 0.0,
        };
    }
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let again: Vec<[f64; 3]> = (0..RESAMPLES)
        .map(|_| {
            let blocks: Vec<Block> = (0..blocks.len())
                .map(|_| blocks[rng.random_range(0..blocks.len())])
                .collect();
            pooled(&blocks)
        })
        .collect();
    let found = pooled(blocks);
    let of = |what: &dyn Fn(&[f64; 3]) -> f64| {
        let value = what(&found);
        let (lo, hi) = middle95(again.iter().map(what).collect());
        let half = half_width(value, drawn.iter().map(what));
        (
            value - (value - lo).max(0.0).hypot(half),
            value + (hi - value).max(0.0).hypot(half),
        )
    };
    let rungs = [0, 1, 2].map(|m| of(&|rungs| rungs[m]));
    let share = |rungs: &[f64; 3]| closed(rungs[0], rungs[2]);
    let (lo, hi) = of(&share);
    let (next_lo, next_hi) = next_run95(blocks).unwrap_or((lo, hi));
    Intervals {
        rungs: rungs.map(|(lo, hi)| (lo.max(0.0), hi)),
        closed: (lo.min(next_lo).max(-1.0), hi.max(next_hi).min(1.0)),
        closed_deviation: (hi - share(&found)) / NORMAL,
    }
}

/// Half of the 95 % interval that drawn numbers give a value; nought where none could be simulated.
fn half_width(value: f64, drawn: impl Iterator<Item = f64>) -> f64 {
    let squares: Vec<f64> = drawn
        .filter(|x| x.is_finite())
        .map(|x| (x - value).powi(2))
        .collect();
    if squares.is_empty() {
        return 0.0;
    }
    let draws = squares.len() as f64;
    student(draws) * (squares.iter().sum::<f64>() / draws).sqrt()
}

/// Where the share closed of one more run lies in 95 % of all cases; `None` where fewer than two runs have a gap.
fn next_run95(blocks: &[Block]) -> Option<(f64, f64)> {
    let runs = blocks.iter().map(|block| block.run).max()? + 1;
    let shares: Vec<f64> = (0..runs)
        .map(|run| {
            let own = blocks.iter().filter(|block| block.run == run);
            pooled(&own.copied().collect::<Vec<_>>())
        })
        .filter(|[before, ..]| *before > FLOOR_COUNTS + LEAST_GAP_COUNTS)
        .map(|[before, _, after]| closed(before, after))
        .collect();
    let n = shares.len() as f64;
    if n < 2.0 {
        return None;
    }
    let mean = shares.iter().sum::<f64>() / n;
    let variance = shares.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let half = student(n - 1.0) * (variance * (1.0 + 1.0 / n)).sqrt();
    Some((mean - half, mean + half))
}

/// Student's t for 95 % of both sides with so many degrees of freedom.
fn student(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(NORMAL, |t| t.inverse_cdf(0.975))
}

/// Where the middle 95 % of the values lie.
fn middle95(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    (at(0.025), at(0.975))
}

#[cfg(test)]
mod tests {
    use super::super::samples::{fit, motor_with, problem, ready, recording};
    use super::*;

    fn block(left: [f64; 3]) -> Block {
        Block {
            squares: left.map(|x| x * x),
            samples: 1,
            run: 0,
        }
    }

    /// One block drawn again is the same block: what is left is how well the numbers are known, 2.12 of Student's t with
    /// 16 degrees of freedom.
    #[test]
    fn of_one_block_the_interval_is_that_of_the_numbers() {
        let before = 10.0 + FLOOR_COUNTS;
        let after = |k: usize| 4.0 + FLOOR_COUNTS + if k.is_multiple_of(2) { 0.5 } else { -0.5 };
        let drawn: Vec<[f64; 3]> = (0..16).map(|k| [before, before, after(k)]).collect();
        let found = intervals(&[block([before, before, 4.0 + FLOOR_COUNTS])], &drawn);
        let (lo, hi) = found.closed;
        assert!((hi - lo - 2.0 * 2.120 * 0.05).abs() < 1e-3, "{lo} {hi}");
        assert!((0.5 * (lo + hi) - 0.6).abs() < 1e-9, "{lo} {hi}");
        assert!((found.closed_deviation - 2.120 * 0.05 / 1.96).abs() < 1e-3);
        assert_eq!(found.rungs[0], (before, before));
    }

    #[test]
    fn without_draws_one_block_tells_no_interval() {
        let found = intervals(&[block([10.0, 8.0, 4.0])], &[]);
        assert_eq!(found.rungs, [(10.0, 10.0), (8.0, 8.0), (4.0, 4.0)]);
    }

    /// The squares of `L^-1 (p - p_fit)` add to chi-square of as many degrees as there are numbers and draws.
    #[test]
    fn numbers_scatter_as_the_covariance_says() {
        let motor = motor_with(&[("stribeck", &[0.002, 0.5])]);
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor));
        let problem = problem(&nominal, &runs);
        let fit = fit(&problem, &[("stribeck", &[0.002, 0.5])]);
        let precision = fit.covariance.clone().try_inverse().expect("regular");
        let drawn = with_numbers_drawn(&fit);
        let squares: f64 = (drawn.iter())
            .map(|p| {
                let off = DVector::from_fn(p.len(), |k, _| p[k] - fit.p[k]);
                off.dot(&(&precision * &off))
            })
            .sum();
        let degrees = (drawn.len() * fit.p.len()) as f64;
        let deviations = (squares - degrees) / (2.0 * degrees).sqrt();
        assert!(
            drawn.len() == DRAWS && deviations.abs() < 3.0,
            "{deviations}"
        );
    }

    /// Student's quantiles as tables have them.
    #[test]
    fn quantiles_are_those_of_tables() {
        for (freedom, quantile) in [(1.0, 12.706), (2.0, 4.303), (16.0, 2.120)] {
            assert!((student(freedom) - quantile).abs() < 1e-3, "{freedom}");
        }
    }
}
