//! Calibration of probabilities and coverage of intervals: verdicts and truths in, scores with sampling errors out.
//!
//! With the probability p of the verdict's statement (of the class of a stated tie) and o = 1 if it is right: Brier
//! score `mean (p - o)^2` (Brier 1950). With the probability q of the truth: log score `mean -ln q`, q at least 1e-6,
//! so that one certain error costs 13.8.

use std::collections::BTreeMap;

use serde::Serialize;

use super::share::mean;
use super::{Judgement, Share, Word};

/// Smallest probability of the log score.
const LEAST_PROBABILITY: f64 = 1e-6;
/// Edges of the reliability table's bins.
const BINS: [f64; 9] = [0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0];

/// Calibration of probabilities.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Probabilities {
    /// Brier score of the verdicts.
    pub brier: Option<f64>,
    /// Brier score over all causes, from 0 to 2.
    pub brier_all_causes: Option<f64>,
    /// Log score of the truth in nats.
    pub log_score: Option<f64>,
    /// Cases whose truth has a probability below 1e-6.
    pub truth_ruled_out: u64,
    /// Verdicts by their probability.
    pub reliability: Vec<ReliabilityRow>,
    /// Right verdicts among those of 90 % and more.
    pub right_from_90: Share,
}

/// One bin of probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReliabilityRow {
    /// Lower end.
    pub from: f64,
    /// Upper end (included in the last bin).
    pub to: f64,
    /// Mean probability of the verdicts.
    pub mean_probability: f64,
    /// Right verdicts.
    pub right: Share,
}

impl Probabilities {
    /// Calibration over all cases with a diagnosis.
    pub fn of(cases: &[Judgement]) -> Self {
        let judged: Vec<&Judgement> = cases.iter().filter(|j| j.verdict != Word::Failed).collect();
        let squares: Vec<f64> = judged
            .iter()
            .map(|j| (j.probability_said - f64::from(u8::from(j.is_right()))).powi(2))
            .collect();
        let logs: Vec<f64> = judged
            .iter()
            .map(|j| -j.probability_truth.max(LEAST_PROBABILITY).ln())
            .collect();
        let all_causes: Vec<f64> = judged.iter().map(|j| j.brier_all_causes).collect();
        let ruled_out = judged
            .iter()
            .filter(|j| j.probability_truth < LEAST_PROBABILITY);
        Self {
            brier: mean(&squares),
            brier_all_causes: mean(&all_causes),
            log_score: mean(&logs),
            truth_ruled_out: ruled_out.count() as u64,
            reliability: reliability(&judged),
            right_from_90: Share::count(judged.iter().filter(|j| j.probability_said >= 0.9), |j| {
                j.is_right()
            }),
        }
    }
}

fn reliability(judged: &[&Judgement]) -> Vec<ReliabilityRow> {
    let rows = BINS.windows(2).filter_map(|edges| {
        let (from, to) = (edges[0], edges[1]);
        let inside: Vec<&&Judgement> = judged
            .iter()
            .filter(|j| {
                let p = j.probability_said;
                p >= from && (p < to || to == 1.0)
            })
            .collect();
        let probabilities: Vec<f64> = inside.iter().map(|j| j.probability_said).collect();
        Some(ReliabilityRow {
            from,
            to,
            mean_probability: mean(&probabilities)?,
            right: Share::count(inside, |j| j.is_right()),
        })
    });
    rows.collect()
}

/// Interval coverage for correctly named effects.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// 95 % intervals that contain the true value.
    pub intervals: Share,
    /// Correct discrete parameters (cycles per revolution, counts per revolution, encoder's side).
    pub whole_numbers: Share,
    /// Both by `effect.parameter`.
    pub by_parameter: BTreeMap<String, Share>,
}

impl Coverage {
    /// Coverage over all cases.
    pub fn of(cases: &[Judgement]) -> Self {
        let checks = || cases.iter().flat_map(|j| &j.parameters);
        let mut by_parameter: BTreeMap<String, Share> = BTreeMap::new();
        for check in checks() {
            let name = format!("{}.{}", check.effect, check.name);
            let share = by_parameter.entry(name).or_default();
            share.hits += u64::from(check.right);
            share.of += 1;
        }
        Self {
            intervals: Share::count(checks().filter(|c| c.interval.is_some()), |c| c.right),
            whole_numbers: Share::count(checks().filter(|c| c.interval.is_none()), |c| c.right),
            by_parameter,
        }
    }
}
