//! Fitted sets with their scores, and which of the two scores judges them.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnose::classes::is_by_direction;
use crate::diagnose::fit::{Fit, Metric, fit, refit};
use crate::diagnose::model::{Base, Member, Model, mean_square};
use crate::diagnose::noise::Whitener;
use crate::diagnose::random;
use crate::diagnose::relevance::{exceeds, noise_floor};
use crate::diagnose::score::{
    Likelihood, effective_observations, likelihood, log_options, scale_free,
};
use crate::diagnose::segments::Segments;
use crate::diagnose::settings::Settings;
use crate::diagnose::settings::solver::{CONVERGED, CONVERGED_START, FLOOR_WITHIN, REFINEMENTS};
use crate::motor::catalogue::catalogue;
use crate::units::ROUNDING_VARIANCE;

/// How sets are judged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judge {
    /// Effective number of observations in the residual of the best set.
    pub n_eff: f64,
    /// Weight of the likelihood in the score, from 0 to 1: how credible its noise is.
    pub credibility: f64,
    /// Whether sets are fitted in the metric of the likelihood.
    pub is_likelihood: bool,
    /// Whether the model without effects leaves more than the noise floor: only then a smaller error is rewarded.
    pub is_relevant: bool,
    /// Mean square in counts^2 of the noise floor that is known before the search: of repeats, of the user, and of the model without effects
    /// where it is not relevant.
    pub known_floor: f64,
    /// Data cost under either score below which nothing is rewarded.
    pub least: (f64, f64),
}

impl Judge {
    /// Score of a fit.
    fn score(&self, base: &Base, fit: &Fit, likelihood: &Likelihood) -> f64 {
        let part = |weight: f64, score: f64| if weight > 0.0 { weight * score } else { 0.0 };
        let likely = part(self.credibility, likelihood.optimum.score(self.least.0));
        let free = scale_free(base, fit, self.n_eff).score(self.least.1);
        let odds = self.odds(fit.model.members.len(), &base.settings);
        likely + odds + part(1.0 - self.credibility, free)
    }

    /// Log prior odds of a number of effects in addition to the catalogue's, as a score: the likelihood overrates a further term by more than
    /// its evidence says.
    pub fn odds(&self, effects: usize, settings: &Settings) -> f64 {
        self.credibility * effects as f64 * settings.effect_log_odds / settings.learning_rate
    }
}

/// A fitted set.
#[derive(Debug, Clone)]
pub(crate) struct Scored {
    pub fit: Fit,
    pub score: f64,
    pub likelihood: Likelihood,
    /// Whether it leaves no more than simulated recordings of itself.
    pub is_at_floor: bool,
}

/// Fitted sets by their ids: of each the best.
pub(crate) struct Pool<'a> {
    pub segments: &'a Segments,
    pub base: &'a Base,
    pub judge: Judge,
    sets: BTreeMap<Vec<&'static str>, Scored>,
    /// Pairs of sets of which the second was fitted from the parameters of the first.
    derived: BTreeSet<(Vec<&'static str>, Vec<&'static str>)>,
    /// Sets beside which every effect was screened.
    expanded: BTreeSet<Vec<&'static str>>,
    /// Sets fitted so far.
    pub fitted: usize,
    /// Simulation time in ns of these segments at which no screened set is fitted any more.
    pub until_ns: u64,
    /// The same for sets derived from the best by leaving out and by exchange.
    pub derived_until_ns: u64,
}

/// A model of segments that were searched, fitted and scored as in the search.
pub(crate) fn scored(
    segments: &Segments,
    base: &Base,
    judge: Judge,
    model: &Model,
    starts: &[Vec<f64>],
) -> Option<Scored> {
    let mut pool = Pool::new(segments, base);
    pool.judge = judge;
    pool.add_fitted(model, starts, None);
    pool.sets.into_values().next()
}

impl<'a> Pool<'a> {
    pub fn new(segments: &'a Segments, base: &'a Base) -> Self {
        Self {
            segments,
            base,
            judge: Judge {
                n_eff: segments.len as f64,
                credibility: 0.0,
                is_likelihood: false,
                is_relevant: true,
                known_floor: 0.0,
                least: (f64::NEG_INFINITY, f64::NEG_INFINITY),
            },
            sets: BTreeMap::new(),
            derived: BTreeSet::new(),
            expanded: BTreeSet::new(),
            fitted: 0,
            until_ns: u64::MAX,
            derived_until_ns: u64::MAX,
        }
    }

    /// Adds a fit where it scores more than one of the same effects.
    fn add(&mut self, fit: Fit, likelihood: Likelihood) {
        self.fitted += 1;
        let scored = Scored {
            score: self.judge.score(self.base, &fit, &likelihood),
            likelihood,
            is_at_floor: self.is_at_floor(&fit),
            fit,
        };
        let ids = scored.fit.ids();
        // A scale-free score does not see the variance that a random effect predicts.
        let is_random = scored.fit.model.is_random();
        let merit = |set: &Scored| match is_random {
            true => set.likelihood.optimum.score(f64::NEG_INFINITY),
            false => set.score,
        };
        match self.sets.get(&ids) {
            Some(known) if merit(known) >= merit(&scored) => {}
            _ => {
                self.sets.insert(ids, scored);
            }
        }
    }

    /// Fits a model from these starts, in the metric of the score that judges, and adds it.
    pub fn add_fitted(&mut self, model: &Model, starts: &[Vec<f64>], extends: Option<&Fit>) {
        if let Some((found, likelihood)) = self.fitted_from(model, starts, extends) {
            self.add(found, likelihood);
        }
    }

    /// Fits a model with a random effect, whose variance only the likelihood sees, and adds it.
    pub fn add_likeliest(&mut self, model: &Model, start: Vec<f64>) {
        if let Some((found, likelihood)) = self.likeliest_from(model, start) {
            self.add(found, likelihood);
        }
    }

    fn likeliest_from(&self, model: &Model, start: Vec<f64>) -> Option<(Fit, Likelihood)> {
        let begun = Fit::at(self.segments, model, start)?;
        let begun = random::with_likeliest(self.segments, self.base, begun);
        let own = likelihood(self.segments, self.base, &begun);
        self.no_worse_than_smaller(self.whitened_from(begun, own)?)
    }

    fn fitted_from(
        &self,
        model: &Model,
        starts: &[Vec<f64>],
        extends: Option<&Fit>,
    ) -> Option<(Fit, Likelihood)> {
        if self.judge.is_likelihood && model.is_random() {
            return self.likeliest_from(model, starts.first()?.clone());
        }
        let metric = Metric::ScaleFree(self.judge.n_eff);
        let least_gain = match self.judge.is_likelihood {
            true => CONVERGED_START,
            false => CONVERGED,
        };
        let found = fit(self.segments, model, starts, metric, least_gain, extends)?;
        let own = likelihood(self.segments, self.base, &found);
        match self.judge.is_likelihood {
            true => self.no_worse_than_smaller(self.whitened_from(found, own)?),
            false => Some((found, own)),
        }
    }

    /// The fit, or where a smaller set has a smaller cost, from which this one is at most a local optimum, the better of it and one that starts
    /// from the smaller set, under that one's noise.
    fn no_worse_than_smaller(&self, found: (Fit, Likelihood)) -> Option<(Fit, Likelihood)> {
        let cost = |likelihood: &Likelihood| likelihood.optimum.cost();
        let ids = found.0.ids();
        let is_smaller = |set: &&Scored| {
            let own = set.fit.ids();
            own.len() < ids.len() && own.iter().all(|id| ids.contains(id))
        };
        let smaller = (self.sets.values().filter(is_smaller))
            .min_by(|a, b| cost(&a.likelihood).total_cmp(&cost(&b.likelihood)))
            .filter(|set| cost(&set.likelihood) < cost(&found.1));
        let Some(Scored {
            fit, likelihood, ..
        }) = smaller
        else {
            return Some(found);
        };
        let model = &found.0.model;
        let other = Fit::at(self.segments, model, model.start_from(&fit.model, &fit.x))
            .and_then(|begun| self.whitened_from(begun, likelihood.clone()));
        let lower =
            |a: &(Fit, Likelihood), b: &(Fit, Likelihood)| cost(&a.1).total_cmp(&cost(&b.1));
        other.into_iter().chain([found]).min_by(lower)
    }

    /// Fits under a noise, then under that which the fit leaves itself, until that stays.
    fn whitened_from(&self, mut begun: Fit, mut before: Likelihood) -> Option<(Fit, Likelihood)> {
        let (segments, base) = (self.segments, self.base);
        let mut round = 0;
        loop {
            let whitener = Whitener::new(segments, &before.plant, before.noise);
            let metric = Metric::Whitened(&whitener);
            let found = refit(segments, begun, metric)?;
            let found = random::with_likeliest(segments, base, found);
            let own = likelihood(segments, base, &found);
            if own.noise == before.noise || round == REFINEMENTS || self.is_far_behind(&own) {
                return Some((found, own));
            }
            begun = found;
            before = own;
            round += 1;
        }
    }

    /// Whether another set is likelier by more than a refinement of this one could change.
    fn is_far_behind(&self, likelihood: &Likelihood) -> bool {
        let score = |likelihood: &Likelihood| likelihood.optimum.score(f64::NEG_INFINITY);
        let least = score(likelihood) + self.base.settings.near_best;
        (self.sets.values()).any(|set| score(&set.likelihood) > least)
    }

    /// Fits the model without effects in either metric, and judges by the likelihood if its noise is credible there.
    pub fn begin(&mut self, model: &Model, starts: &[Vec<f64>]) {
        self.add_fitted(model, starts, None);
        let none = self.none().x.clone();
        if let Some((fit, likelihood)) = self.likeliest_from(model, none) {
            self.judge_by(&likelihood);
            if self.judge.is_likelihood {
                self.add(fit, likelihood);
            }
        }
        self.decide();
    }

    /// Decides which score judges, by what the likelihood's best set leaves, and scores all sets anew.
    pub fn judge(&mut self) {
        let was_likelihood = self.judge.is_likelihood;
        let mut refit = self.near_best();
        self.decide();
        if self.judge.is_likelihood != was_likelihood {
            // Fitted in the other metric so far; from the smallest: a set is no worse than a smaller one.
            refit.extend(self.sets.get(&Vec::new()).cloned());
            refit.sort_by_key(|set| set.fit.model.members.len());
            for set in refit {
                self.add_fitted(&set.fit.model, &[set.fit.x], None);
            }
            self.decide();
        }
    }

    /// Weighs the likelihood by how credible its noise is: half at the limits, by a steep passage.
    fn judge_by(&mut self, likelihood: &Likelihood) {
        let settings = &self.base.settings;
        let load = likelihood.noise.strength / settings.credible_load;
        let squares = (likelihood.squares - 1.0) / (settings.credible_squares - 1.0);
        let beyond = load.max(squares).powi(settings.passage as i32);
        self.judge.credibility = 1.0 / (1.0 + beyond);
        self.judge.is_likelihood = self.judge.credibility >= 0.5;
    }

    fn decide(&mut self) {
        let likelihood_of = |set: &Scored| set.likelihood.optimum.score(f64::NEG_INFINITY);
        let likeliest =
            (self.sets.values()).max_by(|a, b| likelihood_of(a).total_cmp(&likelihood_of(b)));
        if let Some(best) = likeliest.map(|set| set.likelihood.clone()) {
            self.judge_by(&best);
        }
        // The number of observations is that of the best set's residual, which is best for that number.
        for _ in 0..REFINEMENTS {
            self.score_all();
            let best = self.best();
            self.judge.n_eff = effective_observations(self.segments, &best.fit.corrected);
        }
        self.score_all();
    }

    /// Whether a fit leaves no more than simulated recordings of itself.
    fn is_at_floor(&self, fit: &Fit) -> bool {
        let left = fit.mean_square();
        let is_within = |floor: f64| {
            let n_eff = || effective_observations(self.segments, &fit.corrected);
            left <= floor || (floor > 0.0 && !exceeds(left, floor, n_eff(), &self.base.settings))
        };
        if is_within(self.judge.known_floor) {
            return true;
        }
        // Simulated recordings leave no more than twice what quantization does, but where starts decide.
        if left > FLOOR_WITHIN * ROUNDING_VARIANCE {
            return false;
        }
        noise_floor(self.segments, fit).is_some_and(is_within)
    }

    /// The data costs, under either score, of the best of the smallest sets at the noise floor: less is not rewarded.
    fn least_data(&self) -> (f64, f64) {
        let at_floor = || self.sets.values().filter(|set| set.is_at_floor);
        let size = |set: &&Scored| set.fit.model.members.len();
        let smallest = at_floor().map(|set| size(&set)).min();
        let n_eff = self.judge.n_eff;
        let costs = at_floor()
            .filter(|set| Some(size(set)) == smallest)
            .map(|set| {
                let free = scale_free(self.base, &set.fit, n_eff);
                (set.likelihood.optimum.data, free.data)
            });
        let costs = costs.filter(|(likely, free)| likely.is_finite() && free.is_finite());
        let least = costs.reduce(|a, b| (a.0.min(b.0), a.1.min(b.1)));
        least.unwrap_or((f64::NEG_INFINITY, f64::NEG_INFINITY))
    }

    fn score_all(&mut self) {
        self.judge.least = self.least_data();
        for set in self.sets.values_mut() {
            set.score = self.judge.score(self.base, &set.fit, &set.likelihood);
        }
    }

    pub fn best(&self) -> &Scored {
        let sets = self.sets.values();
        sets.max_by(|a, b| a.score.total_cmp(&b.score))
            .expect("the model without effects at least")
    }

    /// Sets whose score is near the best, best first.
    pub fn near_best(&self) -> Vec<Scored> {
        let least = self.best().score - self.base.settings.near_best;
        let near = self.sets.values().filter(|set| set.score >= least);
        let mut near: Vec<Scored> = near.cloned().collect();
        near.sort_by(|a, b| b.score.total_cmp(&a.score));
        near.truncate(self.base.settings.fitted_sets);
        near
    }

    /// Whether the search has taken the simulation time that it may.
    pub fn is_at_limit(&self) -> bool {
        self.segments.work.nanoseconds() >= self.until_ns
    }

    /// The same for sets derived from the best.
    pub fn is_at_end(&self) -> bool {
        self.segments.work.nanoseconds() >= self.derived_until_ns
    }

    /// Whether a set is fitted from the parameters of another for the first time.
    pub fn is_new(&mut self, from: Vec<&'static str>, to: Vec<&'static str>) -> bool {
        self.derived.insert((from, to))
    }

    /// The fit without effects.
    pub fn none(&self) -> &Fit {
        let none = self.sets.get(&Vec::new());
        &none.expect("the model without effects is fitted first").fit
    }

    /// Score of a fitted set.
    pub fn score_of(&self, fit: &Fit) -> f64 {
        let set = self.sets.get(&fit.ids());
        set.map_or(f64::NEG_INFINITY, |set| set.score)
    }

    /// The best set, and the best set without each of its members, of those beside which no effect was screened yet: what is added to one of
    /// these is added to the best set, or exchanged for a member of it.
    pub fn not_expanded(&self) -> Vec<Fit> {
        let best = self.best().fit.ids();
        let without = (0..best.len()).map(|k| {
            let mut fewer = best.clone();
            fewer.remove(k);
            fewer
        });
        let mut near = vec![best.clone()];
        near.extend(without);
        near.retain(|ids| {
            ids.len() < self.base.settings.most_effects && !self.expanded.contains(ids)
        });
        let fits = near.iter().filter_map(|ids| self.sets.get(ids));
        fits.map(|set| set.fit.clone()).collect()
    }

    /// Marks that every effect was screened beside a fit.
    pub fn expanded(&mut self, fit: &Fit) {
        self.expanded.insert(fit.ids());
    }

    pub fn likelihood_of(&self, fit: &Fit) -> Likelihood {
        match self.sets.get(&fit.ids()) {
            Some(scored) => scored.likelihood.clone(),
            None => likelihood(self.segments, self.base, fit),
        }
    }

    /// A model's start with the base parameters of the fit without effects.
    pub fn none_start(&self, model: &Model) -> Vec<f64> {
        match self.sets.get(&Vec::new()) {
            Some(none) => model.start_from(&none.fit.model, &none.fit.x),
            None => model.start(),
        }
    }

    /// Price of an effect's complexity before it is fitted: the catalogue and its discrete alternatives.
    pub fn price(&self, member: &Member) -> f64 {
        (catalogue().len() as f64).ln() + log_options(self.base, member)
    }

    /// All sets, best first, but those with an effect by direction whose two directions are alike: a set with fewer parameters predicts the
    /// same. An effect without a parameter of its own, as a changed inertia, implies no other that predicts the same.
    pub fn sorted(self) -> (Vec<Scored>, Judge) {
        let same = self.base.settings.unexplained_share.powi(2) * ROUNDING_VARIANCE;
        let sets = self.sets.into_values();
        let mut sets: Vec<Scored> = sets.filter(|set| set.score.is_finite()).collect();
        sets.sort_by(|a, b| b.score.total_cmp(&a.score));
        let differ = |a: &Fit, b: &Fit| {
            let pairs = a.corrected.iter().zip(&b.corrected);
            mean_square(&pairs.map(|(a, b)| a - b).collect::<Vec<_>>()) >= same
        };
        let by_direction = |set: &Scored| {
            let ids = set.fit.ids();
            ids.iter().filter(|id| is_by_direction(id)).count()
        };
        let is_implied = |set: &Scored| {
            sets.iter().any(|other| {
                by_direction(other) < by_direction(set)
                    && other.fit.model.members.len() == set.fit.model.members.len()
                    && other.fit.x.len() < set.fit.x.len()
                    && !differ(&other.fit, &set.fit)
            })
        };
        let distinct = sets
            .iter()
            .filter(|set| !is_implied(set))
            .cloned()
            .collect();
        (distinct, self.judge)
    }
}
