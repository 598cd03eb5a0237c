//! `motorlab lab`: the handout's curves and samples against references, its answers, its page.

use std::path::Path;

use crate::support::command::run;
use crate::support::reversed::reversed;

/// Columns of a CSV file by name; empty cells are NaN, comment lines are skipped.
fn columns(path: &Path) -> Vec<(String, Vec<f64>)> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names = lines.next().expect("column names").split(',');
    let mut columns: Vec<(String, Vec<f64>)> =
        names.map(|name| (name.to_owned(), Vec::new())).collect();
    for line in lines {
        for ((_, values), cell) in columns.iter_mut().zip(line.split(',')) {
            values.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    columns
}

fn column(path: &Path, name: &str) -> Vec<f64> {
    let found = columns(path).into_iter().find(|(known, _)| known == name);
    found.unwrap_or_else(|| panic!("no column {name}")).1
}

fn reference(name: &str, column_name: &str) -> Vec<f64> {
    let path = format!("tests/reference/handout/{name}.csv");
    column(Path::new(&path), column_name)
}

fn rpm(speeds: &[f64]) -> Vec<f64> {
    let rpm = 60.0 / std::f64::consts::TAU;
    speeds.iter().map(|w| w * rpm).collect()
}

/// Largest difference over the largest reference value; missing values must be the same in both.
fn largest_relative(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let top = expected.iter().fold(0.0, |m, v| f64::max(m, v.abs()));
    let mut largest: f64 = 0.0;
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.is_nan(), expected.is_nan());
        largest = largest.max((found - expected).abs() / top);
    }
    largest
}

fn json(path: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(path).expect("a JSON file");
    serde_json::from_str(&text).expect("JSON")
}

fn answer<'a>(lab: &'a serde_json::Value, number: &str) -> &'a serde_json::Value {
    let answers = lab["answers"].as_array().expect("answers");
    let found = answers.iter().find(|answer| answer["number"] == number);
    found.unwrap_or_else(|| panic!("no answer {number}"))
}

#[test]
fn curves_and_samples_equal_the_references() {
    let directory = tempfile::tempdir().expect("a folder");
    let finished = run(directory.path(), &["lab", "-o", "lab", "--json"]);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let folder = directory.path().join("lab");
    for curve in [
        "first_order_viscous",
        "second_order_viscous",
        "first_order_coulomb",
        "first_order_frictionless",
        "second_order_frictionless",
    ] {
        let found = column(&folder.join("part1.csv"), &format!("{curve}_rpm"));
        let off = largest_relative(&found, &rpm(&reference(curve, "speed_rad_s")));
        assert!(off < 1e-6, "{curve}: {off}");
    }
    for (file, name) in [
        ("part2-ts0.03", "sampled_ts30"),
        ("part2-ts0.003", "sampled_ts3"),
    ] {
        let path = folder.join(format!("{file}.csv"));
        assert_eq!(column(&path, "counts"), reference(name, "counts"), "{name}");
        for quantity in ["t_s", "speed_rpm", "true_speed_rpm"] {
            let off = largest_relative(&column(&path, quantity), &reference(name, quantity));
            assert!(off < 1e-6, "{name} {quantity}: {off}");
        }
    }
    // First against second order, from the references alone.
    let [first, second] = ["first_order_viscous", "second_order_viscous"]
        .map(|curve| rpm(&reference(curve, "speed_rad_s")));
    let differences: Vec<f64> = first
        .iter()
        .zip(&second)
        .map(|(a, b)| (a - b).abs())
        .collect();
    let largest = differences.iter().fold(0.0, |m: f64, d| m.max(*d));
    let mean_square = differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64;
    let order = &json(&folder.join("lab.json"))["part_1"]["order"];
    let is = |key: &str, expected: f64| {
        let found = order[key].as_f64().expect("a number");
        assert!(
            (found / expected - 1.0).abs() < 1e-6,
            "{key}: {found}, {expected}"
        );
    };
    is("largest_rpm", largest);
    is("rms_rpm", mean_square.sqrt());
    is("electrical_s", 0.0004);
    is("mechanical_s", 0.02 / 0.59);
}

#[test]
fn missing_recordings_are_made_by_the_virtual_board() {
    let directory = tempfile::tempdir().expect("a folder");
    // Twice into the same folder: the virtual board's runs are replaced.
    for _ in 0..2 {
        let finished = run(directory.path(), &["lab"]);
        assert_eq!(finished.status, Some(0), "{}", finished.messages);
    }
    let folder = directory.path().join("lab");
    let lab = json(&folder.join("lab.json"));
    assert_eq!(lab["source"]["virtual_board"], "speed=max");
    let recorded = lab["part_3"].as_array().expect("recordings");
    let sample_times: Vec<_> = recorded
        .iter()
        .map(|run| run["sample_time_s"].as_f64())
        .collect();
    assert_eq!(sample_times, [Some(0.03), Some(0.003)]);
    for recorded in recorded {
        let error = |k: usize| recorded["models"][k]["figures"]["position_rmse_counts"].as_f64();
        // With friction the simulation agrees with the recording down to quantization, 1/sqrt(12).
        assert!(error(0) > Some(50.0) && error(3) < Some(0.35), "{recorded}");
    }
    let page = std::fs::read_to_string(folder.join("index.html")).expect("the page");
    assert!(page.contains("No recording was given"));
    for number in ["1.1", "1.2", "1.3", "2.1", "3.1", "3.2"] {
        assert!(page.contains(&format!("Question {number}:")), "{number}");
    }
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    let addresses = addresses.replace("/*! https://github.com/leeoniya/uPlot (v1.6.32) */", "");
    assert!(!addresses.contains("http") && !addresses.contains("src="));
    assert!(!folder.join("virtual-step3-1.csv").exists());
}

#[test]
fn given_recordings_are_compared_and_missing_ones_listed() {
    let directory = tempfile::tempdir().expect("a folder");
    let folder = directory.path();
    // Four times the file's: twice could be a parameter mismatch.
    let heavier = "[effects.coulomb_friction]\ntorque_nm = 0.08\n";
    std::fs::write(folder.join("bench.toml"), heavier).expect("a motor file");
    let name = "<b>step30.csv";
    let simulated = run(
        folder,
        &[
            "simulate",
            "--motor",
            "bench.toml",
            "--ts",
            "0.03",
            "--duration",
            "1.8",
            "-o",
            name,
        ],
    );
    assert_eq!(simulated.status, Some(0), "{}", simulated.messages);
    let plain = run(folder, &["lab", "--run", name, "-o", "plain"]);
    assert_eq!(plain.status, Some(0), "{}", plain.messages);
    let lab = json(&folder.join("plain/lab.json"));
    assert_eq!(lab["source"], "recorded");
    let short = answer(&lab, "3.a")["short"].as_str().expect("text");
    assert!(!short.starts_with("Nothing"), "{short}");
    let diagnosis = &lab["missing"]["diagnosed"];
    let (_, rest) = (short.split_once(diagnosis["sentence"].as_str().expect("text"))).expect("it");
    let not_shown = lab["not_shown"].as_array().expect("effects");
    assert!(!not_shown.is_empty(), "one step shows few effects");
    for effect in not_shown {
        let name = effect["effect"].as_str().expect("an id");
        let name = name.replace('_', " ");
        assert!(rest.contains(&name), "{name}: {rest}");
    }
    assert!(rest.starts_with(" At their default magnitudes these recordings do not show, "));
    assert!(rest.ends_with("hint: record with --profile reversing too, for more of them."));
    // The motor is unknown: it is fitted, and differences are parameters.
    assert_eq!(diagnosis["nominal_source"], "fit", "{short}");
    assert_eq!(diagnosis["effects"], serde_json::json!([]), "{short}");
    assert!(short.contains("parameters differ"), "{short}");
    let causes = diagnosis["causes"].as_array().expect("causes");
    for cause in causes {
        let inclusion = cause["inclusion"].as_f64().expect("a number");
        assert!((0.0..=1.0).contains(&inclusion), "{cause}");
    }
    let sets = diagnosis["sets"].as_array().expect("sets");
    let probabilities = sets.iter().filter_map(|set| set["probability"].as_f64());
    assert!((probabilities.sum::<f64>() - 1.0).abs() < 1e-6);
    assert!(
        answer(&lab, "3.1")
            .to_string()
            .contains("No recording at TS\u{a0}=\u{a0}0.003\u{a0}s")
    );
    let page = std::fs::read_to_string(folder.join("plain/index.html")).expect("the page");
    assert!(!page.contains("<b>") && !page.contains("No recording was given"));
    let first = causes[0]["effect"].as_str().expect("an id");
    assert!(page.contains("Causes of the gap") && page.contains(first));
    // (Kt V / R - Tf) / (b + Kt Kb / R) with the bench's friction: the recorded value, to one count in its mean.
    let steady = &lab["part_3"][0]["steady"];
    let value = |key: &str| steady[key].as_f64().expect("a number");
    let expected = (0.315 - 0.08) / 0.059;
    assert!((value("speed_rad_s") - expected).abs() <= value("one_count_rad_s"));

    let told = run(
        folder,
        &["lab", "--motor", "bench.toml", "--run", name, "-o", "told"],
    );
    assert_eq!(told.status, Some(0), "{}", told.messages);
    let lab = json(&folder.join("told/lab.json"));
    let short = answer(&lab, "3.a")["short"].as_str().expect("text");
    assert!(
        short.starts_with("Nothing that these recordings show"),
        "{short}"
    );
    assert_eq!(lab["effects"][0], "coulomb_friction");
    assert_eq!(lab["missing"]["diagnosed"]["verdict"], "no_gap");

    let hurried = run(
        folder,
        &["lab", "--run", name, "--no-diagnosis", "-o", "hurried"],
    );
    assert_eq!(hurried.status, Some(0), "{}", hurried.messages);
    let lab = json(&folder.join("hurried/lab.json"));
    assert!(lab["missing"]["undiagnosed"].is_string());
    assert!(answer(&lab, "3.a").to_string().contains("No diagnosis"));
}

/// Fatal findings come first, and replace the answers that need the recording.
#[test]
fn an_unusable_recording_gives_no_answer() {
    let directory = tempfile::tempdir().expect("a folder");
    let folder = directory.path();
    for (profile, name) in [("rest", "rest.csv"), ("reversing", "turned.csv")] {
        let arguments = [
            "capture",
            "virtual:?speed=max",
            "--ts",
            "0.01",
            "--profile",
            profile,
            "--duration",
            "6",
            "-o",
            name,
        ];
        run(folder, &arguments);
    }
    let text = std::fs::read_to_string(folder.join("turned.csv")).expect("a run");
    std::fs::write(folder.join("turned.csv"), reversed(&text)).expect("written");
    for (name, why) in [
        ("rest.csv", "the command is 0 throughout"),
        ("turned.csv", "are swapped"),
    ] {
        let done = run(folder, &["lab", "--run", name, "-o", "lab"]);
        assert_eq!(done.status, Some(1), "{}", done.messages);
        assert!(done.messages.contains(why), "{}", done.messages);
        assert!(!done.messages.contains("mapping") || name == "rest.csv");
        let lab = json(&folder.join("lab/lab.json"));
        assert_eq!(lab["findings"][0]["severity"], "fatal");
        for number in ["1.3", "3.2", "3.a"] {
            let short = answer(&lab, number)["short"].as_str().expect("text");
            assert!(short.starts_with("Not usable before"), "{short}");
            let said = format!("{name} is not usable: ");
            assert!(short.contains(&said) && short.contains(why), "{short}");
            assert!(done.output.contains(short), "{}", done.output);
        }
        let page = std::fs::read_to_string(folder.join("lab/index.html")).expect("the page");
        let at = |what: &str| page.find(what).unwrap_or_else(|| panic!("no {what}"));
        assert!(at(why) < at("class=\"lead\"") && at(why) < at("<th>question</th>"));
    }
    // With a usable one in addition, the answers are for that.
    let runs = [
        "lab",
        "--run",
        "rest.csv",
        "--run",
        "sound.csv",
        "-o",
        "lab",
    ];
    let step = ["simulate", "--ts", "0.03", "--duration", "1.8"];
    run(folder, &[&step[..], &["-o", "sound.csv"]].concat());
    let done = run(folder, &runs);
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let lab = json(&folder.join("lab/lab.json"));
    let short = answer(&lab, "1.3")["short"].as_str().expect("text");
    assert!(short.starts_with("Yes: every recording"), "{short}");
    assert!(short.contains("rest.csv is not usable"), "{short}");
}

#[test]
fn a_file_that_is_no_run_is_bad_input() {
    let directory = tempfile::tempdir().expect("a folder");
    std::fs::write(directory.path().join("run.csv"), "t_s,command_v\n0,0\n").expect("a file");
    for arguments in [["lab", "--run", "run.csv"], ["lab", "--run", "none.csv"]] {
        let finished = run(directory.path(), &arguments);
        assert_eq!(finished.status, Some(2), "{}", finished.messages);
        assert!(finished.messages.contains(arguments[2]));
    }
}

#[test]
fn a_motor_without_viscous_damping_is_worked_through() {
    let directory = tempfile::tempdir().expect("a folder");
    let undamped = "back_emf_v_s_per_rad = 0\nviscous_friction_nm_s_per_rad = 0\n";
    std::fs::write(directory.path().join("motor.toml"), undamped).expect("a motor file");
    let finished = run(directory.path(), &["lab", "--motor", "motor.toml"]);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let lab = json(&directory.path().join("lab/lab.json"));
    let short = answer(&lab, "1.2")["short"].as_str().expect("text");
    assert!(short.starts_with("The dominant damping is Coulomb friction"));
    assert!(lab["missing"]["diagnosed"]["sentence"].is_string());
}

/// The text of answer 3.a agrees with the verdict of the diagnosis beside it.
#[test]
fn the_answer_agrees_with_the_diagnosis() {
    let directory = tempfile::tempdir().expect("a folder");
    let folder = directory.path();
    let mut seen = Vec::new();
    for board in [
        "",
        "effect=voltage_drop&drop_v=0.8",
        "effect=coulomb_friction&torque_nm=0.05",
        "effect=backlash",
        "inertia_kg_m2=0.0024",
    ] {
        let done = run(folder, &["lab", "--board", board, "-o", "lab"]);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let lab = json(&folder.join("lab/lab.json"));
        let verdict = lab["missing"]["diagnosed"]["verdict"]
            .as_str()
            .expect("a verdict");
        let diagnosis = &lab["missing"]["diagnosed"];
        let probability = diagnosis["probability"].as_f64().expect("a number");
        let [step, short] =
            ["1.3", "3.a"].map(|number| answer(&lab, number)["short"].as_str().expect("text"));
        let begins = match verdict {
            "no_gap" => "Nothing",
            "parameters" if probability < 0.9 => "Probably no effect is missing",
            "parameters" => "No effect is missing",
            "ambiguous" => "These recordings do not settle it",
            "outside_catalogue" => "Something that no effect of the catalogue explains",
            _ => "This is missing",
        };
        assert!(short.starts_with(begins), "{board}: {verdict}: {short}");
        // The verdict's probability precedes the diagnosis' sentence.
        let own = short.split("The diagnosis: ").next();
        let stated = motorlab::report::number::probability(probability);
        assert!(own.is_some_and(|own| own.contains(&stated)), "{short}");
        // An accurately simulated step is no "yes" beside a gap; and if two numbers differ, the page explains why.
        assert!(!step.starts_with("Yes") || verdict == "no_gap", "{step}");
        assert!(!step.starts_with("No:") || verdict != "no_gap", "{step}");
        assert!(step.contains("over the whole run"), "{step}");
        let page = std::fs::read_to_string(folder.join("lab/index.html")).expect("the page");
        let says_why = |text: &str| text.contains("predicts segments of");
        assert_eq!(says_why(short), verdict != "no_gap", "{short}");
        assert!(says_why(&page));
        seen.push(verdict.to_owned());
    }
    seen.sort();
    seen.dedup();
    assert!(seen.len() >= 2, "one verdict tries little: {seen:?}");
    assert!(seen.contains(&"no_gap".to_owned()), "{seen:?}");
}
