//! Sealed cases: refusals, the diagnoser's view, and continuation of a stopped run.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use motorlab::blind::{
    BlindError, Diagnoser, Labels, Ledger, Manifest, NewCase, Truth, Verdict, add_cases,
    commitment, open, run,
};
use motorlab::hint::parted;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

const MOTOR: &str = "resistance_ohm = 10.0\n";

fn case(label: &str) -> NewCase {
    NewCase {
        runs: vec!["# a run\n".to_owned(), "# another\n".to_owned()],
        motor: MOTOR.to_owned(),
        unseen: Some("# held out\n".to_owned()),
        truth: Truth::from_words(label).expect("a label of the catalogue"),
    }
}

/// A set of three cases in a temporary directory, with its labels beside it.
struct Set {
    _keep: tempfile::TempDir,
    directory: PathBuf,
    labels: PathBuf,
}

impl Set {
    fn new() -> Self {
        let keep = tempfile::tempdir().expect("a directory");
        let set = Self {
            directory: keep.path().join("set"),
            labels: keep.path().join("labels.json"),
            _keep: keep,
        };
        let cases = ["stribeck", "none", "backlash+voltage_drop"].map(case);
        add_cases(&set.directory, &set.labels, None, cases).expect("sealed");
        set
    }

    fn run(&self) -> Ledger {
        let stub = Stub::default();
        run(&self.directory, &stub, 2, &AtomicBool::new(false), &|_| ()).expect("judged")
    }

    fn open(&self) -> Result<(), BlindError> {
        open(&self.directory, &self.labels, None).map(|_| ())
    }

    /// The reason of a refused opening.
    fn refusal(&self) -> String {
        match self.open() {
            Err(BlindError::Refused(why)) => {
                let why = why.to_string();
                let (what, hint) = parted(&why);
                assert!(hint.is_some(), "{why}");
                what.to_owned()
            }
            other => panic!("expected a refusal, got {other:?}"),
        }
    }

    fn change(&self, file: &Path, change: impl Fn(&mut Value)) {
        let path = self.directory.join(file);
        let mut document = read(&path);
        change(&mut document);
        fs::write(path, document.to_string()).expect("written");
    }
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("there")).expect("JSON")
}

/// A diagnoser that answers "no gap" for all cases, records them, and requests a stop after a number of them.
#[derive(Default)]
struct Stub {
    asked: Mutex<Vec<String>>,
    stop: Option<(usize, AtomicBool)>,
}

impl Diagnoser for Stub {
    fn name(&self) -> String {
        "stub 1".to_owned()
    }

    fn diagnose(&self, runs: &[PathBuf], motor: &Path) -> Result<Verdict, BlindError> {
        assert!(
            runs.iter()
                .chain([&motor.to_owned()])
                .all(|file| file.exists())
        );
        let case = motor.parent().and_then(Path::file_name).expect("a case");
        let mut asked = self.asked.lock().expect("no panic");
        asked.push(case.to_string_lossy().into_owned());
        if let Some((after, flag)) = &self.stop
            && asked.len() == *after
        {
            flag.store(true, Ordering::Relaxed);
        }
        Ok(Verdict {
            diagnosis: json!({"verdict": "no_gap", "causes": [{"effect": "none", "probability": 1.0}]}),
            model: None,
            failure: None,
            wall_s: 0.25,
        })
    }
}

#[test]
fn commitments_are_salted_hashes_that_can_be_verified() {
    let set = Set::new();
    let manifest = Manifest::read(&set.directory).expect("a manifest");
    let labels = Labels::read(&set.labels).expect("labels");
    let mut salts = Vec::new();
    for case in &manifest.cases {
        let label = &labels.cases[&case.name];
        let text = [label.salt.as_str(), &case.name, &label.label].join("\n");
        let hash: String = Sha256::digest(text)
            .iter()
            .map(|b| format!("{b:02x}"))
            .collect();
        assert_eq!(case.commitment, hash);
        assert_eq!(label.salt.len(), 64);
        salts.push(&label.salt);
    }
    salts.dedup();
    assert_eq!(salts.len(), 3);
}

#[test]
fn no_file_of_the_set_contains_a_label() {
    let set = Set::new();
    set.run();
    let labels = Labels::read(&set.labels).expect("labels");
    let words = [
        "stribeck",
        "backlash",
        "voltage_drop",
        "single",
        "pair",
        "seed",
    ];
    let secrets: Vec<&str> = labels
        .cases
        .values()
        .flat_map(|label| [label.salt.as_str(), label.label.as_str()])
        .chain(words)
        .collect();
    let mut folders = vec![set.directory.clone()];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a directory") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            files += 1;
            let text = fs::read_to_string(&path).expect("text");
            for secret in &secrets {
                assert!(!text.contains(secret), "{} tells {secret}", path.display());
            }
        }
    }
    // Manifest, ledger and its lock; for each case two runs, motor, held-out run and verdict.
    assert_eq!(files, 3 + 3 * 5);
}

#[test]
fn labels_inside_the_set_are_refused() {
    let keep = tempfile::tempdir().expect("a directory");
    let inside = keep.path().join("set/labels.json");
    let error = add_cases(&keep.path().join("set"), &inside, None, [case("none")]);
    assert!(
        matches!(error, Err(BlindError::Refused(why)) if why.to_string().contains("inside the set"))
    );
}

#[test]
fn labels_may_be_absent_while_cases_are_judged() {
    let set = Set::new();
    let away = set.labels.with_extension("away");
    fs::rename(&set.labels, &away).expect("moved");
    assert_eq!(set.run().entries.len(), 3);
    assert!(set.open().is_err());
    fs::rename(&away, &set.labels).expect("moved back");
    set.open().expect("opened");
}

#[test]
fn a_tampered_label_is_refused() {
    for tamper in [
        |label: &mut Value| label["label"] = json!(r#"{"kind":"none","effects":[]}"#),
        |label: &mut Value| label["salt"] = json!("00".repeat(32)),
    ] {
        let set = Set::new();
        set.run();
        set.change(&set.labels, |labels| {
            tamper(&mut labels["cases"]["case-0001"])
        });
        assert_eq!(
            set.refusal(),
            "the label of case-0001 does not match its commitment in the manifest"
        );
        assert!(!set.directory.join("opened.json").exists());
    }
}

#[test]
fn a_label_changed_together_with_its_commitment_is_refused_once_opened() {
    let set = Set::new();
    set.run();
    set.open().expect("opened");
    let mut labels = Labels::read(&set.labels).expect("labels");
    let label = labels.cases.get_mut("case-0001").expect("a label");
    label.label = label.label.replace("stribeck", "cogging");
    let forged = commitment("case-0001", label);
    fs::write(&set.labels, serde_json::to_string(&labels).expect("JSON")).expect("written");
    set.change(Path::new("manifest.json"), |manifest| {
        manifest["cases"][0]["commitment"] = json!(forged);
    });
    assert_eq!(
        set.refusal(),
        "the verdict on case-0001 judges another case"
    );
}

#[test]
fn a_changed_verdict_is_refused() {
    let set = Set::new();
    set.run();
    set.change(Path::new("verdicts/case-0002.json"), |verdict| {
        verdict["diagnosis"]["verdict"] = json!("effect");
    });
    assert_eq!(
        set.refusal(),
        "the verdict on case-0002 was changed after it was written"
    );
}

#[test]
fn a_changed_time_breaks_the_chain() {
    let set = Set::new();
    set.run();
    let path = set.directory.join("verdicts.log");
    let text = fs::read_to_string(&path).expect("a chain");
    let year = &text[text.find("\"decided_at\":\"").expect("a time") + 14..][..4];
    fs::write(&path, text.replacen(&format!("\"{year}-"), "\"2001-", 1)).expect("written");
    assert!(
        set.refusal()
            .starts_with("the chain of verdicts breaks at line 1")
    );
}

#[test]
fn a_changed_run_is_refused() {
    let set = Set::new();
    let path = set.directory.join("case-0003/run2.csv");
    fs::write(&path, "# a kinder run\n").expect("written");
    let stub = Stub::default();
    let judged = run(&set.directory, &stub, 1, &AtomicBool::new(false), &|_| ());
    assert!(
        matches!(judged, Err(BlindError::Refused(why)) if why.to_string().starts_with("case-0003/run2.csv was changed after it was sealed"))
    );
}

#[test]
fn a_verdict_newer_than_the_opening_is_refused() {
    let set = Set::new();
    set.run();
    set.open().expect("opened");
    set.open().expect("opened again, as often as one likes");

    // Further verdicts are refused.
    let stub = Stub::default();
    let again = run(&set.directory, &stub, 1, &AtomicBool::new(false), &|_| ());
    assert!(
        matches!(again, Err(BlindError::Refused(why)) if why.to_string().contains("has been opened"))
    );

    // Also if the opening is removed, the cases are judged again, and the opening is restored.
    let opening = set.directory.join("opened.json");
    let aside = set.labels.with_extension("opened");
    fs::rename(&opening, &aside).expect("moved");
    fs::remove_file(set.directory.join("verdicts.log")).expect("removed");
    fs::remove_dir_all(set.directory.join("verdicts")).expect("removed");
    set.run();
    fs::rename(&aside, &opening).expect("moved back");
    assert!(
        set.refusal()
            .ends_with("is newer than the opening of the labels")
    );
}

#[test]
fn a_recorded_hash_must_be_in_the_chain() {
    let set = Set::new();
    let head = set.run().head().to_owned();
    let other = open(&set.directory, &set.labels, Some(&"ab".repeat(32)));
    assert!(matches!(other, Err(BlindError::Refused(why)) if why.to_string().contains(&head)));
    open(&set.directory, &set.labels, Some(&head)).expect("opened");
}

#[test]
fn an_unfinished_run_is_not_opened() {
    let set = Set::new();
    assert!(set.refusal().starts_with("case-0001 has no verdict"));
}

#[test]
fn a_stopped_run_continues_and_judges_nothing_twice() {
    let set = Set::new();
    let stub = Stub {
        stop: Some((2, AtomicBool::new(false))),
        ..Stub::default()
    };
    let (_, flag) = stub.stop.as_ref().expect("set above");
    let begun = run(&set.directory, &stub, 1, flag, &|_| ()).expect("begun");
    assert_eq!(begun.entries.len(), 2);

    // Power failure within the third line.
    let path = set.directory.join("verdicts.log");
    let mut text = fs::read_to_string(&path).expect("a chain");
    text.push_str("{\"case\":\"case-0003\",\"sha2");
    fs::write(&path, text).expect("written");

    let done = run(&set.directory, &stub, 1, &AtomicBool::new(false), &|_| ()).expect("done");
    assert_eq!(done.entries[..2], begun.entries);
    assert_eq!(done, Ledger::read(&set.directory).expect("whole"));
    let mut asked = stub.asked.into_inner().expect("no panic");
    asked.sort();
    assert_eq!(asked, ["case-0001", "case-0002", "case-0003"]);
    set.open().expect("opened");
}

#[test]
fn cases_are_added_to_a_set_until_it_is_opened() {
    let set = Set::new();
    let more = add_cases(
        &set.directory,
        &set.labels,
        None,
        [case("outside:a slack belt")],
    );
    assert_eq!(more.expect("added").cases[3].name, "case-0004");
    set.run();
    set.open().expect("opened");
    let late = add_cases(&set.directory, &set.labels, None, [case("none")]);
    assert!(
        matches!(late, Err(BlindError::Refused(why)) if why.to_string().contains("has been opened"))
    );
}

#[test]
fn a_misspelt_label_is_refused() {
    let slip = Truth::from_words("stribek")
        .expect_err("no effect")
        .to_string();
    assert!(slip.contains("did you mean 'stribeck'?"), "{slip}");
    assert!(Truth::from_words("inertia+inertia").is_err());
    let known: BTreeMap<_, _> = [("none", "none"), ("outside: a b", "outside:a b")].into();
    for (words, meant) in known {
        assert_eq!(Truth::from_words(words).expect("a label").words(), meant);
    }
}
