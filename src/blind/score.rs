//! The score of a set.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use time::OffsetDateTime;

use super::calibration::{Coverage, Probabilities};
use super::share::{mean, quantile};
use super::{Bearing, Judgement, Opened, Recipe, Share, TruthKind, Word};
use crate::compare::FLOOR_COUNTS;
use crate::motor::catalogue::catalogue;

/// The score; serialized as `motorlab-blind-score/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    /// Name of the document's shape.
    pub shape: &'static str,
    /// The set and its diagnoser.
    pub set: SetFacts,
    /// Single effects.
    pub singles: Standing,
    /// Single effects for which the verdict is none with this effect stated as not separated from none. They do not
    /// count as right.
    pub singles_hidden: Share,
    /// Pairs.
    pub pairs: Standing,
    /// Pairs with one of two effects right.
    pub pairs_half_right: Share,
    /// Cases without effects for which an effect or an unknown error is claimed.
    pub false_alarms: Share,
    /// Cases outside the catalogue.
    pub outside: OutsideCases,
    /// Sets consistent with a stated tie.
    pub ties: Ties,
    /// Single effects by id, in the order of the catalogue.
    pub by_effect: Vec<EffectRow>,
    /// Single effects by strength.
    pub by_strength: Vec<StrengthRow>,
    /// Confusion matrix (true x predicted).
    pub confusion: Confusion,
    /// Calibration of probabilities.
    pub probabilities: Probabilities,
    /// Coverage of intervals.
    pub coverage: Coverage,
    /// Claimed error and error on the held-out run.
    pub gap: Gap,
    /// Computing time.
    pub time: Time,
    /// Cases without a diagnosis.
    pub failed: u64,
    /// Every case.
    pub cases: Vec<Judgement>,
}

/// The set and its diagnoser.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetFacts {
    /// Number of cases.
    pub cases: usize,
    /// How they were generated, unless they were recorded.
    pub recipe: Option<Recipe>,
    /// Whether it is a tuning set, whose figures are not published.
    pub for_tuning: bool,
    /// Diagnosers: several if the program changed during the run.
    pub diagnosers: Vec<String>,
    /// Time of the first opening of the labels.
    #[serde(with = "time::serde::rfc3339")]
    pub opened_at: OffsetDateTime,
    /// Head of the chain of verdicts.
    pub head: String,
    /// Whether that head was recorded before the labels were opened.
    pub order_proved: bool,
}

/// Named and right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Standing {
    /// Exactly the truth.
    pub named: Share,
    /// That, or the truth within a stated tie.
    pub right: Share,
}

impl Standing {
    fn of<'a>(judgements: impl Iterator<Item = &'a Judgement> + Clone) -> Self {
        Self {
            named: Share::count(judgements.clone(), |j| j.bearing == Bearing::Named),
            right: Share::count(judgements, Judgement::is_right),
        }
    }
}

/// Cases outside the catalogue.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutsideCases {
    /// Reported as outside the catalogue.
    pub flagged: Share,
    /// Reported as an effect of the catalogue.
    pub taken_for_an_effect: Share,
    /// Reported as no gap.
    pub unnoticed: Share,
    /// Reported as outside, by id.
    pub by_id: BTreeMap<String, Share>,
}

/// Size of ties: large ties are often right at random.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ties {
    /// Verdicts on single effects with a tie.
    pub stated: Share,
    /// Mean number of effects in them.
    pub mean_names: Option<f64>,
    /// Number of effects in the largest.
    pub most_names: usize,
}

/// One effect's row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectRow {
    /// Its id.
    pub effect: String,
    /// Named and right.
    #[serde(flatten)]
    pub standing: Standing,
    /// Verdicts of missed cases, most frequent first.
    pub taken_for: Vec<(String, u64)>,
    /// Median strength in counts RMS, if known.
    pub median_strength_counts: Option<f64>,
}

/// One band of strengths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StrengthRow {
    /// Lower end in counts RMS.
    pub from_counts: f64,
    /// Upper end in counts RMS; `None` for the last band.
    pub to_counts: Option<f64>,
    /// Named and right.
    #[serde(flatten)]
    pub standing: Standing,
}

/// Confusion matrix: predicted (columns) against true (rows).
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Confusion {
    /// Effects, `none`, `outside`.
    pub rows: Vec<String>,
    /// Effects, `several`, `none`, `unknown`, `failed`.
    pub columns: Vec<String>,
    /// Cases by row.
    pub counts: Vec<Vec<u64>>,
}

/// Claimed error and error on the held-out run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// Cases with a claimed error, a motor file and a held-out run.
    pub cases: usize,
    /// Median claimed reduction.
    pub claimed_median: Option<f64>,
    /// Median reduction on the held-out run.
    pub unseen_median: Option<f64>,
    /// Median excess of the claimed over the measured reduction.
    pub overstated_median: Option<f64>,
    /// Cases whose measured reduction is in the claimed interval.
    pub in_interval: Share,
    /// Median error of the diagnosed motor on the held-out run for single effects, in counts RMS.
    pub singles_after_counts: Option<f64>,
    /// The same in multiples of the quantization error (0.289).
    pub singles_after_over_floor: Option<f64>,
    /// Median error of the true motor on these runs in counts RMS.
    pub singles_truth_counts: Option<f64>,
    /// Median error of the nominal motor on these runs in counts RMS.
    pub singles_before_counts: Option<f64>,
}

/// Computing time in s, with the start of the program.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Time {
    /// Median.
    pub median_s: Option<f64>,
    /// 90 % quantile.
    pub p90_s: Option<f64>,
    /// Maximum.
    pub most_s: Option<f64>,
}

/// Lower ends of the bands of strength in counts RMS.
const BANDS: [f64; 6] = [0.0, 2.0, 5.0, 10.0, 30.0, 100.0];

/// Scores judged cases.
pub fn score(opened: &Opened, cases: Vec<Judgement>) -> Score {
    let of_kind = |kind: TruthKind| cases.iter().filter(move |j| j.truth.kind == kind);
    let singles: Vec<&Judgement> = of_kind(TruthKind::Single).collect();
    let failed = cases.iter().filter(|j| j.verdict == Word::Failed).count();
    let diagnosers: BTreeSet<&str> = opened.cases.iter().map(|c| c.diagnoser.as_str()).collect();
    Score {
        shape: "motorlab-blind-score/1",
        set: SetFacts {
            cases: cases.len(),
            for_tuning: opened.recipe.as_ref().is_some_and(Recipe::is_for_tuning),
            recipe: opened.recipe.clone(),
            diagnosers: diagnosers.into_iter().map(str::to_owned).collect(),
            opened_at: opened.opened_at,
            head: opened.head.clone(),
            order_proved: opened.order_proved,
        },
        singles: Standing::of(singles.iter().copied()),
        singles_hidden: Share::count(singles.iter().copied(), |j| j.bearing == Bearing::Hidden),
        pairs: Standing::of(of_kind(TruthKind::Pair)),
        pairs_half_right: Share::count(of_kind(TruthKind::Pair), |j| j.bearing == Bearing::Partly),
        // A failed diagnosis is no false alarm; it is counted as failed.
        false_alarms: Share::count(of_kind(TruthKind::None), |j| {
            !j.is_right() && j.verdict != Word::Failed
        }),
        outside: outside(of_kind(TruthKind::Outside)),
        ties: ties(&singles),
        by_effect: by_effect(&singles),
        by_strength: by_strength(&singles),
        confusion: confusion(&cases),
        probabilities: Probabilities::of(&cases),
        coverage: Coverage::of(&cases),
        gap: gap(&cases),
        time: time(&cases),
        failed: failed as u64,
        cases,
    }
}

fn outside<'a>(judgements: impl Iterator<Item = &'a Judgement> + Clone) -> OutsideCases {
    let mut by_id: BTreeMap<String, Share> = BTreeMap::new();
    for judgement in judgements.clone() {
        let share = by_id.entry(judgement.truth.ids().join("+")).or_default();
        share.hits += u64::from(judgement.is_right());
        share.of += 1;
    }
    OutsideCases {
        flagged: Share::count(judgements.clone(), Judgement::is_right),
        taken_for_an_effect: Share::count(judgements.clone(), |j| {
            matches!(j.verdict, Word::Effect | Word::Ambiguous) && !j.is_right()
        }),
        unnoticed: Share::count(judgements, |j| {
            matches!(j.verdict, Word::NoGap | Word::Parameters)
        }),
        by_id,
    }
}

fn ties(singles: &[&Judgement]) -> Ties {
    let is_tie = |j: &Judgement| j.standing > 1 || j.verdict == Word::Ambiguous;
    let names: Vec<f64> = singles
        .iter()
        .filter(|j| is_tie(j))
        .map(|j| j.standing as f64)
        .collect();
    Ties {
        stated: Share::count(singles, |j| is_tie(j)),
        mean_names: mean(&names),
        most_names: singles.iter().map(|j| j.standing).max().unwrap_or(0),
    }
}

fn by_effect(singles: &[&Judgement]) -> Vec<EffectRow> {
    let row = |id: &str| {
        let of_it: Vec<&Judgement> = singles
            .iter()
            .copied()
            .filter(|j| j.truth.effects.iter().any(|e| e.id == id))
            .collect();
        let mut taken_for: BTreeMap<String, u64> = BTreeMap::new();
        for judgement in of_it.iter().filter(|j| !j.is_right()) {
            *taken_for.entry(judgement.said_in_words()).or_default() += 1;
        }
        let mut taken_for: Vec<_> = taken_for.into_iter().collect();
        taken_for.sort_by_key(|(_, times)| std::cmp::Reverse(*times));
        let strengths: Vec<f64> = of_it
            .iter()
            .filter_map(|j| j.truth.weakest_counts())
            .collect();
        EffectRow {
            effect: id.to_owned(),
            standing: Standing::of(of_it.iter().copied()),
            taken_for,
            median_strength_counts: quantile(&strengths, 0.5),
        }
    };
    let rows = catalogue().iter().map(|kind| row(kind.id));
    rows.filter(|row| row.standing.right.of > 0).collect()
}

fn by_strength(singles: &[&Judgement]) -> Vec<StrengthRow> {
    let rows = BANDS.iter().enumerate().map(|(k, &from_counts)| {
        let to_counts = BANDS.get(k + 1).copied();
        let inside = singles.iter().copied().filter(|j| {
            j.truth.weakest_counts().is_some_and(|strength| {
                strength >= from_counts && to_counts.is_none_or(|to| strength < to)
            })
        });
        StrengthRow {
            from_counts,
            to_counts,
            standing: Standing::of(inside),
        }
    });
    rows.filter(|row| row.standing.right.of > 0).collect()
}

/// A pair counts in neither effect's row; pairs and larger sets as verdicts are `several`.
fn confusion(cases: &[Judgement]) -> Confusion {
    // Verdicts of the published table, and any others.
    let occurs = |id: &str| {
        let hidden = |j: &Judgement| j.truth.effects.iter().any(|effect| effect.id == id);
        cases
            .iter()
            .any(|j| hidden(j) || j.said.iter().any(|said| said == id))
    };
    let effects = catalogue().iter().map(|kind| kind.id);
    let effects = effects
        .filter(|id| case_generator::CATALOGUE.contains(id) || occurs(id))
        .map(str::to_owned);
    let rows: Vec<String> = effects
        .clone()
        .chain(["none", "outside"].map(str::to_owned))
        .collect();
    let columns: Vec<String> = effects
        .chain(["several", "none", "unknown", "failed"].map(str::to_owned))
        .collect();
    let mut counts = vec![vec![0; columns.len()]; rows.len()];
    for judgement in cases {
        let row = match judgement.truth.kind {
            TruthKind::None => "none".to_owned(),
            TruthKind::Outside => "outside".to_owned(),
            TruthKind::Single => judgement.truth.words(),
            TruthKind::Pair => continue,
        };
        let said = match judgement.said.len() {
            0 | 1 => judgement.said_in_words(),
            _ => "several".to_owned(),
        };
        let place = |list: &[String], name: &str| list.iter().position(|known| known == name);
        if let (Some(r), Some(c)) = (place(&rows, &row), place(&columns, &said)) {
            counts[r][c] += 1;
        }
    }
    Confusion {
        rows,
        columns,
        counts,
    }
}

fn gap(cases: &[Judgement]) -> Gap {
    let all: Vec<_> = cases
        .iter()
        .filter_map(|j| j.gap.map(|gap| (j, gap)))
        .collect();
    let both: Vec<(f64, f64)> = all
        .iter()
        .filter_map(|(_, gap)| gap.claimed.zip(gap.unseen))
        .collect();
    let median = |values: Vec<f64>| quantile(&values, 0.5);
    let singles = || {
        all.iter()
            .filter(|(j, _)| j.truth.kind == TruthKind::Single)
    };
    let after = median(singles().map(|(_, gap)| gap.after_counts).collect());
    Gap {
        cases: both.len(),
        claimed_median: median(both.iter().map(|pair| pair.0).collect()),
        unseen_median: median(both.iter().map(|pair| pair.1).collect()),
        overstated_median: median(both.iter().map(|pair| pair.0 - pair.1).collect()),
        in_interval: Share::count(
            all.iter()
                .filter_map(|(_, gap)| gap.claimed_interval.zip(gap.unseen)),
            |((low, high), unseen)| low <= unseen && unseen <= high,
        ),
        singles_after_counts: after,
        singles_after_over_floor: after.map(|after| after / FLOOR_COUNTS),
        singles_truth_counts: median(
            singles()
                .filter_map(|(j, _)| j.truth.unseen_floor_counts)
                .collect(),
        ),
        singles_before_counts: median(singles().map(|(_, gap)| gap.before_counts).collect()),
    }
}

fn time(cases: &[Judgement]) -> Time {
    let walls: Vec<f64> = cases.iter().map(|j| j.wall_s).collect();
    Time {
        median_s: quantile(&walls, 0.5),
        p90_s: quantile(&walls, 0.9),
        most_s: quantile(&walls, 1.0),
    }
}
