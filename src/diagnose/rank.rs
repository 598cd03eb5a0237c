//! Which effects explain the runs: nothing, each effect, pairs by growth, something unknown.
//!
//! Every hypothesis is weighed by its evidence and a prior (half the motors have no effect beyond their
//! tolerances; more effects at once are rarer). The winner is grown by one more effect as long as that is
//! worth it. An effect whose fit has not converged is said so, and keeps its place by its best evidence.

use rayon::prelude::*;

use super::data::RunData;
use super::fit::{Fit, Problem};
use super::hypothesis::Hypothesis;
use super::matter;
use super::search::{Search, Start, is_scanned, largest_acceleration};
use super::unknown::{Flexible, flexible};
use crate::motor::effects::{EffectKind, Stage, catalogue};
use crate::recording::CommandKind;

/// Prior probability that there is no effect.
const PRIOR_NONE: f64 = 0.45;
/// That there is something that the catalogue does not have.
const PRIOR_UNKNOWN: f64 = 0.05;
/// That there is exactly one effect.
const PRIOR_SINGLE: f64 = 0.42;
/// That there are two.
const PRIOR_PAIR: f64 = 0.07;
/// That there are three.
const PRIOR_TRIPLE: f64 = 0.01;
/// A wander up to this share of the largest acceleration is ordinary; more speaks for the unknown.
const ORDINARY_WANDER: f64 = 0.003;
/// Most steps of a first fit, of its continuation, and of a final fit on each level.
const FIRST_STEPS: usize = 2;
const SCANNED_STEPS: usize = 6;
/// Shares of the runs on which an effect of unknown order is fitted first.
const BEGINNINGS: [f64; 2] = [0.25, 0.5];
const FURTHER_STEPS: usize = 5;
const FINAL_STEPS: usize = 10;
/// How many effects of a round are fitted on after the first steps.
const FITTED_ON: usize = 12;
/// How many effects of a round are fitted on long horizons too.
const FULLY_FITTED: usize = 6;
/// How many effects are fitted in each round of growth.
const GROWN: usize = 10;
/// Most effects of a set, and most sets that are grown.
const MOST_EFFECTS: usize = 3;
const MOST_EXPANDED: usize = 5;
/// Sets this many nats behind the best are grown too.
const CLOSE: f64 = 20.0;
/// Effects this many nats behind the best of a round on short horizons are fitted fully too.
const NEAR: f64 = 12.0;
/// A further effect must be worth this many nats.
const WORTH: f64 = 3.0;

/// A hypothesis that was fitted.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    /// Indices of its effects in the catalogue; none for the null.
    pub effects: Vec<usize>,
    /// Its fit.
    pub fit: Fit,
    /// Evidence and prior together, in nats.
    pub log_weight: f64,
    /// Its probability.
    pub probability: f64,
}

/// Everything that was weighed.
#[derive(Debug)]
pub(super) struct Ranking {
    /// All hypotheses, likeliest first; the null among them.
    pub candidates: Vec<Candidate>,
    /// Probability of something that the catalogue does not have.
    pub unknown: f64,
    /// What a flexible acceleration would add to the winner.
    pub flexible: Flexible,
}

impl Ranking {
    /// The hypothesis without effects.
    pub fn null(&self) -> Option<&Candidate> {
        self.candidates.iter().find(|c| c.effects.is_empty())
    }

    /// Probability that effect `index` is there: of every hypothesis in equal shares to its effects.
    pub fn share_of(&self, index: usize) -> f64 {
        let with = self
            .candidates
            .iter()
            .filter(|c| c.effects.contains(&index));
        with.map(|c| c.probability / c.effects.len() as f64).sum()
    }

    /// Probability that effect `index` is there, alone or with others.
    pub fn inclusion_of(&self, index: usize) -> f64 {
        let with = self
            .candidates
            .iter()
            .filter(|c| c.effects.contains(&index));
        with.map(|c| c.probability).sum()
    }
}

/// Weighs all hypotheses; `None` where not even the nominal motor can be simulated.
pub(super) fn rank(problem: &Problem<'_>, progress: &(dyn Fn(&str) + Sync)) -> Option<Ranking> {
    let kind = problem.runs.first()?.kind;
    let scale = largest_acceleration(problem.nominal, problem.runs);
    progress("fitting the nominal model");
    let empty = Hypothesis::new(problem.nominal, Vec::new(), &problem.setting);
    let null = problem.fit(&empty, &empty.start(), FINAL_STEPS)?;
    let mut candidates = vec![candidate(problem, Vec::new(), null.clone(), scale)];

    let applicable: Vec<usize> = (0..catalogue().len())
        .filter(|&index| applies(&catalogue()[index], kind))
        .filter(|&index| problem.setting.tells_of(&catalogue()[index]))
        .filter(|&index| problem.nominal.effects.get(catalogue()[index].id).is_none())
        .collect();
    let heads = BEGINNINGS.map(|share| heads(problem.runs, share));
    let beginnings: Vec<Problem<'_>> = heads
        .iter()
        .map(|runs| {
            Problem::new(
                problem.nominal,
                runs,
                problem.damping,
                problem.levels.clone(),
            )
        })
        .collect();
    progress("trying every effect");
    candidates.extend(with_one_more(
        problem,
        &beginnings,
        &candidates[0],
        &applicable,
        usize::MAX,
        scale,
    ));
    candidates.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));

    let mut expanded: Vec<Vec<usize>> = Vec::new();
    while let Some(parent) = next_parent(&candidates, &expanded) {
        expanded.push(sorted(&parent.effects));
        progress("trying further effects beside the best");
        let others: Vec<usize> = applicable
            .iter()
            .copied()
            .filter(|index| !parent.effects.contains(index))
            .collect();
        let grown = with_one_more(problem, &beginnings, &parent, &others, GROWN, scale);
        candidates.extend(
            grown
                .into_iter()
                .filter(|new| new.fit.log_evidence > parent.fit.log_evidence + WORTH),
        );
        dedup(&mut candidates);
    }
    progress("checking that every part of it is needed");
    for _ in 0..MOST_EXPANDED {
        let better = without_one(problem, &candidates[0], scale);
        let before = sorted(&candidates[0].effects);
        candidates.extend(better);
        dedup(&mut candidates);
        if sorted(&candidates[0].effects) == before {
            break;
        }
    }
    let best = &candidates[0];
    let flexible = flexible(problem, &best.fit, scale);
    let excess = excess_wander(best.fit.wander, scale);
    // The unknown: the best named model, its wander as large as it likes, and a free acceleration.
    let log_unknown = best.log_weight + excess + flexible.log_gain + PRIOR_UNKNOWN.ln();
    let top = best.log_weight.max(log_unknown);
    let mut total = (log_unknown - top).exp();
    for c in &candidates {
        total += (c.log_weight - top).exp();
    }
    for c in &mut candidates {
        c.probability = (c.log_weight - top).exp() / total;
    }
    let unknown = (log_unknown - top).exp() / total;
    Some(Ranking {
        candidates,
        unknown,
        flexible,
    })
}

/// Fits a candidate's set without each of its effects, from the candidate's own numbers: a smaller set must
/// not lose because its own fit ended in a worse hollow.
fn without_one(problem: &Problem<'_>, full: &Candidate, scale: f64) -> Vec<Candidate> {
    (0..full.effects.len())
        .into_par_iter()
        .filter_map(|m| {
            let mut effects = full.effects.clone();
            let removed = effects.remove(m);
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

/// Which set to grow next: the best; then, once two effects together are better than one, each of its parts
/// alone (the best pair need not hold the best single effect); then what is close behind the best.
fn next_parent(candidates: &[Candidate], expanded: &[Vec<usize>]) -> Option<Candidate> {
    let best = candidates.first()?;
    let open = |c: &&Candidate| {
        !c.effects.is_empty()
            && c.effects.len() < MOST_EFFECTS
            && !expanded.contains(&sorted(&c.effects))
    };
    if expanded.len() >= MOST_EXPANDED {
        return None;
    }
    let part_of_best = |c: &&Candidate| {
        c.effects.len() + 1 == best.effects.len()
            && c.effects.iter().all(|e| best.effects.contains(e))
    };
    let close = |c: &&Candidate| c.log_weight > best.log_weight - CLOSE;
    let found = candidates
        .first()
        .filter(open)
        .or_else(|| candidates.iter().filter(open).find(part_of_best))
        .or_else(|| candidates.iter().filter(open).find(close));
    found.cloned()
}

fn sorted(effects: &[usize]) -> Vec<usize> {
    let mut set = effects.to_vec();
    set.sort_unstable();
    set
}

/// The first part of every run; a run that cannot be cut is left out.
fn heads(runs: &[RunData], share: f64) -> Vec<RunData> {
    let head = |run: &RunData| run.head((run.len() as f64 * share).ceil() as usize).ok();
    runs.iter().filter_map(head).collect()
}

/// How implausible a wander of this size is in an ordinary motor, in nats.
fn excess_wander(wander: f64, scale: f64) -> f64 {
    2.0 * (wander / scale / ORDINARY_WANDER - 1.0).max(0.0)
}

fn candidate(problem: &Problem<'_>, effects: Vec<usize>, fit: Fit, scale: f64) -> Candidate {
    let n = catalogue().len() as f64;
    let log_prior = match effects.len() {
        0 => PRIOR_NONE.ln(),
        1 => (PRIOR_SINGLE / n).ln(),
        2 => (PRIOR_PAIR / (n * (n - 1.0) / 2.0)).ln(),
        _ => (PRIOR_TRIPLE / (n * (n - 1.0) * (n - 2.0) / 6.0)).ln(),
    };
    let explained = effects.iter().any(|&e| catalogue()[e].id == "clock_error");
    let clock = if explained {
        0.0
    } else {
        problem.setting.against_a_right_clock()
    };
    Candidate {
        log_weight: fit.log_evidence + log_prior
            - excess_wander(fit.wander, scale)
            - matter::discount(problem, &fit)
            - clock,
        effects,
        fit,
        probability: 0.0,
    }
}

/// Fits the parent with each of these effects added; only the `most` promising where there are more.
fn with_one_more(
    problem: &Problem<'_>,
    beginnings: &[Problem<'_>],
    parent: &Candidate,
    indices: &[usize],
    most: usize,
    scale: f64,
) -> Vec<Candidate> {
    let Some(search) = Search::new(problem, &parent.fit) else {
        return Vec::new();
    };
    let mut starts: Vec<(usize, f64, Vec<Start>)> = indices
        .par_iter()
        .map(|&index| {
            let (score, starts) = search.starts(index);
            (index, score, starts)
        })
        .collect();
    starts.sort_by(|a, b| a.1.total_cmp(&b.1));
    starts.truncate(most);
    let mut short: Vec<(usize, Fit)> = starts
        .into_par_iter()
        .filter_map(|(index, _, starts)| {
            let fit = if is_scanned(catalogue()[index].id) {
                scanned_fit(problem, beginnings, starts)
            } else {
                first_fit(problem, starts)
            };
            Some((index, fit?))
        })
        .collect();
    let by_evidence =
        |a: &(usize, Fit), b: &(usize, Fit)| b.1.log_evidence.total_cmp(&a.1.log_evidence);
    short.sort_by(by_evidence);
    short
        .par_iter_mut()
        .take(FITTED_ON)
        .for_each(|(_, fit)| continue_fit(problem, fit));
    short.sort_by(by_evidence);
    let best = short.first().map_or(0.0, |first| first.1.log_evidence);
    short
        .into_par_iter()
        .enumerate()
        .map(|(place, (index, fit))| {
            // The long horizons decide between the best; the others keep what they have.
            let full = if place < FULLY_FITTED || fit.log_evidence > best - NEAR {
                problem.fit(&fit.hypothesis, &fit.p, FINAL_STEPS)
            } else {
                None
            };
            let fit = match full {
                Some(full) if full.log_evidence > fit.log_evidence => full,
                _ => fit,
            };
            let mut effects = parent.effects.clone();
            effects.push(index);
            candidate(problem, effects, fit, scale)
        })
        .collect()
}

/// A few steps from every start on short horizons; the best of them.
fn first_fit(problem: &Problem<'_>, starts: Vec<Start>) -> Option<Fit> {
    let short = problem.levels.get(1).or(problem.levels.first()).copied()?;
    best_fit(
        starts.into_iter().filter_map(|(hypothesis, start)| {
            problem.fit_at(&hypothesis, &start, short, FIRST_STEPS)
        }),
    )
}

/// The same where an order was scanned for: a simulated angle that is some counts off is far off in phase, so
/// the first part of the runs comes first, and the order is let go last.
fn scanned_fit(
    problem: &Problem<'_>,
    beginnings: &[Problem<'_>],
    starts: Vec<Start>,
) -> Option<Fit> {
    let shortest = problem.levels.first().copied()?;
    let short = problem.levels.get(1).copied().unwrap_or(shortest);
    let fit = |hypothesis: Hypothesis, mut p: Vec<f64>| {
        for beginning in beginnings {
            let held = hypothesis.with_orders_held(&p);
            p = beginning.fit_at(&held, &p, shortest, SCANNED_STEPS)?.p;
            p = beginning.fit_at(&hypothesis, &p, short, SCANNED_STEPS)?.p;
        }
        problem.fit_at(&hypothesis, &p, short, SCANNED_STEPS)
    };
    best_fit(
        starts
            .into_iter()
            .filter_map(|(hypothesis, start)| fit(hypothesis, start)),
    )
}

fn best_fit(fits: impl Iterator<Item = Fit>) -> Option<Fit> {
    fits.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
}

/// More steps from where a fit is, on the same horizons.
fn continue_fit(problem: &Problem<'_>, fit: &mut Fit) {
    if fit.converged {
        return;
    }
    let further = problem.fit_at(&fit.hypothesis, &fit.p, fit.wander, FURTHER_STEPS);
    if let Some(further) = further.filter(|new| new.log_evidence > fit.log_evidence) {
        *fit = further;
    }
}

/// Keeps the best fit of every set of effects.
fn dedup(candidates: &mut Vec<Candidate>) {
    candidates.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
    let mut seen: Vec<Vec<usize>> = Vec::new();
    candidates.retain(|c| {
        let set = sorted(&c.effects);
        let new = !seen.contains(&set);
        if new {
            seen.push(set);
        }
        new
    });
}

/// Whether an effect means anything on an axis that commands this.
fn applies(kind: &EffectKind, command: CommandKind) -> bool {
    match command {
        CommandKind::Voltage => true,
        CommandKind::Current => {
            kind.stage != Stage::Driver && !matches!(kind.id, "inductance" | "winding_heating")
        }
        CommandKind::Torque => !matches!(kind.stage, Stage::Driver | Stage::Electrical),
    }
}
