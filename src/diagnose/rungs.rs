//! How far the gap shrinks: nominal, refitted, refitted with the effects, floor, on data kept from the fit.
//!
//! A run without which at least half of the samples remain is kept whole and predicted by a fit on the
//! others. The last part of one that holds most of the samples is kept, and predicted through the whole
//! run by a fit on the others and on its first part. How sure they are: `rung_intervals.rs`.

use std::sync::Arc;

use rayon::prelude::*;

use super::data::{PIECE_S, RunData};
use super::effort::{ALL, Effort};
use super::fit::Fit;
use super::kept::Kept;
use super::predict::predict;
use super::problem::Problem;
use super::rung_intervals::{Block, Intervals, intervals, with_numbers_drawn};
use super::verdict::Gap;
use crate::compare::{FLOOR_COUNTS, rms};
use crate::motor::Motor;

/// Share of a run that is fitted where it cannot be kept whole.
const FITTED_SHARE: f64 = 0.6;
/// Most steps of a refit.
const STEPS: usize = 6;
/// Length of a block of the bootstrap in s.
const BLOCK_S: f64 = 0.5;
/// A motor as it was fitted, and with its numbers drawn from what the fit knows of them.
#[derive(Debug, Clone)]
pub(super) struct Refitted {
    motor: Motor,
    drawn: Vec<Motor>,
}

impl Refitted {
    fn new(problem: &Problem<'_>, fit: &Fit) -> Self {
        let of = |p: &[f64]| fit.hypothesis.motor(problem.nominal, p);
        Self {
            motor: of(&fit.p),
            drawn: with_numbers_drawn(fit).iter().map(|p| of(p)).collect(),
        }
    }
}

/// What three models leave of a stretch that they were not fitted to.
struct Left {
    blocks: Vec<Block>,
    /// Squared errors in counts^2 of the refitted models with each of their drawn numbers.
    drawn: Vec<[f64; 2]>,
}

impl Left {
    /// From sample `from` of a run on.
    fn of(
        nominal: &Motor,
        refitted: &Refitted,
        chosen: &Refitted,
        run: &RunData,
        from: usize,
    ) -> Self {
        let models = [nominal, &refitted.motor, &chosen.motor];
        let squares = |motor: &Motor| -> f64 {
            let left = residuals(motor, run, from);
            left.iter().map(|x| x * x).sum()
        };
        let drawn = refitted.drawn.iter().zip(&chosen.drawn);
        Self {
            blocks: blocks(models.map(|motor| residuals(motor, run, from)), run),
            drawn: drawn.map(|(a, b)| [squares(a), squares(b)]).collect(),
        }
    }

    /// Whether all three models can be simulated on it.
    fn is_simulated(&self) -> bool {
        let mut squares = self.blocks.iter().flat_map(|block| block.squares);
        squares.all(f64::is_finite)
    }
}

/// Fits refitted to what is not kept of a run, by that run's number, the set, and its numbers with the wander first.
pub(super) type Refits = Kept<(usize, Vec<usize>, Vec<u64>), Refitted>;

/// What is kept of a run, from sample `from` on, and what is fitted to predict it.
struct Split {
    /// The run's number.
    run: usize,
    from: usize,
    training: Vec<RunData>,
}

/// Whether a run is kept whole: at least half of the samples remain without it.
fn is_kept_whole(problem: &Problem<'_>, run: &RunData) -> bool {
    let total: usize = problem.runs.iter().map(RunData::len).sum();
    problem.runs.len() > 1 && 2 * (total - run.len()) >= total
}

impl Split {
    /// That of run `k`.
    fn of(problem: &Problem<'_>, k: usize) -> Self {
        let run = &problem.runs[k];
        let from = if is_kept_whole(problem, run) {
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
        Self {
            run: k,
            from,
            training,
        }
    }

    /// A fit refitted to that: once, since the rungs and what asks which effects are needed want the same.
    fn refit(&self, problem: &Problem<'_>, fit: &Fit) -> Arc<Refitted> {
        let effects = fit.hypothesis.members.iter().map(|member| member.index);
        let numbers = std::iter::once(&fit.wander)
            .chain(&fit.p)
            .map(|x| x.to_bits());
        let key = (self.run, effects.collect(), numbers.collect());
        (problem.refits).of(key, || refit(problem, &self.training, fit))
    }
}

/// The rungs of the chosen fit beside the refitted model without effects.
pub(super) fn rungs(problem: &Problem<'_>, null: &Fit, chosen: &Fit) -> Gap {
    let whole = problem
        .runs
        .iter()
        .filter(|run| is_kept_whole(problem, run));
    let whole = whole.count();
    let parts = problem.runs.len() - whole;
    let of_run = |(k, run): (usize, &RunData)| {
        let split = Split::of(problem, k);
        let (refitted, with_effects) = rayon::join(
            || split.refit(problem, null),
            || {
                let has_effects = !chosen.hypothesis.members.is_empty();
                has_effects.then(|| split.refit(problem, chosen))
            },
        );
        let with_effects = with_effects.unwrap_or_else(|| refitted.clone());
        Left::of(problem.nominal, &refitted, &with_effects, run, split.from)
    };
    let by_run: Vec<Left> = problem.runs.par_iter().enumerate().map(of_run).collect();
    let held_out = match (whole, parts) {
        (0, _) => "the last 40 % of each run, predicted by a fit on the first 60 %".to_owned(),
        (_, 0) => "each run whole, predicted by a fit on the others".to_owned(),
        _ => "each run whole, predicted by a fit on the others; of a run that holds more than half of \
              the samples the last 40 %, predicted by a fit on the rest"
            .to_owned(),
    };
    gap(&by_run, held_out)
}

/// The rungs on whole runs that nothing was fitted to.
pub(super) fn held_out(problem: &Problem<'_>, null: &Fit, chosen: &Fit, kept: &[RunData]) -> Gap {
    let [null, chosen] = [null, chosen].map(|fit| Refitted::new(problem, fit));
    let kept: Vec<Left> = kept
        .par_iter()
        .map(|run| Left::of(problem.nominal, &null, &chosen, run, 0))
        .collect();
    let words = format!("{} whole, kept from every fit and choice", runs(kept.len()));
    gap(&kept, words)
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
    let [null, chosen] = [null, chosen].map(|fit| refit(problem, &training, fit));
    let kept: Vec<Left> = test
        .par_iter()
        .map(|piece| Left::of(problem.nominal, &null, &chosen, piece, 0))
        .collect();
    gap(
        &kept,
        format!("the last 40 % of each run, by a fit on the first 60 %, predicted {horizon}"),
    )
}

/// What each of these fits leaves of what [`rungs`] keeps of the runs, in counts RMS, refitted to the rest.
pub(super) fn left_of_runs_by(problem: &Problem<'_>, fits: &[&Fit]) -> Vec<f64> {
    let splits: Vec<Split> = (0..problem.runs.len())
        .map(|k| Split::of(problem, k))
        .collect();
    let kept = problem.runs.iter().zip(&splits);
    let samples: usize = kept.map(|(run, split)| run.len() - split.from).sum();
    let left = fits.par_iter().map(|fit| {
        let squares = |(run, split): (&RunData, &Split)| -> f64 {
            let left = residuals(&split.refit(problem, fit).motor, run, split.from);
            left.iter().map(|x| x * x).sum()
        };
        let by_run = problem.runs.par_iter().zip(&splits).map(squares);
        (by_run.sum::<f64>() / samples.max(1) as f64).sqrt()
    });
    left.collect()
}

/// What each of these fits leaves of the last pieces of each run, in counts RMS, refitted to those before; `None` where no
/// piece can be kept.
pub(super) fn left_by(problem: &Problem<'_>, fits: &[&Fit]) -> Option<Vec<f64>> {
    let (training, test) = early_and_late(problem)?;
    let samples: usize = test.iter().map(RunData::len).sum();
    let left = fits.par_iter().map(|fit| {
        let motor = refit(problem, &training, fit).motor;
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

fn gap(kept: &[Left], mut held_out: String) -> Gap {
    // What one of the models cannot be simulated on is measured for none.
    let of = |kept: &[&Left]| -> Vec<Block> {
        kept.iter().flat_map(|kept| kept.blocks.clone()).collect()
    };
    let samples = |blocks: &[Block]| blocks.iter().map(|block| block.samples).sum::<usize>();
    let all = samples(&of(&kept.iter().collect::<Vec<_>>()));
    let kept: Vec<&Left> = kept.iter().filter(|kept| kept.is_simulated()).collect();
    let whole = of(&kept);
    let left = samples(&whole);
    if left < all {
        let share = 100.0 * (all - left) as f64 / all as f64;
        held_out +=
            &format!("; without {share:.1} % of the samples, on which a model cannot be simulated");
    }
    let [before, after_parameters, after_effect] = pooled(&whole);
    let draws = kept.iter().map(|kept| kept.drawn.len()).min().unwrap_or(0);
    let drawn: Vec<[f64; 3]> = (0..draws)
        .map(|draw| {
            let squares = |model: usize| kept.iter().map(|kept| kept.drawn[draw][model]).sum();
            let rms = |squares: f64| (squares / left.max(1) as f64).sqrt();
            [before, rms(squares(0)), rms(squares(1))]
        })
        .filter(|rungs| rungs.iter().all(|rung| rung.is_finite()))
        .collect();
    let Intervals {
        rungs: rungs95,
        closed: (closed_lo95, closed_hi95),
        closed_deviation,
    } = intervals(&whole, &drawn);
    Gap {
        metric: "position_rmse_counts",
        floor: FLOOR_COUNTS,
        before,
        after_parameters,
        after_effect,
        closed: closed(before, after_effect),
        closed_lo95,
        closed_hi95,
        closed_deviation,
        rungs95,
        held_out,
    }
}

/// The motor of a hypothesis fitted to other data, from where it fitted before: on shorter horizons first, unless all work is spent.
fn refit(problem: &Problem<'_>, training: &[RunData], fit: &Fit) -> Refitted {
    let mut levels = vec![3.0 * fit.wander, fit.wander];
    if !problem.effort.is_left(ALL) {
        levels.remove(0);
    }
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
    Refitted::new(problem, found.as_ref().unwrap_or(fit))
}

/// Squared errors of three models block by block, from what they leave of the last samples of a run.
fn blocks(residuals: [Vec<f64>; 3], run: &RunData) -> Vec<Block> {
    let samples = residuals[0].len();
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
    let x = predict(motor, run, &Effort::default()).unwrap_or_else(|| vec![f64::NAN; run.len()]);
    let raw: Vec<f64> = run.counts.iter().zip(&x).map(|(n, x)| n - x).collect();
    let kept = &raw[from..];
    let mean = kept.iter().sum::<f64>() / kept.len().max(1) as f64;
    // Where inside a count the shaft started.
    let start = mean.clamp(0.0, 1.0);
    kept.iter().map(|r| r - start).collect()
}

/// What each model leaves of all blocks, in counts RMS.
pub(super) fn pooled(blocks: &[Block]) -> [f64; 3] {
    let samples: usize = blocks.iter().map(|block| block.samples).sum();
    std::array::from_fn(|m| {
        let squares: f64 = blocks.iter().map(|block| block.squares[m]).sum();
        rms([(squares / samples.max(1) as f64).sqrt()])
    })
}

/// Share of the gap above the floor that is closed; 0 where there was none.
pub(super) fn closed(before: f64, after: f64) -> f64 {
    let gap = before - FLOOR_COUNTS;
    if gap <= 0.0 {
        return 0.0;
    }
    (1.0 - (after - FLOOR_COUNTS).max(0.0) / gap).max(-1.0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

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
