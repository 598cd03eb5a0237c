//! Identified causes, their probabilities and parameters, for both shapes of a diagnosis.

use super::document::{BudgetStep, Cause, Document, EffectSet, Interval};
use crate::diagnose::SHAPE;

impl Document {
    /// The identified causes: one per effect, in the earlier shape one for all of them.
    pub fn identified(&self) -> impl Iterator<Item = &Cause> {
        let is_whole = |cause: &Cause| cause.effect == self.effects.join("+");
        let holds_all = |cause: &Cause| {
            let parts: Vec<&str> = cause.effect.split('+').collect();
            let mut effects = self.effects.iter();
            effects.all(|effect| parts.contains(&effect.as_str()))
        };
        let earlier = match self.shape != SHAPE && !self.effects.is_empty() {
            true => {
                let whole = self.causes.iter().position(is_whole);
                whole.or_else(|| self.causes.iter().position(holds_all))
            }
            false => None,
        };
        let causes = self.causes.iter().enumerate();
        let found = causes.filter(move |(place, cause)| match self.shape == SHAPE {
            true => self.effects.contains(&cause.effect),
            false => earlier == Some(*place),
        });
        found.map(|(_, cause)| cause)
    }

    /// Whether a cause of this document is identified.
    pub fn identifies(&self, cause: &Cause) -> bool {
        self.identified().any(|one| std::ptr::eq(one, cause))
    }

    /// Probability of exactly this set of effects.
    pub fn probability_of(&self, cause: &Cause) -> f64 {
        cause
            .probability
            .unwrap_or_else(|| self.probability_of_set(&[&cause.effect]))
    }

    fn probability_of_set(&self, effects: &[&str]) -> f64 {
        let is_same = |set: &&EffectSet| set.effects == effects;
        let same = self.sets.iter().filter(is_same);
        same.fold(0.0, |sum, set| sum + set.probability)
    }

    /// Probability that no effect is present; `None` for an unusable recording.
    pub fn probability_of_none(&self) -> Option<f64> {
        match self.shape == SHAPE {
            true => (!self.sets.is_empty()).then(|| self.probability_of_set(&[])),
            false => self.stated_probability("none"),
        }
    }

    /// Probability of a cause as the earlier shape states it.
    pub fn stated_probability(&self, name: &str) -> Option<f64> {
        let found = self.causes.iter().find(|cause| cause.effect == name);
        found.and_then(|cause| cause.probability)
    }

    /// The most probable set of effects, joined by `+` (`none` for the empty set), with its probability.
    pub fn most_probable(&self) -> Option<(String, f64)> {
        if self.shape != SHAPE {
            let first = self.causes.first()?;
            return Some((first.effect.clone(), self.probability_of(first)));
        }
        let sets = self.sets.iter();
        let best = sets.max_by(|a, b| a.probability.total_cmp(&b.probability))?;
        let name = match best.effects.is_empty() {
            true => "none".to_owned(),
            false => best.effects.join("+"),
        };
        Some((name, best.probability))
    }

    /// A step of the error budget.
    pub fn budget_step(&self, name: &str) -> Option<&BudgetStep> {
        self.budget.iter().find(|step| step.step == name)
    }

    /// Every identified parameter by its name: base parameters, and `EFFECT.KEY` of the identified effects.
    pub fn numbers(&self) -> impl Iterator<Item = (String, &Interval)> {
        let base = self
            .base
            .iter()
            .map(|(name, number)| (name.clone(), number));
        let identified = self.identified().flat_map(|cause| {
            (cause.parameters.iter()).map(|(key, number)| (full_name(&cause.effect, key), number))
        });
        base.chain(identified)
    }
}

/// `EFFECT.KEY`, also where the key already contains the effect's name.
pub(super) fn full_name(effect: &str, key: &str) -> String {
    if key.contains('.') {
        key.to_owned()
    } else {
        format!("{effect}.{key}")
    }
}
