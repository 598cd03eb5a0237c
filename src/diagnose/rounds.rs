//! Rounds of growth: which set is grown next, and until when.
//!
//! The best single effect is grown first, then the other part of the pair that it becomes, or what leaves something. What a parent
//! got wrong for want of its partner is mended: effects that go in steps are looked for again beside their new partners, and where
//! the best set leaves something, pairs are weighed at once. Where lost edges or late samples stand for what is there, the effect beside
//! them is grown next. It ends with a set that leaves nothing from both of its parts, with what
//! the catalogue has little to say of (`outlook.rs`), with a recording that is ranked by pieces, or with the work that there may be.

use super::candidate::{Candidate, dedup, sorted};
use super::disturbance::disturbance;
use super::effort::ALL;
use super::growth::{Field, Known};
use super::other_law::OF_A_LAW;
use super::outlook::Outlook;
use super::refined::Refined;
use super::ties::TIE;

/// A further effect may weigh this many nats less than none: a prior of a further effect costs about four, so
/// that it must explain something.
const CHEAPEST: f64 = 1.5;
/// A third effect must weigh more than two alone by what three times the separation that noise hides comes to, `9^2 / 2`: as
/// much the laws of two together may differ from the motor's (`other_law.rs`).
const THIRD: f64 = 0.5 * (OF_A_LAW * TIE) * (OF_A_LAW * TIE);
/// How many single effects are grown where the best set leaves something.
const BEST_SINGLES: usize = 3;
/// Most effects of a set, and most sets that are grown.
const MOST_EFFECTS: usize = 3;
const MOST_EXPANDED: usize = 2;
/// The same where pairs are not weighed at once.
const MOST_EXPANDED_ALONE: usize = 4;
/// The same on pieces of a rough recording where work has a limit.
const MOST_EXPANDED_IN_PIECES: usize = 1;
/// Sets this many nats behind the best are grown too.
const CLOSE: f64 = 20.0;
/// How many single effects, the likeliest ones, are looked at in the place of one part of a pair that leaves nothing, where work has a
/// limit, and late.
const IN_PLACE: usize = 12;
const IN_PLACE_LATE: usize = 6;
/// How many effects, those that came next in the round before, are tried as a third one where there is little work left for it.
const NEXT: usize = 4;

/// What is grown from, and what with.
pub(super) struct Rounds<'a> {
    /// Effects that these runs can tell of.
    pub applicable: &'a [usize],
    /// The set without effects.
    pub null: &'a Candidate,
    /// What was looked for again so far.
    pub refined: Refined,
    /// Is told what is being done.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

impl Rounds<'_> {
    /// Adds sets to candidates of no effect and of one, likeliest first.
    pub fn grow(mut self, field: &mut Field<'_>, candidates: &mut Vec<Candidate>) {
        let mut expanded: Vec<Vec<usize>> = Vec::new();
        let mut asked = Asked::default();
        let mut is_covered_up = false;
        loop {
            let next = if is_covered_up {
                without_noise(candidates)
            } else {
                field.next_parent(candidates, &expanded)
            };
            let Some(parent) = next else {
                break;
            };
            if !field.goes_on(&candidates[0]) || asked.is_rough(field, &candidates[0]) {
                break;
            }
            if expanded.is_empty() {
                field.outlook = Outlook::with(field, &candidates[0]);
            }
            expanded.push(sorted(&parent.effects));
            (self.progress)("trying further effects beside the best");
            self.round(field, candidates, &parent, is_covered_up);
            if asked.is_rough(field, &candidates[0]) {
                break;
            }
            let (before, after) = (field.outlook, Outlook::with(field, &candidates[0]));
            field.outlook = Outlook::Open;
            if after == Outlook::Open {
                is_covered_up = false;
                self.mend(field, candidates, expanded.len() == 1);
                continue;
            }
            field.problem.effort.cut();
            if is_covered_up {
                break;
            }
            is_covered_up = (before, after) == (Outlook::CoveredUp, Outlook::CoveredUp);
        }
    }

    /// Looks again for what goes in steps; after the first round, where the best set leaves something, weighs pairs at once.
    fn mend(&mut self, field: &Field<'_>, candidates: &mut Vec<Candidate>, is_first: bool) {
        let effort = &field.problem.effort;
        let is_due =
            effort.is_early() || field.problem.is_rough() || field.is_enough(&candidates[0]);
        if !is_due {
            effort.cut();
        } else if field.goes_on(&candidates[0]) {
            let again = field.refined(candidates, &mut self.refined);
            candidates.extend(again);
            dedup(candidates);
        }
        // Where the command answers to the motion, what effects take off the residual does not add up.
        let adds_up = !field.problem.setting.is_held;
        let wants_pairs = is_first && adds_up && field.wants_more(&candidates[0]);
        if wants_pairs && !effort.is_early() {
            effort.cut();
        } else if wants_pairs {
            (self.progress)("trying pairs");
            candidates.extend(field.pairs(self.null, &candidates[0], self.applicable));
            dedup(candidates);
        }
    }

    /// Adds the parent with one more effect, where that is worth it; beneath a noise with those that it was not fitted with before.
    fn round(
        &self,
        field: &Field<'_>,
        candidates: &mut Vec<Candidate>,
        parent: &Candidate,
        is_beneath: bool,
    ) {
        let instead_of = field.pair_that_is_enough(parent, candidates);
        let mut others = self.others(field, candidates, parent, instead_of.as_ref());
        if is_beneath {
            others.retain(|&e| !is_known_beside(candidates, parent, e));
        }
        let grown = field.with_one_more(parent, &others, instead_of.as_ref());
        let least = if parent.effects.len() > 1 {
            THIRD
        } else {
            -CHEAPEST
        };
        let is_worth_it = |new: &Candidate| new.log_weight > parent.log_weight + least;
        candidates.extend(grown.into_iter().filter(is_worth_it));
        dedup(candidates);
    }

    /// The effects that are tried beside a parent. Where work has a limit: in the place of one part of a pair that leaves nothing
    /// the likeliest ones, and late, or beside what is covered up, as a third one what came next in the round before.
    fn others(
        &self,
        field: &Field<'_>,
        candidates: &[Candidate],
        parent: &Candidate,
        instead_of: Option<&Known<'_>>,
    ) -> Vec<usize> {
        let effort = &field.problem.effort;
        let is_new = |e: &usize| !parent.effects.contains(e);
        let mut others: Vec<usize> = self.applicable.iter().copied().filter(is_new).collect();
        if effort.is_unlimited() {
            return others;
        }
        if let Some(known) = instead_of {
            let most = if effort.is_early() {
                IN_PLACE
            } else {
                IN_PLACE_LATE
            };
            let singles = candidates.iter().filter(|c| c.effects.len() == 1);
            let likeliest: Vec<usize> = singles.take(most).map(|c| c.effects[0]).collect();
            effort.retain(&mut others, |e| {
                *e == known.partner || likeliest.contains(e)
            });
        }
        let is_hurried = || effort.is_half() || Outlook::with(field, parent) == Outlook::CoveredUp;
        if parent.effects.len() > 1 && !field.problem.is_rough() && is_hurried() {
            let next = came_next(candidates, parent);
            effort.retain(&mut others, |e| next.contains(e));
        }
        others
    }
}

impl Field<'_> {
    /// Which set to grow next: the best; then the other part of a best pair that leaves nothing (the best pair need not hold
    /// the best single effect), or the pair that leaves something. In a rough recording each part of a best pair, and as long
    /// as the best leaves something, the other best single effects, and what is close.
    fn next_parent(&self, candidates: &[Candidate], expanded: &[Vec<usize>]) -> Option<Candidate> {
        let effort = &self.problem.effort;
        let most = if self.problem.setting.is_held {
            MOST_EXPANDED_ALONE
        } else {
            MOST_EXPANDED
        };
        if expanded.len() >= most {
            return None;
        }
        let next = self.open_parent(candidates, expanded)?;
        if next.effects.len() > 1 && !self.problem.is_rough() && effort.is_late() {
            effort.cut();
            return None;
        }
        let is_hurried = self.problem.is_rough() && !effort.is_unlimited();
        if is_hurried && (expanded.len() >= MOST_EXPANDED_IN_PIECES || !effort.is_early()) {
            effort.cut();
            return None;
        }
        Some(next)
    }

    /// The same whatever was grown before, and however much work there is left.
    fn open_parent(&self, candidates: &[Candidate], expanded: &[Vec<usize>]) -> Option<Candidate> {
        let best = candidates.first()?;
        let open = |c: &&Candidate| {
            !c.effects.is_empty()
                && c.effects.len() < MOST_EFFECTS
                && !expanded.contains(&sorted(&c.effects))
        };
        if open(&best) && best.effects.len() == 1 {
            return Some(best.clone());
        }
        let part_of_best = |c: &&Candidate| {
            c.effects.len() + 1 == best.effects.len()
                && c.effects.iter().all(|e| best.effects.contains(e))
        };
        let other_part = candidates.iter().filter(open).find(part_of_best);
        // What stands in for one effect while the other is missing need not be it: a pair is looked for from both of its
        // parts, even where the first that was found leaves nothing.
        let is_enough = self.is_enough(best);
        let is_rough = self.problem.is_rough();
        if best.effects.len() == 2 && other_part.is_some() && (is_enough || is_rough) {
            return other_part.cloned();
        }
        if is_enough {
            return None;
        }
        if !is_rough {
            return candidates.first().filter(open).cloned();
        }
        let singles = candidates.iter().filter(|c| c.effects.len() == 1);
        let close = |c: &&Candidate| c.log_weight > best.log_weight - CLOSE;
        let found = other_part
            .or_else(|| singles.take(BEST_SINGLES).find(open))
            .or_else(|| candidates.first().filter(open))
            .or_else(|| candidates.iter().filter(open).find(close));
        found.cloned()
    }

    /// The best pair, where `parent` is one of it and it leaves nothing.
    fn pair_that_is_enough<'c>(
        &self,
        parent: &Candidate,
        candidates: &'c [Candidate],
    ) -> Option<Known<'c>> {
        let best = candidates.first().filter(|best| best.effects.len() == 2)?;
        let [own] = parent.effects.as_slice() else {
            return None;
        };
        let is_part = best.effects.contains(own) && self.is_enough(best);
        let partner = *best
            .effects
            .iter()
            .find(|e| *e != own)
            .filter(|_| is_part)?;
        Some(Known {
            pair: best,
            partner,
        })
    }

    /// Whether the search goes on: as long as work is left, and on whole runs from a set that leaves nothing up to the limit itself.
    /// (On pieces with the noise of a rough recording many a set does.)
    fn goes_on(&self, best: &Candidate) -> bool {
        if !self.problem.is_rough() && self.is_enough(best) {
            self.problem.effort.is_left(ALL)
        } else {
            self.is_work_left()
        }
    }

    /// Whether the best set leaves something, and work is left to look for it.
    fn wants_more(&self, best: &Candidate) -> bool {
        !self.is_enough(best) && self.is_work_left()
    }
}

/// The part of the best pair beside what is noise of its own, where it is the likeliest effect without such noise, too: lost edges and
/// late samples can cover up what is there beside it.
fn without_noise(candidates: &[Candidate]) -> Option<Candidate> {
    let is_bare =
        |c: &&Candidate| c.effects.len() == 1 && c.fit.hypothesis.noise_numbers().next().is_none();
    let best = candidates.first()?;
    let likeliest = candidates.iter().find(is_bare)?;
    let is_part = best.effects.contains(&likeliest.effects[0]);
    is_part.then(|| likeliest.clone())
}

/// Whether the parent with this effect was fitted before.
fn is_known_beside(candidates: &[Candidate], parent: &Candidate, effect: usize) -> bool {
    let set = sorted(&[parent.effects.as_slice(), &[effect]].concat());
    candidates.iter().any(|c| sorted(&c.effects) == set)
}

/// The effects that the likeliest pairs have beside one effect of the parent.
fn came_next(candidates: &[Candidate], parent: &Candidate) -> Vec<usize> {
    let mut next = Vec::new();
    for pair in candidates.iter().filter(|c| c.effects.len() == 2) {
        let (known, new): (Vec<usize>, Vec<usize>) =
            (pair.effects.iter()).partition(|e| parent.effects.contains(e));
        if known.len() == 1 && !next.contains(&new[0]) && next.len() < NEXT {
            next.push(new[0]);
        }
    }
    next
}

/// The best set that was asked last whether what it leaves is noise of the recording's own.
#[derive(Default)]
struct Asked(Vec<usize>);

impl Asked {
    /// Whether it is, once half of the work is spent: such a recording is ranked by pieces, whatever else is found. Asked once
    /// of a set.
    fn is_rough(&mut self, field: &Field<'_>, best: &Candidate) -> bool {
        let problem = field.problem;
        if !problem.effort.is_half()
            || problem.is_rough()
            || problem.setting.is_held
            || self.0 == best.effects
            || field.is_enough(best)
        {
            return false;
        }
        self.0.clone_from(&best.effects);
        disturbance(problem, &best.fit, field.scale).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{fit, held_at, index, motor_with, problem, ready, recording};
    use super::*;

    #[test]
    fn what_came_next_are_the_other_effects_of_the_likeliest_pairs_with_one_of_the_parent() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let fit = fit(&problem(&nominal, &runs), &[]);
        let set = |effects: &[usize]| Candidate {
            effects: effects.to_vec(),
            fit: fit.clone(),
            log_weight: 0.0,
            probability: 0.0,
        };
        let sets = [
            &[6, 19][..],
            &[7, 6],
            &[6],
            &[3, 8],
            &[6, 2],
            &[19, 7],
            &[19, 4],
            &[],
            &[6, 11],
            &[6, 12],
        ]
        .map(set);
        assert_eq!(came_next(&sets, &sets[0]), [7, 2, 4, 11]);
        let known = [3, 7, 19, 20].map(|e| is_known_beside(&sets, &sets[2], e));
        assert_eq!(known, [false, true, true, false]);
    }

    /// The partner of lost edges where it is the likeliest effect without noise, and nothing where another one is likelier.
    #[test]
    fn beneath_a_noise_the_effect_beside_it_is_grown_where_none_is_likelier() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let set = |effects: &[(&str, &[f64])]| Candidate {
            effects: effects.iter().map(|(id, _)| index(id)).collect(),
            fit: held_at(&problem, effects),
            log_weight: 0.0,
            probability: 0.0,
        };
        let lost = ("missed_counts", &[0.01, 0.0][..]);
        let (drag, sag) = (("quadratic_drag", &[1e-3][..]), ("supply_sag", &[1.0][..]));
        let next = |second: &[(&str, &[f64])], third: &[(&str, &[f64])]| {
            let sets = [&[lost, drag][..], &[lost], second, third].map(set);
            without_noise(&sets).map(|c| c.effects)
        };
        assert_eq!(next(&[drag], &[sag]), Some(vec![index("quadratic_drag")]));
        assert_eq!(next(&[sag], &[drag]), None);
    }
}
