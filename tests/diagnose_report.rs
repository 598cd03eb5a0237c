//! `diagnose --html`: one offline page that leads with the sentence, and nothing of a file becomes markup.

#[path = "support/command.rs"]
mod command;

use case_generator::generate;
use command::run;

/// Ends an attribute and a tag, and begins others; no slash fits into a file's name.
const HOSTILE: &str = "\"'><script>alert(1)<img src=x onerror=alert(2)>.csv";

#[test]
fn the_page_leads_with_the_sentence_and_needs_no_network() {
    let directory = tempfile::tempdir().expect("a directory");
    let case = generate(3, &"stribeck".parse().expect("a kind"));
    let mut arguments = vec!["diagnose"];
    let names = [HOSTILE, "fast.csv", "reversing.csv"];
    for (name, recorded) in names.iter().zip(&case.runs) {
        std::fs::write(directory.path().join(name), recorded.to_csv()).expect("room");
        arguments.push(name);
    }
    std::fs::write(directory.path().join("motor.toml"), case.nominal.to_toml()).expect("room");
    arguments.extend(["--motor", "motor.toml", "--html", "why.html", "--json"]);
    let done = run(directory.path(), &arguments);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let json: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
    let page = std::fs::read_to_string(directory.path().join("why.html")).expect("a page");

    // The sentence comes first.
    let sentence = json["sentence"].as_str().expect("a sentence");
    let lead = page.find("class=\"lead\"").expect("a lead");
    let escaped = motorlab::report::escaped(sentence);
    assert!(
        page.find(&escaped)
            .is_some_and(|at| at > lead && at < lead + 20)
    );
    assert!(page.find("<h2>").is_some_and(|at| at > lead));

    // The command to copy asks the same again, and every number beside it is one of the document.
    assert!(sentence.contains("--motor motor.toml"), "{sentence}");
    assert_numbers_of(&json, sentence);

    // Nothing is fetched, nothing runs, and the file's name is text.
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http") && !page.contains("src=\"") && !page.contains("href"));
    assert!(!page.contains("<script") && !page.contains("<img") && !page.contains("\"'>"));
    assert!(page.contains("alert(2)&gt;.csv"));

    // Rungs, stages and the overlays twice each (desk and phone), four pictures of what orders the gap.
    let titles = |title: &str| page.matches(&format!("aria-label=\"{title}\"")).count();
    assert_eq!(titles("Position error"), 2);
    assert_eq!(titles("Stage of the chain"), 2);
    for axis in [
        "speed (RPM)",
        "angle of the encoder (degrees)",
        "time since the run began (s)",
        "voltage (V)",
    ] {
        assert!(page.contains(&format!(">{axis}</text></svg>")), "{axis}");
    }
    // The rungs and the likeliest cause are those of the document.
    for rung in ["before", "after_parameters", "floor"] {
        let value = json["gap"][rung].as_f64().expect("a number");
        let text = motorlab::report::number::figure(value, 3);
        assert!(page.contains(&format!(">{text} counts")), "{rung} {text}");
    }
    let cause = &json["causes"][0];
    let name = cause["effect"].as_str().expect("an id");
    assert!(page.contains(&format!("<td>{name}: ")), "{name}");
    for parameter in cause["parameters"].as_object().expect("numbers").keys() {
        assert!(
            page.contains(&format!("<td>{name}: {parameter}</td>")),
            "{parameter}"
        );
    }
}

/// Every number of a text but those of its commands is a number of the document, or follows from two, as it is rounded there.
fn assert_numbers_of(document: &serde_json::Value, text: &str) {
    let mut known = Vec::new();
    numbers(document, &mut known);
    let gap = |key: &str| document["gap"][key].as_f64().expect("a number");
    known.push(gap("before") / gap("travel"));
    let shares: Vec<f64> = known.iter().map(|number| 100.0 * number).collect();
    known.extend(shares);
    let regions = document["where"]["regions"].as_array().expect("a list");
    for region in regions {
        let alike = regions
            .iter()
            .filter(|other| other["regime"] == region["regime"]);
        known.push(100.0 * alike.filter_map(|r| r["share"].as_f64()).sum::<f64>());
    }
    let mut told = 0;
    for word in text.split('`').step_by(2).flat_map(str::split_whitespace) {
        let word = word.trim_matches(|c: char| "(),.;:%".contains(c));
        let Ok(number) = word.parse::<f64>() else {
            continue;
        };
        let decimals = word.split_once('.').map_or(0, |(_, after)| after.len());
        // Shares are rounded down, all else to the nearest.
        let step = 10f64.powi(-i32::try_from(decimals).expect("few"));
        let is_near =
            |known: &f64| (known - number).abs() <= 0.5001 * step || known.floor() == number;
        assert!(known.iter().any(is_near), "{word} in {text}");
        told += 1;
    }
    assert!(told >= 5, "{text}");
}

fn numbers(value: &serde_json::Value, into: &mut Vec<f64>) {
    match value {
        serde_json::Value::Number(number) => into.extend(number.as_f64()),
        serde_json::Value::Array(values) => values.iter().for_each(|value| numbers(value, into)),
        serde_json::Value::Object(map) => map.values().for_each(|value| numbers(value, into)),
        _ => (),
    }
}
