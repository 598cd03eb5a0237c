//! The published accuracy, held on a reduced set: fails when a figure drops by more than chance.
//!
//! The set is made anew from a seed of its own for tuning; `docs/blind/published.json` holds the published
//! figures. A figure fails where so few hits (or so many false alarms) would come up in less than one of a
//! thousand sets, both sets' chances counted.

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use motorlab::blind::{
    Program, Recipe, Score, Share, add_cases, judge, make, measure_gap, open, run, score,
};

/// Of the tuning seeds; its cases are not to be looked at one by one either.
const SEED: u64 = 700_001;
const CASES: usize = 60;
/// What a figure's chance must not fall below.
const LEAST_CHANCE: f64 = 1e-3;

fn program() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_motorlab"))
}

fn scored(directory: &Path) -> Score {
    let recipe = Recipe {
        cases: CASES,
        seed: SEED,
        kind: "mixed".to_owned(),
        other_motors: false,
        wander_scale: 1.0,
    };
    let (set, labels) = (directory.join("set"), directory.join("labels.json"));
    let cases = make(&recipe, &|| ()).expect("a kind of cases");
    add_cases(&set, &labels, Some(recipe), cases).expect("sealed");
    let diagnoser = Program::new(&program(), 1).expect("it starts");
    run(&set, &diagnoser, 2, &AtomicBool::new(false), &|_| ()).expect("judged");
    let opened = open(&set, &labels, None).expect("opened");
    let judged = opened.cases.iter().map(|case| {
        let gap = measure_gap(&set, case).expect("the unseen run can be read");
        judge(case, gap)
    });
    let judged = judged.collect();
    score(&opened, judged)
}

fn share(document: &serde_json::Value, path: &str) -> Share {
    let value = document.pointer(path).expect("a published figure").clone();
    serde_json::from_value(value).expect("hits and of")
}

/// The cases that do not count: so few of these is so many of those.
fn others(share: Share) -> Share {
    Share {
        hits: share.of - share.hits,
        of: share.of,
    }
}

#[test]
fn accuracy_has_not_dropped_by_more_than_chance() {
    let name = "accuracy_has_not_dropped_by_more_than_chance";
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/blind/published.json");
    let Ok(text) = std::fs::read_to_string(&published) else {
        return support::skip(name, "docs/blind/published.json is not there yet");
    };
    let help = Command::new(program())
        .args(["diagnose", "--help"])
        .output();
    if !help.expect("it starts").status.success() {
        return support::skip(name, "there is no 'motorlab diagnose'");
    }
    let published: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let keep = tempfile::tempdir().expect("a directory");
    let score = scored(keep.path());
    assert_eq!(score.failed, 0, "every case has a diagnosis");
    let figures = [
        (
            "single effects right",
            score.singles.right,
            share(&published, "/singles/right"),
        ),
        (
            "single effects named",
            score.singles.named,
            share(&published, "/singles/named"),
        ),
        (
            "pairs right",
            score.pairs.right,
            share(&published, "/pairs/right"),
        ),
        (
            "unknown flagged",
            score.outside.flagged,
            share(&published, "/outside/flagged"),
        ),
        (
            "no false alarm",
            others(score.false_alarms),
            others(share(&published, "/false_alarms")),
        ),
    ];
    for (what, found, published) in figures {
        let chance = found.chance_of_so_few(published);
        assert!(
            chance > LEAST_CHANCE,
            "{what}: {}, published {}; so few has a chance of {chance:.1e}",
            found.words(),
            published.words()
        );
    }
}
