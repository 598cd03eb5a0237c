//! Documents of the second and the third shape of a diagnosis, judged.

use motorlab::blind::{Bearing, judge};
use serde_json::{Value, json};

use crate::score::{JudgedCase, estimate};

/// A document of the second shape: a further unknown, a class, no answer.
#[test]
fn the_second_shape_of_a_diagnosis_is_judged() {
    let story = |label: &'static str, diagnosis: Value| {
        let case = JudgedCase::new(label, diagnosis).opened(1);
        judge(&case, None)
    };
    let partial = |label| {
        story(
            label,
            json!({"shape": "motorlab-diagnosis/2", "verdict": "partial", "effects": ["stribeck"], "probability": 0.8,
            "causes": [{"effect": "stribeck", "probability": 0.7}, {"effect": "unknown", "probability": 0.3}]}),
        )
    };
    let judged = partial("stribeck");
    assert_eq!(judged.said, ["stribeck", "unknown"]);
    assert_eq!(
        (judged.bearing, judged.probability_said),
        (Bearing::Partly, 0.8)
    );
    assert_eq!(partial("stribeck+inertia").bearing, Bearing::Partly);
    assert_eq!(partial("outside:a belt").bearing, Bearing::Partly);
    assert_eq!(partial("inertia").bearing, Bearing::Missed);
    assert_eq!(partial("none").bearing, Bearing::Missed);
    let class = |label| {
        story(
            label,
            json!({"shape": "motorlab-diagnosis/2", "verdict": "ambiguous", "effects": [], "probability": 0.9, "causes": [
            {"effect": "stribeck", "probability": 0.5, "class": "start", "class_probability": 0.9},
            {"effect": "dead_zone", "probability": 0.4, "class": "start", "class_probability": 0.9},
            {"effect": "unknown", "probability": 0.1}]}),
        )
    };
    assert_eq!(
        (class("dead_zone").bearing, class("dead_zone").standing),
        (Bearing::Tied, 2)
    );
    assert!((class("dead_zone").probability_said - 0.9).abs() < 1e-12);
    assert_eq!(class("inertia").bearing, Bearing::Missed);
    let fatal_first = story(
        "stribeck",
        json!({"shape": "motorlab-diagnosis/2", "verdict": "bad_recording", "probability": 1.0,
        "causes": [], "data": [{"id": "time_unit"}]}),
    );
    assert!(fatal_first.failure.is_some() && fatal_first.bearing == Bearing::Missed);
}

/// The third shape: inclusion probabilities, sets with the sum 1, classes in place of an effect, no `unknown`.
#[test]
fn the_third_shape_of_a_diagnosis_is_judged() {
    let judged = |label: &'static str,
                  verdict: &str,
                  probability: f64,
                  effects: Value,
                  classes: Value,
                  sets: Value| {
        let causes = json!([
            {"effect": "stribeck", "stage": "mechanical", "inclusion": 0.55, "class": "start", "class_probability": 0.95, "at_bound": false,
                "parameters": {"strength_ratio": estimate(0.4, 0.6)}},
            {"effect": "dead_zone", "stage": "command", "inclusion": 0.4, "class": "start", "class_probability": 0.95, "at_bound": false, "parameters": {}},
            {"effect": "inertia", "stage": "mechanical", "inclusion": 0.3, "at_bound": false, "parameters": {}}]);
        let document = json!({"shape": "motorlab-diagnosis/3", "verdict": verdict, "probability": probability, "effects": effects,
            "classes": classes, "causes": causes, "sets": sets, "budget": [], "elapsed_s": 1.0,
            "gap": {"closed": 0.9, "closed_lo95": 0.8, "closed_hi95": 0.95}});
        judge(&JudgedCase::new(label, document).opened(1), None)
    };
    let start =
        json!([{"class": "start", "probability": 0.95, "members": ["stribeck", "dead_zone"]}]);
    let singles = json!([{"effects": ["stribeck"], "probability": 0.55}, {"effects": ["dead_zone"], "probability": 0.4},
        {"effects": [], "probability": 0.05}]);
    let pairs = json!([{"effects": ["stribeck", "inertia"], "probability": 0.5}, {"effects": ["dead_zone", "inertia"], "probability": 0.4},
        {"effects": [], "probability": 0.1}]);
    // A class is a tie of its members; without one the effect is named.
    for label in ["stribeck", "dead_zone"] {
        let of_class = judged(
            label,
            "effect",
            0.95,
            json!(["stribeck"]),
            start.clone(),
            singles.clone(),
        );
        assert_eq!(
            (of_class.bearing, of_class.standing),
            (Bearing::Tied, 2),
            "{label}"
        );
        assert!((of_class.probability_said - 0.95).abs() < 1e-12);
    }
    let stribeck = judged(
        "stribeck",
        "effect",
        0.95,
        json!(["stribeck"]),
        start.clone(),
        singles.clone(),
    );
    assert!((stribeck.probability_truth - 0.55).abs() < 1e-12);
    assert_eq!(stribeck.rank_of_truth, Some(1));
    assert!(
        (stribeck.brier_all_causes - (0.45_f64.powi(2) + 0.4_f64.powi(2) + 0.05_f64.powi(2))).abs()
            < 1e-12
    );
    let alone = judged(
        "inertia",
        "effect",
        0.95,
        json!(["inertia"]),
        json!([]),
        singles.clone(),
    );
    assert_eq!((alone.bearing, alone.standing), (Bearing::Named, 1));
    assert_eq!(
        judged(
            "backlash",
            "effect",
            0.95,
            json!(["inertia"]),
            json!([]),
            singles.clone()
        )
        .bearing,
        Bearing::Missed
    );
    // In a pair, a member of a class may be exchanged.
    let pair = judged(
        "dead_zone+inertia",
        "effect",
        0.9,
        json!(["inertia", "stribeck"]),
        start.clone(),
        pairs.clone(),
    );
    assert_eq!((pair.bearing, pair.standing), (Bearing::Tied, 2));
    assert!((pair.probability_truth - 0.4).abs() < 1e-12);
    // Named effects and an unexplained error.
    let partial = judged(
        "stribeck",
        "partial",
        0.95,
        json!(["stribeck"]),
        start,
        singles.clone(),
    );
    assert_eq!(
        (partial.bearing, &partial.said[..]),
        (
            Bearing::Partly,
            &["stribeck".to_owned(), "unknown".to_owned()][..]
        )
    );
    // No named effect: the most probable set and its ties, with their probabilities.
    let ambiguous = judged(
        "dead_zone",
        "ambiguous",
        0.95,
        json!([]),
        json!([]),
        singles.clone(),
    );
    assert_eq!(
        (ambiguous.bearing, &ambiguous.said[..]),
        (Bearing::Tied, &["stribeck".to_owned()][..])
    );
    assert!((ambiguous.probability_said - 0.95).abs() < 1e-12);
    let ambiguous = judged(
        "dead_zone+inertia",
        "ambiguous",
        0.9,
        json!([]),
        json!([]),
        pairs,
    );
    assert_eq!(ambiguous.bearing, Bearing::Tied);
    // The probability of no effect of the catalogue is that of an outside cause.
    let outside_sets =
        json!([{"effects": [], "probability": 0.7}, {"effects": ["stribeck"], "probability": 0.3}]);
    let outside = judged(
        "outside:a belt",
        "outside_catalogue",
        0.7,
        json!([]),
        json!([]),
        outside_sets,
    );
    assert_eq!(
        (outside.bearing, &outside.said[..]),
        (Bearing::Named, &["unknown".to_owned()][..])
    );
    assert!((outside.probability_truth - 0.7).abs() < 1e-12);
    assert!((outside.brier_all_causes - 2.0 * 0.3_f64.powi(2)).abs() < 1e-12);
    let quiet = judged("none", "parameters", 0.05, json!([]), json!([]), singles);
    assert_eq!(
        (quiet.bearing, quiet.rank_of_truth),
        (Bearing::Named, Some(3))
    );
    assert!((quiet.probability_truth - 0.05).abs() < 1e-12);
    let fatal_first = JudgedCase::new(
        "stribeck",
        json!({"shape": "motorlab-diagnosis/3", "verdict": "bad_recording", "probability": 1.0,
        "budget": [], "unexplained": null, "causes": [], "sets": [], "gap": null}),
    );
    let fatal_first = judge(&fatal_first.opened(1), None);
    assert!(fatal_first.failure.is_some() && fatal_first.bearing == Bearing::Missed);
}
