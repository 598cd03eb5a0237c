//! What the weighed hypotheses come to: the verdict, the causes, their numbers, the place.

use std::collections::BTreeMap;

use super::bagging::MOSTLY;
use super::candidate::Candidate;
use super::fit::Fit;
use super::hypothesis::{BASE, BASE_KEYS};
use super::other_law::Doubtful;
use super::problem::Problem;
use super::rank::Ranking;
use super::rivals::catalogue;
use super::unknown::flexible;
use super::verdict::{Cause, EffectSet, Gap, Interval, Place, Verdict};
use super::{regimes, ties};

/// Below this gap above the floor in counts RMS the nominal model is as good as the encoder.
const NO_GAP_COUNTS: f64 = 0.1;
/// The likeliest set is named outright from this probability on.
const NAMED: f64 = 0.7;
/// The same where these runs cannot tell a rival from it: then what is known beforehand alone speaks against that one.
const NAMED_IN_A_TIE: f64 = 0.9;
/// Where there is a gap, that there is none is said of all effects at once, and said outright from this probability on.
const NONE_NAMED: f64 = 0.8;
/// Sets this many nats behind the best are looked at for ties.
const IN_PLAY: f64 = 12.0;

/// Ids of a hypothesis.
pub(super) fn ids(candidate: &Candidate) -> Vec<&'static str> {
    let mut ids: Vec<_> = candidate
        .effects
        .iter()
        .map(|&index| catalogue()[index].id)
        .collect();
    ids.sort_unstable();
    ids
}

/// What cannot be told apart: for each effect (or `none`) the others and the smallest separation.
pub(super) struct Ties {
    /// Pairs of ids with their separation.
    pairs: Vec<(&'static str, &'static str, f64)>,
    /// Whether a rival of the best set is tied with it.
    of_the_best: bool,
}

impl Ties {
    pub(super) fn among(
        problem: &Problem<'_>,
        ranking: &Ranking,
        doubtful: Option<Doubtful>,
        alike: &[Vec<usize>],
    ) -> Self {
        let mut ties = Self {
            pairs: Vec::new(),
            of_the_best: doubtful.is_some(),
        };
        if let Some(Doubtful {
            effects,
            instead,
            separation,
        }) = doubtful
        {
            let id = |effect: &usize| catalogue()[*effect].id;
            for a in effects.iter().map(id) {
                if instead.is_empty() {
                    ties.pairs.push((a, "none", separation));
                }
                for b in instead.iter().map(id) {
                    ties.pairs.push((a, b, separation));
                    ties.pairs.push((b, a, separation));
                }
            }
        }
        for (effect, separation) in &ranking.imitated {
            let id = catalogue()[*effect].id;
            ties.pairs.push((id, "unknown", *separation));
            ties.pairs.push(("unknown", id, *separation));
        }
        let best = &ranking.candidates[0];
        for rival in &ranking.candidates[1..] {
            let is_alike = alike.contains(&rival.effects);
            if rival.log_weight < best.log_weight - IN_PLAY && !is_alike {
                continue;
            }
            let Some(d) = ties::separation(problem, &best.fit, &rival.fit) else {
                continue;
            };
            if d >= ties::TIE && !is_alike {
                continue;
            }
            ties.of_the_best |= is_alike;
            let (mine, theirs) = (ids(best), ids(rival));
            let only = |a: &[&'static str], b: &[&'static str]| -> Vec<&'static str> {
                a.iter().copied().filter(|id| !b.contains(id)).collect()
            };
            let (mut left, mut right) = (only(&mine, &theirs), only(&theirs, &mine));
            if left.is_empty() && best.effects.is_empty() {
                left.push("none");
            }
            if right.is_empty() {
                right.push("none");
            }
            for a in &left {
                for b in &right {
                    ties.of_the_best = true;
                    ties.pairs.push((a, b, d));
                    ties.pairs.push((b, a, d));
                }
            }
        }
        ties
    }

    fn of(&self, id: &str) -> (Vec<&'static str>, Option<f64>) {
        let mut others = Vec::new();
        let mut least: Option<f64> = None;
        for (_, other, d) in self.pairs.iter().filter(|pair| pair.0 == id) {
            if !others.contains(other) {
                others.push(*other);
            }
            least = Some(least.map_or(*d, |least| least.min(*d)));
        }
        (others, least)
    }
}

/// Something is outside the catalogue if that is likelier than not: less than half, though more than any one of several sets
/// that share the rest, is one of what these runs cannot tell apart.
pub(super) fn verdict_of(ranking: &Ranking, gap: &Gap, ties: &Ties) -> Verdict {
    let best = &ranking.candidates[0];
    if ranking.unknown > MOSTLY {
        return Verdict::OutsideCatalogue;
    }
    let is_gap = gap.before - gap.floor >= NO_GAP_COUNTS;
    let from = match (best.effects.is_empty(), is_gap) {
        (true, true) => NONE_NAMED,
        (false, _) if ties.of_the_best => NAMED_IN_A_TIE,
        _ => NAMED,
    };
    let named = best.probability >= from || (best.probability >= 0.5 && !ties.of_the_best);
    if best.effects.is_empty() && named {
        return if is_gap {
            Verdict::Parameters
        } else {
            Verdict::NoGap
        };
    }
    if named {
        Verdict::Effect
    } else {
        Verdict::Ambiguous
    }
}

pub(super) fn causes(problem: &Problem<'_>, ranking: &Ranking, ties: &Ties) -> Vec<Cause> {
    let null = ranking.null();
    let mut causes = vec![
        Cause {
            effect: "none",
            stage: None,
            probability: null.map_or(0.0, |null| null.probability),
            inclusion: null.map_or(0.0, |null| null.probability),
            parameters: BTreeMap::new(),
            indistinguishable_from: ties.of("none").0,
            separation: ties.of("none").1,
            converged: null.is_some_and(|null| null.fit.converged),
        },
        Cause {
            effect: "unknown",
            stage: None,
            probability: ranking.unknown,
            inclusion: ranking.unknown,
            parameters: BTreeMap::new(),
            indistinguishable_from: ties.of("unknown").0,
            separation: ties.of("unknown").1,
            converged: true,
        },
    ];
    for (index, kind) in catalogue().iter().enumerate() {
        // Candidates are sorted: the first with the effect is the likeliest.
        let Some(with) = ranking
            .candidates
            .iter()
            .find(|c| c.effects.contains(&index))
        else {
            continue;
        };
        let (indistinguishable_from, separation) = ties.of(kind.id);
        causes.push(Cause {
            effect: kind.id,
            stage: Some(kind.stage.id()),
            probability: ranking.share_of(index),
            inclusion: ranking.inclusion_of(index),
            parameters: parameters(problem, &with.fit, index),
            indistinguishable_from,
            separation,
            converged: with.fit.converged,
        });
    }
    causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    causes
}

/// An effect's numbers in a fit, with their intervals.
fn parameters(problem: &Problem<'_>, fit: &Fit, index: usize) -> BTreeMap<&'static str, Interval> {
    let members = &fit.hypothesis.members;
    let Some(m) = members.iter().position(|member| member.index == index) else {
        return BTreeMap::new();
    };
    let values = fit.hypothesis.values(m, &fit.p);
    let kind = &catalogue()[index];
    let intervals = kind.parameters.iter().enumerate().map(|(k, parameter)| {
        let value = values[k];
        let (lo95, hi95) = match fit.hypothesis.place(m, k) {
            Some((place, logarithmic)) => {
                let deviation = fit.covariance[(place, place)].max(0.0).sqrt();
                let scale = fit
                    .hypothesis
                    .scale_deviation(problem.nominal, parameter.unit);
                let least = problem
                    .setting
                    .range(parameter, &problem.nominal.parameters)
                    .0;
                let half = if logarithmic {
                    1.96 * deviation.hypot(scale)
                } else {
                    1.96 * deviation.hypot(scale * value.abs())
                };
                if logarithmic && value <= least {
                    // As good as nothing: a logarithm knows no nought.
                    (parameter.possible.0, value * half.exp())
                } else if logarithmic {
                    (value * (-half).exp(), value * half.exp())
                } else {
                    (value - half, value + half)
                }
            }
            None if kind.id == "dead_zone" => problem.levels_around(value),
            None => (value, value),
        };
        let unit = parameter.unit;
        (
            parameter.key,
            Interval {
                value,
                lo95,
                hi95,
                unit,
            },
        )
    });
    intervals.collect()
}

/// The base's numbers as multiples of the motor file's.
pub(super) fn base(fit: &Fit) -> BTreeMap<&'static str, Interval> {
    (0..BASE)
        .map(|k| {
            let half = 1.96 * fit.covariance[(k, k)].max(0.0).sqrt();
            let interval = Interval {
                value: fit.p[k].exp(),
                lo95: (fit.p[k] - half).exp(),
                hi95: (fit.p[k] + half).exp(),
                unit: "",
            };
            (BASE_KEYS[k], interval)
        })
        .collect()
}

pub(super) fn sets(ranking: &Ranking) -> Vec<EffectSet> {
    let best = ranking.candidates[0].log_weight;
    let all = ranking.candidates.iter().map(|candidate| EffectSet {
        effects: ids(candidate),
        probability: candidate.probability,
        behind_nats: best - candidate.log_weight,
    });
    all.take(20).collect()
}

pub(super) fn place(
    problem: &Problem<'_>,
    ranking: &Ranking,
    names: &[String],
    scale: f64,
) -> Place {
    let mut stages: BTreeMap<&'static str, f64> = BTreeMap::new();
    for (index, kind) in catalogue().iter().enumerate() {
        *stages.entry(kind.stage.id()).or_default() += ranking.share_of(index);
    }
    // Something unknown lies where what it depends on points.
    *stages.entry(ranking.flexible.group.stage()).or_default() += ranking.unknown;
    let total: f64 = stages.values().sum();
    for probability in stages.values_mut() {
        *probability /= total.max(1e-300);
    }
    let is_gap = total > 0.5;
    let stage = stages
        .iter()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .map(|(stage, _)| *stage)
        .filter(|_| is_gap);
    let (mut regions, mut ordered_by) = (Vec::new(), BTreeMap::new());
    if let Some(null) = ranking.null() {
        let mut short = null.fit.clone();
        short.wander = problem.levels.get(1).copied().unwrap_or(short.wander);
        let runs: Vec<_> = names.iter().cloned().zip(problem.runs).collect();
        regions = regimes::regions(&runs, &problem.innovations_by_run(&short));
        let gains = flexible(problem, &null.fit, scale).gains;
        ordered_by = gains
            .into_iter()
            .map(|(d, gain)| (d.word(), gain))
            .collect();
    }
    Place {
        stage,
        stage_probabilities: stages,
        regions,
        ordered_by,
        oscillation_hz: ranking.flexible.group.oscillation_hz(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{
        gap, held_at, index, motor_with, problem, ranking, ready, recording,
    };
    use super::*;

    /// The verdict on something unknown beside two sets with these shares, whose first these runs can tell from the second or not.
    fn verdict(unknown: f64, shares: [f64; 2], of_the_best: bool) -> Verdict {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let fit = held_at(&problem, &[]);
        let set = |(k, probability): (usize, f64)| Candidate {
            effects: vec![k],
            fit: fit.clone(),
            log_weight: probability.ln(),
            probability,
        };
        let sets = shares.into_iter().enumerate().map(set).collect();
        let ties = Ties {
            pairs: Vec::new(),
            of_the_best,
        };
        verdict_of(&ranking(sets, unknown), &gap(1.0), &ties)
    }

    #[test]
    fn what_is_less_likely_than_not_is_one_of_several() {
        let verdict = |unknown, shares| verdict(unknown, shares, false);
        assert_eq!(verdict(0.6, [0.3, 0.1]), Verdict::OutsideCatalogue);
        assert_eq!(verdict(0.4, [0.3, 0.3]), Verdict::Ambiguous);
        assert_eq!(verdict(0.1, [0.8, 0.1]), Verdict::Effect);
    }

    #[test]
    fn what_cannot_be_told_apart_is_named_from_nine_in_ten() {
        assert_eq!(verdict(0.0, [0.85, 0.15], true), Verdict::Ambiguous);
        assert_eq!(verdict(0.0, [0.85, 0.15], false), Verdict::Effect);
        assert_eq!(verdict(0.0, [0.95, 0.05], true), Verdict::Effect);
    }

    /// Drag of a size that a run of 20 s cannot show beside Stribeck friction that it can.
    #[test]
    fn a_part_that_changes_nothing_is_tied_with_none() {
        let stribeck: (&str, &[f64]) = ("stribeck", &[0.002, 0.5]);
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[stribeck])));
        let problem = problem(&nominal, &runs);
        let said = |drag: f64| {
            let set = |members: &[(&str, &[f64])], probability| Candidate {
                effects: members.iter().map(|(id, _)| index(id)).collect(),
                fit: held_at(&problem, members),
                log_weight: f64::ln(probability),
                probability,
            };
            let both = set(&[stribeck, ("quadratic_drag", &[drag])], 0.8);
            let ranking = ranking(vec![both, set(&[stribeck], 0.2)], 0.0);
            let ties = Ties::among(&problem, &ranking, None, &[]);
            (
                ties.of("quadratic_drag").0,
                ties.of("stribeck").0,
                ties.of_the_best,
            )
        };
        assert_eq!(said(1e-9), (vec!["none"], vec![], true));
        assert_eq!(said(1e-3), (vec![], vec![], false));
    }
}
