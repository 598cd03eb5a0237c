//! Looks again for what goes in steps beside partners that were not known when it was chosen.
//!
//! Which levels a dead zone swallows, which of the common resolutions, which order: what was right while the others were
//! missing need not be right with them, and no slope leads from one to the other.

use rayon::prelude::*;

use super::candidate::{Candidate, candidate, sorted};
use super::fit::Fit;
use super::growth::{FINAL_STEPS, Field};
use super::looks::{first_fit, least_of_all};
use super::rivals::catalogue;
use super::search::Search;
use crate::motor::catalogue::Prior;

/// How many sets, and how many nats behind the best, have their effects looked for again.
const REFINED: usize = 4;
/// The same late.
const REFINED_LATE: usize = 1;
const REFINED_NEAR: f64 = 200.0;
/// Fits of a set this many nats apart are the same.
const ALIKE: f64 = 0.5;

impl Field<'_> {
    /// The best sets with each of their effects that goes in steps (which levels a dead zone swallows, which
    /// of the common resolutions, which order) looked for again beside the others as they are now: what was
    /// right while the others were missing need not be right with them.
    pub fn refined(&self, candidates: &[Candidate], known: &mut Refined) -> Vec<Candidate> {
        let best = candidates.first().map_or(0.0, |first| first.log_weight);
        let is_near = |c: &&Candidate| c.log_weight > best - REFINED_NEAR;
        let mut near: Vec<&Candidate> = candidates.iter().filter(is_near).take(REFINED).collect();
        let effort = &self.problem.effort;
        if near.len() > REFINED_LATE && !effort.is_early() {
            near.truncate(REFINED_LATE);
            effort.cut();
        }
        let parts: Vec<(&Candidate, usize)> = near
            .into_iter()
            .flat_map(|c| (0..c.effects.len()).map(move |m| (c, m)))
            .filter(|(c, m)| goes_in_steps(c.effects[*m]) && known.is_news(c, *m))
            .collect();
        parts
            .into_par_iter()
            .with_max_len(1)
            .filter_map(|(full, m)| {
                let known = full.fit.hypothesis.values(m, &full.fit.p);
                self.with_instead(full, m, full.effects[m], Some(&known))
            })
            .collect()
    }

    /// Whether a look at a set is so far behind that set's own fit on the same horizons that it is given up, where work has a limit.
    fn is_far_behind(&self, full: &Candidate, look: &Fit, level: usize) -> bool {
        if self.problem.effort.is_unlimited() {
            return false;
        }
        let least = least_of_all(self.problem, &full.fit, level);
        let is_far = least.is_some_and(|least| look.log_evidence < least);
        if is_far {
            self.problem.effort.cut();
        }
        is_far
    }

    /// A set with this effect looked for in the place of its member `m`, beside the others as they are; `known` are the
    /// effect's values near which to look more closely.
    pub fn with_instead(
        &self,
        full: &Candidate,
        m: usize,
        index: usize,
        known: Option<&[f64]>,
    ) -> Option<Candidate> {
        let problem = self.problem;
        let mut effects = full.effects.clone();
        let removed = effects.remove(m);
        let level = self.search_level(&full.fit);
        let (hypothesis, start) =
            full.fit
                .hypothesis
                .without(removed, problem.nominal, &problem.setting, &full.fit.p);
        let rest = problem.fit_at(&hypothesis, &start, problem.levels[level], 0)?;
        let search = Search::new(problem, &rest, level)?;
        let fit = first_fit(problem, search.starts(index, known), level)?;
        if known.is_some() && self.is_far_behind(full, &fit, level) {
            return None;
        }
        effects.push(index);
        let fit = problem.fit_from(level, &fit.hypothesis, &fit.p, FINAL_STEPS)?;
        Some(candidate(problem, effects, fit, self.scale))
    }
}

/// What was looked for again in which set, and how likely that set was.
#[derive(Default)]
pub(super) struct Refined(Vec<(Vec<usize>, usize, f64)>);

impl Refined {
    /// Whether member `m` of this set was not yet looked for beside a fit as likely as this; from now on it was.
    fn is_news(&mut self, c: &Candidate, m: usize) -> bool {
        let (set, sought) = (sorted(&c.effects), c.effects[m]);
        let same = |(of, member, log_weight): &(Vec<usize>, usize, f64)| {
            *of == set && *member == sought && (log_weight - c.log_weight).abs() < ALIKE
        };
        let is_news = !self.0.iter().any(same);
        if is_news {
            self.0.push((set, sought, c.log_weight));
        }
        is_news
    }
}

/// Whether an effect has numbers that no slope leads to.
fn goes_in_steps(index: usize) -> bool {
    let mut parameters = catalogue()[index].parameters.iter();
    parameters.any(|p| !p.smooth || matches!(p.prior, Prior::OneOf(_)))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::effort::Effort;
    use super::super::samples::{fit, index, motor_with, problem, ready, recording};
    use super::*;

    #[test]
    fn a_look_far_behind_its_set_is_given_up_where_work_has_a_limit() {
        let cogging = ("cogging", &[0.02, 12.0, 1.1][..]);
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[cogging])));
        let level = 1;
        let given_up = |effort: Effort, look: &[(&str, &[f64])]| {
            let problem = problem(&nominal, &runs).with_effort(&Arc::new(effort));
            let field = Field::new(&problem, &[]);
            let right = Candidate {
                effects: vec![index("cogging")],
                fit: fit(&problem, &[cogging]),
                log_weight: 0.0,
                probability: 0.0,
            };
            let look = fit(&problem, look);
            let look = problem.fit_at(&look.hypothesis, &look.p, problem.levels[level], 1);
            let is_far = field.is_far_behind(&right, &look.expect("it can be simulated"), level);
            (is_far, problem.effort.was_cut())
        };
        let limited = || Effort::limited_for(6500);
        assert_eq!(given_up(limited(), &[]), (true, true));
        assert_eq!(given_up(limited(), &[cogging]), (false, false));
        assert_eq!(given_up(Effort::default(), &[]), (false, false));
    }

    /// Late those of the best set alone are looked for again.
    #[test]
    fn late_the_effects_of_the_best_set_alone_are_looked_for_again() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let again = |is_late: bool| {
            let effort = Arc::new(Effort::limited_for(6500));
            let problem = problem(&nominal, &runs).with_effort(&effort);
            let field = Field::new(&problem, &[]);
            let set = |effect: (&str, &[f64])| {
                let fit = fit(&problem, &[effect]);
                candidate(&problem, vec![index(effect.0)], fit, field.scale)
            };
            let sets = [
                set(("backlash", &[0.02, 0.5, 0.0])),
                set(("compliance", &[20.0, 0.1, 0.3, 0.0])),
            ];
            if is_late {
                effort.spend(900_000_000);
            }
            let again = field.refined(&sets, &mut Refined::default());
            (again.len(), effort.was_cut())
        };
        assert_eq!(again(false), (2, false));
        assert_eq!(again(true), (1, true));
    }
}
