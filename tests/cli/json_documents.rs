//! Every document of `--json` against the JSON Schema that `motorlab schema` prints for it.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::support::command::{Finished, motorlab, run, start};
use crate::support::json_schema::faults;
use serde_json::{Value, json};

fn schema(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/json/{name}.json"));
    let text =
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).expect("a schema is JSON")
}

/// The document satisfies its schema, and corrupted copies of it do not.
fn fits(name: &str, document: &Value) {
    let schema = schema(name);
    assert_eq!(faults(&schema, document), [""; 0], "{name}");
    let Some(object) = document.as_object() else {
        return;
    };
    let spoilt = |key: &str, value: Option<Value>| {
        let mut spoilt = object.clone();
        spoilt.remove(key);
        spoilt.extend(value.map(|value| (key.to_owned(), value)));
        faults(&schema, &Value::Object(spoilt))
    };
    assert_eq!(
        spoilt("surprise", Some(json!(1))).len(),
        1,
        "{name}: a key that nobody knows"
    );
    for key in object.keys() {
        assert!(
            !spoilt(key, Some(json!([[[]]]))).is_empty(),
            "{name}: any {key} will do"
        );
    }
}

fn document(finished: &Finished) -> Value {
    serde_json::from_str(&finished.output).unwrap_or_else(|error| panic!("{error}: {finished:?}"))
}

/// Runs the words with `--json` in a folder; checks the document and returns it.
fn prints(here: &Path, name: &str, words: &str) -> Value {
    let mut words: Vec<&str> = words.split_whitespace().collect();
    words.push("--json");
    let finished = run(here, &words);
    let document = document(&finished);
    fits(name, &document);
    document
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn fixture(name: &str) -> String {
    format!("{}/fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn every_schema_is_listed_and_printed_unchanged() {
    let keep = folder();
    let listed = prints(keep.path(), "schemas", "schema");
    let listed = listed["documents"].as_array().expect("a list").iter();
    let names: BTreeSet<String> = listed
        .map(|entry| entry["name"].as_str().expect("a name").to_owned())
        .collect();
    let files =
        fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/json")).expect("a folder");
    let files = files.map(|file| file.expect("a file").path());
    let files = files.filter(|file| file.extension().is_some_and(|end| end == "json"));
    let files: BTreeSet<String> = files
        .map(|file| {
            file.file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    assert_eq!(names, files);
    for name in names {
        let printed = run(keep.path(), &["schema", &name]);
        assert_eq!(document(&printed), schema(&name), "{name}");
    }
    let wrong = run(keep.path(), &["schema", "diagnose"]);
    assert_eq!(wrong.status, Some(2));
    assert!(
        wrong.messages.contains("did you mean 'diagnosis'?"),
        "{}",
        wrong.messages
    );
}

#[test]
fn every_key_is_described_and_its_unit_is_stated_in_words() {
    /// Endings of names, with what a description has to contain.
    const UNITS: [(&str, &str); 9] = [
        ("_s", " s"),
        ("_rad", "rad"),
        ("_rad_s", "rad/s"),
        ("_v", "V"),
        ("_a", "A"),
        ("_rpm", "RPM"),
        ("_counts", "counts"),
        ("_nats", "nats"),
        ("_us", "microseconds"),
    ];
    fn look(name: &str, schema: &Value) {
        for (key, says) in schema["properties"].as_object().into_iter().flatten() {
            let said = says["description"].as_str().unwrap_or_default();
            let is_said =
                !said.is_empty() || says.get("$ref").is_some() || says.get("const").is_some();
            assert!(is_said, "{name}: {key} is not described");
            let unit = UNITS
                .iter()
                .filter(|(end, _)| key.ends_with(end))
                .max_by_key(|(end, _)| end.len());
            if let Some((_, unit)) =
                unit.filter(|_| says["type"] != "object" && says["type"] != "string")
            {
                let of_type = schema["description"].as_str().unwrap_or_default();
                let said = format!(" {said} {of_type}").replace(" seconds", " s");
                assert!(
                    said.contains(unit),
                    "{name}: the unit of {key} is not in '{said}'"
                );
            }
        }
        for inner in schema
            .as_object()
            .into_iter()
            .flatten()
            .map(|(_, inner)| inner)
        {
            look(name, inner);
        }
        for inner in schema.as_array().into_iter().flatten() {
            look(name, inner);
        }
    }
    let keep = folder();
    for entry in prints(keep.path(), "schemas", "schema")["documents"]
        .as_array()
        .expect("a list")
    {
        let name = entry["name"].as_str().expect("a name");
        look(name, &schema(name));
    }
}

#[test]
fn simulate_check_compare_and_export_print_documents() {
    let keep = folder();
    let here = keep.path();
    fs::write(
        here.join("short.toml"),
        "resistance_ohm = 8.0\nresistance_assumed = true\n[effects.missed_counts]\n[effects.backlash]\ngap_rad = 0.01\n",
    )
    .expect("a file");
    let simulated = prints(
        here,
        "simulation",
        "simulate --duration 1 --motor short.toml -o run.csv",
    );
    assert!(
        simulated["handout_values"].is_object(),
        "the motor file lacks numbers"
    );
    prints(here, "simulation", "simulate --duration 0.05 -o short.csv");
    assert_eq!(
        prints(here, "check", "check short.csv")["findings"][0]["severity"],
        "fatal"
    );
    prints(here, "comparison", "compare run.csv --motor short.toml");
    prints(here, "motor", "motor short.toml");
    prints(here, "effects", "effects");
    prints(here, "explanation", "explain backlash");
    prints(here, "isolability", "design --duration 0.5 --ts 0.03");
    prints(here, "export-json", "export json --motor short.toml");
    prints(
        here,
        "export",
        "export json --motor short.toml -o motor.json",
    );
    prints(here, "export", "export mujoco");
    prints(here, "export", "export c --motor short.toml");
    prints(here, "ports", "ports");
    prints(here, "names", "names");
    prints(here, "names", "names effects");
    fs::create_dir_all(here.join("monday/one")).expect("a folder");
    fs::create_dir_all(here.join("monday/two")).expect("a folder");
    fs::copy(here.join("run.csv"), here.join("monday/one/run.csv")).expect("copied");
    let class = prints(here, "class", "lab --class monday -o page");
    assert!(class["students"][0]["together"].is_object(), "{class}");
    assert!(class["students"][1]["problem"].is_string(), "{class}");
    prints(here, "firmware", "firmware sketch");
    let lab = prints(here, "lab", "lab --run run.csv --no-diagnosis");
    assert!(
        lab["answers"]
            .as_array()
            .is_some_and(|answers| answers.len() > 5)
    );
    for words in [
        "check nowhere.csv",
        "compare run.csv --motr x",
        "export urdf -o run.csv",
        "design --profile wavy",
    ] {
        let error = prints(here, "error", words);
        assert!(error["error"]["message"].is_string(), "{words}");
    }
}

#[test]
fn capture_and_import_print_documents() {
    let keep = folder();
    let here = keep.path();
    let log = fixture("faults.log");
    let replayed = prints(here, "capture", &format!("replay {log} -o faults.csv"));
    assert!(
        replayed["lost"].as_u64() > Some(0),
        "a log with losses: {replayed}"
    );
    prints(
        here,
        "capture",
        "capture virtual:?speed=max --duration 0.5 -o run.csv",
    );
    prints(here, "demo", "demo --board speed=max");
    let known = prints(
        here,
        "until-known",
        "capture virtual:?speed=max --until-known 1 --duration 2 --ts 0.03 -o loop.csv",
    );
    assert_eq!(known["rounds"].as_array().map(Vec::len), Some(1), "{known}");
    let text = "time_ms,volts,counts\n0,0,0\n10,2,1\n20,2,5\n20,2,x\n30,2,11\n40,2,18\n50,2,26\n60,2,34\n70,2,42\n80,2,50\n90,2,58\n";
    fs::write(here.join("log.csv"), text).expect("a file");
    let imported = prints(
        here,
        "import",
        "import log.csv --counts-per-rev 720 --supply 4.5",
    );
    assert_eq!(imported["bad_rows"], 1, "{imported}");
    // The port of a board that runs until it is stopped.
    let mut board = start(here, &["virtual", "virtual:?speed=max", "--json"]);
    let mut text = String::new();
    let mut output = board.stdout.take().expect("a pipe");
    while serde_json::from_str::<Value>(&text).is_err() {
        let mut byte = [0];
        output.read_exact(&mut byte).expect("a document");
        text.push(char::from(byte[0]));
    }
    board.kill().and_then(|()| board.wait()).expect("stopped");
    fits("port", &serde_json::from_str(&text).expect("a document"));
}

#[test]
fn flash_prints_documents() {
    let keep = folder();
    let tool = keep.path().join("avrdude");
    fs::write(&tool, "#!/bin/sh\nexit 0\n").expect("a script");
    fs::set_permissions(&tool, fs::Permissions::from_mode(0o755)).expect("executable");
    fs::write(keep.path().join("x.hex"), "").expect("a file");
    let words = [
        "flash",
        "/dev/null",
        "--hex",
        "x.hex",
        "--board",
        "uno",
        "--json",
    ];
    let output = motorlab(keep.path(), &words)
        .env("PATH", keep.path())
        .output();
    let finished = Finished::from(output.expect("the command starts"));
    fits("flash", &document(&finished));
}

#[test]
fn diagnose_and_tabulate_print_documents() {
    let keep = folder();
    let here = keep.path();
    fs::write(
        here.join("heavy.toml"),
        "[effects.inertia]\ninertia_kg_m2 = 0.004\n",
    )
    .expect("a file");
    for (name, motor) in [("now.csv", " --motor heavy.toml"), ("then.csv", "")] {
        let words = format!("simulate --profile reversing --duration 2 --ts 0.01 -o {name}{motor}");
        prints(here, "simulation", &words);
    }
    prints(here, "simulation", "simulate --duration 0.02 -o bad.csv");
    fs::create_dir(here.join("out")).expect("a folder");
    for (name, words) in [
        ("heavy_2026-03-01", "diagnose now.csv"),
        (
            "changed",
            "diagnose now.csv --reference then.csv --hold-out then.csv",
        ),
        ("bad", "diagnose bad.csv"),
    ] {
        let diagnosis = prints(here, "diagnosis", words);
        assert_eq!(diagnosis["runs"][0]["role"], "diagnosed");
        let path = here.join(format!("out/{name}.json"));
        fs::write(path, diagnosis.to_string()).expect("written");
    }
    prints(
        here,
        "next-experiment",
        "design --diagnosis out/heavy_2026-03-01.json",
    );
    let table = prints(here, "table", "tabulate out -o fleet.csv");
    assert_eq!(table["diagnoses"], 3);
    fs::write(here.join("out/broken.json"), "{\"shape\": ").expect("written");
    assert_eq!(
        prints(here, "table", "tabulate out -o fleet.csv")["skipped"][0]["document"],
        "out/broken.json"
    );
}

#[test]
fn blind_commands_print_documents() {
    let keep = folder();
    let here = keep.path();
    let answer = r#"{"verdict": "effect", "effects": ["inertia"], "elapsed_s": 0.1,
        "gap": {"closed": 0.9, "closed_lo95": 0.5, "closed_hi95": 1.01},
        "causes": [{"effect": "inertia", "probability": 0.9}, {"effect": "none", "probability": 0.1}]}"#;
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = --version ] && {{ echo 'fixed 1'; exit; }}\ncat <<'END'\n{answer}\nEND\n"
    );
    fs::write(here.join("fixed"), script).expect("a script");
    fs::set_permissions(here.join("fixed"), fs::Permissions::from_mode(0o755)).expect("executable");
    prints(here, "simulation", "simulate -o mine.csv");
    // `make` prints the same for simulated cases, which takes seconds.
    for label in ["inertia", "none", "outside:felt"] {
        let words = format!("blind seal mine.csv --label {label} --into set");
        prints(here, "blind-sealed", &words);
    }
    prints(here, "blind-run", "blind run set --diagnoser ./fixed");
    let score = prints(
        here,
        "blind-score",
        "blind score set --labels set.labels.json",
    );
    assert_eq!(score["cases"].as_array().map(Vec::len), Some(3));
}
