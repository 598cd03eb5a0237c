//! Forward over sets of effects: at each level every rival is looked at, and those that promise most are fitted.

mod backward;
mod forward;
mod judged;

use nalgebra::DVector;
use rayon::prelude::*;

use super::fit::{Base, Fit, Member, Model, Most, finished, fit, sensitivities};
use super::noise::Noise;
use super::pieces::Pieces;
use super::screening::{Candidate, Pick, Screen, Shape, candidates, shares};
use super::settings::{FITTED, LEAST_GAIN, LEAST_PROMISE, TIED_NATS, WANDER_SHARES};
use super::validation::{Presence, presence};
use crate::motor::fit::ParameterId;

pub(crate) use forward::{Forward, forward};
pub(crate) use judged::{Judged, simpler_of};

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

/// What is looked for: effects that predict something, or those that only scatter (edges lost by chance, late samples). A noise takes
/// up any error in part, so what scatters is looked for where nothing that predicts is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sought {
    Predicting,
    Scattering,
}

/// All rivals of one more effect, best first. Beside them, those of the inverse form's `pick` are fitted from the whole motor that it has found.
pub(crate) fn level(
    pieces: &Pieces,
    base: &Base,
    from: &Fit,
    sought: Sought,
    pick: Option<&Pick>,
) -> Option<Level> {
    let mut points = vec![Point::new(pieces, base, from, sought)?];
    // A base that is bent by what is missing hides it: candidates are looked at from the motor file's numbers too.
    if from.prior >= LEAST_GAIN
        && let Some(unbent) = unbent(pieces, base, from)
    {
        points.extend(Point::new(pieces, base, &unbent, sought));
    }
    // What is missing makes the load seem to wander: what stands out where it wanders less is looked at too. What scatters would take
    // the place of any wander.
    let mut noises = vec![from.noise];
    if from.noise.strength > 0.0 && sought == Sought::Predicting {
        noises.extend(WANDER_SHARES.map(|share| Noise {
            strength: share * from.noise.strength,
            ..from.noise
        }));
    }
    let first = &points[0];
    let mut looks: Vec<Look> = (noises.iter())
        .map(|noise| Look::new(pieces, first.screen(pieces, base, *noise), from, *noise))
        .collect();
    // Where nothing promises more than chance makes of the smaller model, nothing is fitted.
    let presences = looks.iter().map(|look| &look.presence);
    let likeliest = presences.max_by(|a, b| b.p_value().total_cmp(&a.p_value()));
    if let Some(found) = likeliest.filter(|found| found.is_by_chance())
        && points.len() < 2
    {
        return Some(Level {
            fits: Vec::new(),
            screened: Vec::new(),
            presence: Some(found.clone()),
        });
    }
    let mut screened = Vec::new();
    let mut chosen: Vec<Member> = Vec::new();
    for look in &looks {
        screened.extend(first.promising(&look.screen, &mut chosen));
    }
    for point in &points[1..] {
        for noise in &noises {
            let screen = point.screen(pieces, base, *noise);
            screened.extend(point.promising(&screen, &mut chosen));
        }
    }
    let mut fits = Vec::new();
    let seeds = pick.map_or(Vec::new(), |pick| first.seeds(base, pick, &looks[0].screen));
    add(pieces, base, from, &chosen, seeds, &mut fits);
    // Once more with the noise that the best of them leaves.
    let left = |fits: &[Fit]| fits.first().map(|best| best.noise);
    if let Some(noise) = left(&fits) {
        let before = chosen.len();
        let look = look_under(&mut looks, noise, || {
            Look::new(pieces, first.screen(pieces, base, noise), from, noise)
        });
        first.promising(&look.screen, &mut chosen);
        add(pieces, base, from, &chosen[before..], Vec::new(), &mut fits);
    }
    let presence = left(&fits).map(|noise| {
        let look = look_under(&mut looks, noise, || {
            Look::new(pieces, first.screen(pieces, base, noise), from, noise)
        });
        look.presence.clone()
    });
    Some(Level {
        fits,
        screened,
        presence,
    })
}

/// A model with one start of its own, which is fitted from there whatever another start promises.
type Seed = (Model, Vec<f64>);

/// All candidates under a noise, and what chance makes of them.
#[derive(Debug)]
struct Look {
    noise: Noise,
    screen: Screen,
    presence: Presence,
}

impl Look {
    fn new(pieces: &Pieces, screen: Screen, from: &Fit, noise: Noise) -> Self {
        Self {
            presence: presence(pieces, from, &screen, noise),
            noise,
            screen,
        }
    }
}

/// The look under a noise among those that were taken, or a new one.
fn look_under(looks: &mut Vec<Look>, noise: Noise, new: impl FnOnce() -> Look) -> &Look {
    let known = looks.iter().position(|look| look.noise == noise);
    let k = known.unwrap_or_else(|| {
        looks.push(new());
        looks.len() - 1
    });
    &looks[k]
}

/// Members of a fit with one more.
fn with(from: &Fit, member: Member) -> Vec<Member> {
    let mut members = from.model.members.clone();
    members.push(member);
    members
}

/// Fits a model with each of some members more, and keeps the best of each name.
fn add(
    pieces: &Pieces,
    base: &Base,
    from: &Fit,
    chosen: &[Member],
    seeds: Vec<Seed>,
    fits: &mut Vec<Fit>,
) {
    let most = Most::beside(from.mean_square());
    let mut models: Vec<(Model, Vec<Vec<f64>>, bool)> = Vec::new();
    for member in chosen {
        let model = Model::new(base, with(from, member.clone()));
        let starts = [model.start_from(&from.model, &from.x), model.start()];
        match models.iter_mut().find(|(other, ..)| other.is_like(&model)) {
            Some((_, others, _)) => others.extend(starts),
            None => models.push((model, starts.to_vec(), false)),
        }
    }
    let seeds = seeds.into_iter();
    models.extend(seeds.map(|(model, start)| (model, vec![start], true)));
    let fitted: Vec<Fit> = (models.par_iter())
        .filter_map(|(model, starts, is_seed)| {
            let of = |most| fit(pieces, model, base.kind, starts, most);
            // What the inverse form decides may leave more: there no simulation is the measure.
            of(most).or_else(|| is_seed.then(Most::anything).and_then(of))
        })
        .collect();
    for one in fitted {
        let ids = one.model.ids();
        let is_better = |one: &Fit, other: &Fit| {
            let beyond = |fit: &Fit| !most.allows(fit.mean_square());
            (beyond(one).cmp(&beyond(other)))
                .then(one.cost().total_cmp(&other.cost()))
                .is_lt()
        };
        match fits.iter_mut().find(|fit| fit.model.ids() == ids) {
            Some(other) if is_better(&one, other) => *other = one,
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
    fn new(pieces: &Pieces, base: &Base, fit: &Fit, sought: Sought) -> Option<Self> {
        let (_, columns) = sensitivities(pieces, &fit.model, &fit.x, &fit.starts)?;
        let mut all = candidates(pieces, base, fit);
        all.retain(|one| matches!(one.shape, Shape::Scatter(..)) == (sought == Sought::Scattering));
        Some(Self {
            all,
            fit: fit.clone(),
            columns,
        })
    }

    /// Starts of the effects that the inverse form points at, beside the motor that it has found with them.
    fn seeds(&self, base: &Base, pick: &Pick, screen: &Screen) -> Vec<Seed> {
        let shares = shares(base, pick.own);
        let distance = DVector::from_column_slice(&self.fit.x) - &self.fit.model.mean;
        let gains = screen.gains(&self.fit.residual, &distance, true);
        let start = |id: &&str| {
            let of_it = (0..self.all.len()).filter(|&k| {
                let member = &self.all[k].member;
                member.id() == *id && pick.is_of_order(member)
            });
            let best = of_it.max_by(|&a, &b| gains[a].nats.total_cmp(&gains[b].nats))?;
            let member = pick.started(base, &self.all[best].member);
            let model = Model::new(base, with(&self.fit, member));
            let start = model.start_with(shares);
            Some((model, start))
        };
        pick.form.ids().iter().filter_map(start).collect()
    }

    /// Its candidates under a noise.
    fn screen(&self, pieces: &Pieces, base: &Base, noise: Noise) -> Screen {
        Screen::new(pieces, base, &self.fit, &self.columns, &self.all, noise)
    }

    /// Adds the start of each effect that promises most under a screen's noise; returns what each promises.
    fn promising(&self, screen: &Screen, chosen: &mut Vec<Member>) -> Vec<(&'static str, f64)> {
        let distance = DVector::from_column_slice(&self.fit.x) - &self.fit.model.mean;
        let gains = screen.gains(&self.fit.residual, &distance, true);
        let mut order: Vec<usize> = (0..self.all.len()).collect();
        order.sort_by(|a, b| gains[*b].nats.total_cmp(&gains[*a].nats));
        let first = order.first().copied().unwrap_or(0);
        let mut found = Vec::new();
        let mut effects: Vec<usize> = Vec::new();
        for k in order {
            let candidate = &self.all[k];
            if effects.contains(&candidate.member.index) {
                continue;
            }
            let best = gains[first].nats;
            let is_enough = effects.len() >= FITTED && gains[k].nats < best - TIED_NATS;
            if is_enough || gains[k].nats < LEAST_PROMISE {
                break;
            }
            effects.push(candidate.member.index);
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
    let starts = from.starts.clone();
    finished(pieces, &from.model, base.kind, x, from.noise, starts)
}

fn started(candidate: &Candidate, coefficients: (f64, f64)) -> Member {
    let mut member = candidate.member.clone();
    if let Shape::Pair(_, wave) = &candidate.shape {
        member.values = wave.values(&member, coefficients);
    }
    member
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::fit::Member;
    use crate::diagnose::samples::{base_of, fitted, member, motor_with, recording};
    use crate::motor::Motor;

    /// Beside a phase, of which nothing is plausible, chance makes some nats: as much as beside an effect without one.
    #[test]
    fn chance_makes_no_more_beside_a_phase() {
        let run = recording(&motor_with(&[("gravity_load", &[0.01, 0.5])]), 1000);
        let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        let base = base_of(&pieces);
        let gravity = Member {
            values: vec![0.01, 0.5],
            ..member("gravity_load", 0.01)
        };
        let by_chance = |members: &[Member]| {
            let from = fitted(&pieces, &base, members);
            let level = level(&pieces, &base, &from, Sought::Predicting, None).expect("a motor");
            let presence = level.presence.expect("candidates");
            *presence.by_chance.last().expect("some recordings")
        };
        let (with, without) = (
            by_chance(&[gravity]),
            by_chance(&[member("dead_zone", 0.4)]),
        );
        assert!(with < 2.0 * without, "{with} {without}");
    }
}
