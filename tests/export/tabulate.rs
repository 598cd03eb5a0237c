//! `motorlab tabulate`: many diagnoses as tables, and as the fleet page.

use std::fs;
use std::path::Path;

use crate::support::command::{Finished, run};
use serde_json::{Value, json};

/// A diagnosis as `diagnose --json` writes it, for a motor whose friction is `friction` times the file's.
fn diagnosis(unit: &str, day: u32, friction: f64) -> Value {
    let interval = |value: f64, unit: &str| json!({"value": value, "lo95": value - 0.02, "hi95": value + 0.02, "unit": unit});
    let step = |step: &str, rms: f64, share: f64| json!({"step": step, "rms_counts": rms, "share": share, "lo95": share - 0.01, "hi95": share + 0.01, "alternatives": []});
    json!({
        "shape": "motorlab-diagnosis/3",
        "verdict": "effect",
        "sentence": "Present: \"backlash\", 0.02 rad",
        "probability": 0.93,
        "effects": ["backlash", "cogging"],
        "classes": [],
        "budget": [step("nominal", 9.0, 1.0), step("parameters", 4.0, 0.8), step("backlash", 0.6, 0.15), step("cogging", 0.4, 0.04), step("unexplained", 0.4, 0.01)],
        "unexplained": {"rms_counts": 0.26, "share": 0.01, "lo95": 0.0, "hi95": 0.02, "equivalent_torque_share": 0.003, "regions": []},
        "causes": [
            {"effect": "backlash", "stage": "transmission", "inclusion": 0.98, "at_bound": false,
             "parameters": {"gap_rad": {"value": 0.02, "lo95": 0.019, "hi95": 0.021, "unit": "rad"}}},
            {"effect": "cogging", "stage": "mechanical", "inclusion": 0.93, "at_bound": true, "parameters": {}},
            {"effect": "stribeck", "stage": "mechanical", "inclusion": 0.02, "class": "start", "class_probability": 0.03, "at_bound": false, "parameters": {}}
        ],
        "sets": [
            {"effects": ["backlash", "cogging"], "probability": 0.93, "score": 10.0, "rms_counts": 0.4},
            {"effects": ["backlash"], "probability": 0.05, "score": 7.0, "rms_counts": 0.6},
            {"effects": [], "probability": 0.02, "score": 6.0, "rms_counts": 4.0}
        ],
        "identifiable": {"speed_per_volt": interval(1.2, "rad/s/V"), "time_constant_s": interval(0.04, "s"), "friction_v": interval(0.3, "V")},
        "where": {"stage": "transmission+mechanical", "stage_probabilities": {}, "regions": []},
        "gap": {"metric": "position", "horizon_s": 0.5, "floor": 0.3, "floor_parts": {"rounding": 0.3, "repeats": null, "good_enough": null},
            "travel": 300.0, "before": 9.0, "after_parameters": 4.0, "after_effect": 0.4, "closed": 0.98,
            "closed_lo95": 0.9, "closed_hi95": 1.0, "fitted": {"before": 8.0, "after_parameters": 3.5, "after_effect": 0.35}, "held_out": "segments"},
        "scoring": {"score": "likelihood", "effective_observations": 40.0, "random_load_share": 0.001, "whitened_squares": 1.0},
        "note": "", "data": [], "next_experiment": null, "steps": [], "elapsed_s": 0.5, "nominal_source": "given",
        "base": {"coulomb_friction_nm": interval(friction, ""), "inertia_kg_m2": interval(1.0 + 0.01 * f64::from(day % 3), "")},
        "runs": [{"path": "r.csv", "role": "diagnosed", "unit": unit, "started": format!("2026-03-{day:02}T08:00:00Z"),
            "samples": 500, "sample_time_s": 0.003, "duration_s": 1.5}]
    })
}

/// The same in the earlier shape.
fn earlier(unit: &str, day: u32, friction: f64) -> Value {
    let interval = |value: f64| json!({"value": value, "lo95": value - 0.02, "hi95": value + 0.02, "unit": ""});
    json!({
        "shape": "motorlab-diagnosis/2",
        "verdict": "effect",
        "sentence": "Backlash, \"0.02 rad\", explains it",
        "probability": 0.93,
        "effects": ["backlash"],
        "causes": [
            {"effect": "backlash", "stage": "transmission", "probability": 0.93, "inclusion": 0.95,
             "parameters": {"gap_rad": {"value": 0.02, "lo95": 0.019, "hi95": 0.021, "unit": "rad"}},
             "indistinguishable_from": [], "evidence": {"gain_nats": 12.5, "error_nats": 2.0, "gaining_pieces": 7, "pieces": 8}},
            {"effect": "none", "stage": null, "probability": 0.07, "inclusion": 0.07, "parameters": {}, "indistinguishable_from": ["unknown"]}
        ],
        "where": {"stage": "transmission", "stage_probabilities": {}, "regions": []},
        "gap": {"metric": "position", "horizon_s": 0.5, "floor": 0.3, "floor_parts": {"rounding": 0.3, "repeats": null, "good_enough": null},
            "wander": 0.1, "travel": 300.0, "before": 9.0, "after_parameters": 4.0, "after_effect": 0.4, "closed": 0.98,
            "closed_lo95": 0.9, "closed_hi95": 1.0, "fitted": {"before": 8.0, "after_parameters": 3.5, "after_effect": 0.35}, "held_out": "pieces"},
        "sets": [], "note": "", "data": [], "next_experiment": null, "steps": [], "elapsed_s": 0.5,
        "base": {"coulomb_friction_nm": interval(friction), "inertia_kg_m2": interval(1.0 + 0.01 * f64::from(day % 3))},
        "runs": [{"path": "r.csv", "role": "diagnosed", "unit": unit, "started": format!("2026-03-{day:02}T08:00:00Z"),
            "samples": 500, "sample_time_s": 0.003, "duration_s": 1.5}]
    })
}

fn write(here: &Path, name: &str, document: &Value) {
    fs::write(here.join(name), document.to_string()).expect("written");
}

fn tabulate(here: &Path, words: &str) -> Finished {
    let words: Vec<&str> = words.split_whitespace().collect();
    run(here, &[&["tabulate"], &words[..]].concat())
}

/// The rows of a CSV by the names of its columns.
fn rows(path: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    reader
        .deserialize()
        .map(|row| row.expect("a row"))
        .collect()
}

#[test]
fn each_diagnosis_cause_and_parameter_has_a_row() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    write(here, "a.json", &diagnosis("A17", 1, 1.1));
    let mut bad = diagnosis("A18", 2, 1.0);
    for (key, value) in [
        ("verdict", json!("bad_recording")),
        ("where", Value::Null),
        ("gap", Value::Null),
        ("unexplained", Value::Null),
        ("identifiable", Value::Null),
        ("scoring", Value::Null),
    ] {
        bad[key] = value;
    }
    for key in ["effects", "causes", "sets", "budget"] {
        bad[key] = json!([]);
    }
    for key in ["base", "runs"] {
        bad.as_object_mut().expect("an object").remove(key);
    }
    bad["data"] = json!([{"id": "encoder_reversed", "severity": "fatal"}]);
    write(here, "axis8_2026-04-05.json", &bad);
    let done = tabulate(
        here,
        "a.json axis8_2026-04-05.json -o fleet.csv --causes causes.csv --numbers numbers.csv",
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);

    let fleet = rows(&here.join("fleet.csv"));
    assert_eq!(fleet.len(), 2);
    for (name, cell) in [
        ("document", "a.json"),
        ("unit", "A17"),
        ("started", "2026-03-01T08:00:00Z"),
        ("verdict", "effect"),
        ("probability", "0.93"),
        ("effects", "backlash+cogging"),
        ("stage", "transmission+mechanical"),
        ("sentence", "Present: \"backlash\", 0.02 rad"),
        ("likeliest_cause", "backlash+cogging"),
        ("likeliest_cause_probability", "0.93"),
        ("none_probability", "0.02"),
        ("unknown_probability", ""),
        ("parameters_share", "0.8"),
        ("unexplained_counts", "0.26"),
        ("unexplained_hi95", "0.02"),
        ("equivalent_torque_share", "0.003"),
        ("shape", "motorlab-diagnosis/3"),
        ("before_counts", "9"),
        ("closed_lo95", "0.9"),
        ("fitted_after_effect_counts", "0.35"),
        ("samples", "500"),
        ("duration_s", "1.5"),
    ] {
        assert_eq!(fleet[0][name], cell, "{name}");
    }
    for (name, cell) in [
        ("unit", "axis8"),
        ("started", "2026-04-05"),
        ("verdict", "bad_recording"),
        ("before_counts", ""),
        ("none_probability", ""),
        ("unexplained_share", ""),
        ("fatal_findings", "1"),
        ("finding_ids", "encoder_reversed"),
    ] {
        assert_eq!(fleet[1][name], cell, "{name}");
    }
    let causes = rows(&here.join("causes.csv"));
    let seen: Vec<_> = causes
        .iter()
        .map(|row| (&row["rank"][..], &row["effect"][..], &row["named"][..]))
        .collect();
    let expected = [
        ("1", "backlash", "1"),
        ("2", "cogging", "1"),
        ("3", "stribeck", "0"),
    ];
    assert_eq!(seen, expected);
    for (name, cell) in [
        ("probability", "0.05"),
        ("inclusion", "0.98"),
        ("at_bound", "0"),
        ("removed_share", "0.15"),
        ("class", ""),
        ("gain_nats", ""),
    ] {
        assert_eq!(causes[0][name], cell, "{name}");
    }
    assert_eq!(
        (&causes[2]["class"][..], &causes[2]["removed_share"][..]),
        ("start", "")
    );
    let numbers = rows(&here.join("numbers.csv"));
    let seen: Vec<_> = numbers
        .iter()
        .map(|row| (&row["name"][..], &row["value"][..], &row["si_unit"][..]))
        .collect();
    let expected = [
        ("coulomb_friction_nm", "1.1", ""),
        ("inertia_kg_m2", "1.01", ""),
        ("backlash.gap_rad", "0.02", "rad"),
    ];
    assert_eq!(seen, expected);
    assert_eq!(
        (&numbers[2]["named"][..], &numbers[2]["inclusion"][..]),
        ("1", "0.98")
    );

    // Its own outputs are replaced, others are not.
    assert_eq!(
        tabulate(here, "a.json -o fleet.csv --causes causes.csv").status,
        Some(0)
    );
    fs::write(here.join("mine.csv"), "a,b\n").expect("written");
    let refused = tabulate(here, "a.json -o mine.csv");
    assert_eq!(refused.status, Some(2), "{}", refused.messages);
    assert_eq!(
        fs::read_to_string(here.join("mine.csv")).expect("a file"),
        "a,b\n"
    );
}

/// The second shape is still read: causes with their probabilities, `none` among them, no error budget.
#[test]
fn documents_of_the_earlier_shape_are_tabulated() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    write(here, "a.json", &earlier("A17", 1, 1.1));
    let done = tabulate(
        here,
        "a.json -o fleet.csv --causes causes.csv --numbers numbers.csv",
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let fleet = rows(&here.join("fleet.csv"));
    for (name, cell) in [
        ("effects", "backlash"),
        ("likeliest_cause", "backlash"),
        ("likeliest_cause_probability", "0.93"),
        ("none_probability", "0.07"),
        ("unknown_probability", ""),
        ("wander_counts", "0.1"),
        ("unexplained_share", ""),
        ("shape", "motorlab-diagnosis/2"),
    ] {
        assert_eq!(fleet[0][name], cell, "{name}");
    }
    let causes = rows(&here.join("causes.csv"));
    let seen: Vec<_> = causes
        .iter()
        .map(|row| (&row["rank"][..], &row["effect"][..], &row["named"][..]))
        .collect();
    assert_eq!(seen, [("1", "backlash", "1"), ("2", "none", "0")]);
    assert_eq!(causes[0]["gaining_pieces"], "7");
    assert_eq!(causes[1]["indistinguishable_from"], "unknown");
    let numbers = rows(&here.join("numbers.csv"));
    assert_eq!(numbers[2]["name"], "backlash.gap_rad");
}

#[test]
fn damaged_documents_are_named_and_skipped() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    fs::create_dir(here.join("out")).expect("a folder");
    write(here, "out/a.json", &diagnosis("A17", 1, 1.1));
    let whole = diagnosis("A18", 1, 1.1).to_string();
    fs::write(here.join("out/torn.json"), &whole[..whole.len() / 2]).expect("written");
    fs::write(here.join("out/empty.json"), "").expect("written");
    fs::write(here.join("out/bytes.json"), [0xff, 0xfe, 0x00]).expect("written");
    write(
        here,
        "out/check.json",
        &json!({"shape": "motorlab-check/1", "findings": []}),
    );
    write(
        here,
        "out/failed.json",
        &json!({"error": {"kind": "bad_input", "message": "no such run"}}),
    );
    let mut sure = diagnosis("A19", 1, 1.1);
    sure["probability"] = json!(1.2);
    write(here, "out/sure.json", &sure);
    let done = tabulate(here, "out nowhere.json -o fleet.csv");
    assert_eq!(done.status, Some(1), "{}", done.messages);
    for said in [
        "out/torn.json: is no diagnosis: EOF",
        "out/empty.json: is empty",
        "out/bytes.json: ",
        "out/check.json: its shape is 'motorlab-check/1'",
        "out/failed.json: holds an error, no diagnosis: no such run",
        "out/sure.json: its probability is 1.2",
        "nowhere.json: No such file",
    ] {
        assert!(done.messages.contains(said), "{said}: {}", done.messages);
    }
    assert_eq!(rows(&here.join("fleet.csv")).len(), 1);
    // Without any diagnosis it is wrong use, and nothing is written.
    let none = tabulate(here, "out/torn.json -o none.csv");
    assert_eq!(
        (none.status, here.join("none.csv").exists()),
        (Some(2), false)
    );
    for words in [
        "out -o fleet.xlsx",
        "out -o x.csv --causes x.csv",
        "out",
        "out/a.json -o out/a.json",
    ] {
        assert_eq!(tabulate(here, words).status, Some(2), "{words}");
    }
}

#[test]
fn an_outlier_among_ten_units_and_a_drift_are_found() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    fs::create_dir(here.join("out")).expect("a folder");
    let scatter = |k: u32| 0.03 * f64::from(k * 7 % 5) / 5.0;
    for unit in 0..10 {
        for day in 1..13 {
            let friction = match unit {
                3 => 1.6 + scatter(day),
                // 0.005 a day: 0.15 in 30 days.
                6 => 1.0 + 0.005 * f64::from(day),
                _ => 1.0 + scatter(day + unit),
            };
            let name = format!("out/u{unit}-{day}.json");
            write(here, &name, &diagnosis(&format!("U{unit}"), day, friction));
        }
    }
    write(here, "out/torn.json", &json!({}));
    let done = tabulate(here, "out --html fleet.html");
    assert_eq!(done.status, Some(1), "{}", done.messages);
    let page = fs::read_to_string(here.join("fleet.html")).expect("a page");
    assert!(
        page.contains(
            "120 diagnoses of 10 units. 1 unit stands out. First: U3, coulomb_friction_nm, relative to the motor file. 1 recording is not usable."
        )
    );
    let between = |from: &str, to: &str| {
        let rest = &page[page.find(from).expect(from)..];
        rest[..rest.find(to).expect(to)].to_owned()
    };
    let apart = between("Units that stand out", "Verdicts and identified effects");
    assert!(
        apart.contains("<td>U3</td>") && apart.contains("<td>coulomb_friction_nm"),
        "{apart}"
    );
    assert!(!apart.contains("U4") && !apart.contains("U6"), "{apart}");
    let drift = between("<h2>Drift", "<figure>");
    assert!(drift.contains("<td>U6</td><td>coulomb_friction_nm, relative to the motor file</td><td class=\"number\">0.15</td>"), "{drift}");
    assert!(!drift.contains("U3") && !drift.contains("U5"), "{drift}");
    assert!(page.contains("out/torn.json") && page.contains("SELECT verdict"));
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http") && !addresses.contains("src="));
}

#[test]
fn a_page_of_two_thousand_units_has_five_megabytes_at_most() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    fs::create_dir(here.join("out")).expect("a folder");
    for unit in 0..2000 {
        let friction = 1.0 + 0.1 * f64::from(unit % 101) / 101.0;
        let document = diagnosis(&format!("U{unit}"), 1 + unit % 28, friction);
        write(here, &format!("out/{unit}.json"), &document);
    }
    let done = tabulate(here, "out --html fleet.html");
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let page = fs::read_to_string(here.join("fleet.html")).expect("a page");
    assert!(
        page.contains("2000 diagnoses of 2000 units"),
        "{:.600}",
        page
    );
    assert!(page.len() <= 5_000_000, "{} bytes", page.len());
}

#[cfg(feature = "parquet")]
#[test]
fn parquet_has_the_cells_of_the_csv() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    for k in 0..3 {
        write(
            here,
            &format!("d{k}.json"),
            &diagnosis("A17", 1 + k, 1.0 + f64::from(k)),
        );
    }
    for end in ["csv", "parquet"] {
        let words = format!(
            "d0.json d1.json d2.json -o fleet.{end} --causes causes.{end} --numbers numbers.{end}"
        );
        // The second call replaces the first one's files.
        for _ in 0..2 {
            let done = tabulate(here, &words);
            assert_eq!(done.status, Some(0), "{}", done.messages);
        }
    }
    for name in ["fleet", "causes", "numbers"] {
        let plain = rows(&here.join(format!("{name}.csv")));
        let file = fs::File::open(here.join(format!("{name}.parquet"))).expect("a file");
        let reader = SerializedFileReader::new(file).expect("Parquet");
        let read: Vec<_> = reader.get_row_iter(None).expect("rows").collect();
        assert_eq!(read.len(), plain.len());
        for (row, plain) in read.into_iter().zip(plain) {
            let row = row.expect("a row");
            assert_eq!(row.len(), plain.len());
            for (column, field) in row.get_column_iter() {
                let cell = &plain[column];
                let same = match field {
                    Field::Null => cell.is_empty(),
                    Field::Str(text) => text == cell,
                    Field::Double(number) => Ok(*number) == cell.parse(),
                    Field::Long(number) => Ok(*number) == cell.parse(),
                    other => panic!("{column} is {other}"),
                };
                assert!(same, "{column}: {field} {cell}");
            }
        }
    }
}

/// A unit with the fault in five of five recordings is first, before one whose friction is outlying in the median;
/// each recording is linked to its page.
#[test]
fn a_fault_in_every_recording_of_a_unit_is_listed_first() {
    let keep = tempfile::tempdir().expect("a folder");
    let here = keep.path();
    fs::create_dir(here.join("out")).expect("a folder");
    for unit in 0..8 {
        for day in 1..6 {
            let name = format!("axis{unit}");
            let friction = match unit {
                2 => 3.0,
                _ => 1.0 + 0.01 * f64::from(unit) + 0.001 * f64::from(day),
            };
            let mut one = diagnosis(&name, day, friction);
            let has_fault = unit == 5 || (unit == 7 && day == 1);
            one["effects"] = if has_fault {
                json!(["backlash"])
            } else {
                json!([])
            };
            if !has_fault {
                one["verdict"] = json!("parameters");
            }
            write(here, &format!("out/{name}_{day} #.json"), &one);
            fs::write(here.join(format!("out/{name}_{day} #.html")), "").expect("written");
        }
    }
    let done = tabulate(here, "out -o fleet.csv --html fleet.html");
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let page = fs::read_to_string(here.join("fleet.html")).expect("a page");
    assert!(page.contains("First: axis5, backlash in 5 of 5 recordings."));
    let rows = page.split("Units that stand out").nth(1).expect("a table");
    let at = |text: &str| rows.find(text).unwrap_or_else(|| panic!("no {text}"));
    assert!(at("<td>axis5</td><td>backlash in 5 of 5 recordings</td>") < at("<td>axis2</td>"));
    // One in five is no recurrence.
    assert!(!page.contains("backlash in 1 of 5"));
    assert!(rows.contains("<a href=\"./out/axis5_1%20%23.html\">2026-03-01</a>"));
    assert_eq!(page.matches("<a href=\"./out/").count(), 2 * 5 + 8 * 5);
    // The axis of a figure has the names of the units.
    assert!(page.contains("text-anchor=\"end\">axis5</text>"));

    // The same from fits without a motor file: parameters that need no resistance, and torques in V.
    for unit in 0..8 {
        for day in 1..6 {
            let mut one = diagnosis(&format!("axis{unit}"), day, 1.0);
            one["nominal_source"] = json!("fit");
            one["effects"] = json!(["cogging"]);
            one["causes"][1]["parameters"] = json!({"torque_nm": {"value": 0.001, "lo95": 0.0009, "hi95": 0.0011, "unit": "N m",
                "in_command": {"value": 0.5, "lo95": 0.4, "hi95": 0.6, "unit": "V"}}});
            write(here, &format!("out/axis{unit}_{day} #.json"), &one);
        }
    }
    let done = tabulate(
        here,
        "out -o fleet.csv --numbers numbers.csv --html fleet.html",
    );
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let page = fs::read_to_string(here.join("fleet.html")).expect("a page");
    assert!(
        !page.contains("(N m") && !page.contains("coulomb_friction_nm (") && !page.contains("kg m")
    );
    assert!(page.contains("speed_per_volt (rad/s/V)") && page.contains("cogging.torque (V)"));
    let numbers = rows_of(&here.join("numbers.csv"), "cogging.torque");
    assert!(
        numbers
            .iter()
            .all(|row| row["value"] == "0.5" && row["si_unit"] == "V")
    );
}

fn rows_of(path: &Path, name: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut all = rows(path);
    all.retain(|row| row["name"] == name);
    assert!(!all.is_empty(), "no {name}");
    all
}
