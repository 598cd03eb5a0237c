//! Which sets of effects are fitted: single ones, then the best with one more beside them.
//!
//! Every effect is tried beside a parent on short horizons, the promising ones are fitted on long ones. Which parent, and in
//! how many rounds, `rounds.rs` says.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::candidate::{Candidate, by_weight, candidate};
use super::data::RunData;
use super::fit::Fit;
use super::further::Further;
use super::kept::Kept;
use super::looks::{Bar, first_fit, least_of_all, likelier, scanned_fit};
use super::outlook::Outlook;
use super::pairs::{not_repeating, promising};
use super::periodic::parts;
use super::problem::Problem;
use super::prospect::{Prospect, by_promise, keep_rivals};
use super::rivals::catalogue;
use super::scales::largest_acceleration;
use super::search::Search;
use super::unknown::flexible;

/// Most steps of a final fit on each level.
pub(super) const FINAL_STEPS: usize = 10;
/// A set that leaves a wander of this share of the largest acceleration, and a base bent by this many squares of
/// the prior's standard deviations (exceeded by chance once in a hundred), leaves nothing.
const CALM: f64 = 0.001;
const UNBENT: f64 = 13.3;
/// How many nats the base alone loses at most in a hollow that is not the deepest.
const DEEPEST_HOLLOW: f64 = 300.0;

/// How many looks are taken before it is asked again whether work is left.
const AT_ONCE: usize = 6;
/// How many pairs are fitted that promise to explain the runs together.
const PROMISING: usize = 4;
/// In recordings of more samples than this they are looked for in the first part.
const LONG: usize = 20_000;

/// A pair that leaves nothing, one of whose effects is the parent of a round.
pub(super) struct Known<'a> {
    /// The pair.
    pub pair: &'a Candidate,
    /// Its other effect.
    pub partner: usize,
}

/// What is searched, and how.
pub(super) struct Field<'a> {
    /// The runs and the nominal motor.
    pub problem: &'a Problem<'a>,
    /// The same for the first parts of the runs.
    pub beginnings: &'a [Problem<'a>],
    /// Largest acceleration in counts/s^2.
    pub scale: f64,
    /// What every effect promises beside nothing, kept from when it was first asked: by one at a time, since making it waits for
    /// other tasks.
    alone: OnceLock<Vec<Prospect>>,
    /// How the search stands.
    pub outlook: Outlook,
    /// Whether sets leave nothing, by their effects and evidence.
    enough: Kept<(Vec<usize>, u64), bool>,
}

impl<'a> Field<'a> {
    /// Of this problem, and the same for the first parts of its runs.
    pub fn new(problem: &'a Problem<'a>, beginnings: &'a [Problem<'a>]) -> Self {
        Self {
            problem,
            beginnings,
            scale: largest_acceleration(problem.nominal, problem.runs),
            alone: OnceLock::new(),
            outlook: Outlook::default(),
            enough: Kept::default(),
        }
    }

    /// Whether a set leaves nothing to explain: no wander to speak of, the base where it was stated, and
    /// nothing in the residual that depends on speed, angle, time or command.
    pub fn is_enough(&self, candidate: &Candidate) -> bool {
        let fit = &candidate.fit;
        let is_flat = || flexible(self.problem, fit, self.scale).gain_of_large < 0.0;
        let key = (candidate.effects.clone(), fit.log_evidence.to_bits());
        fit.wander <= CALM * self.scale
            && fit.hypothesis.strain(&fit.p) < UNBENT
            && *self.enough.of(key, is_flat)
    }

    /// Whether another part of the search may begin.
    pub fn is_work_left(&self) -> bool {
        self.problem.effort.is_left(self.outlook.share())
    }

    /// Fits the parent with each of these effects added. Beside an effect of a pair that leaves nothing, `instead_of` the
    /// other one. Where work has a limit that one is asked what it promises, but not fitted again (of 163 such pairs one became
    /// likelier by a nat for it, none by more), and what is far behind the pair on short horizons is not fitted on long ones.
    pub fn with_one_more(
        &self,
        parent: &Candidate,
        indices: &[usize],
        instead_of: Option<&Known<'_>>,
    ) -> Vec<Candidate> {
        let problem = self.problem;
        let known = instead_of.filter(|_| !problem.effort.is_unlimited());
        let level = self.search_level(&parent.fit);
        let Some(search) = Search::new(problem, &parent.fit, level) else {
            return Vec::new();
        };
        // Where much is left, what is linear close by tells little of what an effect could do.
        let is_good = !parent.effects.is_empty() && self.is_enough(parent);
        let mut found = if parent.effects.is_empty() {
            let alone = self.alone.get_or_init(|| prospects(&search, indices));
            alone.clone()
        } else {
            prospects(&search, indices)
        };
        found.retain(|new| !is_good || new.is_worth_it());
        if let Some(known) = instead_of {
            keep_rivals(&mut found, known.partner);
        }
        found.retain(|new| known.is_none_or(|known| new.index != known.partner));
        let is_alone = parent.effects.is_empty();
        let is_plenty = problem.effort.is_plenty();
        let (likely, others) = by_promise(found, is_alone, is_plenty);
        let least = known.and_then(|known| least_of_all(problem, &known.pair.fit, level));
        let mut further = Further::above(least);
        let mut short = self.looks(parent, likely, level, None);
        let grown = self.fitted_on(short.clone(), level, &mut further);
        let best = grown.iter().min_by(|a, b| by_weight(a, b));
        let is_third = parent.effects.len() > 1 && !problem.is_rough();
        let is_enough = || known.is_some() || best.is_some_and(|best| self.is_enough(best));
        if others.is_empty() || is_third || is_enough() {
            return grown;
        }
        if !is_alone && !problem.effort.is_unlimited() {
            problem.effort.cut();
            return grown;
        }
        let first = short.iter().min_by(|a, b| by_weight(a, b));
        let more = self.looks(parent, others, level, first);
        short.extend(more);
        self.fitted_on(short, level, &mut further)
    }

    /// First looks at the parent with each of these effects. Those whose order is scanned for cost ten times as much: they come
    /// after the others, and stop early where they are far behind the best of all looks. Late, on pieces of a rough recording, where
    /// nothing has the time to part, each is looked at from its likeliest start alone.
    fn looks(
        &self,
        parent: &Candidate,
        new: Vec<Prospect>,
        level: usize,
        before: Option<&Candidate>,
    ) -> Vec<Candidate> {
        let weighed = |index: usize, fit: Option<Fit>| {
            let mut effects = parent.effects.clone();
            effects.push(index);
            Some(candidate(self.problem, effects, fit?, self.scale))
        };
        let is_hurried = self.problem.is_rough() && !self.problem.effort.is_early();
        if is_hurried {
            self.problem.effort.cut();
            let looks = new.into_par_iter().with_max_len(1).filter_map(|mut new| {
                new.starts.truncate(1);
                weighed(new.index, first_fit(self.problem, new.starts, level))
            });
            return looks.collect();
        }
        let (mut scanned, mut others): (Vec<_>, Vec<_>) =
            new.into_iter().partition(|new| new.is_scanned());
        let goes_on = || parent.effects.is_empty() || self.is_work_left();
        let mut found: Vec<Candidate> = Vec::new();
        others.sort_by(|a, b| b.promise.total_cmp(&a.promise));
        let promises = others.iter().map(|new| new.promise);
        let highest = promises.filter(|x| x.is_finite()).fold(0.0, f64::max);
        for (k, some) in others.chunks(AT_ONCE).enumerate() {
            if k > 0 && !goes_on() {
                break;
            }
            let some = some.to_vec().into_par_iter().with_max_len(1);
            let look = |new: Prospect| {
                let parts = parts(catalogue()[new.index].id) && new.is_worth_scanning(highest);
                let far = parts.then(|| scanned_fit(self, new.starts.clone(), level, None));
                let near = first_fit(self.problem, new.starts, level);
                likelier(near, far.flatten())
            };
            found.par_extend(some.filter_map(|new| {
                let index = new.index;
                weighed(index, look(new))
            }));
        }
        // What promises the most of all is looked at in any case.
        if !scanned.is_empty() && !goes_on() {
            scanned.retain(|new| new.promise > highest);
        }
        // One after the other: where the first is right, the next stops early.
        scanned.sort_by(|a, b| b.promise.total_cmp(&a.promise));
        for (k, new) in scanned.into_iter().enumerate() {
            if k > 0 && !goes_on() {
                break;
            }
            let best = found.iter().chain(before).min_by(|a, b| by_weight(a, b));
            let bar = best.and_then(|best| Bar::new(self, &best.fit, level));
            let fit = scanned_fit(self, new.starts, level, bar.as_ref());
            found.extend(weighed(new.index, fit));
        }
        found
    }

    /// The most promising pairs, fitted: two that show together only are not found one by one. What is far behind the best
    /// known set on short horizons is not fitted on long ones.
    pub fn pairs(&self, null: &Candidate, best: &Candidate, indices: &[usize]) -> Vec<Candidate> {
        let problem = self.problem;
        let level = self.search_level(&null.fit);
        // A beginning of a long recording tells which pairs are worth a fit.
        let samples: usize = problem.runs.iter().map(RunData::len).sum();
        let beginning = self.beginnings.first().filter(|_| samples > LONG);
        let promises = match beginning {
            None => Search::new(problem, &null.fit, level).map(|search| {
                let alone = self.alone.get_or_init(|| prospects(&search, indices));
                promising(problem, &search, alone, indices, PROMISING)
            }),
            Some(beginning) => {
                let null = &null.fit;
                let null = beginning.fit_at(&null.hypothesis, &null.p, null.wander, 0);
                let search = null.and_then(|null| Search::new(beginning, &null, level));
                search.map(|search| {
                    let alone = prospects(&search, &not_repeating(indices));
                    promising(beginning, &search, &alone, indices, PROMISING)
                })
            }
        };
        let Some(promises) = promises.filter(|promises| !promises.is_empty()) else {
            return Vec::new();
        };
        let bar = Bar::new(self, &best.fit, level);
        let short: Vec<Candidate> = promises
            .into_par_iter()
            .with_max_len(1)
            .filter_map(|promise| {
                let effects = promise.effects.to_vec();
                let fit = if effects.iter().any(|&e| parts(catalogue()[e].id)) {
                    scanned_fit(self, promise.starts, level, bar.as_ref())
                } else {
                    first_fit(problem, promise.starts, level)
                };
                Some(candidate(problem, effects, fit?, self.scale))
            })
            .collect();
        let (hopeless, open): (Vec<_>, Vec<_>) = short
            .into_iter()
            .partition(|c| bar.as_ref().is_some_and(|bar| bar.is_out_of_reach(&c.fit)));
        let mut fitted = self.fitted_on(open, level, &mut Further::above(None));
        fitted.extend(hopeless);
        fitted
    }

    /// On which level of the wander to look beside a fit: on short horizons, but not so short that what is
    /// left of it by a good fit drowns.
    pub fn search_level(&self, parent: &Fit) -> usize {
        let levels = &self.problem.levels;
        let own = levels.iter().position(|level| *level <= parent.wander);
        let two_stronger = own.unwrap_or(0).saturating_sub(2);
        two_stronger.max(1).min(levels.len() - 1)
    }
}

/// What each of these effects promises.
fn prospects(search: &Search<'_>, indices: &[usize]) -> Vec<Prospect> {
    let indices = indices.par_iter().with_max_len(1);
    indices.map(|&index| search.prospect(index, None)).collect()
}

/// Fits the best candidate's set without each of its effects, from that candidate's own numbers: a smaller set must
/// not lose because its own fit ended in a worse hollow. The base alone has none as deep as what it lacks where it is far behind.
pub(super) fn without_one(
    problem: &Problem<'_>,
    candidates: &[Candidate],
    scale: f64,
) -> Vec<Candidate> {
    let Some(full) = candidates.first() else {
        return Vec::new();
    };
    (0..full.effects.len())
        .into_par_iter()
        .filter_map(|m| {
            let mut effects = full.effects.clone();
            let removed = effects.remove(m);
            let alone = candidates.iter().find(|c| c.effects.is_empty());
            let is_hopeless =
                alone.is_some_and(|c| c.log_weight < full.log_weight - DEEPEST_HOLLOW);
            if effects.is_empty() && is_hopeless {
                return None;
            }
            let (hypothesis, start) = full.fit.hypothesis.without(
                removed,
                problem.nominal,
                &problem.setting,
                &full.fit.p,
            );
            let fit = problem.fit(&hypothesis, &start, FINAL_STEPS)?;
            Some(candidate(problem, effects, fit, scale))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::disturbance::Disturbance;
    use super::super::effort::Effort;
    use super::super::samples::{fit, index, motor_with, problem, ready, recording};
    use super::*;

    #[test]
    fn the_partner_of_a_pair_that_leaves_nothing_is_not_fitted_again_where_work_has_a_limit() {
        let pair = [
            ("gravity_load", &[0.05, 0.4][..]),
            ("stribeck", &[0.03, 0.5]),
        ];
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&pair)));
        let partner = index("stribeck");
        let grown = |effort: Effort| -> Vec<usize> {
            let problem = problem(&nominal, &runs).with_effort(&Arc::new(effort));
            let field = Field::new(&problem, &[]);
            let set = |effects: &[(&str, &[f64])]| {
                let indices = effects.iter().map(|(id, _)| index(id)).collect();
                candidate(&problem, indices, fit(&problem, effects), field.scale)
            };
            let (pair, parent) = (set(&pair), set(&pair[..1]));
            let known = Known {
                pair: &pair,
                partner,
            };
            let others = [partner, index("asymmetric_friction"), index("dead_zone")];
            let grown = field.with_one_more(&parent, &others, Some(&known));
            grown.iter().map(|set| set.effects[1]).collect()
        };
        assert!(grown(Effort::default()).contains(&partner));
        assert!(!grown(Effort::limited_for(6500)).contains(&partner));
    }

    /// Three effects, so that none is enough: late, on pieces of a rough recording, the order of a ripple is not scanned for.
    #[test]
    fn late_on_pieces_of_a_rough_recording_effects_are_looked_at_from_one_start() {
        let there = [
            ("gravity_load", &[0.05, 0.4][..]),
            ("quadratic_drag", &[1e-3]),
            ("coast_at_zero", &[]),
        ];
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&there)));
        let ripple = index("torque_ripple");
        let grown = |is_rough: bool, is_late: bool| {
            let effort = Arc::new(Effort::limited_for(6500));
            let mut problem = problem(&nominal, &runs).with_effort(&effort);
            if is_rough {
                problem.set_rough(Disturbance {
                    scatter: 1.0,
                    ..Disturbance::default()
                });
            }
            if is_late {
                effort.spend(770_000_000);
            }
            let field = Field::new(&problem, &[]);
            let null = candidate(&problem, Vec::new(), fit(&problem, &[]), field.scale);
            let tried = [index("gravity_load"), ripple];
            let grown = field.with_one_more(&null, &tried, None);
            let found = grown.iter().find(|set| set.effects == [ripple]);
            let evidence = found.expect("it is weighed").fit.log_evidence;
            (evidence, effort.was_cut())
        };
        let (scanned, looked_at) = (grown(true, false), grown(true, true));
        assert!(!scanned.1 && looked_at.1);
        assert!(looked_at.0 < scanned.0, "{looked_at:?} {scanned:?}");
        assert_eq!(grown(false, false).0, grown(false, true).0);
    }
}
