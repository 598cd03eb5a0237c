//! One verdict compared with its truth: named, tied, hidden, partly right or missed.
//!
//! A single effect, nothing, or something outside is named, tied (the truth is among the names that the
//! verdict states to be one class) or missed. Of a pair both, one or none can be right.

use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::claim::{Claim, Names, Word, names};
use super::unseen::GapCheck;
use super::{OpenedCase, Truth, TruthKind};

/// How a verdict stands to the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bearing {
    /// It says the truth and nothing else.
    Named,
    /// The truth is among names stated to be one class.
    Tied,
    /// It says none, and that the truth looks the same in these runs.
    Hidden,
    /// Some of several effects are right, or one is and something unknown is said to be beside it.
    Partly,
    /// It says something else.
    Missed,
}

/// One verdict judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// The case.
    pub case: String,
    /// True cause.
    pub truth: Truth,
    /// The verdict in a word.
    pub verdict: Word,
    /// Names that the verdict puts first: ids, `unknown`, or nothing.
    pub said: Vec<String>,
    /// How many sets the verdict leaves standing; 1 where it states no tie.
    pub standing: usize,
    /// How it stands to the truth.
    pub bearing: Bearing,
    /// Probability given to what it says (the whole class where it states one).
    pub probability_said: f64,
    /// Probability given to the truth alone.
    pub probability_truth: f64,
    /// Sum over all causes of the squared difference between probability and outcome; of a pair each effect counts half.
    pub brier_all_causes: f64,
    /// Place of the truth among the sets weighed, from 1; none where it is not there.
    pub rank_of_truth: Option<usize>,
    /// The likeliest sets and their probabilities, as many as help to see what went wrong.
    pub likeliest: Vec<(String, f64)>,
    /// Estimates of the effects that are named rightly.
    pub parameters: Vec<ParameterCheck>,
    /// Error as claimed and as measured on the held-out run.
    pub gap: Option<GapCheck>,
    /// Wall time of the diagnosis in s.
    pub wall_s: f64,
    /// Why there is no diagnosis.
    pub failure: Option<String>,
}

impl Judgement {
    /// Whether it is right, outright or within a stated tie.
    pub fn is_right(&self) -> bool {
        matches!(self.bearing, Bearing::Named | Bearing::Tied)
    }

    /// Verdict in a word: ids joined by `+`, `none`, `unknown` or `failed`.
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

/// An estimated parameter against its true value.
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
    /// 95 % interval; of a whole number (cycles, encoder's side) there is none to judge.
    pub interval: Option<(f64, f64)>,
    /// Whether the interval holds the true value, or the whole number is the true one.
    pub right: bool,
}

/// Judges a case; `gap` was measured apart.
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
        // The worst there is: certain of something that is not so.
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
    // The verdict's own, where a document has one: what is outside the catalogue is less sure than that something unknown is there.
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

/// How many of the likeliest sets are kept.
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

/// The set that a diagnosis should name.
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

/// `sum over causes of (p - o)^2`, o = 1/n for each of the n effects that are there; a set among the causes
/// counts for its effects in equal shares.
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

/// Parameters that are whole numbers, or one of a few values: an interval says nothing of them.
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

/// Whether an angle lies between two others, whole turns aside.
fn holds_angle(low: f64, high: f64, angle: f64) -> bool {
    (angle - low).rem_euclid(TAU) <= high - low
}
