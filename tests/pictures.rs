//! `compare` on several runs at once: what it draws on the terminal, as SVG and as one page.

#[path = "support/command.rs"]
mod command;

use command::run;

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
    // A motor file of one key: the rest is the handout's.
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

    // Without a terminal: no colours, 80 columns, every panel of the worst run with its name, and a line a run.
    assert!(!done.output.contains('\u{1b}'));
    let is_drawn = |c: char| ('\u{2801}'..='\u{28ff}').contains(&c);
    assert!(done.output.contains(is_drawn));
    for label in ["speed (RPM)", "position (counts)", "gap (counts)"] {
        assert_eq!(done.output.matches(label).count(), 1, "{label}");
    }
    let plotted = done.output.lines().filter(|line| line.contains('┤'));
    assert!(plotted.map(|line| line.chars().count()).max() <= Some(80));

    // Of three runs or a hundred the picture is of the worst.
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
    // One figure a run, drawn for a desk and for a phone.
    assert_eq!(page.matches("<figure data-plot=").count(), 2);
    assert_eq!(page.matches("<svg").count(), 4);
    assert!(page.contains("inertia_kg_m2 = 0.004") && page.contains("fast.csv"));
    // Nothing is fetched: no address but SVG's name and where uPlot, which is inside, comes from.
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    let addresses = addresses.replace("/*! https://github.com/leeoniya/uPlot (v1.6.32) */", "");
    assert!(!addresses.contains("http") && page.contains("Copyright (c) 2022 Leon Sorokin"));
    assert_eq!(page.matches("<script").count(), 1);
    // The lines of the table sort, and the worst run comes first among the pictures.
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
