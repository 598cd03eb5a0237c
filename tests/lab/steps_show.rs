//! `lab --board effect=E` for every effect of the catalogue: the answer names the effect or its class, or states how
//! little these steps show it.

use serde_json::Value;

use crate::support::command::run;

/// Effects that are a parameter of the motor: re-identified parameters are the right answer.
const PARAMETERS: [&str; 5] = [
    "supply_error",
    "coulomb_friction",
    "viscous_friction",
    "inertia",
    "resolution_error",
];
/// Largest difference in counts between the stated figure and the recordings: another seed, another initial fraction
/// of a count.
const SAME_COUNTS: f64 = 0.3;

fn texts(value: &Value) -> Vec<String> {
    let items = value.as_array().into_iter().flatten();
    items
        .filter_map(|item| item.as_str().map(str::to_owned))
        .collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn every_effect_is_named_or_stated_to_be_hardly_visible() {
    let folder = tempfile::tempdir().expect("a folder");
    let all = run(folder.path(), &["effects", "--json"]);
    let all: Value = serde_json::from_str(&all.output).expect("a document");
    let ids: Vec<&str> = (all["effects"].as_array().expect("effects").iter())
        .map(|one| one["effect"].as_str().expect("an id"))
        .collect();
    let mut open = Vec::new();
    for effect in &ids {
        let board = format!("effect={effect}&seed=7");
        let done = run(folder.path(), &["lab", "--board", &board, "-o", effect]);
        assert_ne!(done.status, Some(2), "{effect}: {}", done.messages);
        let text = std::fs::read_to_string(folder.path().join(effect).join("lab.json"));
        let lab: Value = serde_json::from_str(&text.expect("lab.json")).expect("a document");
        let diagnosis = &lab["missing"]["diagnosed"];
        let classes = diagnosis["classes"].as_array().into_iter().flatten();
        let mut named: Vec<String> = classes.flat_map(|class| texts(&class["members"])).collect();
        named.extend(texts(&diagnosis["effects"]));
        let not_shown = lab["not_shown"].as_array().expect("a list");
        let own = not_shown.iter().find(|one| one["effect"] == *effect);
        let own = own.map(|one| number(&one["beyond_parameters_counts"]));
        let gap = &diagnosis["gap"];
        let (left, floor) = (number(&gap["after_parameters"]), number(&gap["floor"]));
        let left = (left * left - floor * floor).max(0.0).sqrt();
        let answers = lab["answers"].as_array().expect("answers");
        let answer = answers.iter().find(|answer| answer["number"] == "3.a");
        let short = answer.expect("the answer")["short"]
            .as_str()
            .expect("a text");
        let name = effect.replace('_', " ");
        let sentence = diagnosis["sentence"].as_str().expect("a text");
        let (_, after) = short.split_once(sentence).expect("the sentence");
        let is_parameter = PARAMETERS.contains(effect) && diagnosis["verdict"] == "parameters";
        let is_named = named.iter().any(|id| id == effect);
        let is_said =
            own.is_some_and(|own| after.contains(&name) && (own - left).abs() < SAME_COUNTS);
        let line = format!(
            "{effect}: {} {:.2}, named {named:?}, said {own:?}, left {left:.2}",
            diagnosis["verdict"],
            number(&diagnosis["probability"])
        );
        println!("{line}");
        if !(is_named || is_parameter || is_said) {
            open.push(line);
        }
    }
    assert!(ids.len() > 30);
    assert!(open.is_empty(), "{open:#?}");
}
