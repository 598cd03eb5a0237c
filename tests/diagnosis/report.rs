//! `diagnose --html`: one offline page that begins with the sentence, and no text of a file becomes markup.

use crate::support::command::run;
use case_generator::generate;

/// Closes an attribute and a tag, and opens others; a file name has no slash.
const HOSTILE: &str = "\"'><script>alert(1)<img src=x onerror=alert(2)>.csv";

#[test]
fn the_page_starts_with_the_sentence_and_needs_no_network() {
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

    // Findings come first, then the sentence in its four parts, then figures.
    let sentence = json["sentence"].as_str().expect("a sentence");
    let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
    let lead = at("<dl class=\"lead\">");
    assert!(lead < at("motorlab check finds nothing wrong") && lead < at("<h2>"));
    let plain = page.replace("<code>", "`").replace("</code>", "`");
    for name in ["Error", "Cause", "Next step"] {
        let part = plain
            .split(&format!("<dt>{name}</dt><dd>"))
            .nth(1)
            .expect("a part");
        let part = part.split("</dd>").next().expect("its end");
        for part_of_text in part.split('`') {
            assert!(
                motorlab::report::escaped(sentence).contains(part_of_text),
                "{part_of_text}"
            );
        }
    }

    // The command to copy is the same one, and every number near it is one of the document.
    assert!(sentence.contains("--motor motor.toml"), "{sentence}");
    assert_numbers_of(&json, sentence);

    // Nothing is fetched, no script runs, and the file's name is text.
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    let addresses = addresses.replace("/*! https://github.com/leeoniya/uPlot (v1.6.32) */", "");
    assert!(!addresses.contains("http") && !page.contains("src=\"") && !page.contains("href="));
    assert_eq!(page.matches("<script").count(), 1);
    assert!(!page.contains("<script>alert") && !page.contains("<img") && !page.contains("\"'>"));
    assert!(page.contains("alert(2)&gt;.csv"));

    // Nested models, stages and the overlays twice each (desktop and phone), four figures of the residual torque.
    let titles = |title: &str| page.matches(&format!("aria-label=\"{title}\"")).count();
    assert_eq!(titles("Error budget"), 2);
    assert_eq!(titles("Stage of the chain"), 2);
    for axis in [
        "speed (RPM)",
        "angle of the encoder (degrees)",
        "time since the run began (s)",
        "voltage (V)",
    ] {
        assert!(page.contains(&format!(">{axis}</text></svg>")), "{axis}");
    }
    // The captions have, run by run, the figures that the bars have for all runs together.
    let of_run = |text: &str| -> f64 {
        let number = text
            .split("nominal ")
            .nth(1)
            .and_then(|rest| rest.split(',').next());
        number
            .and_then(|number| number.parse().ok())
            .expect("a number")
    };
    let captions = page
        .split("Prediction error of the position in counts RMS: ")
        .skip(1);
    let of_runs: Vec<f64> = captions.map(of_run).collect();
    let before = json["gap"]["before"].as_f64().expect("a number");
    assert_eq!(of_runs.len(), names.len());
    assert!(
        of_runs.iter().any(|run| *run <= 1.01 * before),
        "{of_runs:?} {before}"
    );
    assert!(
        of_runs.iter().any(|run| *run >= 0.99 * before),
        "{of_runs:?} {before}"
    );
    // The nested models and the most probable cause are those of the document.
    for model in ["before", "after_parameters", "floor"] {
        let value = json["gap"][model].as_f64().expect("a number");
        let text = motorlab::report::number::figure(value, 3);
        assert!(page.contains(&text), "{model} {text}");
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

/// Every number of a text except in commands is a rounded number of the document, or follows from two.
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
    // A probability that is printed as a bound.
    let text = &text.replace("P > 0.999", "");
    for word in text.split('`').step_by(2).flat_map(str::split_whitespace) {
        let word = word.trim_matches(|c: char| "(),.;:%".contains(c));
        let Ok(number) = word.parse::<f64>() else {
            continue;
        };
        let decimals = word.split_once('.').map_or(0, |(_, after)| after.len());
        // Shares are rounded down, all others to the nearest.
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

/// A recording with a fatal finding has a page too: findings, remedies, and the run.
#[test]
fn a_bad_recording_has_its_page() {
    let directory = tempfile::tempdir().expect("a directory");
    let simulate = "simulate --profile reversing --duration 6 --ts 0.01 -o run.csv";
    let arguments: Vec<&str> = simulate.split(' ').collect();
    assert_eq!(run(directory.path(), &arguments).status, Some(0));
    let file = std::fs::read_to_string(directory.path().join("run.csv")).expect("a run");
    // The encoder's wires are swapped: the sign of the counts, the third value of every row, is changed.
    let turned = |line: &str| match line.split(',').collect::<Vec<_>>()[..] {
        [t_s, command, counts, _] if counts != "counts" => {
            format!(
                "{t_s},{command},{},\n",
                -counts.parse::<i64>().expect("counts")
            )
        }
        _ => format!("{line}\n"),
    };
    let file: String = file.lines().map(turned).collect();
    std::fs::write(directory.path().join(HOSTILE), file).expect("room");
    let arguments = [
        "diagnose",
        HOSTILE,
        "--html",
        "why.html",
        "--model-out",
        "m.toml",
    ];
    let done = run(directory.path(), &arguments);
    assert_eq!(done.status, Some(1), "{}{}", done.output, done.messages);
    assert!(
        done.messages.contains("m.toml: not written"),
        "{}",
        done.messages
    );
    let page = std::fs::read_to_string(directory.path().join("why.html")).expect("a page");
    let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
    assert!(at("Findings about the recordings") < at("the model error was not measured"));
    assert!(at("the model error was not measured") < at("position (counts)"));
    assert!(!page.contains("<script>alert") && !page.contains("<img"));
}

/// The error is stated once, and the handout's motor is not named if a fit replaces it.
#[test]
fn nothing_is_stated_twice() {
    let directory = tempfile::tempdir().expect("a directory");
    let log = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/tutorial/log.csv");
    let import = ["import", log, "--supply", "12", "-o", "run.csv"];
    assert_eq!(run(directory.path(), &import).status, Some(0));
    let done = run(
        directory.path(),
        &["diagnose", "run.csv", "--html", "why.html"],
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert!(!done.messages.contains("handout"), "{}", done.messages);
    let page = std::fs::read_to_string(directory.path().join("why.html")).expect("a page");
    assert_eq!(page.matches("<dt>Error</dt>").count(), 1);
}
