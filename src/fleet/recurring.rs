//! Effects that recur in the recordings of one unit, compared with the other units' recordings.
//!
//! The count is tested against a binomial distribution with the rate of the other units (k + 1/2 of n + 1, Jeffreys
//! 1946). Effects that recordings seldom separate, a class, count as one.

use std::collections::BTreeMap;

use super::document::Document;
use super::population::{SIGNIFICANT, Unit};
use crate::diagnose::class_of;

/// An effect that is identified more often in a unit's recordings than in those of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Recurring {
    /// Index of the unit.
    pub unit: usize,
    /// The effect; for a class its most frequent member.
    pub effect: String,
    /// Recordings that identify it.
    pub found: usize,
    /// Usable recordings of the unit.
    pub of: usize,
    /// p-value of the count under the rate of the other units.
    pub p: f64,
}

pub(super) fn recurring(documents: &[Document], units: &[Unit]) -> Vec<Recurring> {
    let counts: Vec<Counts> = units
        .iter()
        .map(|unit| Counts::of(documents, unit))
        .collect();
    let all: usize = counts.iter().map(|unit| unit.usable).sum();
    let mut everywhere: BTreeMap<&str, usize> = BTreeMap::new();
    for (group, names) in counts.iter().flat_map(|unit| &unit.found) {
        *everywhere.entry(group).or_default() += names.values().sum::<usize>();
    }
    // Each unit is tested for each effect of any unit.
    let tests = (units.len() * everywhere.len()) as f64;
    let mut recurring = Vec::new();
    for (unit, own) in counts.iter().enumerate() {
        for (group, names) in &own.found {
            let found: usize = names.values().sum();
            let others = (everywhere[group] - found, all - own.usable);
            let rate = (others.0 as f64 + 0.5) / (others.1 as f64 + 1.0);
            let p = at_least(found, own.usable, rate);
            let most = names.iter().max_by_key(|(_, count)| **count);
            if let Some((effect, _)) = most.filter(|_| p * tests < SIGNIFICANT) {
                recurring.push(Recurring {
                    unit,
                    effect: (*effect).to_owned(),
                    found,
                    of: own.usable,
                    p,
                });
            }
        }
    }
    recurring.sort_by(|a, b| a.p.total_cmp(&b.p));
    recurring
}

struct Counts<'a> {
    usable: usize,
    found: BTreeMap<&'a str, BTreeMap<&'a str, usize>>,
}

impl<'a> Counts<'a> {
    fn of(documents: &'a [Document], unit: &Unit) -> Self {
        let usable = || {
            let own = unit.documents.iter().map(|place| &documents[*place]);
            own.filter(|document| !document.is_bad())
        };
        let mut found: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
        for document in usable() {
            let mut seen = Vec::new();
            for effect in &document.effects {
                let group = class_of(effect).unwrap_or(effect);
                if !seen.contains(&group) {
                    seen.push(group);
                    *found.entry(group).or_default().entry(effect).or_default() += 1;
                }
            }
        }
        Self {
            usable: usable().count(),
            found,
        }
    }
}

/// Probability of at least `least` successes in `n` trials of this rate.
fn at_least(least: usize, n: usize, rate: f64) -> f64 {
    let odds = rate / (1.0 - rate);
    let mut term = (1.0 - rate).powf(n as f64);
    let mut below = 0.0;
    let mut above = 0.0;
    for k in 0..=n {
        if k < least {
            below += term;
        } else {
            above += term;
        }
        term *= odds * (n - k) as f64 / (k + 1) as f64;
    }
    above / (below + above)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_of_the_binomial_distribution_is_its_sum() {
        assert!((at_least(2, 3, 0.5) - 0.5).abs() < 1e-12);
        assert!((at_least(5, 5, 0.1) - 1e-5).abs() < 1e-17);
        assert!((at_least(0, 4, 0.3) - 1.0).abs() < 1e-12);
    }
}
