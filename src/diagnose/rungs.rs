//! How far the gap shrinks: nominal, refitted, refitted with the effects, floor, on data kept from the fit.
//!
//! A run without which at least half of the samples remain is kept whole and predicted by a fit on the
//! others. The last part of one that holds most of the samples is kept, and predicted through the whole
//! run by a fit on the others and on its first part. The interval is a bootstrap over half-second blocks.

use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

use super::data::{PIECE_S, RunData};
use super::fit::{Fit, Problem};
use super::predict::predict;
use super::verdict::Gap;
use crate::compare::{FLOOR_COUNTS, rms};
use crate::motor::Motor;

/// Share of a run that is fitted where it cannot be kept whole.
const FITTED_SHARE: f64 = 0.6;
/// Most steps of a refit.
const STEPS: usize = 6;
/// Length of a block of the bootstrap in s.
const BLOCK_S: f64 = 0.5;
/// Student's t for 95 % of both sides with 1, 2, ... degrees of freedom.
const STUDENT: [f64; 9] = [
    12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262,
];
/// A run whose gap above the floor is smaller, in counts, does not tell which share is closed.
const LEAST_GAP_COUNTS: f64 = 1.0;
/// Bootstrap samples.
const RESAMPLES: usize = 400;

/// A stretch of a run that a model was not fitted to.
#[derive(Debug, Clone, Copy)]
struct Block {
    /// Squared errors in counts^2 under the three models.
    squares: [f64; 3],
    samples: usize,
    /// Number of its run.
    run: usize,
}

/// The rungs of the chosen fit beside the refitted model without effects.
pub(super) fn rungs(problem: &Problem<'_>, null: &Fit, chosen: &Fit) -> Gap {
    let total: usize = problem.runs.iter().map(RunData::len).sum();
    let is_kept_whole = |run: &RunData| problem.runs.len() > 1 && 2 * (total - run.len()) >= total;
    let whole = problem.runs.iter().filter(|run| is_kept_whole(run)).count();
    let parts = problem.runs.len() - whole;
    let of_run = |(k, run): (usize, &RunData)| {
        let from = if is_kept_whole(run) {
            0
        } else {
            (run.len() as f64 * FITTED_SHARE) as usize
        };
        let mut training: Vec<RunData> = Vec::new();
        for (j, other) in problem.runs.iter().enumerate() {
            if j != k {
                training.push(other.clone());
            } else if let (true, Ok(head)) = (from > 1, run.head(from)) {
                training.push(head);
            }
        }
        let (refitted, with_effects) = rayon::join(
            || refit(problem, &training, null),
            || {
                let has_effects = !chosen.hypothesis.members.is_empty();
                has_effects.then(|| refit(problem, &training, chosen))
            },
        );
        let with_effects = with_effects.unwrap_or_else(|| refitted.clone());
        errors(
            &[problem.nominal.clone(), refitted, with_effects],
            run,
            from,
        )
    };
    let by_run: Vec<Vec<Block>> = problem.runs.par_iter().enumerate().map(of_run).collect();
    let blocks = by_run.concat();
    let held_out = match (whole, parts) {
        (0, _) => "the last 40 % of each run, predicted by a fit on the first 60 %".to_owned(),
        (_, 0) => "each run whole, predicted by a fit on the others".to_owned(),
        _ => "each run whole, predicted by a fit on the others; of a run that holds more than half of \
              the samples the last 40 %, predicted by a fit on the rest"
            .to_owned(),
    };
    gap(&blocks, held_out)
}

/// The rungs on whole runs that nothing was fitted to.
pub(super) fn held_out(problem: &Problem<'_>, null: &Fit, chosen: &Fit, kept: &[RunData]) -> Gap {
    let of = |fit: &Fit| fit.hypothesis.motor(problem.nominal, &fit.p);
    let models = [problem.nominal.clone(), of(null), of(chosen)];
    let blocks: Vec<Block> = kept
        .iter()
        .flat_map(|run| errors(&models, run, 0))
        .collect();
    let words = format!("{} whole, kept from every fit and choice", runs(kept.len()));
    gap(&blocks, words)
}

/// The rungs on pieces, each predicted from the angle and the speed recorded at its start: those of runs kept from
/// everything, or the last of each run by a fit on those before.
pub(super) fn by_pieces(problem: &Problem<'_>, null: &Fit, chosen: &Fit, kept: &[RunData]) -> Gap {
    let longest_s = (problem.runs.iter())
        .filter_map(|run| Some(run.t_s.last()? - run.t_s.first()?))
        .fold(0.0, f64::max);
    let horizon = format!("{longest_s:.1} s at a time from the recorded angle and speed");
    if !kept.is_empty() {
        let found = held_out(problem, null, chosen, kept);
        let held = 1 + kept.iter().map(|piece| piece.origin).max().unwrap_or(0);
        let held_out = format!(
            "{} whole, kept from every fit and choice, predicted {horizon}",
            runs(held)
        );
        return Gap { held_out, ..found };
    }
    let Some((training, test)) = early_and_late(problem) else {
        return rungs(problem, null, chosen);
    };
    let models = [
        problem.nominal.clone(),
        refit(problem, &training, null),
        refit(problem, &training, chosen),
    ];
    let blocks: Vec<Block> = test
        .iter()
        .flat_map(|piece| errors(&models, piece, 0))
        .collect();
    gap(
        &blocks,
        format!("the last 40 % of each run, by a fit on the first 60 %, predicted {horizon}"),
    )
}

/// What each of these fits leaves of the last pieces of each run, in counts RMS, refitted to those before; `None` where no
/// piece can be kept.
pub(super) fn left_by(problem: &Problem<'_>, fits: &[&Fit]) -> Option<Vec<f64>> {
    let (training, test) = early_and_late(problem)?;
    let samples: usize = test.iter().map(RunData::len).sum();
    let left = fits.par_iter().map(|fit| {
        let motor = refit(problem, &training, fit);
        let squares = |piece: &RunData| -> f64 {
            let left = residuals(&motor, piece, 0);
            left.iter().map(|x| x * x).sum()
        };
        (test.iter().map(squares).sum::<f64>() / samples as f64).sqrt()
    });
    Some(left.collect())
}

/// How many pieces that is; those shorter than a second, which are not apart enough to tell anew, by their share of one.
pub(super) fn kept_pieces(problem: &Problem<'_>) -> f64 {
    let late = early_and_late(problem).map_or_else(Vec::new, |(_, late)| late);
    let lasts_s = |piece: &RunData| piece.sample_time_s * piece.len() as f64;
    late.iter()
        .map(|piece| (lasts_s(piece) / PIECE_S).min(1.0))
        .sum()
}

/// The pieces of the first part of each run, and the others; `None` where there are not both.
fn early_and_late(problem: &Problem<'_>) -> Option<(Vec<RunData>, Vec<RunData>)> {
    let is_early = |k: usize| {
        let origin = problem.runs[k].origin;
        let same = |run: &&RunData| run.origin == origin;
        let count = problem.runs.iter().filter(same).count();
        let before = problem.runs[..k].iter().filter(same).count();
        count > 1 && ((before as f64) < FITTED_SHARE * count as f64)
    };
    let (mut early, mut late) = (Vec::new(), Vec::new());
    for (k, piece) in problem.runs.iter().enumerate() {
        if is_early(k) {
            early.push(piece.clone());
        } else {
            late.push(piece.clone());
        }
    }
    (!early.is_empty() && !late.is_empty()).then_some((early, late))
}

/// What edges lost by chance leave of a right model in open loop, in counts RMS: each is an error of one count from then on,
/// so that the variance after a travel of `n` counts is `q (1 - q) n`.
pub(super) fn lost_by_chance(problem: &Problem<'_>, fit: &Fit) -> f64 {
    let q = problem
        .noise(&fit.hypothesis, &fit.p, fit.wander)
        .lost_share;
    let (mut squares, mut samples) = (0.0, 0);
    for run in problem.runs {
        let mut travel = 0.0;
        for pair in run.counts.windows(2) {
            travel += (pair[1] - pair[0]).abs();
            squares += q * (1.0 - q) * travel;
        }
        samples += run.len();
    }
    (squares / samples.max(1) as f64).sqrt()
}

fn runs(count: usize) -> String {
    match count {
        1 => "one run".to_owned(),
        _ => format!("{count} runs"),
    }
}

fn gap(blocks: &[Block], mut held_out: String) -> Gap {
    // What one of the models cannot be simulated on is measured for none.
    let whole: Vec<Block> = blocks
        .iter()
        .filter(|block| block.squares.iter().all(|x| x.is_finite()))
        .copied()
        .collect();
    let all: usize = blocks.iter().map(|block| block.samples).sum();
    let left: usize = whole.iter().map(|block| block.samples).sum();
    if left < all {
        let share = 100.0 * (all - left) as f64 / all as f64;
        held_out +=
            &format!("; without {share:.1} % of the samples, on which a model cannot be simulated");
    }
    let blocks = whole.as_slice();
    let [before, after_parameters, after_effect] = pooled(blocks);
    let (rungs95, (closed_lo95, closed_hi95)) = intervals(blocks);
    Gap {
        metric: "position_rmse_counts",
        floor: FLOOR_COUNTS,
        before,
        after_parameters,
        after_effect,
        closed: closed(before, after_effect),
        closed_lo95,
        closed_hi95,
        rungs95,
        held_out,
    }
}

/// The motor of a hypothesis fitted to other data, from where it fitted before.
fn refit(problem: &Problem<'_>, training: &[RunData], fit: &Fit) -> Motor {
    let levels = vec![3.0 * fit.wander, fit.wander];
    let part = Problem::new(
        problem.nominal,
        training,
        problem.damping,
        levels,
        problem.rough,
    )
    .with_rounding(problem.rounding)
    .holding(problem.setting.is_held);
    let found = part.fit(&fit.hypothesis, &fit.p, STEPS);
    let p = found.map_or_else(|| fit.p.clone(), |found| found.p);
    fit.hypothesis.motor(problem.nominal, &p)
}

/// Squared errors from sample `from` on, block by block.
fn errors(models: &[Motor; 3], run: &RunData, from: usize) -> Vec<Block> {
    let residuals = models.each_ref().map(|motor| residuals(motor, run, from));
    let samples = run.len() - from;
    let length = ((BLOCK_S / run.sample_time_s).round() as usize).max(1);
    (0..samples)
        .step_by(length)
        .map(|first| {
            let last = (first + length).min(samples);
            let squares = residuals
                .each_ref()
                .map(|r| r[first..last].iter().map(|x| x * x).sum());
            Block {
                squares,
                samples: last - first,
                run: run.origin,
            }
        })
        .collect()
}

/// Recorded less predicted counts from sample `from` on; not a number where the motor cannot be simulated.
fn residuals(motor: &Motor, run: &RunData, from: usize) -> Vec<f64> {
    let x = predict(motor, run).unwrap_or_else(|| vec![f64::NAN; run.len()]);
    let raw: Vec<f64> = run.counts.iter().zip(&x).map(|(n, x)| n - x).collect();
    let kept = &raw[from..];
    let mean = kept.iter().sum::<f64>() / kept.len().max(1) as f64;
    // Where inside a count the shaft started.
    let start = mean.clamp(0.0, 1.0);
    kept.iter().map(|r| r - start).collect()
}

fn pooled(blocks: &[Block]) -> [f64; 3] {
    let samples: usize = blocks.iter().map(|block| block.samples).sum();
    std::array::from_fn(|m| {
        let squares: f64 = blocks.iter().map(|block| block.squares[m]).sum();
        rms([(squares / samples.max(1) as f64).sqrt()])
    })
}

/// Share of the gap above the floor that is closed; 0 where there was none.
fn closed(before: f64, after: f64) -> f64 {
    let gap = before - FLOOR_COUNTS;
    if gap <= 0.0 {
        return 0.0;
    }
    (1.0 - (after - FLOOR_COUNTS).max(0.0) / gap).max(-1.0)
}

/// 95 % intervals of the three rungs by drawing the blocks again; that of the share closed spans this and what one more
/// run may show, judged by how much the runs differ: `mean +- t s sqrt(1 + 1/n)`.
fn intervals(blocks: &[Block]) -> ([(f64, f64); 3], (f64, f64)) {
    if blocks.is_empty() {
        return ([(0.0, 0.0); 3], (0.0, 0.0));
    }
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let mut rungs: [Vec<f64>; 3] = Default::default();
    let mut shares = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        let drawn: Vec<Block> = (0..blocks.len())
            .map(|_| blocks[rng.random_range(0..blocks.len())])
            .collect();
        let found = pooled(&drawn);
        for (rung, value) in rungs.iter_mut().zip(found) {
            rung.push(value);
        }
        shares.push(closed(found[0], found[2]));
    }
    let (lo, hi) = middle95(shares);
    let (next_lo, next_hi) = next_run95(blocks).unwrap_or((lo, hi));
    (rungs.map(middle95), (lo.min(next_lo), hi.max(next_hi)))
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
    let quantile = STUDENT.get(shares.len().checked_sub(2)?).unwrap_or(&2.0);
    let mean = shares.iter().sum::<f64>() / n;
    let variance = shares.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let half = quantile * (variance * (1.0 + 1.0 / n)).sqrt();
    Some(((mean - half).max(-1.0), (mean + half).min(1.0)))
}

/// Where the middle 95 % of the values lie.
fn middle95(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    (at(0.025), at(0.975))
}

#[cfg(test)]
mod tests {
    use super::super::samples::{held_at, motor_with, problem, ready, recording};
    use super::*;

    /// Edges thrown away one by one, by no code of the diagnosis, forty times over.
    #[test]
    fn what_chance_takes_is_what_edges_thrown_away_one_by_one_leave() {
        const LOST: f64 = 0.02;
        const TIMES: usize = 40;
        let motor = motor_with(&[]);
        let run = recording(&motor);
        let runs = ready(&run);
        let problem = problem(&motor, &runs);
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        let (mut squares, mut samples) = (0.0, 0);
        for _ in 0..TIMES {
            let mut off = 0.0;
            for pair in run.counts.windows(2) {
                let step = pair[1] - pair[0];
                for _ in 0..step.abs() {
                    let lost = f64::from(u8::from(rng.random_bool(LOST)));
                    // Beside those that are lost on average.
                    off += step.signum() as f64 * (LOST - lost);
                }
                squares += off * off;
                samples += 1;
            }
        }
        let drawn = (squares / f64::from(samples)).sqrt();
        let fit = held_at(&problem, &[("missed_counts", &[LOST, 0.0])]);
        let said = lost_by_chance(&problem, &fit);
        assert!(
            (0.8 * drawn..1.25 * drawn).contains(&said),
            "{said}, drawn {drawn}"
        );
    }
}
