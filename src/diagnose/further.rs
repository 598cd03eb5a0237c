//! Fits on what first looks found: a few more steps for the better ones, long horizons for the best.
//!
//! Who is fitted on hangs on who else was looked at. Where a round is widened, what was fitted before is not fitted again.

use std::collections::HashMap;

use rayon::prelude::*;

use super::candidate::{Candidate, by_weight, candidate};
use super::effort::MOST;
use super::growth::{FINAL_STEPS, Field};
use super::outlook::Outlook;

/// Most steps by which a first look is continued on the same horizons.
const FURTHER_STEPS: usize = 5;
/// How many effects of a round are fitted on after the first steps.
const FITTED_ON: usize = 12;
/// How many effects of a round are fitted on long horizons too.
const FULLY_FITTED: usize = 6;
/// Effects this many nats behind the best of a round on short horizons are fitted fully too.
const NEAR: f64 = 12.0;
/// The same for those further behind of the first of a round; and from where on not even a few more steps pay.
const FAR: f64 = 100.0;
const HOPELESS: f64 = 1000.0;
/// How many of a round are fitted on in any case, and fully where the best of it leaves something and most of the work is not spent.
const LEADERS: usize = 3;

/// What was fitted on in a round, by its effects.
pub(super) struct Further {
    /// What has less evidence on short horizons is not fitted on long ones.
    least: f64,
    /// After a few more steps.
    continued: HashMap<Vec<usize>, Candidate>,
    /// After the long horizons.
    full: HashMap<Vec<usize>, Candidate>,
}

impl Further {
    /// Nothing yet; only what has this evidence on short horizons will be fitted on long ones, where there is a bar.
    pub fn above(least: Option<f64>) -> Self {
        Self {
            least: least.unwrap_or(f64::NEG_INFINITY),
            continued: HashMap::new(),
            full: HashMap::new(),
        }
    }
}

impl Field<'_> {
    /// Candidates after first steps on short horizons, the best of them fitted on and then on long ones; on these the first alone
    /// where no work is left for what is covered up.
    pub fn fitted_on(
        &self,
        mut short: Vec<Candidate>,
        level: usize,
        known: &mut Further,
    ) -> Vec<Candidate> {
        short.sort_by(by_weight);
        let best = short.first().map_or(0.0, |first| first.log_weight);
        let pays = |(place, c): &(usize, &mut Candidate)| {
            *place < LEADERS || (*place < FITTED_ON && c.log_weight > best - HOPELESS)
        };
        remembering(
            &mut known.continued,
            short.iter_mut().enumerate().filter(pays).map(|(_, c)| c),
            |c| self.continued(c),
            || self.is_work_left(),
        );
        short.sort_by(by_weight);
        if self.outlook == Outlook::CoveredUp && !self.is_work_left() {
            // Where what leads leaves nothing on long horizons, nothing is covered up.
            let leader = short.iter_mut().take(1);
            remembering(&mut known.full, leader, |c| self.full(c, level), || false);
            return short;
        }
        let best = short.first().map_or(0.0, |first| first.log_weight);
        // The long horizons decide between the best; the others keep what they have.
        let least = known.least;
        let is_in_reach = |c: &Candidate| c.fit.log_evidence >= least;
        let is_near = |(place, c): &(usize, &mut Candidate)| {
            let behind = best - c.log_weight;
            (behind <= NEAR || (*place < FULLY_FITTED && behind <= FAR)) && is_in_reach(c)
        };
        remembering(
            &mut known.full,
            short.iter_mut().enumerate().filter(is_near).map(|(_, c)| c),
            |c| self.full(c, level),
            || self.is_work_left(),
        );
        // What is far behind one that leaves nothing will not come nearer.
        let best = short.iter().min_by(|a, b| by_weight(a, b));
        if best.is_some_and(|best| !self.is_enough(best)) && self.problem.effort.is_left(MOST) {
            remembering(
                &mut known.full,
                (short.iter_mut().take(LEADERS)).filter(|c| is_in_reach(c)),
                |c| self.full(c, level),
                || self.is_work_left(),
            );
        }
        short
    }

    /// More steps from where a candidate is, on the same horizons.
    fn continued(&self, c: &Candidate) -> Candidate {
        if c.fit.converged {
            return c.clone();
        }
        let fit = &c.fit;
        let further = self
            .problem
            .fit_at(&fit.hypothesis, &fit.p, fit.wander, FURTHER_STEPS);
        match further {
            Some(new) if new.log_evidence > fit.log_evidence => {
                candidate(self.problem, c.effects.clone(), new, self.scale)
            }
            _ => c.clone(),
        }
    }

    /// A candidate on long horizons, if it is better there.
    fn full(&self, c: &Candidate, level: usize) -> Candidate {
        let (hypothesis, p) = (&c.fit.hypothesis, &c.fit.p);
        match self.problem.fit_from(level, hypothesis, p, FINAL_STEPS) {
            Some(full) if full.log_evidence > c.fit.log_evidence => {
                candidate(self.problem, c.effects.clone(), full, self.scale)
            }
            _ => c.clone(),
        }
    }
}

/// Puts in the place of each candidate what `fit` makes of it, or what it made of it before; the first few in any case, the
/// others as long as it `goes_on`.
fn remembering<'a>(
    known: &mut HashMap<Vec<usize>, Candidate>,
    candidates: impl Iterator<Item = &'a mut Candidate>,
    fit: impl Fn(&Candidate) -> Candidate + Sync,
    goes_on: impl Fn() -> bool,
) {
    let candidates: Vec<&mut Candidate> = candidates.collect();
    let unknown: Vec<&Candidate> = candidates
        .iter()
        .map(|c| &**c)
        .filter(|c| !known.contains_key(&c.effects))
        .collect();
    for (k, some) in unknown.chunks(LEADERS).enumerate() {
        if k > 0 && !goes_on() {
            break;
        }
        let some = some.par_iter().with_max_len(1);
        let new: Vec<Candidate> = some.map(|c| fit(c)).collect();
        known.extend(new.into_iter().map(|c| (c.effects.clone(), c)));
    }
    for c in candidates {
        if let Some(fitted) = known.get(&c.effects) {
            *c = fitted.clone();
        }
    }
}
