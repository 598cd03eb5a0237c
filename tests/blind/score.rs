//! The score of nine verdicts compared with figures computed by hand.

use std::collections::BTreeMap;

use motorlab::blind::{
    Bearing, GapCheck, Judgement, Opened, OpenedCase, Score, SealedCase, Share, Truth, Verdict,
    judge, markdown, page, score, text,
};
use serde_json::{Value, json};
use time::OffsetDateTime;

fn share(hits: u64, of: u64) -> Share {
    Share { hits, of }
}

fn near(found: Option<f64>, expected: f64) {
    let found = found.expect("a figure");
    assert!(
        (found - expected).abs() < 1e-6,
        "{found}, expected {expected}"
    );
}

/// A case: its label with strengths and parameters, and the diagnosis (null for a failure).
pub(crate) struct JudgedCase {
    label: &'static str,
    strength: Option<f64>,
    parameters: &'static [(&'static str, f64)],
    diagnosis: Value,
    gap: Option<GapCheck>,
}

impl JudgedCase {
    pub(crate) fn new(label: &'static str, diagnosis: Value) -> Self {
        Self {
            label,
            strength: None,
            parameters: &[],
            diagnosis,
            gap: None,
        }
    }

    pub(crate) fn opened(&self, k: usize) -> OpenedCase {
        let mut truth = Truth::from_words(self.label).expect("a label");
        for effect in &mut truth.effects {
            if let Some(strength) = self.strength {
                truth.strength_counts.insert(effect.id.clone(), strength);
            }
        }
        if let Some(first) = truth.effects.first_mut() {
            let given = self.parameters.iter();
            first.parameters = given.map(|(name, v)| ((*name).to_owned(), *v)).collect();
        }
        OpenedCase {
            sealed: SealedCase {
                name: format!("case-{k}"),
                runs: vec!["run.csv".to_owned()],
                motor: "motor.toml".to_owned(),
                unseen: None,
                sha256: BTreeMap::new(),
                commitment: String::new(),
            },
            truth,
            diagnoser: "by hand".to_owned(),
            verdict: Verdict {
                failure: self.diagnosis.is_null().then(|| "it died".to_owned()),
                diagnosis: self.diagnosis.clone(),
                model: None,
                wall_s: k as f64,
            },
        }
    }
}

pub(crate) fn estimate(lo95: f64, hi95: f64) -> Value {
    json!({"value": 0.5 * (lo95 + hi95), "lo95": lo95, "hi95": hi95, "unit": "N m"})
}

fn measured(unseen: f64, after_counts: f64) -> Option<GapCheck> {
    Some(GapCheck {
        claimed: None,
        claimed_interval: None,
        unseen: Some(unseen),
        before_counts: 10.0,
        after_counts,
    })
}

/// Nine cases, numbered from 1.
fn stories() -> Vec<JudgedCase> {
    vec![
        JudgedCase {
            strength: Some(1.5),
            parameters: &[("extra_torque_nm", 0.03), ("stribeck_speed_rad_s", 1.0)],
            gap: measured(0.99, 0.4),
            ..JudgedCase::new(
                "stribeck",
                json!({"verdict": "effect", "effects": ["stribeck"],
                    "gap": {"closed": 0.98, "closed_lo95": 0.97, "closed_hi95": 0.995},
                    "causes": [
                        {"effect": "stribeck", "probability": 0.9, "parameters": {
                            "extra_torque_nm": estimate(0.02, 0.04),
                            "stribeck_speed_rad_s": estimate(1.1, 1.3)}},
                        {"effect": "dead_zone", "probability": 0.1}]}),
            )
        },
        JudgedCase {
            strength: Some(20.0),
            ..JudgedCase::new(
                "coulomb_friction",
                json!({"verdict": "ambiguous", "effects": ["voltage_drop"], "causes": [
                    {"effect": "voltage_drop", "probability": 0.5, "indistinguishable_from": ["coulomb_friction"]},
                    {"effect": "coulomb_friction", "probability": 0.4, "indistinguishable_from": ["voltage_drop"]},
                    {"effect": "none", "probability": 0.1}]}),
            )
        },
        JudgedCase {
            strength: Some(50.0),
            ..JudgedCase::new(
                "backlash",
                json!({"verdict": "effect", "effects": ["compliance"], "causes": [
                    {"effect": "compliance", "probability": 0.7, "indistinguishable_from": ["backlash"]},
                    {"effect": "backlash", "probability": 0.2},
                    {"effect": "unknown", "probability": 0.1}]}),
            )
        },
        JudgedCase {
            gap: measured(0.5, 2.0),
            ..JudgedCase::new(
                "stribeck+inertia",
                json!({"verdict": "effect", "effects": ["inertia", "stribeck"],
                    "gap": {"closed": 0.9, "closed_lo95": 0.85, "closed_hi95": 0.95},
                    "sets": [
                        {"effects": ["inertia", "stribeck"], "probability": 0.8},
                        {"effects": ["stribeck"], "probability": 0.2}],
                    "causes": [
                        {"effect": "stribeck", "probability": 0.6},
                        {"effect": "inertia", "probability": 0.4}]}),
            )
        },
        JudgedCase {
            parameters: &[
                ("phase_rad", 0.1),
                ("cycles_per_rev", 7.0),
                ("torque_nm", 0.02),
            ],
            ..JudgedCase::new(
                "cogging+backlash",
                json!({"verdict": "effect", "effects": ["cogging"], "causes": [
                    {"effect": "cogging", "probability": 1.0, "parameters": {
                        "phase_rad": estimate(6.2, 6.5),
                        "cycles_per_rev": estimate(7.0, 7.0),
                        "cogging.torque_nm": estimate(0.01, 0.02)}}]}),
            )
        },
        JudgedCase::new(
            "none",
            json!({"verdict": "no_gap", "causes": [
                {"effect": "none", "probability": 0.95},
                {"effect": "stribeck", "probability": 0.05}]}),
        ),
        JudgedCase::new(
            "none",
            json!({"verdict": "effect", "effects": ["viscous_friction"], "causes": [
                {"effect": "viscous_friction", "probability": 0.6},
                {"effect": "none", "probability": 0.4}]}),
        ),
        JudgedCase::new(
            "outside:a belt that jumps",
            json!({"verdict": "outside_catalogue", "causes": [
                {"effect": "unknown", "probability": 0.7},
                {"effect": "backlash", "probability": 0.3}]}),
        ),
        JudgedCase::new("outside:a belt that jumps", Value::Null),
    ]
}

fn judged() -> (Opened, Vec<Judgement>) {
    let stories = stories();
    let cases: Vec<OpenedCase> = stories.iter().zip(1..).map(|(s, k)| s.opened(k)).collect();
    let judgements = cases
        .iter()
        .zip(&stories)
        .map(|(case, s)| judge(case, s.gap))
        .collect();
    let opened = Opened {
        opened_at: OffsetDateTime::UNIX_EPOCH,
        head: "start".to_owned(),
        order_proved: false,
        recipe: None,
        cases,
    };
    (opened, judgements)
}

fn scored() -> Score {
    let (opened, judgements) = judged();
    score(&opened, judgements)
}

#[test]
fn each_verdict_is_scored_as_documented() {
    let bearings: Vec<Bearing> = judged().1.iter().map(|j| j.bearing).collect();
    use Bearing::{Missed, Named, Partly, Tied};
    assert_eq!(
        bearings,
        [
            Named, Tied, Missed, Named, Partly, Named, Missed, Named, Missed
        ]
    );
}

#[test]
fn shares_are_counted_by_kind() {
    let score = scored();
    assert_eq!(score.singles.named, share(1, 3));
    assert_eq!(score.singles.right, share(2, 3));
    assert_eq!(score.pairs.right, share(1, 2));
    assert_eq!(score.pairs_half_right, share(1, 2));
    assert_eq!(score.false_alarms, share(1, 2));
    assert_eq!(score.outside.flagged, share(1, 2));
    assert_eq!(score.outside.taken_for_an_effect, share(0, 2));
    assert_eq!(score.ties.stated, share(1, 3));
    assert_eq!(score.ties.most_names, 2);
    assert_eq!(score.failed, 1);
}

#[test]
fn strengths_and_confusion_count_each_case_once() {
    let score = scored();
    let rows: Vec<_> = score
        .by_strength
        .iter()
        .map(|row| (row.from_counts, row.standing.named, row.standing.right))
        .collect();
    assert_eq!(
        rows,
        [
            (0.0, share(1, 1), share(1, 1)),
            (10.0, share(0, 1), share(1, 1)),
            (30.0, share(0, 1), share(0, 1)),
        ]
    );
    let confusion = &score.confusion;
    let mut filled = Vec::new();
    for (r, row) in confusion.counts.iter().enumerate() {
        for (c, &count) in row.iter().enumerate().filter(|(_, count)| **count > 0) {
            filled.push((
                confusion.rows[r].as_str(),
                confusion.columns[c].as_str(),
                count,
            ));
        }
    }
    assert_eq!(
        filled,
        [
            ("coulomb_friction", "voltage_drop", 1),
            ("stribeck", "stribeck", 1),
            ("backlash", "compliance", 1),
            ("none", "viscous_friction", 1),
            ("none", "none", 1),
            ("outside", "unknown", 1),
            ("outside", "failed", 1),
        ]
    );
    let backlash = score.by_effect.iter().find(|row| row.effect == "backlash");
    assert_eq!(
        backlash.expect("a row").taken_for,
        [("compliance".to_owned(), 1)]
    );
}

#[test]
fn probabilities_are_scored_as_defined() {
    let probabilities = scored().probabilities;
    // Probabilities .9 .9 .7 .8 1 .95 .6 .7, right: 1 1 0 1 0 1 0 1.
    near(
        probabilities.brier,
        (0.01 + 0.01 + 0.49 + 0.04 + 1.0 + 0.0025 + 0.36 + 0.09) / 8.0,
    );
    // By case: .1^2 + .1^2; .5^2 + .6^2 + .1^2; .7^2 + .8^2 + .1^2; for pairs .1^2 + .1^2 and .5^2 + .5^2; ...
    near(
        probabilities.brier_all_causes,
        (0.02 + 0.62 + 1.14 + 0.02 + 0.5 + 0.005 + 0.72 + 0.18) / 8.0,
    );
    // -ln of .9 .4 .2 .8 1e-6 .95 .4 .7.
    near(probabilities.log_score, 2.249_250_28);
    assert_eq!(probabilities.truth_ruled_out, 1);
    assert_eq!(probabilities.right_from_90, share(3, 4));
    let rows: Vec<_> = probabilities
        .reliability
        .iter()
        .map(|r| (r.from, r.right))
        .collect();
    assert_eq!(
        rows,
        [
            (0.5, share(0, 1)),
            (0.7, share(1, 2)),
            (0.8, share(1, 1)),
            (0.9, share(2, 2)),
            (0.95, share(1, 1)),
            (0.99, share(0, 1)),
        ]
    );
}

#[test]
fn intervals_claims_and_times_are_summarized() {
    let score = scored();
    // Torque in, speed out, phase in (6.2 to 6.5 is -0.08 to 0.22 plus one turn), torque at the end.
    assert_eq!(score.coverage.intervals, share(3, 4));
    assert_eq!(score.coverage.whole_numbers, share(1, 1));
    near(score.gap.claimed_median, 0.94);
    near(score.gap.unseen_median, 0.745);
    near(score.gap.overstated_median, 0.195);
    assert_eq!(score.gap.in_interval, share(1, 2));
    near(score.gap.singles_after_counts, 0.4);
    near(score.gap.singles_after_over_floor, 0.4 * 12f64.sqrt());
    near(score.time.median_s, 5.0);
    near(score.time.p90_s, 8.2);
    near(score.time.most_s, 9.0);
}

#[test]
fn text_and_page_list_every_miss() {
    let score = scored();
    let missed: Vec<&str> = (score.cases.iter().filter(|j| !j.is_right()))
        .map(|j| j.case.as_str())
        .collect();
    assert_eq!(missed, ["case-3", "case-5", "case-7", "case-9"]);
    let (text, page, markdown) = (text(&score), page(&score), markdown(&score));
    for case in missed {
        assert!(markdown.contains(&format!("\n- {case}: ")));
        assert!(text.contains(&format!("  {case}: ")) && page.contains(&format!("<li>{case}: ")));
    }
    assert!(text.contains(
        "backlash [backlash: 50.0 counts]. Said: compliance (0.700); the truth has 2.00e-1, place 2; \
         likeliest: compliance 0.700, backlash 0.200, unknown 0.100"
    ));
}

/// The bearing of one additional verdict.
fn bearing_of(label: &'static str, diagnosis: Value) -> Bearing {
    judge(&JudgedCase::new(label, diagnosis).opened(1), None).bearing
}

#[test]
fn a_member_inseparable_from_none_may_be_absent() {
    let said = |verdict: &str| {
        json!({"verdict": verdict, "effects": ["backlash", "transport_delay"], "causes": [
            {"effect": "backlash", "probability": 0.6},
            {"effect": "transport_delay", "probability": 0.4, "indistinguishable_from": ["none"]}]})
    };
    assert_eq!(bearing_of("backlash", said("ambiguous")), Bearing::Tied);
    assert_eq!(
        bearing_of("backlash+transport_delay", said("ambiguous")),
        Bearing::Tied
    );
    assert_eq!(
        bearing_of("transport_delay", said("ambiguous")),
        Bearing::Missed
    );
    assert_eq!(bearing_of("backlash", said("effect")), Bearing::Missed);
}

#[test]
fn effects_inseparable_from_none_are_counted_separately() {
    let said = |tied: &[&str]| {
        json!({"verdict": "parameters", "causes": [
            {"effect": "none", "probability": 0.95, "indistinguishable_from": tied},
            {"effect": "viscous_friction", "probability": 0.05}]})
    };
    let hidden = bearing_of("viscous_friction", said(&["viscous_friction"]));
    assert_eq!(hidden, Bearing::Hidden);
    assert_eq!(bearing_of("viscous_friction", said(&[])), Bearing::Missed);
    assert_eq!(
        bearing_of("none", said(&["viscous_friction"])),
        Bearing::Named
    );
}
