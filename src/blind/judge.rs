//! One verdict compared with its truth: named, tied, hidden, partly right or missed.
//!
//! A single effect, none, or an outside cause is named, tied (the truth is in the stated class) or missed. Of a pair,
//! both, one or none can be right.

use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::claim::{Claim, Names, Word, names};
use super::unseen::GapCheck;
use super::{OpenedCase, Truth, TruthKind};

/// Agreement of a verdict with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bearing {
    /// Exactly the truth.
    Named,
    /// The truth is in a stated class.
    Tied,
    /// No effect, with the statement that the truth is not separated from none.
    Hidden,
    /// Some of several effects are right, or one is with a further unknown.
    Partly,
    /// Anything else.
    Missed,
}

/// One verdict judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// The case.
    pub case: String,
    /// True cause.
    pub truth: Truth,
    /// The verdict.
    pub verdict: Word,
    /// Effects of the first set: ids, `unknown`, or none.
    pub said: Vec<String>,
    /// Number of sets consistent with the verdict; 1 without a tie.
    pub standing: usize,
    /// Agreement with the truth.
    pub bearing: Bearing,
    /// Probability of the verdict's statement (of the class, if it states one).
    pub probability_said: f64,
    /// Probability of the truth alone.
    pub probability_truth: f64,
    /// Sum of the squared differences between probability and outcome over all causes; of a pair each effect counts
    /// half.
    pub brier_all_causes: f64,
    /// Rank of the truth among the sets, from 1; `None` if it is absent.
    pub rank_of_truth: Option<usize>,
    /// The most probable sets with their probabilities, to analyse errors.
    pub likeliest: Vec<(String, f64)>,
    /// Estimates of the correctly named effects.
    pub parameters: Vec<ParameterCheck>,
    /// Claimed error, and error measured on the held-out run.
    pub gap: Option<GapCheck>,
    /// Wall time of the diagnosis in s.
    pub wall_s: f64,
    /// Why there is no diagnosis.
    pub failure: Option<String>,
}

impl Judgement {
    /// Whether it is right, by name or within a stated tie.
    pub fn is_right(&self) -> bool {
        matches!(self.bearing, Bearing::Named | Bearing::Tied)
    }

    /// The verdict as text: ids joined by `+`, `none`, `unknown` or `failed`.
    pub fn said_in_words(&self) -> String {
        match self.verdict {
            Word::Failed => "failed".to_owned(),
            Word::NoGap | Word::Parameters => "none".to_owned(),
            Word::Effect | Word::Partial | Word::Ambiguous | Word::OutsideCatalogue => {
                self.said.join("+")
            }
        }
    }
}

/// An estimated parameter compared with its true value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterCheck {
    /// The effect.
    pub effect: String,
    /// The parameter.
    pub name: String,
    /// True value.
    pub truth: f64,
    /// Estimate.
    pub value: f64,
    /// 95 % interval; `None` for a discrete parameter (cycles, encoder's side).
    pub interval: Option<(f64, f64)>,
    /// Whether the interval contains the true value, or the discrete value is right.
    pub right: bool,
}

/// Judges a case; `gap` is measured separately.
pub fn judge(case: &OpenedCase, gap: Option<GapCheck>) -> Judgement {
    let verdict = &case.verdict;
    let claim = match &verdict.failure {
        Some(failure) => Err(failure.clone()),
        None => Claim::read(&verdict.diagnosis),
    };
    let truth_set = truth_set(&case.truth);
    let mut judgement = Judgement {
        case: case.sealed.name.clone(),
        truth: case.truth.clone(),
        verdict: Word::Failed,
        said: Vec::new(),
        standing: 0,
        bearing: Bearing::Missed,
        probability_said: 1.0,
        probability_truth: 0.0,
        // The worst score: certain and wrong.
        brier_all_causes: 2.0,
        rank_of_truth: None,
        likeliest: Vec::new(),
        parameters: Vec::new(),
        gap: None,
        wall_s: verdict.wall_s,
        failure: None,
    };
    let claim = match claim {
        Ok(claim) if claim.verdict != Word::Failed => claim,
        Ok(_) => {
            judgement.failure = Some(
                "there is no diagnosis: the verdict is 'failed' or 'bad_recording'".to_owned(),
            );
            return judgement;
        }
        Err(failure) => {
            judgement.failure = Some(failure);
            return judgement;
        }
    };
    let standing = claim.standing();
    let leading = claim.leading();
    judgement.verdict = claim.verdict;
    judgement.bearing = bearing(&claim, &truth_set, &standing);
    // The verdict's own, if the document has one: `outside the catalogue` is less probable than `any unknown`.
    let of_sets = standing
        .iter()
        .map(|set| claim.probability(set))
        .sum::<f64>();
    judgement.probability_said = claim.of_verdict.unwrap_or(of_sets).min(1.0);
    judgement.probability_truth = claim.probability(&truth_set);
    judgement.brier_all_causes = brier_all_causes(&claim, &truth_set);
    let weighed = claim.weighed();
    judgement.rank_of_truth = weighed
        .iter()
        .position(|(set, _)| *set == truth_set)
        .map(|k| k + 1);
    judgement.likeliest = weighed
        .iter()
        .take(MOST_CAUSES_SHOWN)
        .map(in_words)
        .collect();
    judgement.parameters = check_parameters(&claim, &case.truth, &leading);
    judgement.standing = standing.len();
    judgement.said = leading.into_iter().collect();
    judgement.gap = gap.map(|gap| GapCheck {
        claimed: claim.gap.closed,
        claimed_interval: claim.gap.closed_lo95.zip(claim.gap.closed_hi95),
        ..gap
    });
    judgement
}

const MOST_CAUSES_SHOWN: usize = 4;

fn in_words((set, probability): &(Names, f64)) -> (String, f64) {
    let ids: Vec<&str> = set.iter().map(String::as_str).collect();
    let name = if ids.is_empty() {
        "none".to_owned()
    } else {
        ids.join("+")
    };
    (name, *probability)
}

fn truth_set(truth: &Truth) -> Names {
    match truth.kind {
        TruthKind::Outside => names("unknown"),
        TruthKind::None | TruthKind::Single | TruthKind::Pair => truth
            .effects
            .iter()
            .map(|effect| effect.id.clone())
            .collect(),
    }
}

fn bearing(claim: &Claim, truth: &Names, standing: &[Names]) -> Bearing {
    let leading = &standing[0];
    if leading == truth && claim.verdict != Word::Ambiguous && standing.len() == 1 {
        Bearing::Named
    } else if standing.contains(truth) {
        Bearing::Tied
    } else if claim.hides(truth) {
        Bearing::Hidden
    } else if (truth.len() > 1 || claim.verdict == Word::Partial)
        && standing.iter().any(|set| !set.is_disjoint(truth))
    {
        Bearing::Partly
    } else {
        Bearing::Missed
    }
}

/// `sum over causes of (p - o)^2` with o = 1/n for each of the n present effects; a set among the causes counts for
/// its effects in equal shares.
fn brier_all_causes(claim: &Claim, truth: &Names) -> f64 {
    let mut off: BTreeMap<String, f64> = BTreeMap::new();
    let mut share = |set: &Names, amount: f64| {
        if set.is_empty() {
            *off.entry("none".to_owned()).or_default() += amount;
        }
        for name in set {
            *off.entry(name.clone()).or_default() += amount / set.len() as f64;
        }
    };
    for cause in &claim.causes {
        share(&names(&cause.effect), cause.probability);
    }
    share(truth, -1.0);
    off.values().map(|off| off.powi(2)).sum()
}

/// Discrete parameters, which have no interval.
const WHOLE: [&str; 3] = ["cycles_per_rev", "encoder_side", "counts_per_rev"];

fn check_parameters(claim: &Claim, truth: &Truth, leading: &Names) -> Vec<ParameterCheck> {
    let mut checks = Vec::new();
    for effect in truth.effects.iter().filter(|e| leading.contains(&e.id)) {
        for (name, &true_value) in &effect.parameters {
            let Some(estimate) = claim.estimate(&effect.id, name) else {
                continue;
            };
            let Some(value) = estimate.value else {
                continue;
            };
            let whole = WHOLE.contains(&name.as_str());
            let interval = estimate.lo95.zip(estimate.hi95).filter(|_| !whole);
            let right = match interval {
                Some((low, high)) if name == "phase_rad" => holds_angle(low, high, true_value),
                Some((low, high)) => low <= true_value && true_value <= high,
                None if whole => (value - true_value).abs() < 0.5,
                None => continue,
            };
            checks.push(ParameterCheck {
                effect: effect.id.clone(),
                name: name.clone(),
                truth: true_value,
                value,
                interval,
                right,
            });
        }
    }
    checks
}

/// Whether an angle is between two others, modulo a turn.
fn holds_angle(low: f64, high: f64, angle: f64) -> bool {
    (angle - low).rem_euclid(TAU) <= high - low
}
