//! `motorlab blind` from the command line, with a diagnoser that records what it can access.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::support::command::run;
use serde_json::Value;

/// A motor of twice the handout's inertia, with which the runs are simulated.
const HEAVY: &str = "inertia_kg_m2 = 0.004\n";

/// A diagnoser: writes down all that it can access, answers "inertia", and writes the prepared motor file.
fn spy(directory: &Path) {
    let notes = directory.join("notes.txt");
    let answer = r#"{"verdict": "effect", "effects": ["inertia"], "elapsed_s": 0.1,
        "gap": {"closed": 0.9, "closed_lo95": 0.5, "closed_hi95": 1.01},
        "causes": [{"effect": "inertia", "probability": 0.9}, {"effect": "none", "probability": 0.1}]}"#;
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = --version ] && {{ echo 'spy 3'; exit; }}\n\
         {{ echo \"arguments: $*\"; pwd; env; ls; cat ./*; }} >> '{}'\n\
         echo '{HEAVY}' > diagnosed.toml\ncat <<'END'\n{answer}\nEND\n",
        notes.display()
    );
    let path = directory.join("spy");
    fs::write(&path, script).expect("written");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("executable");
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("one JSON document")
}

#[test]
fn prepared_recordings_are_sealed_judged_and_scored() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    spy(here);
    fs::create_dir(here.join("away")).expect("created");
    fs::write(here.join("heavy.toml"), HEAVY).expect("written");
    fs::write(here.join("nominal.toml"), "").expect("written");
    for (name, profile) in [("one.csv", "step"), ("two.csv", "reversing")] {
        let motor = ["--motor", "heavy.toml", "--profile", profile, "-o", name];
        let done = run(here, &[&["simulate"], &motor[..]].concat());
        assert_eq!(done.status, Some(0), "{}", done.messages);
    }
    let seal = |label: &str| {
        let arguments = "blind seal one.csv --unseen two.csv --motor nominal.toml --into set \
                         --labels away/labels.json --label";
        let mut words: Vec<&str> = arguments.split_whitespace().collect();
        words.push(label);
        run(here, &words)
    };
    assert_eq!(seal("inertai").status, Some(2));
    assert_eq!(seal("inertia").status, Some(0));
    assert_eq!(seal("outside:wet felt").status, Some(0));

    let judged = run(
        here,
        &["blind", "run", "set", "--diagnoser", "./spy", "--json"],
    );
    assert_eq!(judged.status, Some(0), "{}", judged.messages);
    let judged = json(&judged.output);
    assert_eq!(judged["verdicts"], 2);
    let head = judged["head"].as_str().expect("a hash");

    // Its view: copies of the run and the motor, and no path to the set or the labels.
    let notes = fs::read_to_string(here.join("notes.txt")).expect("it was called");
    assert!(notes.contains(
        "arguments: diagnose run1.csv --motor motor.toml --model-out diagnosed.toml --json\n"
    ));
    let place = here.join("set").display().to_string();
    for hidden in [
        place.as_str(),
        "away",
        "labels",
        "manifest",
        "unseen",
        "wet felt",
        "commitment",
    ] {
        assert!(!notes.contains(hidden), "it can see '{hidden}':\n{notes}");
    }
    assert!(notes.contains("\nmotor.toml\nrun1.csv\n"), "{notes}");

    let arguments = [
        "blind",
        "score",
        "set",
        "--labels",
        "away/labels.json",
        "--json",
    ];
    let wrong = run(here, &[&arguments[..], &["--head", "start"]].concat());
    assert_eq!(wrong.status, Some(2));
    assert!(wrong.messages.contains("refused"), "{}", wrong.messages);
    let more = ["--head", head, "--html", "score.html"];
    let scored = run(here, &[&arguments[..], &more].concat());
    assert_eq!(scored.status, Some(0), "{}", scored.messages);
    let score = json(&scored.output);
    assert_eq!(score["shape"], "motorlab-blind-score/1");
    assert_eq!(score["singles"]["named"]["hits"], 1);
    assert_eq!(score["outside"]["taken_for_an_effect"]["hits"], 1);
    let diagnoser = score["set"]["diagnosers"][0].as_str().expect("a name");
    assert!(diagnoser.starts_with("spy 3 (sha256 "), "{diagnoser}");

    // The motor file that it wrote is the truth: on the held-out run all of the gap except quantization is removed.
    let gap = &score["cases"][0]["gap"];
    assert!(gap["before_counts"].as_f64() > Some(2.0), "{gap}");
    assert!(gap["after_counts"].as_f64() < Some(0.32), "{gap}");
    let closed = gap["unseen"].as_f64().expect("a share");
    assert!((closed - 1.0).abs() < 0.02, "{gap}");
    assert!(here.join("score.html").exists());
    let text = run(here, &arguments[..arguments.len() - 1]);
    assert!(
        text.output
            .contains("case-0002: outside:wet felt. Said: inertia (0.900)")
    );
}

#[test]
fn sealing_needs_no_more_than_runs_and_a_label() {
    let keep = tempfile::tempdir().expect("a directory");
    let done = run(keep.path(), &["simulate", "-o", "run.csv"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let seal = ["blind", "seal", "run.csv", "--label", "stribeck"];
    let done = run(keep.path(), &seal);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let sealed = keep.path().join("sealed/case-0001");
    let motor = fs::read_to_string(sealed.join("motor.toml")).expect("the handout's motor");
    assert_eq!(
        motorlab::motor::Motor::from_toml(&motor).expect("a motor file"),
        motorlab::motor::Motor::default()
    );
    let labels = fs::read_to_string(keep.path().join("sealed.labels.json")).expect("labels");
    assert!(labels.contains("stribeck"));
}

#[test]
fn generated_cases_are_reproduced_from_their_seed_and_do_not_contain_it() {
    let keep = tempfile::tempdir().expect("a directory");
    let make = |name: &str| {
        let fixed = [
            "blind", "make", "--cases", "1", "--kind", "none", "--seed", "4217",
        ];
        let done = run(keep.path(), &[&fixed[..], &[name]].concat());
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let manifest = fs::read_to_string(keep.path().join(name).join("manifest.json"));
        let manifest = manifest.expect("a manifest");
        let labels = fs::read_to_string(keep.path().join(format!("{name}.labels.json")));
        assert!(!manifest.contains("4217") && labels.expect("labels").contains("4217"));
        json(&manifest)["cases"][0].clone()
    };
    let (one, two) = (make("one"), make("two"));
    assert_eq!(one["sha256"], two["sha256"]);
    // Salts are random: the commitments to equal labels differ.
    assert_ne!(one["commitment"], two["commitment"]);
    let again = run(keep.path(), &["blind", "make", "one"]);
    assert_eq!(again.status, Some(2));
}

#[test]
fn the_score_has_the_random_load_of_each_bench_and_whether_one_step_is_recorded() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    spy(here);
    let command = |words: &str| {
        let done = run(here, &words.split(' ').collect::<Vec<_>>());
        assert_eq!(done.status, Some(0), "{}", done.messages);
        json(&done.output)
    };
    command("blind make --breadth --cases 4 --seed 7 set --labels labels.json --json");
    command("blind run set --diagnoser ./spy --json");
    let score = command("blind score set --labels labels.json --json");
    // As the generator draws them: one reversing recording under a random load, one step, random levels, chirps.
    let drawn = [
        (0.005_035_18, false),
        (0.0, true),
        (0.0, false),
        (0.0, false),
    ];
    let cases = score["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), drawn.len());
    for (case, (share, one_step)) in cases.iter().zip(drawn) {
        let found = case["truth"]["random_load_share"]
            .as_f64()
            .expect("a share");
        assert!((found - share).abs() < 1e-8, "{found}, expected {share}");
        assert_eq!(case["truth"]["one_step"], one_step);
    }
}

#[test]
fn a_diagnosers_version_call_gets_no_case_and_is_read_up_to_one_line() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    let made = ["blind", "make", "--cases", "1", "--seed", "3", "set"];
    assert_eq!(run(here, &made).status, Some(0));
    let seen = here.join("seen.txt");
    let script = format!(
        "#!/bin/sh\nif [ \"$1\" = --version ]; then {{ pwd; env; ls -A; }} > '{}'; yes | tr -d '\\n'; fi\necho no >&2; exit 4\n",
        seen.display()
    );
    let path = here.join("endless");
    fs::write(&path, script).expect("written");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("executable");
    let judged = run(here, &["blind", "run", "set", "--diagnoser", "./endless"]);
    assert_eq!(judged.status, Some(1), "{}", judged.messages);
    let seen = fs::read_to_string(seen).expect("it was called");
    assert!(
        !seen.contains("manifest") && !seen.contains("labels.json"),
        "{seen}"
    );
    assert!(!seen.contains(&format!("PWD={}", here.display())), "{seen}");
    let verdict = fs::read_to_string(here.join("set/verdicts/case-001.json"));
    let verdict = verdict.unwrap_or_else(|_| {
        let files = fs::read_dir(here.join("set/verdicts")).expect("a folder");
        let first = files.flatten().next().expect("a verdict").path();
        fs::read_to_string(first).expect("text")
    });
    let verdict = json(&verdict);
    assert!(
        verdict["diagnoser"]
            .as_str()
            .is_some_and(|name| name.len() < 300)
    );
    assert!(
        verdict["failure"]
            .as_str()
            .is_some_and(|why| why.contains("no"))
    );
}

#[test]
fn without_the_chain_head_the_order_is_not_proved_and_markdown_is_text() {
    let keep = tempfile::tempdir().expect("a directory");
    let here = keep.path();
    spy(here);
    fs::write(here.join("heavy.toml"), HEAVY).expect("written");
    let simulate = ["simulate", "--motor", "heavy.toml", "-o", "one.csv"];
    assert_eq!(run(here, &simulate).status, Some(0));
    let label = "outside:a|b <img src=x> [link](http://x)";
    let seal = [
        "blind",
        "seal",
        "one.csv",
        "--into",
        "set",
        "--labels",
        "labels.json",
        "--label",
        label,
    ];
    assert_eq!(run(here, &seal).status, Some(0));
    let judged = run(
        here,
        &["blind", "run", "set", "--diagnoser", "./spy", "--json"],
    );
    let head = json(&judged.output)["head"]
        .as_str()
        .expect("a hash")
        .to_owned();
    let score = [
        "blind",
        "score",
        "set",
        "--labels",
        "labels.json",
        "--json",
        "--markdown",
        "score.md",
    ];
    let unproved = run(here, &score);
    assert!(unproved.messages.contains("the order is not proved"));
    assert_eq!(json(&unproved.output)["set"]["order_proved"], false);
    let markdown = fs::read_to_string(here.join("score.md")).expect("written");
    assert!(markdown.contains("the order is not proved"), "{markdown}");
    let as_text = r"a\|b \<img src=x\> \[link\](http://x)";
    assert!(markdown.contains(as_text), "{markdown}");
    let said = markdown.split("<!-- written by").next().expect("a text");
    let marks: Vec<&str> = said.split(['<', '[']).collect();
    assert!(
        marks[..marks.len() - 1]
            .iter()
            .all(|before| before.ends_with('\\')),
        "{markdown}"
    );
    let proved = run(here, &[&score[..], &["--head", &head]].concat());
    assert_eq!(json(&proved.output)["set"]["order_proved"], true);
    let markdown = fs::read_to_string(here.join("score.md")).expect("written");
    assert!(!markdown.contains("the order is not proved"), "{markdown}");
}
