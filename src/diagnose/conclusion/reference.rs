//! Then and now: what differs between the runs and reference runs of the same axis.
//!
//! The reference is diagnosed first. The motor that it comes to is the nominal one of the runs, with its numbers as well known as the
//! reference tells them: a joint fit in which every number is shared, to second order. What an effect sets free differs by set.
//!
//! What the runs show may have been there all along, where the reference does not tell. So every effect that is found is asked of the
//! reference too: a change is only what the reference predicts its own pieces worse with.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, Exp1};
use rand_pcg::Pcg64Mcg;

use super::floor::{Apart, repeats};
use super::intervals::{WITHIN_95, ends};
use super::weights::Weights;
use crate::diagnose::error::name_of;
use crate::diagnose::fit::{BASE, Base, Fit, Member, Model, Most, Then, dot, fit, unweighted};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::report::ReferenceRuns;
use crate::diagnose::selection::Forward;
use crate::diagnose::settings::{CLUSTERED_RUNS, SAME_AXIS};
use crate::diagnose::validation::standing;
use crate::motor::Motor;
use crate::motor::catalogue::catalogue;
use crate::motor::fit::ParameterId;
use crate::recording::Run;

/// Draws of the bootstrap.
const DRAWS: u64 = 400;
/// Least standard deviation of a threshold, as a share of its range.
const LEAST_WIDTH: f64 = 1e-3;

/// Reference runs as they were diagnosed, for the runs that are held against them.
#[derive(Debug)]
pub(crate) struct Reference {
    pub pieces: Pieces,
    pub base: Base,
    /// The set of effects that explains them, of several that they do not tell apart the one that explains the other runs too.
    pub fit: Fit,
    /// Recorded less predicted in counts, each piece by a fit on the other folds.
    predicted: Vec<f64>,
    /// What those differ by that repeat each other.
    pub repeats: Vec<Apart>,
    /// What they are called.
    pub runs: Vec<String>,
}

/// What has changed since the reference.
#[derive(Debug)]
pub(crate) struct Changes {
    /// The search with the effects alone that have changed.
    pub found: Forward,
    pub weights: Weights,
    /// Sets that the runs show and that the reference may have had as well.
    pub alike: Vec<Vec<&'static str>>,
}

impl Reference {
    /// The reference of some runs, and the base of their own diagnosis; none where no model can be simulated.
    pub fn new(
        runs: &[Run],
        (pieces, base): (Pieces, Base),
        found: &Forward,
        now: &Pieces,
    ) -> Option<(Self, Base)> {
        let kept = found.levels.iter().rfind(|level| level.is_kept);
        let tied: Vec<&Fit> = match kept {
            Some(level) => level.tied().map(|(fit, _)| fit).collect(),
            None => vec![&found.best],
        };
        let both = tied.into_iter().filter_map(|then| {
            let base = as_then(&pieces, &base, then)?;
            let model = Model::new(&base, Vec::new());
            let most = Most::of_start(now, &model, base.kind)?;
            let again = fit(now, &model, base.kind, &[model.start()], most)?;
            Some((then.score() + again.score(), then, base))
        });
        let (_, then, now) = both.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let fit = then.clone();
        let left = unweighted(&pieces, &fit.model, base.kind, std::slice::from_ref(&fit.x))?;
        let reference = Self {
            predicted: left.predicted,
            repeats: repeats(runs, &pieces, &[]),
            runs: (runs.iter().enumerate())
                .map(|(k, run)| name_of(k, run))
                .collect(),
            pieces,
            base,
            fit,
        };
        Some((reference, now))
    }

    /// What the document says of it.
    pub fn report(&self) -> ReferenceRuns {
        ReferenceRuns {
            runs: self.runs.clone(),
            effects: self.fit.model.ids(),
            left_counts: (dot(&self.predicted, &self.predicted) / self.predicted.len() as f64)
                .sqrt(),
        }
    }

    /// Effects of a set that differ from the reference: those with which, as the runs have them, it predicts its own pieces worse.
    fn changed(&self, pieces: &Pieces, now: &Fit) -> Vec<&'static str> {
        let own = self.fit.model.motor(&self.fit.x);
        let is_changed = |member: &&Member| {
            let others = self.fit.model.members.iter();
            let others: Vec<Member> = others
                .filter(|m| m.index != member.index)
                .cloned()
                .collect();
            let alike = self
                .with(pieces, now, member)
                .into_iter()
                .filter_map(|base| {
                    let model = Model::new(&base, others.clone());
                    let starts = [model.start(), start_at(&model, &own)];
                    let most = Most::of_start(&self.pieces, &model, base.kind)?;
                    fit(&self.pieces, &model, base.kind, &starts, most)
                });
            let alike = alike.max_by(|a, b| a.score().total_cmp(&b.score()));
            alike.is_none_or(|alike| !standing(&[&self.fit, &alike])[1].is_tied)
        };
        let changed = now.model.members.iter().filter(is_changed);
        let mut ids: Vec<&str> = changed.map(Member::id).collect();
        ids.sort_unstable();
        ids
    }

    /// The base of the reference with one effect as other runs have it: at its value there, and at the ends of what is known of it.
    fn with(&self, pieces: &Pieces, now: &Fit, member: &Member) -> Vec<Base> {
        let motor = now.model.motor(&now.x);
        if let Some(number) = now.model.frees(member) {
            let key = BASE[number];
            let mut base = self.base.clone();
            let own = (now.model.numbers.iter()).position(|n| n.id.key() == key);
            let (Some(k), Some(slot)) = (own, base.motor.parameters.get_mut(key)) else {
                return Vec::new();
            };
            *slot = now.model.numbers[k].value(now.x[k]);
            let (lo, hi) = ends(pieces, now, k);
            let sd = 0.5 * (hi - lo) / WITHIN_95 / now.x[k];
            base.motor
                .tolerance
                .insert(key.to_owned(), sd.hypot(SAME_AXIS));
            return vec![base];
        }
        let Some(effect) = motor.effects.get(member.id()) else {
            return Vec::new();
        };
        let free = now.model.numbers.iter().position(
            |number| matches!(number.id, ParameterId::Effect(of, _) if of == member.index),
        );
        let mut motors = vec![self.base.motor.clone()];
        motors[0].effects.set(*effect);
        if let Some(k) = free {
            let number = &now.model.numbers[k];
            let (lo, hi) = ends(pieces, now, k);
            for end in [lo, hi] {
                let mut motor = motors[0].clone();
                number.id.set(&mut motor, number.value(end));
                motors.push(motor);
            }
        }
        let bases = motors.into_iter().map(|motor| Base {
            motor,
            ..self.base.clone()
        });
        bases.collect()
    }

    /// How much likelier it is that more is left of the runs than of the reference, each piece predicted by fits on others, than less:
    /// of what is unknown in the runs, this share has changed.
    pub fn share_of_unknown(&self, pieces: &Pieces, predicted: &[f64]) -> f64 {
        let mut random = Pcg64Mcg::seed_from_u64(0x7468_656e);
        let mut left = |pieces: &Pieces, predicted: &[f64]| -> f64 {
            let (mut squares, mut samples) = (0.0, 0.0);
            for piece in &pieces.pieces {
                let weight: f64 = Exp1.sample(&mut random);
                let of_piece = &predicted[pieces.range(piece)];
                squares += weight * of_piece.iter().map(|r| r * r).sum::<f64>();
                samples += weight * of_piece.len() as f64;
            }
            squares / samples
        };
        let is_more = |_: &u64| left(pieces, predicted) > left(&self.pieces, &self.predicted);
        let more = (0..DRAWS).filter(is_more).count() as f64 / DRAWS as f64;
        (2.0 * more - 1.0).max(0.0)
    }

    /// What has changed, of what was found: the sets that the runs do not tell apart without the effects that the reference has too.
    pub fn changes(&self, pieces: &Pieces, found: &Forward, mut weights: Weights) -> Changes {
        let fits = || {
            std::iter::once(&found.best).chain(found.levels.iter().flat_map(|level| &level.fits))
        };
        let mut sets: Vec<Vec<&'static str>> = Vec::new();
        let mut alike = Vec::new();
        let mut moved = Vec::new();
        for set in &found.sets {
            let fit = fits().find(|fit| fit.model.ids() == *set);
            let changed = fit.map_or_else(|| set.clone(), |fit| self.changed(pieces, fit));
            if changed.len() < set.len() {
                let is_kept = |id: &&&'static str| !changed.contains(*id);
                alike.push(set.iter().filter(is_kept).copied().collect());
            }
            moved.push((set.clone(), changed.clone()));
            if !sets.contains(&changed) {
                sets.push(changed);
            }
        }
        // Where one of them needs no change, no change is shown.
        let is_none = sets.iter().any(Vec::is_empty);
        for (set, changed) in moved {
            let changed = if is_none { Vec::new() } else { changed };
            weights.rename(&set, changed);
        }
        let mut found = found.clone();
        if is_none {
            sets = Vec::new();
        }
        found.sets = sets;
        alike.dedup();
        Changes {
            found,
            weights,
            alike,
        }
    }
}

/// A model's numbers as a motor has them, those that it does not have as they start.
fn start_at(model: &Model, motor: &Motor) -> Vec<f64> {
    let numbers = model.numbers.iter().zip(model.start());
    numbers
        .map(|(number, start)| match number.id.get(motor) {
            Some(value) if number.log => value.max(f64::MIN_POSITIVE).ln(),
            Some(value) => value / number.unit,
            None => start,
        })
        .collect()
}

/// The base of other runs of the same axis, where these have shown a motor.
fn as_then(pieces: &Pieces, base: &Base, fit: &Fit) -> Option<Base> {
    let motor = fit.model.motor(&fit.x);
    let numbers = &fit.model.numbers;
    let mut covariance = covariance(pieces, fit)?;
    for (k, number) in numbers.iter().enumerate() {
        if number.smooth {
            continue;
        }
        // Thresholds have no curvature: their interval says how well they are known.
        let (lo, hi) = ends(pieces, fit, k);
        let least = LEAST_WIDTH * (number.hi - number.lo).min(1e3);
        let sd = (0.5 * (hi - lo) / WITHIN_95).max(least);
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        covariance[(k, k)] = sd * sd;
    }
    for (k, number) in numbers.iter().enumerate() {
        if matches!(number.id, ParameterId::Nominal(_)) {
            covariance.row_mut(k).scale_mut(1.0 / fit.x[k]);
            covariance.column_mut(k).scale_mut(1.0 / fit.x[k]);
        }
    }
    let of_effects = numbers
        .iter()
        .zip(&fit.x)
        .filter(|(number, _)| matches!(number.id, ParameterId::Effect(..)));
    let then = Then {
        effects: (motor.effects.iter())
            .filter(|effect| effect.index() < catalogue().len())
            .map(|effect| Member {
                index: effect.index(),
                values: effect.parameters().map(|(_, value)| value).collect(),
            })
            .collect(),
        numbers: of_effects.map(|(number, x)| (*number, *x)).collect(),
        covariance,
    };
    Some(Base {
        motor,
        then: Some(then),
        ..base.clone()
    })
}

/// Covariance of a fit's numbers: by the curvature of the cost, and by how the pieces (or runs) pull them apart, which is more where the
/// model is not quite right (Huber, 1967; White, 1982).
fn covariance(pieces: &Pieces, fit: &Fit) -> Option<DMatrix<f64>> {
    let inverse = fit.hessian.clone().cholesky()?.inverse();
    let by_run = pieces.runs.len() >= CLUSTERED_RUNS;
    let count = if by_run {
        pieces.runs.len()
    } else {
        pieces.pieces.len()
    };
    let n = fit.x.len();
    let mut pulls = vec![DVector::zeros(n); count];
    for (stretch, gradient) in pieces.stretches.iter().zip(&fit.stretch_gradient) {
        let piece = stretch.piece;
        pulls[if by_run {
            pieces.pieces[piece].run
        } else {
            piece
        }] += gradient;
    }
    let spread: DMatrix<f64> = pulls.iter().map(|pull| pull * pull.transpose()).sum();
    Some(&inverse + &inverse * spread * &inverse)
}
