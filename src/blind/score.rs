//! The figures of a whole set.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use time::OffsetDateTime;

use super::calibration::{Coverage, Probabilities};
use super::share::{mean, quantile};
use super::{Bearing, Judgement, Opened, Recipe, Share, TruthKind, Word};
use crate::compare::FLOOR_COUNTS;
use crate::motor::catalogue::catalogue;

/// The figures; serialises to the shape `motorlab-blind-score/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    /// Name of the shape.
    pub shape: &'static str,
    /// Which set, judged by whom.
    pub set: SetFacts,
    /// Single effects.
    pub singles: Standing,
    /// Single effects of which it is said that none is there, and that this one would look the same in these runs. They
    /// do not count as right.
    pub singles_hidden: Share,
    /// Pairs.
    pub pairs: Standing,
    /// Pairs of which one effect is right and not both.
    pub pairs_half_right: Share,
    /// Cases without any effect in which one is said to be, or something unknown.
    pub false_alarms: Share,
    /// Cases outside the catalogue.
    pub outside: OutsideCases,
    /// Sets of names left standing where a tie is stated.
    pub ties: Ties,
    /// Single effects by id, in the order of the catalogue.
    pub by_effect: Vec<EffectRow>,
    /// Single effects by strength.
    pub by_strength: Vec<StrengthRow>,
    /// Confusion matrix (true x predicted).
    pub confusion: Confusion,
    /// How far probabilities hold.
    pub probabilities: Probabilities,
    /// How far intervals hold.
    pub coverage: Coverage,
    /// Claimed error against the error on the held-out run.
    pub gap: Gap,
    /// Time of a diagnosis.
    pub time: Time,
    /// Cases without a diagnosis.
    pub failed: u64,
    /// Every case.
    pub cases: Vec<Judgement>,
}

/// Which set, judged by whom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetFacts {
    /// How many cases.
    pub cases: usize,
    /// How they were made, if they were made.
    pub recipe: Option<Recipe>,
    /// Whether it is a tuning set, whose figures are not to be published.
    pub for_tuning: bool,
    /// Who judged: more than one name where the program changed under way.
    pub diagnosers: Vec<String>,
    /// When the labels were first opened.
    #[serde(with = "time::serde::rfc3339")]
    pub opened_at: OffsetDateTime,
    /// Head of the chain of verdicts.
    pub head: String,
    /// Whether somebody had written that head down before the labels were opened.
    pub order_proved: bool,
}

/// Named and right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Standing {
    /// The truth and nothing else.
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
    /// Said to be outside.
    pub flagged: Share,
    /// Taken for an effect of the catalogue.
    pub taken_for_an_effect: Share,
    /// Not noticed.
    pub unnoticed: Share,
    /// Flagged, by id.
    pub by_id: BTreeMap<String, Share>,
}

/// Size of ties: a tie of many names is often right at random.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ties {
    /// Verdicts on single effects that state one.
    pub stated: Share,
    /// Names in them, on the mean.
    pub mean_names: Option<f64>,
    /// Names in the largest.
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
    /// Its kind taken for when it is missed, most often first.
    pub taken_for: Vec<(String, u64)>,
    /// Median strength in counts RMS, where known.
    pub median_strength_counts: Option<f64>,
}

/// One band of strengths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StrengthRow {
    /// From this many counts RMS on.
    pub from_counts: f64,
    /// Up to less than this many; none in the last band.
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
    /// Cases, row by row.
    pub counts: Vec<Vec<u64>>,
}

/// Claimed error against the error on the held-out run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// Cases with a claimed error, a motor file and a held-out run.
    pub cases: usize,
    /// Median share said to close.
    pub claimed_median: Option<f64>,
    /// Median share that closed on the unseen run.
    pub unseen_median: Option<f64>,
    /// Median of how much more was said than closed.
    pub overstated_median: Option<f64>,
    /// Cases whose share closed lies in the interval claimed.
    pub in_interval: Share,
    /// Median error of the diagnosed motor on the unseen run, single effects, in counts RMS.
    pub singles_after_counts: Option<f64>,
    /// The same in multiples of what rounding to counts leaves (0.289).
    pub singles_after_over_floor: Option<f64>,
    /// Median of what the truth itself leaves of these runs in counts RMS.
    pub singles_truth_counts: Option<f64>,
    /// Median error of the nominal motor on these runs in counts RMS.
    pub singles_before_counts: Option<f64>,
}

/// Time of a diagnosis in s, start of the program included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Time {
    /// Half take less.
    pub median_s: Option<f64>,
    /// Nine of ten take less.
    pub p90_s: Option<f64>,
    /// The longest.
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
        // A diagnosis that failed raises no alarm; it is counted as failed.
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

/// A pair counts in neither effect's row; said pairs and larger sets are `several`.
fn confusion(cases: &[Judgement]) -> Confusion {
    // Verdicts of the published table, and any other.
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
