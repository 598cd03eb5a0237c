//! `compare` on several runs: its plots on the terminal, as SVG and as one page.

use crate::support::command;
use crate::support::command::run;
use crate::support::reversed::reversed;

#[test]
fn two_runs_are_drawn_on_the_terminal_as_svg_and_as_one_page() {
    let directory = tempfile::tempdir().expect("a directory");
    for (ts, name) in [("0.03", "a&b.csv"), ("0.003", "fast.csv")] {
        let arguments = [
            "simulate",
            "--ts",
            ts,
            "--profile",
            "reversing",
            "--duration",
            "3",
            "-o",
            name,
        ];
        let done = run(directory.path(), &arguments);
        assert_eq!(done.status, Some(0), "{}", done.messages);
    }
    // A motor file with one key: the rest is the handout's.
    let file = |name: &str| std::fs::read_to_string(directory.path().join(name)).expect("a file");
    std::fs::write(directory.path().join("heavy.toml"), "inertia_kg_m2 = 0.004").expect("room");
    let compare = [
        "compare",
        "a&b.csv",
        "fast.csv",
        "--motor",
        "heavy.toml",
        "--html",
        "gap.html",
        "--svg",
        "gap.svg",
    ];
    let done = run(directory.path(), &compare);
    assert_eq!(done.status, Some(0), "{}", done.messages);

    // Without a terminal: no colours, 80 columns, every panel of the worst run with its name, and a line per run.
    assert!(!done.output.contains('\u{1b}'));
    let is_drawn = |c: char| ('\u{2801}'..='\u{28ff}').contains(&c);
    assert!(done.output.contains(is_drawn));
    for label in ["speed (RPM)", "position (counts)", "error (counts)"] {
        assert_eq!(done.output.matches(label).count(), 1, "{label}");
    }
    let plotted = done.output.lines().filter(|line| line.contains('┤'));
    assert!(plotted.map(|line| line.chars().count()).max() <= Some(80));

    // For any number of runs the plot is of the worst.
    let gap = |k: usize| {
        json_of(directory.path(), &compare[..5])["runs"][k]["position_rmse_counts"].as_f64()
    };
    let (worst, name) = if gap(0) > gap(1) {
        (0, "a&amp;b.csv")
    } else {
        (1, "fast.csv")
    };
    assert!(gap(worst) > gap(1 - worst));
    let svg = file("gap.svg");
    assert!(svg.contains(name), "{name}");
    assert!(svg.contains("<svg ") && svg.contains("</svg>\n<!-- written by motorlab compare -->"));
    assert!(!svg.contains("a&b"));
    for label in [
        "recorded",
        "simulated",
        "recorded \u{2212} simulated",
        "speed (RPM)",
        "position (counts)",
        "command (V)",
        "time (s)",
    ] {
        assert!(svg.contains(&format!(">{label}<")), "{label}");
    }

    let page = file("gap.html");
    // One figure per run, for a desktop and for a phone.
    assert_eq!(page.matches("<figure data-plot=").count(), 2);
    assert_eq!(page.matches("<svg").count(), 4);
    assert!(page.contains("inertia_kg_m2 = 0.004") && page.contains("fast.csv"));
    // Nothing is fetched: no address but SVG's name space and the source of uPlot, which is inlined.
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    let addresses = addresses.replace("/*! https://github.com/leeoniya/uPlot (v1.6.32) */", "");
    assert!(!addresses.contains("http") && page.contains("Copyright (c) 2022 Leon Sorokin"));
    assert_eq!(page.matches("<script").count(), 1);
    // The table is sortable, and the worst run is the first figure.
    assert!(page.contains("<table class=\"sortable\">"));

    // The figures on the page are those of the document.
    let json = run(directory.path(), &[&compare[..5], &["--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json.output).expect("one document");
    for shown in json["runs"].as_array().expect("a list") {
        let rmse = shown["position_rmse_counts"].as_f64().expect("a number");
        assert!(rmse > 1.0, "{rmse}");
        assert!(page.contains(&format!(">{rmse:.3}<")), "{rmse}");
        assert!(done.output.contains(&format!("{rmse:.3}")), "{rmse}");
    }
}

fn json_of(directory: &std::path::Path, arguments: &[&str]) -> serde_json::Value {
    let done = run(directory, &[arguments, &["--json"]].concat());
    serde_json::from_str(&done.output).expect("one document")
}

/// Fatal findings come first on the page and on standard output, before the comparison.
#[test]
fn an_unusable_run_is_reported_before_it_is_compared() {
    let directory = tempfile::tempdir().expect("a directory");
    let here = directory.path();
    let simulate = [
        "simulate",
        "--profile",
        "reversing",
        "--duration",
        "3",
        "-o",
    ];
    for name in ["sound.csv", "turned.csv"] {
        let done = run(here, &[&simulate[..], &[name]].concat());
        assert_eq!(done.status, Some(0), "{}", done.messages);
    }
    let text = std::fs::read_to_string(here.join("turned.csv")).expect("a run");
    std::fs::write(here.join("turned.csv"), reversed(&text)).expect("written");
    let page = |runs: &[&str]| {
        let done = run(
            here,
            &[&["compare"], runs, &["--html", "gap.html"]].concat(),
        );
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let page = std::fs::read_to_string(here.join("gap.html")).expect("a page");
        (done.output, page)
    };
    let (output, one) = page(&["turned.csv"]);
    let at = |page: &str, what: &str| page.find(what).unwrap_or_else(|| panic!("no {what}"));
    assert!(at(&one, "are swapped") < at(&one, "class=\"lead\""));
    for said in [&output, &one] {
        assert!(said.contains("turned.csv is not usable: "), "{output}");
        assert!(!said.contains("differ by more than"), "{output}");
    }
    let (output, both) = page(&["turned.csv", "sound.csv"]);
    assert!(at(&both, "are swapped") < at(&both, "class=\"lead\""));
    for said in [&output, &both] {
        assert!(
            said.contains("sound.csv: the simulation agrees"),
            "{output}"
        );
        let fatal = "Fatal findings: turned.csv.";
        assert!(said.contains(fatal), "{output}");
    }
    let (_, sound) = page(&["sound.csv"]);
    assert!(!sound.contains("is not usable"));
}

/// Values of a curve under the cursor: the packed value with its decimals.
#[test]
fn values_on_a_page_are_those_of_the_run() {
    let directory = tempfile::tempdir().expect("a directory");
    let here = directory.path();
    let simulate = [
        "simulate",
        "--profile",
        "reversing",
        "--duration",
        "3",
        "-o",
        "run.csv",
    ];
    assert_eq!(run(here, &simulate).status, Some(0));
    let compare = ["compare", "run.csv", "--html", "gap.html"];
    assert_eq!(run(here, &compare).status, Some(0));
    let page = std::fs::read_to_string(here.join("gap.html")).expect("a page");
    let data = page.split("data-plot=\"").nth(1).expect("a figure");
    let data = data.split('"').next().unwrap_or_default();
    let data = data.replace("&quot;", "\"").replace("&#39;", "'");
    let data: serde_json::Value =
        serde_json::from_str(&data.replace("&amp;", "&")).expect("its data");
    let curve = |label: &str| {
        let mut panels = data["panels"].as_array().expect("panels").iter();
        let panel = panels.find(|panel| panel["y"] == label).expect("a panel");
        told(&panel["s"][0])
    };
    let column = command::RunFile::read(&here.join("run.csv")).column("command_v");
    let command = curve("command (V)");
    let mut pairs = command.iter().zip(&column);
    assert!(pairs.all(|(told, recorded)| (told - recorded).abs() < 1e-9));
    assert_eq!(command.len(), column.len());
    assert!(command.contains(&0.0) && command.contains(&2.7));
    // At rest the recorded speed is no number other than 0.
    let speed = curve("speed (RPM)");
    assert!(speed.iter().filter(|rpm| **rpm == 0.0).count() > 10);
}

/// Values of a packed curve, with its decimals.
fn told(curve: &serde_json::Value) -> Vec<f64> {
    let number = |key: &str| curve[key].as_f64().expect("a number");
    let power = 10_f64.powi(number("decimals") as i32);
    let letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let packed = curve["v"].as_str().expect("text").trim_end_matches('=');
    let mut bytes = Vec::new();
    let (mut bits, mut held) = (0_u32, 0);
    for letter in packed.chars() {
        bits = (bits << 6) | letters.find(letter).expect("base 64") as u32;
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
            bits &= (1 << held) - 1;
        }
    }
    let values = bytes
        .chunks_exact(2)
        .map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    let values = values.filter(|packed| *packed < 65534);
    let value = |packed| number("lo") + f64::from(packed) * number("step");
    values
        .map(|packed| (value(packed) * power).round() / power)
        .collect()
}
