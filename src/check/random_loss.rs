//! Edges that are lost at random in one direction.
//!
//! A counter that misses each edge with probability `p` shows `n = (1 - p) N` of `N` edges in a time bin, with the
//! binomial variance `N p (1 - p) = n p`. `p` is estimated twice: from the counts in the two directions under equal
//! commands, and from the variance of the counts in short bins. Driver, brushes and friction can cause the same
//! difference of speed, but inertia keeps it smooth; a rough shaft is rough in both directions. The second difference
//! of three bins removes speed and acceleration: its variance is six times that of independent counts, and 20/12 for
//! quantization (1, -3, 3, -1).

use super::edges_lost::DIFFERS;
use super::subject::Subject;
use crate::recording::{Run, Steps};

/// Counts in a bin at the usual speed: with fewer, quantization hides the loss; in longer bins the speed changes.
const BIN_COUNTS: f64 = 8.0;
/// Bins with fewer counts are no steady motion.
const LEAST_COUNTS: f64 = 4.0;
/// Fewest differences in each direction: the variance then has an error of 25 %, as neighbouring differences share
/// two bins.
const LEAST_BINS: usize = 60;
/// Variance of a second difference: as a multiple of the variance of independent counts, and for quantization.
const OF_INDEPENDENT: f64 = 6.0;
const OF_QUANTIZATION: f64 = 20.0 / 12.0;
/// Squared differences up to this quantile are averaged, so that starts and shocks have no weight; for a normal
/// distribution their mean is this share of the variance.
const KEPT: f64 = 0.9;
const KEPT_VARIANCE: f64 = 0.623;
/// Largest relative difference of the integrals and of the squares of the commands in the two directions.
const ALIKE: f64 = 0.25;
/// The two estimates of the probability agree within this factor.
const AGREE: f64 = 2.0;
/// Largest variance of the other direction, relative to the losing one.
const SMOOTH: f64 = 0.3;

/// Edges lost at random in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RandomLoss {
    /// Share of the edges that is lost, from the counts in the two directions.
    pub share: f64,
    /// The same from the variance of the counts in bins.
    pub by_variance: f64,
    /// The estimate from the variance in the other direction.
    pub other_variance: f64,
    /// -1 if the negative direction loses.
    pub sign: f64,
}

#[derive(Debug, Default)]
struct Direction {
    counts: f64,
    command: f64,
    command_squared: f64,
    squares: Vec<f64>,
    of_counts: f64,
}

impl Direction {
    /// Variance of the counts in a bin over their mean.
    fn variance(&mut self) -> Option<f64> {
        let many = self.squares.len();
        if many < LEAST_BINS {
            return None;
        }
        self.squares.sort_by(f64::total_cmp);
        let kept = &self.squares[..(KEPT * many as f64) as usize];
        let variance = kept.iter().sum::<f64>() / kept.len() as f64 / KEPT_VARIANCE;
        let mean = self.of_counts / many as f64;
        Some((variance - OF_QUANTIZATION) / OF_INDEPENDENT / mean)
    }
}

pub(super) fn find(subject: &Subject<'_>) -> Option<RandomLoss> {
    let run = subject.run;
    if run.is_integrated() {
        return None;
    }
    let mut directions = [Direction::default(), Direction::default()];
    fill(run, &mut directions)?;
    let [negative, positive] = &mut directions;
    let (first, second) = (negative.variance()?, positive.variance()?);
    let alike = |a: f64, b: f64| a.min(b) >= (1.0 - ALIKE) * a.max(b);
    let is_comparable = alike(negative.command, positive.command)
        && alike(negative.command_squared, positive.command_squared);
    let rates = [negative, positive].map(|one| one.counts / one.command);
    let loses_negative = rates[0] < rates[1];
    let (less, more) = if loses_negative {
        (rates[0], rates[1])
    } else {
        (rates[1], rates[0])
    };
    let (by_variance, other_variance) = if loses_negative {
        (first, second)
    } else {
        (second, first)
    };
    let share = 1.0 - less / more;
    let is_found = is_comparable
        && share >= DIFFERS
        && other_variance <= SMOOTH * by_variance
        && (share / AGREE..=share * AGREE).contains(&by_variance);
    is_found.then_some(RandomLoss {
        share,
        by_variance,
        other_variance,
        sign: if loses_negative { -1.0 } else { 1.0 },
    })
}

/// Counts, commands and differences of both directions; `None` for a shaft that hardly moves.
fn fill(run: &Run, directions: &mut [Direction; 2]) -> Option<()> {
    let usual_s = Steps::of(run)?.median_s();
    let mut moving: Vec<u64> = (run.counts.windows(2))
        .map(|pair| pair[1].abs_diff(pair[0]))
        .filter(|&counts| counts > 0)
        .collect();
    moving.sort_unstable();
    let usual = *moving.get(moving.len() / 2)? as f64;
    let bin = (BIN_COUNTS / usual).ceil().max(1.0) as usize;
    let bin_s = bin as f64 * usual_s;
    let mut last: Vec<f64> = Vec::new();
    for from in (0..run.len().saturating_sub(bin)).step_by(bin) {
        let to = from + bin;
        let lasts_s = run.t_s[to] - run.t_s[from];
        let counts = run.counts[to].saturating_sub(run.counts[from]) as f64;
        for k in from..to {
            let one = &mut directions[usize::from(run.command[k] > 0.0)];
            let step_s = run.t_s[k + 1] - run.t_s[k];
            one.command += run.command[k].abs() * step_s;
            one.command_squared += run.command[k].powi(2) * step_s;
        }
        let one = &mut directions[usize::from(counts > 0.0)];
        one.counts += counts.abs();
        let is_usual = (lasts_s - bin_s).abs() <= DIFFERS * bin_s;
        if !is_usual || counts.abs() < LEAST_COUNTS || last.iter().any(|n| n * counts < 0.0) {
            last.clear();
            continue;
        }
        last.push(counts * bin_s / lasts_s);
        if let [a, b, c] = last[..] {
            one.squares.push((a - 2.0 * b + c).powi(2));
            one.of_counts += b.abs();
            last.remove(0);
        }
    }
    Some(())
}
