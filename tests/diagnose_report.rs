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
    let escaped = sentence.replace('\'', "&#39;");
    assert!(
        page.find(&escaped)
            .is_some_and(|at| at > lead && at < lead + 20)
    );
    assert!(page.find("<h2>").is_some_and(|at| at > lead));

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
