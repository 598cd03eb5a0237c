//! Which effects explain the runs: nothing, each effect, two or three by growth, something unknown.
//!
//! Every hypothesis is weighed by its evidence and a prior. The winner is grown by one more effect as long as
//! that is worth it. An effect whose fit has not converged is said so, and keeps its place by its best evidence.

use super::candidate::{Candidate, candidate, dedup, sorted};
use super::come_round;
use super::data::RunData;
use super::effort::ALL;
use super::growth::{FINAL_STEPS, Field, without_one};
use super::hypothesis::Hypothesis;
use super::jumps::jumps;
use super::other_law::has_laws;
use super::problem::Problem;
use super::refined::Refined;
use super::rivals::catalogue;
use super::rivals::rivals;
use super::rounds::Rounds;
use super::unknown::{Flexible, likeliest};
use crate::motor::catalogue::{EffectKind, Stage};
use crate::recording::CommandKind;

/// That there is something that the catalogue does not have.
pub(super) const PRIOR_UNKNOWN: f64 = 0.1;
/// Shares of the runs on which an effect of unknown order is fitted first.
const BEGINNINGS: [f64; 2] = [0.25, 0.5];
/// Most rounds of taking away what is not needed.
const MOST_ROUNDS: usize = 5;

/// Everything that was weighed.
#[derive(Debug)]
pub(super) struct Ranking {
    /// All hypotheses, likeliest first; the null among them.
    pub candidates: Vec<Candidate>,
    /// Probability of something that the catalogue does not have.
    pub unknown: f64,
    /// What a flexible acceleration would add to the winner.
    pub flexible: Flexible,
    /// By how many nats the unknown is likelier than the winner, priors aside.
    pub unknown_gain: f64,
    /// By how many nats jumps that nothing in the catalogue makes would explain what the winner leaves.
    pub jumps: f64,
    /// Effects and their probability beside something unknown, given that it is there.
    pub beside: Vec<(usize, f64)>,
    /// Effects that the unknown may be a part of or be taken for, and their separation from it.
    pub imitated: Vec<(usize, f64)>,
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

    /// Probability that effect `index` is there, alone, with others or beside something unknown.
    pub fn inclusion_of(&self, index: usize) -> f64 {
        let with = self
            .candidates
            .iter()
            .filter(|c| c.effects.contains(&index));
        let beside = self.beside.iter().find(|(other, _)| *other == index);
        let beside = beside.map_or(0.0, |(_, share)| self.unknown * share);
        with.map(|c| c.probability).sum::<f64>() + beside
    }
}

/// Weighs all hypotheses; `None` where not even the nominal motor can be simulated.
pub(super) fn rank(problem: &Problem<'_>, progress: &(dyn Fn(&str) + Sync)) -> Option<Ranking> {
    let applicable = applicable(problem)?;
    let heads = BEGINNINGS.map(|share| heads(problem.runs, share));
    let beginnings = heads.each_ref().map(|runs| beginning(problem, runs));
    let mut field = Field::new(problem, &beginnings);
    let scale = field.scale;
    let mut refined = Refined::default();
    let mut candidates = up_to_one(&field, &applicable, &mut refined, progress)?;
    let null = candidates.iter().find(|c| c.effects.is_empty()).cloned()?;

    let rounds = Rounds {
        applicable: &applicable,
        null: &null,
        refined,
        progress,
    };
    rounds.grow(&mut field, &mut candidates);
    progress("checking that every part of it is needed");
    for _ in 0..MOST_ROUNDS {
        let better = without_one(problem, &candidates, scale);
        let before = sorted(&candidates[0].effects);
        candidates.extend(better);
        dedup(&mut candidates);
        if sorted(&candidates[0].effects) == before {
            break;
        }
    }
    if problem.is_rough() {
        come_round::weigh(&field, &mut candidates);
    }
    let best = &candidates[0];
    // The unknown: the best named model, its wander as large as it likes, and a free acceleration.
    let (flexible, gain) = likeliest(problem, &best.fit, scale);
    let jumps = jumps(problem, &best.fit);
    let log_unknown = best.log_weight + gain + PRIOR_UNKNOWN.ln();
    let unknown = share_out(&mut candidates, log_unknown);
    Some(Ranking {
        candidates,
        unknown,
        flexible,
        unknown_gain: gain,
        jumps,
        beside: Vec::new(),
        imitated: Vec::new(),
    })
}

/// Gives each set its share of all weights; that of the unknown.
fn share_out(candidates: &mut [Candidate], log_unknown: f64) -> f64 {
    let weights = candidates.iter().map(|c| c.log_weight);
    let top = weights.fold(log_unknown, f64::max);
    let mut total = (log_unknown - top).exp();
    for c in &*candidates {
        total += (c.log_weight - top).exp();
    }
    for c in &mut *candidates {
        c.probability = (c.log_weight - top).exp() / total;
    }
    (log_unknown - top).exp() / total
}

/// Weighs the best set with each of its effects exchanged for another too, where both have laws.
pub(super) fn exchange(problem: &Problem<'_>, ranking: &mut Ranking) {
    let (Some(best), Some(applicable)) = (ranking.candidates.first(), applicable(problem)) else {
        return;
    };
    if best.effects.len() < 2 || ranking.unknown > best.probability {
        return;
    }
    let log_unknown = best.log_weight + (ranking.unknown.max(1e-300) / best.probability).ln();
    let heads = BEGINNINGS.map(|share| heads(problem.runs, share));
    let beginnings = heads.each_ref().map(|runs| beginning(problem, runs));
    let field = Field::new(problem, &beginnings);
    let mut grown = Vec::new();
    for removed in best.effects.iter().filter(|&&e| has_laws(e)) {
        let is_rest = |c: &&Candidate| {
            c.effects.len() + 1 == best.effects.len()
                && !c.effects.contains(removed)
                && c.effects.iter().all(|e| best.effects.contains(e))
        };
        let Some(rest) = ranking.candidates.iter().find(is_rest) else {
            continue;
        };
        let is_new = |index: &usize| {
            let known = |c: &Candidate| {
                c.effects.len() == best.effects.len()
                    && c.effects.contains(index)
                    && rest.effects.iter().all(|e| c.effects.contains(e))
            };
            has_laws(*index)
                && !best.effects.contains(index)
                && !ranking.candidates.iter().any(known)
        };
        let others: Vec<usize> = applicable.iter().copied().filter(is_new).collect();
        grown.extend(field.with_one_more(rest, &others, None));
    }
    come_round::discount(problem, &mut grown);
    ranking.candidates.extend(grown);
    dedup(&mut ranking.candidates);
    ranking.unknown = share_out(&mut ranking.candidates, log_unknown);
}

/// No effect and every effect alone, fitted, likeliest first; `None` as [`rank`].
pub(super) fn singles(
    problem: &Problem<'_>,
    progress: &(dyn Fn(&str) + Sync),
) -> Option<Vec<Candidate>> {
    let heads = BEGINNINGS.map(|share| heads(problem.runs, share));
    let beginnings = heads.each_ref().map(|runs| beginning(problem, runs));
    let field = Field::new(problem, &beginnings);
    up_to_one(
        &field,
        &applicable(problem)?,
        &mut Refined::default(),
        progress,
    )
}

fn up_to_one(
    field: &Field<'_>,
    applicable: &[usize],
    refined: &mut Refined,
    progress: &(dyn Fn(&str) + Sync),
) -> Option<Vec<Candidate>> {
    let problem = field.problem;
    progress("fitting the nominal model");
    let empty = Hypothesis::new(problem.nominal, Vec::new(), &problem.setting);
    let null = problem.fit(&empty, &empty.start(), FINAL_STEPS)?;
    let mut candidates = vec![candidate(problem, Vec::new(), null, field.scale)];
    progress("trying every effect");
    let singles = field.with_one_more(&candidates[0], applicable, None);
    candidates.extend(singles);
    dedup(&mut candidates);
    if problem.effort.is_left(ALL) {
        let again = field.refined(&candidates, refined);
        candidates.extend(again);
        dedup(&mut candidates);
    }
    Some(candidates)
}

/// The effects that these runs can tell of.
fn applicable(problem: &Problem<'_>) -> Option<Vec<usize>> {
    let kind = problem.runs.first()?.kind;
    let applicable = rivals()
        .filter(|&index| applies(&catalogue()[index], kind))
        .filter(|&index| problem.setting.tells_of(&catalogue()[index]))
        .filter(|&index| problem.nominal.effects.get(catalogue()[index].id).is_none());
    Some(applicable.collect())
}

/// The problem of parts of its runs.
pub(super) fn beginning<'a>(problem: &Problem<'a>, runs: &'a [RunData]) -> Problem<'a> {
    Problem::new(
        problem.nominal,
        runs,
        problem.damping,
        problem.levels.clone(),
        problem.rough,
    )
    .with_rounding(problem.rounding)
    .holding(problem.setting.is_held)
    .with_effort(&problem.effort)
}

/// The first part of every run; a run that cannot be cut is left out.
pub(super) fn heads(runs: &[RunData], share: f64) -> Vec<RunData> {
    let head = |run: &RunData| run.head((run.len() as f64 * share).ceil() as usize).ok();
    runs.iter().filter_map(head).collect()
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
