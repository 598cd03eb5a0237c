//! Fits through the levels of the wander, from strong to weak.
//!
//! A strong wander forgets quickly: short horizons, a smooth objective. A weak one judges a model by where it goes in the
//! whole run. Each level is fitted from the numbers of the one before, and the one with the best evidence is kept.

use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::problem::Problem;

/// A level of the wander this many nats behind another ends the search for the best: of 3,000 such searches one found a better one
/// behind a level that was 25 nats worse.
const HOPELESS: f64 = 50.0;

/// Most steps of a fit that is taken to another level of the wander.
const OTHER_LEVEL_STEPS: usize = 4;

impl Problem<'_> {
    /// The number of this wander's level; of one between two the weaker's, of one below all the last.
    pub fn level_of(&self, wander: f64) -> usize {
        let found = self.levels.iter().position(|level| *level <= wander);
        found.unwrap_or(self.levels.len().saturating_sub(1))
    }

    /// The same set from where it fits, on another level of the wander.
    pub fn on_wander(&self, fit: &Fit, wander: f64) -> Option<Fit> {
        if wander == fit.wander {
            return Some(fit.clone());
        }
        self.fit_at(&fit.hypothesis, &fit.p, wander, OTHER_LEVEL_STEPS)
    }

    /// Fits from strong to weak wander and keeps the level with the best evidence.
    pub fn fit(&self, hypothesis: &Hypothesis, start: &[f64], most_steps: usize) -> Option<Fit> {
        self.fit_from(0, hypothesis, start, most_steps)
    }

    /// The same from the level with this number on; stronger ones only where the first was the best.
    pub fn fit_from(
        &self,
        first: usize,
        hypothesis: &Hypothesis,
        start: &[f64],
        most_steps: usize,
    ) -> Option<Fit> {
        let mut best: Option<(usize, Fit)> = None;
        let mut p = start.to_vec();
        for (k, &wander) in self.levels.iter().enumerate().skip(first) {
            let reached = best.as_ref().map(|(_, best)| best.log_evidence);
            // Weaker still is worse still; but a little worse is no peak yet.
            let least = reached.map_or(f64::NEG_INFINITY, |reached| reached - HOPELESS);
            match self.fit_towards(least, hypothesis, &p, wander, most_steps) {
                Some(fit) if fit.log_evidence >= least => {
                    p.clone_from(&fit.p);
                    if reached.is_none_or(|reached| fit.log_evidence >= reached) {
                        best = Some((k, fit));
                    }
                }
                None if best.is_none() => {}
                _ => break,
            }
        }
        let (mut at, mut best) = best?;
        while at <= first && at > 0 {
            at -= 1;
            match self.fit_at(hypothesis, &best.p, self.levels[at], most_steps) {
                Some(fit) if fit.log_evidence > best.log_evidence => best = fit,
                _ => break,
            }
        }
        Some(best)
    }
}

/// Puts what `at` finds in the place of the best as long as it gains more.
pub(super) fn climb<T>(
    best: &mut (f64, T),
    levels: impl Iterator<Item = usize>,
    at: impl Fn(usize) -> Option<(f64, T)>,
) {
    for found in levels.map_while(at) {
        if found.0 <= best.0 {
            return;
        }
        *best = found;
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{index, motor_with, problem, ready, recording};
    use super::*;
    use crate::diagnose::hypothesis::Member;

    /// Whoever tries every level to its end finds no better one.
    #[test]
    fn levels_that_are_given_up_after_a_look_are_worse() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[("cogging", &[0.02, 12.0, 1.1])])));
        let problem = problem(&nominal, &runs);
        let drag = Member {
            index: index("quadratic_drag"),
            values: vec![1e-4],
        };
        for members in [Vec::new(), vec![drag]] {
            let hypothesis = Hypothesis::new(&nominal, members, &problem.setting);
            let found = problem
                .fit(&hypothesis, &hypothesis.start(), 10)
                .expect("a fit");
            let mut p = hypothesis.start();
            let mut given_up = 0;
            for &wander in &problem.levels {
                let fit = problem.fit_at(&hypothesis, &p, wander, 10).expect("a fit");
                assert!(fit.log_evidence < found.log_evidence + 0.1);
                given_up += usize::from(fit.log_evidence < found.log_evidence - HOPELESS);
                p = fit.p;
            }
            assert!(given_up > 0, "no level is that far behind");
        }
    }

    /// Up to the next peak, whatever lies behind it, and not past what cannot be fitted.
    #[test]
    fn a_climb_ends_at_the_next_peak() {
        let gains = [4.0, 3.0, 5.0, 1.0, 9.0, f64::NAN, 20.0].map(|x| (!x.is_nan()).then_some(x));
        let at = |level: usize| gains[level].map(|gain| (gain, level));
        let from = |first: usize, levels: std::ops::Range<usize>| {
            let mut best = at(first).expect("a gain");
            climb(&mut best, levels, at);
            best
        };
        assert_eq!(from(1, 2..7), (5.0, 2));
        assert_eq!(from(3, 4..7), (9.0, 4));
        assert_eq!(from(0, 1..7), (4.0, 0));
    }
}
