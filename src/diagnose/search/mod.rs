//! Search over sets of effects: all are screened together, few are fitted.
//!
//! In: segments, base. Out: [`Found`], every fitted set with its score. Columns of all starts of all effects are screened in one Gram
//! matrix, as singles, pairs and triples; the best are fitted on a subset of the segments; then members are added, dropped and exchanged
//! until the best set stays; what is near it is fitted to all segments.

use crate::motor::catalogue::ids;
mod candidates;
mod gram;
mod periodic;
mod pool;

pub(crate) use candidates::{Candidate, Shape, candidates, starts};
pub(crate) use pool::{Judge, Scored, scored};

use nalgebra::DVector;

use candidates::{grid, members};
use gram::{Screen, Screened, distinct};
use periodic::with_wave;
use pool::Pool;

use super::classes::{class_of, members_of, symmetric_of};
use super::fit::Fit;
use super::inverse::{load_term, shares};
use super::model::{BASE, Base, Member, Model, dot, range_of};
use super::noise::Whitener;
use super::report::SearchStep;
use super::score::effective_observations;
use super::segments::Segments;
use super::settings::solver::{
    FITTED_ANYWAY, LARGEST_SCREENED, LAST_DIGITS, LATER_PART, ROUNDS, SEARCH_NS,
    SEARCH_NS_PER_FURTHER_SAMPLE, SEARCH_SAMPLES, SIMPLIFIED, STARTS_PER_SET,
};
use crate::motor::Motor;
use crate::motor::catalogue::{EffectParameter, Prior, catalogue, find};
use crate::units::ROUNDING_VARIANCE;

/// Fitted sets, best score first, and how they were judged.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub sets: Vec<Scored>,
    pub judge: Judge,
    pub steps: Vec<SearchStep>,
}

impl Found {
    pub fn best(&self) -> &Scored {
        &self.sets[0]
    }
}

/// Searches on `coarse` segments from the base fit, and refits what is near the best to all. `progress` is told what is done, and which part
/// of it has been.
pub(crate) fn search(
    segments: &Segments,
    coarse: &Segments,
    base: &Base,
    none: &Fit,
    (is_relevant, stated_floor): (bool, f64),
    proposed: &[Motor],
    progress: &dyn Fn(&str, f64),
) -> Option<Found> {
    let settings = &base.settings;
    let model = Model::new(base, Vec::new());
    let mut pool = Pool::new(coarse, base);
    let limit_ns = time_limit_ns(segments.len);
    pool.until_ns = segments.work.nanoseconds() + limit_ns;
    pool.derived_until_ns = pool.until_ns + limit_ns;
    pool.judge.is_relevant = is_relevant;
    pool.judge.known_floor = match is_relevant {
        true => stated_floor,
        false => stated_floor.max(none.mean_square()),
    };
    let least_squares = Fit::at(coarse, &model, none.x.clone())?;
    pool.judge.n_eff = effective_observations(coarse, &least_squares.corrected);
    pool.begin(&model, &[none.x.clone(), model.start()]);
    for motor in proposed {
        pool.propose(motor);
    }
    pool.fit_measured(none);
    let mut steps = Vec::new();
    for round in 0..ROUNDS {
        let fitted = |sets: usize, part: f64| {
            let number = round + 1;
            let done = format!("round {number} of {ROUNDS} at most, {sets} sets of effects fitted");
            progress(&format!("searching, {done}"), part);
        };
        fitted(pool.fitted, 0.0);
        let begun = match round {
            // The likelihood's fit may have an effect in its noise.
            0 => vec![least_squares.clone()],
            _ => pool.not_expanded(),
        };
        let Some(first) = (begun.first()).filter(|_| round == 0 || !pool.is_at_limit()) else {
            break;
        };
        let (deepest, sets) = match round {
            0 if is_relevant => (LARGEST_SCREENED, settings.fitted_sets),
            _ => (1, settings.fitted_sets / LATER_PART),
        };
        let mut screened = Vec::new();
        for (k, from) in begun.iter().enumerate() {
            if k > 0 && pool.is_at_limit() {
                break;
            }
            let room = settings.most_effects - from.model.members.len();
            let ahead = match round {
                0 => 0.0,
                _ => pool.best().score - pool.score_of(from),
            };
            let of_all =
                |sets: usize, part: f64| fitted(sets, (k as f64 + part) / begun.len() as f64);
            screened.extend(pool.expand(from, ahead, deepest.min(room), sets, &of_all));
        }
        if round == 0 && is_relevant {
            pool.fit_stochastic(first);
        }
        pool.judge();
        pool.simplify();
        pool.exchange();
        pool.judge();
        let now = pool.best();
        steps.push(SearchStep {
            from: first.ids(),
            screened,
            best: now.fit.ids(),
            score: now.score,
            rms_counts: now.fit.rms(),
            fitted: pool.fitted,
            limited: pool.is_at_limit(),
        });
    }
    let last = format!(
        "fitting the likeliest of {} sets to all segments",
        pool.fitted
    );
    progress(&last, 0.0);
    let (sets, judge) = if std::ptr::eq(segments, coarse) {
        pool.sorted()
    } else {
        let near = pool.near_best();
        let mut all = Pool::new(segments, base);
        all.judge = Judge {
            least: all.judge.least,
            ..pool.judge
        };
        all.add_fitted(&model, std::slice::from_ref(&none.x), None);
        for scored in near {
            if !scored.fit.model.members.is_empty() {
                all.add_fitted(&scored.fit.model, &[scored.fit.x], None);
            }
        }
        all.judge();
        all.sorted()
    };
    Some(Found { sets, judge, steps })
}

/// Most simulation time in ns of a search for recordings with this many samples.
fn time_limit_ns(samples: usize) -> u64 {
    SEARCH_NS + samples.saturating_sub(SEARCH_SAMPLES) as u64 * SEARCH_NS_PER_FURTHER_SAMPLE
}

/// Whether the base parameters imitate a candidate, but for a part of an immaterial share of its squares: it may be present where they leave nothing.
fn is_like_parameters(
    segments: &Segments,
    from: &Fit,
    candidate: &Candidate,
    immaterial: f64,
) -> bool {
    let Shape::One(column) = &candidate.shape else {
        return matches!(candidate.shape, Shape::Widens(..));
    };
    let column = segments.corrected(column);
    let own: Vec<Vec<f64>> = from.columns.iter().map(|c| segments.corrected(c)).collect();
    let along = DVector::from_fn(own.len(), |i, _| dot(&own[i], &column));
    let mut ridge = from.gram.clone();
    (0..own.len()).for_each(|k| ridge[(k, k)] *= 1.0 + LAST_DIGITS);
    let square = dot(&column, &column);
    let explained = ridge
        .cholesky()
        .map_or(0.0, |c| c.solve(&along).dot(&along));
    square > 0.0 && explained >= (1.0 - immaterial) * square
}

/// The best sets of each size, by turns.
fn best_of_each_size(sets: Vec<Screened>, all: &[Candidate], most: usize) -> Vec<Screened> {
    let sets = distinct(sets, all, STARTS_PER_SET);
    let largest = sets.iter().map(|set| set.of.len()).max().unwrap_or(0);
    let mut found = Vec::new();
    let mut of_size: Vec<_> = (1..=largest)
        .map(|size| sets.iter().filter(move |set| set.of.len() == size))
        .collect();
    for turn in 0..most {
        for (k, sets) in of_size.iter_mut().enumerate() {
            // Twice as many of a size as of the next larger.
            if turn % (1 << k) == 0 {
                found.extend(sets.next().cloned());
            }
        }
    }
    found
}

/// A member with its values at a coefficient of its column: the first parameter moves from where it changes nothing.
fn scaled(base: &Base, member: &Member, coefficient: f64) -> Member {
    let kind = &catalogue()[member.index];
    let mut scaled = member.clone();
    let (Some(parameter), Some(value)) = (kind.parameters.first(), scaled.values.first_mut())
    else {
        return scaled;
    };
    let (lo, hi) = range_of(parameter, base);
    match (parameter.prior, parameter.neutral(&base.motor.parameters)) {
        (Prior::LogUniform, Some((neutral, _))) if neutral > 0.0 => {
            *value = neutral * (*value / neutral).powf(coefficient);
        }
        (Prior::Uniform, Some((neutral, _))) => *value = neutral + coefficient * (*value - neutral),
        (Prior::Uniform, None) if lo >= 0.0 => *value *= coefficient,
        _ => return scaled,
    }
    *value = value.clamp(lo, hi);
    scaled
}

/// A set to fit: its ids, its model, its starts.
type Started = (Vec<&'static str>, Model, Vec<Vec<f64>>);

impl Pool<'_> {
    /// Screens everything beside a fit and fits the best sets that may be as good as the best one, which is `ahead` of the fit in the score;
    /// returns what was screened best.
    fn expand(
        &mut self,
        from: &Fit,
        ahead: f64,
        deepest: usize,
        sets: usize,
        fitted: &dyn Fn(usize, f64),
    ) -> Vec<(Vec<&'static str>, f64)> {
        let (segments, base) = (self.segments, self.base);
        self.expanded(from);
        let mut all = candidates(segments, base, from);
        if !self.judge.is_relevant {
            all.retain(|candidate| {
                is_like_parameters(segments, from, candidate, base.settings.unexplained_share)
            });
        }
        if all.is_empty() {
            return Vec::new();
        }
        let prices: Vec<f64> = (all.iter())
            .map(|candidate| self.price(&candidate.member))
            .collect();
        let n_eff = self.judge.n_eff;
        let screen = if self.judge.is_likelihood {
            let likelihood = self.likelihood_of(from);
            let whitener = Whitener::new(segments, &likelihood.plant, likelihood.noise);
            Screen::new(from, &all, prices, &|c| whitener.whiten(c), 1.0, None)
        } else {
            let weight = n_eff / (segments.len as f64 * from.mean_square().max(ROUNDING_VARIANCE));
            let corrected = |column: &[f64]| segments.corrected(column);
            Screen::new(from, &all, prices, &corrected, weight, Some(n_eff))
        };
        let Some(screen) = screen else {
            return Vec::new();
        };
        let chosen = best_of_each_size(screen.sets(&all, deepest), &all, sets);
        let screened = (chosen.iter())
            .map(|set| {
                (
                    set.of.iter().map(|k| all[*k].member.id()).collect(),
                    set.worth,
                )
            })
            .collect();
        let most = chosen
            .iter()
            .map(|set| set.worth)
            .fold(f64::NEG_INFINITY, f64::max);
        let within = self.base.settings.near_best;
        // Screening is linear: single effects are fitted first, whatever their score.
        let mut by_size: Vec<&Screened> = chosen.iter().collect();
        by_size.sort_by_key(|set| set.of.len());
        let mut taken: Vec<Started> = Vec::new();
        for set in by_size {
            let is_behind = set.worth < 0.0 || set.worth < most - within;
            if set.worth < ahead - within || (is_behind && set.of.len() > 1) {
                continue;
            }
            let (model, starts) = self.started(from, set, &all);
            let ids = model.ids();
            let is_new = taken.iter().all(|(known, ..)| *known != ids);
            let alike = taken
                .iter()
                .position(|(known, other, _)| *known == ids && model.is_like(other));
            match alike {
                Some(k) => taken[k].2.extend(starts),
                None if is_new && taken.len() >= sets => {}
                None => taken.push((ids, model, starts)),
            }
        }
        // Beside no effect, the best are fitted whatever the time.
        let anyway = match from.model.members.is_empty() {
            true => FITTED_ANYWAY,
            false => 0,
        };
        let number = taken.len() as f64;
        for (rank, (_, model, starts)) in taken.into_iter().enumerate() {
            if rank < anyway || !self.is_at_limit() {
                self.add_fitted(&model, &starts, Some(from));
                fitted(self.fitted, (rank + 1) as f64 / number);
            }
        }
        screened
    }

    /// The model of a screened set, with starts at its linear coefficients and at its columns' own values.
    fn started(&self, from: &Fit, set: &Screened, all: &[Candidate]) -> (Model, Vec<Vec<f64>>) {
        let base = self.base;
        let with = |is_scaled: bool| -> Vec<Member> {
            let added = set.of.iter().zip(&set.coefficients).map(|(k, (a, b))| {
                let Candidate { member, shape } = &all[*k];
                match shape {
                    Shape::Pair(_, per_unit) => with_wave(member, *per_unit, (*a, *b)),
                    Shape::One(_) if is_scaled => scaled(base, member, *a),
                    _ => member.clone(),
                }
            });
            from.model.members.iter().cloned().chain(added).collect()
        };
        let model = Model::new(base, with(true));
        let own = Model::new(base, with(false));
        let mut starts = vec![model.start_from(&from.model, &from.x), model.start()];
        starts.push(own.start_from(&from.model, &from.x));
        (model, starts)
    }

    /// Fits what is measured without any simulation: a clock error against the host's clock, loads by the equation-error regression; against
    /// a reference also each base parameter by itself, which a linear prediction puts behind others when it has changed much.
    fn fit_measured(&mut self, from: &Fit) {
        let base = self.base;
        let mut members = Vec::new();
        if let (Some((seen, _)), Some((index, _))) = (base.clock, find(ids::CLOCK_ERROR)) {
            let values = vec![seen];
            members.push((Member { index, values }, None));
        }
        if base.reference.is_some() {
            for (index, kind) in catalogue().iter().enumerate() {
                if base.frees(kind.id).is_some() {
                    let of =
                        |p: &EffectParameter| p.default(&base.motor.parameters, base.sample_time_s);
                    let values = kind.parameters.iter().map(of).collect();
                    members.push((Member { index, values }, None));
                }
            }
        }
        for id in [ids::GRAVITY_LOAD, ids::CONSTANT_LOAD] {
            let is_given = base.motor.effects.get(id).is_some();
            if let (false, Some((index, kind))) = (is_given, find(id))
                && let Some((own, values)) = load_term(self.segments, base, kind)
            {
                members.push((Member { index, values }, Some(shares(base, own))));
            }
        }
        for (member, shares) in members {
            let model = Model::new(base, vec![member]);
            let mut starts = vec![model.start_from(&from.model, &from.x), model.start()];
            starts.extend(shares.map(|shares| model.start_with(shares)));
            self.add_fitted(&model, &starts, None);
        }
    }

    /// Fits the set of effects of a motor, started from its values.
    fn propose(&mut self, motor: &Motor) {
        let base = self.base;
        let model = Model::new(base, Member::of(motor));
        let shares = BASE.map(|key| {
            let of = |motor: &Motor| motor.parameters.get(key).filter(|value| *value > 0.0);
            of(motor)
                .zip(of(&base.motor))
                .map_or(1.0, |(its, own)| its / own)
        });
        self.add_fitted(&model, &[model.start_with(shares), model.start()], None);
    }

    /// Fits the effects that are random, whose variance only the likelihood sees; it is found from any start.
    fn fit_stochastic(&mut self, from: &Fit) {
        let base = self.base;
        let mut taken = Vec::new();
        for member in members(self.segments, base, from) {
            let members = from.model.members.iter().cloned().chain([member]);
            let model = Model::new(base, members.collect());
            if model.is_random() && !taken.contains(&model.ids()) {
                taken.push(model.ids());
                let start = model.start_from(&from.model, &from.x);
                self.add_likeliest(&model, start);
            }
        }
    }

    /// Fits the sets near the best without each of their members.
    fn simplify(&mut self) {
        let near = self.near_best();
        for set in near.iter().take(SIMPLIFIED) {
            let members = &set.fit.model.members;
            for k in 0..members.len() {
                let mut fewer = members.clone();
                fewer.remove(k);
                let model = Model::new(self.base, fewer);
                if !self.is_at_end() && self.is_new(set.fit.ids(), model.ids()) {
                    let starts = [
                        model.start_from(&set.fit.model, &set.fit.x),
                        self.none_start(&model),
                    ];
                    self.add_fitted(&model, &starts, None);
                }
            }
        }
    }

    /// Fits the best set with each member exchanged for the others of its class, and for what does the same in both directions alike.
    fn exchange(&mut self) {
        let best = self.best().fit.clone();
        let is_freed = |member: &Member| self.base.frees(member.id()).is_some();
        let members = best.model.members.clone();
        for (k, member) in members.iter().enumerate().filter(|(_, m)| !is_freed(m)) {
            let of_class = class_of(member.id()).map_or(&[][..], |class| members_of(class));
            let rivals = of_class.iter().copied().chain(symmetric_of(member.id()));
            for rival in rivals.filter(|id| *id != member.id()) {
                let Some((index, kind)) = find(rival) else {
                    continue;
                };
                let is_other = |m: &Member| m.id() == rival;
                let is_given = self.base.motor.effects.get(rival).is_some();
                if is_given || members.iter().any(is_other) {
                    continue;
                }
                let models: Vec<Model> = (grid(kind, self.base).into_iter())
                    .map(|values| {
                        let mut others = members.clone();
                        others[k] = Member { index, values };
                        Model::new(self.base, others)
                    })
                    .collect();
                let Some(model) = models.first() else {
                    continue;
                };
                if self.is_at_end() || !self.is_new(best.ids(), model.ids()) {
                    continue;
                }
                let starts: Vec<Vec<f64>> = (models.iter())
                    .filter(|other| other.members.len() == model.members.len())
                    .map(|other| other.start_from(&best.model, &best.x))
                    .collect();
                let model = model.clone();
                self.add_fitted(&model, &starts, None);
            }
        }
    }
}
