//! Figures of a sentence, and whether the document contains them.

use serde_json::Value;

/// Numbers of the document that a sentence may print, without those of the search, which are too many for a test.
pub fn printable(document: &Value) -> Vec<f64> {
    let mut document = document.clone();
    let map = document.as_object_mut().expect("an object");
    for key in [
        "steps",
        "sets",
        "elapsed_s",
        "simulated_samples",
        "sentence",
    ] {
        assert!(map.remove(key).is_some(), "{key}");
    }
    let mut found = Vec::new();
    numbers(&document, &mut found);
    found
}

fn numbers(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Number(number) => into.extend(number.as_f64()),
        Value::Array(values) => values.iter().for_each(|value| numbers(value, into)),
        Value::Object(map) => map.values().for_each(|value| numbers(value, into)),
        _ => (),
    }
}

/// Figures of a sentence, without its commands, that are no rounded number of the document.
pub fn unknown_figures(sentence: &str, known: &[f64]) -> Vec<String> {
    let text: Vec<&str> = sentence.split('`').step_by(2).collect();
    let text = text.join(" ").replace("95 %", "");
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut unknown = Vec::new();
    for (k, word) in words.iter().enumerate() {
        let trimmed = word.trim_matches(|c: char| "(),.;:%".contains(c));
        let Ok(number) = trimmed.parse::<f64>() else {
            continue;
        };
        let is_percent = word.ends_with('%')
            || words.get(k + 1).is_some_and(|next| next.starts_with('%'))
            || words.get(k + 1) == Some(&"to")
                && words.get(k + 3).is_some_and(|w| w.starts_with('%'));
        let decimals = trimmed.split_once('.').map_or(0, |(_, after)| after.len());
        let step = 10f64.powi(-i32::try_from(decimals).expect("few digits"));
        let before = if k > 0 { words[k - 1] } else { "" };
        let is_known = |known: &&f64| {
            let value = if is_percent { 100.0 * **known } else { **known };
            match before {
                ">" => (number..=1.0).contains(&value),
                "<" => value > 0.0 && value < number,
                // A probability near 1 is never rounded up.
                _ if (0.99..1.0).contains(&number) => (number..number + step).contains(&value),
                // Three digits of a large number, and bounds of a share that are clipped at 0.
                _ => {
                    (value.max(0.0) - number.abs()).abs() <= 0.5001 * step
                        || (value - number).abs() <= 0.5001 * step
                }
            }
        };
        if !known.iter().any(|known| is_known(&known)) {
            unknown.push((*word).to_owned());
        }
    }
    unknown
}
