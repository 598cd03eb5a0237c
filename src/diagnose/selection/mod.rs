//! Forward over sets of effects: at each level every rival is looked at, and those that promise most are fitted.

mod forward;

use nalgebra::DVector;
use rayon::prelude::*;

use super::fit::{Base, Fit, Member, Model, finished, fit, sensitivities};
use super::noise::Noise;
use super::pieces::Pieces;
use super::screening::{Candidate, Screen, Shape, candidates};
use super::settings::{CHANCE, FITTED, LEAST_GAIN, LEAST_PROMISE, TIED_NATS, WANDER_SHARES};
use super::validation::{Presence, presence};
use crate::motor::fit::ParameterId;

pub(crate) use forward::{Forward, Judged, forward, simpler_of};

/// One level of the search.
#[derive(Debug)]
pub(crate) struct Level {
    /// Rivals fitted, best first.
    pub fits: Vec<Fit>,
    /// What each promised.
    pub screened: Vec<(&'static str, f64)>,
    /// Whether the best of them is more than chance.
    pub presence: Option<Presence>,
}

/// All rivals of one more effect, best first.
pub(crate) fn level(pieces: &Pieces, base: &Base, from: &Fit) -> Option<Level> {
    let mut points = vec![Point::new(pieces, base, from)?];
    // A base that is bent by what is missing hides it: candidates are looked at from the motor file's numbers too.
    if from.prior >= LEAST_GAIN
        && let Some(unbent) = unbent(pieces, base, from)
    {
        points.extend(Point::new(pieces, base, &unbent));
    }
    // What is missing makes the load seem to wander: what stands out where it wanders less is looked at too.
    let mut noises = vec![from.noise];
    if from.noise.strength > 0.0 {
        noises.extend(WANDER_SHARES.map(|share| Noise {
            strength: share * from.noise.strength,
            ..from.noise
        }));
    }
    let present = |noise: Noise| {
        let (columns, all) = (&points[0].columns, &points[0].all);
        let screen = Screen::new(pieces, base, from, columns, all, noise);
        presence(pieces, from, &screen, noise)
    };
    // Where nothing promises more than chance makes of the smaller model, nothing is fitted.
    let presences = noises.iter().map(|noise| present(*noise));
    let first = presences.max_by(|a, b| b.p_value().total_cmp(&a.p_value()));
    if first.as_ref().is_some_and(|first| first.p_value() > CHANCE) && points.len() < 2 {
        return Some(Level {
            fits: Vec::new(),
            screened: Vec::new(),
            presence: first,
        });
    }
    let mut screened = Vec::new();
    let mut chosen: Vec<Member> = Vec::new();
    for point in &points {
        for noise in &noises {
            screened.extend(point.promising(pieces, base, *noise, &mut chosen));
        }
    }
    let mut fits = Vec::new();
    add(pieces, base, from, &chosen, &mut fits);
    // Once more with the noise that the best of them leaves.
    if let Some(noise) = fits.first().map(|best: &Fit| best.noise) {
        let before = chosen.len();
        points[0].promising(pieces, base, noise, &mut chosen);
        add(pieces, base, from, &chosen[before..], &mut fits);
    }
    let presence = fits.first().map(|best| present(best.noise));
    Some(Level {
        fits,
        screened,
        presence,
    })
}

/// Fits a model with each of some members more, and keeps the best of each name.
fn add(pieces: &Pieces, base: &Base, from: &Fit, chosen: &[Member], fits: &mut Vec<Fit>) {
    let mut models: Vec<(Model, Vec<Vec<f64>>)> = Vec::new();
    for member in chosen {
        let mut members = from.model.members.clone();
        members.push(member.clone());
        let model = Model::new(base, members);
        let starts = [model.start_from(&from.model, &from.x), model.start()];
        match models.iter_mut().find(|(other, _)| other.is_like(&model)) {
            Some((_, others)) => others.extend(starts),
            None => models.push((model, starts.to_vec())),
        }
    }
    let fitted: Vec<Fit> = (models.par_iter())
        .filter_map(|(model, starts)| fit(pieces, model, base.kind, starts))
        .collect();
    for one in fitted {
        let ids = one.model.ids();
        match fits.iter_mut().find(|fit| fit.model.ids() == ids) {
            Some(other) if other.cost() > one.cost() => *other = one,
            Some(_) => {}
            None => fits.push(one),
        }
    }
    fits.sort_by(|a, b| b.score().total_cmp(&a.score()));
}

/// A fit to look for candidates from.
#[derive(Debug)]
struct Point {
    fit: Fit,
    all: Vec<Candidate>,
    columns: Vec<Vec<f64>>,
}

impl Point {
    fn new(pieces: &Pieces, base: &Base, fit: &Fit) -> Option<Self> {
        let (_, columns) = sensitivities(pieces, &fit.model, &fit.x)?;
        Some(Self {
            all: candidates(pieces, base, fit),
            fit: fit.clone(),
            columns,
        })
    }

    /// Adds the start of each effect that promises most under a noise; returns what each promises.
    fn promising(
        &self,
        pieces: &Pieces,
        base: &Base,
        noise: Noise,
        chosen: &mut Vec<Member>,
    ) -> Vec<(&'static str, f64)> {
        let screen = Screen::new(pieces, base, &self.fit, &self.columns, &self.all, noise);
        let distance = DVector::from_column_slice(&self.fit.x) - &self.fit.model.mean;
        let gains = screen.gains(&self.fit.residual, &distance, true);
        let mut order: Vec<usize> = (0..self.all.len()).collect();
        order.sort_by(|a, b| gains[*b].nats.total_cmp(&gains[*a].nats));
        let first = order.first().copied().unwrap_or(0);
        let mut found = Vec::new();
        let mut effects: Vec<(usize, bool)> = Vec::new();
        for k in order {
            let candidate = &self.all[k];
            // What an effect does by chance and what it does always are looked at apart.
            let scatters = matches!(candidate.shape, Shape::Scatter(..));
            if effects.contains(&(candidate.member.index, scatters)) {
                continue;
            }
            let best = gains[first].nats;
            let is_enough = effects.len() >= FITTED && gains[k].nats < best - TIED_NATS;
            if is_enough || gains[k].nats < LEAST_PROMISE {
                break;
            }
            effects.push((candidate.member.index, scatters));
            found.push((candidate.member.id(), gains[k].nats));
            let member = started(candidate, gains[k].coefficients);
            if !chosen.contains(&member) {
                chosen.push(member);
            }
        }
        found
    }
}

/// The same model with the base numbers of the motor file.
fn unbent(pieces: &Pieces, base: &Base, from: &Fit) -> Option<Fit> {
    let mut x = from.x.clone();
    for (k, number) in from.model.numbers.iter().enumerate() {
        if matches!(number.id, ParameterId::Nominal(_)) {
            x[k] = from.model.mean[k];
        }
    }
    finished(pieces, &from.model, base.kind, x, from.noise)
}

fn started(candidate: &Candidate, coefficients: (f64, f64)) -> Member {
    let mut member = candidate.member.clone();
    if let Shape::Pair(_, wave) = &candidate.shape {
        member.values = wave.values(&member, coefficients);
    }
    member
}
