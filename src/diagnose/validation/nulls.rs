//! What chance makes of the best of all rivals: the same question asked of recordings simulated from the smaller model.
//!
//! A recording: the fitted model's prediction, a load that wanders, a start anywhere in a count, rounding down, and numbers of the
//! motor drawn from what was known of them. Its statistic is the largest gain of all candidates (a parametric bootstrap of the score
//! test: Davison and Hinkley, 1997, ch. 4).

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::diagnose::fit::{Fit, less_start};
use crate::diagnose::noise::{Noise, Passing, Surroundings};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::screening::Screen;
use crate::diagnose::settings::NULLS;

/// Whether something is there.
#[derive(Debug, Clone)]
pub(crate) struct Presence {
    /// Largest gain of all in the recording.
    pub gain: f64,
    /// The same in each simulated one, smallest first.
    pub by_chance: Vec<f64>,
}

impl Presence {
    /// Share of simulated recordings that gain as much, by chance one more.
    pub fn p_value(&self) -> f64 {
        let as_much = self.by_chance.iter().filter(|g| **g >= self.gain).count();
        (as_much + 1) as f64 / (self.by_chance.len() + 1) as f64
    }

    /// Whether a simulated recording gains as much.
    pub fn is_by_chance(&self) -> bool {
        self.by_chance.last().is_none_or(|most| *most >= self.gain)
    }

    /// Nats that it gains beyond the most that chance makes.
    pub fn beyond_chance(&self) -> f64 {
        self.gain - self.by_chance.last().copied().unwrap_or(0.0)
    }
}

pub(crate) fn presence(pieces: &Pieces, fit: &Fit, screen: &Screen, noise: Noise) -> Presence {
    let distance = DVector::from_column_slice(&fit.x) - &fit.model.mean;
    let best = |gains: Vec<crate::diagnose::screening::Gain>| {
        gains.iter().map(|g| g.nats).fold(0.0, f64::max)
    };
    let gain = best(screen.gains(&fit.residual, &distance, true));
    let predicted = fit.predicted(pieces);
    let mut precision = fit.model.precision_as_unlikely(&fit.x);
    // A phase is anywhere: nothing is said of it, so that it may be drawn from anything.
    for k in (0..distance.len()).filter(|k| fit.model.precision[(*k, *k)] == 0.0) {
        precision[(k, k)] = 1.0;
    }
    let draw = precision.cholesky().map(|c| c.l().transpose());
    let mut by_chance: Vec<f64> = (0..NULLS as u64)
        .into_par_iter()
        .map(|seed| {
            let mut random = Pcg64Mcg::seed_from_u64(0x6e75_6c6c ^ seed);
            let residual = residual_by_chance(pieces, &predicted, &fit.around, noise, &mut random);
            let z = DVector::from_fn(distance.len(), |_, _| StandardNormal.sample(&mut random));
            let distance = draw
                .as_ref()
                .and_then(|l| l.clone().solve_upper_triangular(&z))
                .unwrap_or(z);
            best(screen.gains(&residual, &distance, false))
        })
        .collect();
    by_chance.sort_by(f64::total_cmp);
    Presence { gain, by_chance }
}

/// Mean square in counts^2 of the position error that a model leaves of recordings simulated from it, as it is shown.
pub(crate) fn left_by_chance(pieces: &Pieces, fit: &Fit, noise: Noise) -> f64 {
    let predicted = fit.predicted(pieces);
    let one = |seed: u64| {
        let mut random = Pcg64Mcg::seed_from_u64(0x666c_6f6f ^ seed);
        let left = residual_by_chance(pieces, &predicted, &fit.around, noise, &mut random);
        let left = less_start(pieces, fit.around.time_constant_s, &left);
        left.iter().map(|r| r * r).sum::<f64>() / left.len().max(1) as f64
    };
    // Added in the order of the seeds: in that of the threads the last bits would be theirs.
    let each: Vec<f64> = (0..NULLS as u64).into_par_iter().map(one).collect();
    each.iter().sum::<f64>() / NULLS as f64
}

/// Recorded less predicted, of a recording simulated from the model.
pub(crate) fn residual_by_chance(
    pieces: &Pieces,
    predicted: &[f64],
    around: &Surroundings,
    noise: Noise,
    random: &mut Pcg64Mcg,
) -> Vec<f64> {
    let mut out = Vec::with_capacity(pieces.len);
    let sigma = noise.strength * around.stall_counts_s2;
    let mut passing = Passing::new(around.time_constant_s, noise.time_s);
    let normal = |random: &mut Pcg64Mcg| -> f64 { StandardNormal.sample(random) };
    for piece in &pieces.pieces {
        let run = &pieces.runs[piece.run];
        let (mut x, mut v, mut d) = (
            0.0,
            normal(random) * piece.start_speed_sd,
            sigma * normal(random),
        );
        let fraction: f64 = random.random_range(0.0..1.0);
        let predicted = &predicted[pieces.range(piece)];
        out.push(0.0);
        for k in piece.from + 1..piece.to {
            // A shaft at rest forgets how fast it was.
            let step = passing.step(run.t_s[k] - run.t_s[k - 1], run.moving[k]);
            x += step.f01 * v + step.f02 * d;
            v = step.f11 * v + step.f12 * d;
            let renewed = sigma * (1.0 - step.f22 * step.f22).sqrt();
            d = step.f22 * d + renewed * normal(random);
            if around.loss > 0.0 {
                let travelled = (run.counts[k] - run.counts[k - 1]).abs();
                x += (around.loss * travelled).sqrt() * normal(random);
            }
            let scatter = run.scatter(noise, k);
            if scatter > 0.0 {
                x += scatter * normal(random);
            }
            let late = run.speed[k] * around.jitter_s * (random.random_range(0.0..1.0) - 0.5);
            let p = predicted[k - piece.from];
            out.push((p + x + late + fraction).floor() - p);
        }
    }
    out
}
