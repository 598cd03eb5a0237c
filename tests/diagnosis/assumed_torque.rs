//! Without a known resistance or torque constant, nothing is shown in units that need them.

use std::path::Path;

use crate::support::command::run;
use serde_json::Value;

/// Units and symbols of an assumed resistance or torque constant.
const ASSUMED: [&str; 8] = ["N m", "mN", "kg m", "ohm", "Ohm", "\u{3a9}", "Kt", "_nm"];

/// A run of the handout's motor under a constant load, and the same in the format of another program.
fn record(folder: &Path) {
    let motor = "[effects.constant_load]\ntorque_nm = 0.03\n";
    std::fs::write(folder.join("loaded.toml"), motor).expect("room");
    let simulate =
        "simulate --motor loaded.toml --profile reversing --duration 6 --ts 0.005 -o run.csv";
    let words: Vec<&str> = simulate.split(' ').collect();
    assert_eq!(run(folder, &words).status, Some(0));
    let text = std::fs::read_to_string(folder.join("run.csv")).expect("a run");
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = rows.next().expect("names").split(',').collect();
    let columns = ["t_s", "command_v", "counts"];
    let columns = columns.map(|name| names.iter().position(|one| *one == name).expect(name));
    let mut log = "time_s,voltage_v,counts\n".to_owned();
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        log.push_str(&format!("{}\n", columns.map(|k| cells[k]).join(",")));
    }
    std::fs::write(folder.join("log.csv"), log).expect("room");
}

/// The texts of a page, without styles, scripts and the packed values of its figures.
fn texts(page: &str) -> String {
    let mut text = page.to_owned();
    for (open, close) in [
        ("<style>", "</style>"),
        ("<script>", "</script>"),
        ("&quot;v&quot;:&quot;", "&quot;"),
        ("&quot;t&quot;:&quot;", "&quot;"),
    ] {
        while let Some(at) = text.find(open) {
            let behind = at + open.len();
            let end = text[behind..]
                .find(close)
                .map_or(text.len(), |end| behind + end + close.len());
            text.replace_range(at..end, "");
        }
    }
    plain(&text)
}

/// A text without the one allowed word.
fn plain(text: &str) -> String {
    text.replace('\u{a0}', " ")
        .replace("ohmmeter", "meter")
        .replace("--resistance OHM", "")
}

fn diagnosed(folder: &Path, arguments: &[&str]) -> (Value, String, String) {
    let mut all = vec!["diagnose"];
    all.extend(arguments);
    all.extend(["--html", "page.html", "--force"]);
    let told = run(folder, &all);
    assert_eq!(told.status, Some(0), "{}", told.messages);
    all.push("--json");
    let done = run(folder, &all);
    let page = std::fs::read_to_string(folder.join("page.html")).expect("a page");
    let document = serde_json::from_str(&done.output).expect("one document");
    (document, texts(&page), plain(&told.output))
}

#[test]
fn without_a_known_torque_nothing_is_in_newton_metres_or_ohms() {
    let keep = tempfile::tempdir().expect("a folder");
    record(keep.path());
    std::fs::write(keep.path().join("motor.toml"), "resistance_ohm = 10\n").expect("room");
    let fitted = ["run.csv", "--nominal", "fit"];
    let imported = ["log.csv", "--counts-per-rev", "720", "--supply", "4.5"];
    for arguments in [&fitted[..], &imported[..]] {
        let (document, page, told) = diagnosed(keep.path(), arguments);
        assert_eq!(document["nominal_source"], "fit");
        let sentence = document["sentence"].as_str().expect("a sentence");
        for word in ASSUMED {
            for text in [&page, &told, sentence] {
                let found = text
                    .find(word)
                    .map(|at| text[..at].chars().rev().take(60).collect::<String>());
                assert_eq!(
                    found.map(|text| text.chars().rev().collect::<String>()),
                    None,
                    "{word}"
                );
            }
        }
        assert!(page.contains("steady speed per volt") && page.contains("rad/s/V"));
        assert!(page.contains("residual voltage (mV)"));
        // The torque of the effect is present, in V.
        let mut causes = document["causes"].as_array().expect("a list").iter();
        let load = causes.find(|cause| cause["effect"] == "constant_load");
        let load = &load.expect("a load")["parameters"]["torque_nm"]["in_command"];
        assert_eq!(load["unit"], "V");
        let volts = load["value"].as_f64().expect("a number");
        let shown = motorlab::report::number::figure(volts, 4);
        assert!(
            page.contains("constant_load: torque<") && page.contains(&shown),
            "{shown}"
        );
    }
    // The same recording with a motor file, which states them.
    let (document, page, _) = diagnosed(keep.path(), &["run.csv", "--motor", "motor.toml"]);
    assert!(page.contains("residual torque (mN m)") && page.contains("resistance_ohm"));
    assert!(
        document["causes"][0]["parameters"]
            .as_object()
            .expect("numbers")
            .values()
            .all(|one| one["in_command"].is_null())
    );
}
