//! Every error of wrong use or invalid input has a remedy, in a line `hint: ...` and in the document's `remedy`.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::command::run;

const RUN: &str = "# counts_per_rev = 720\nt_s,command_v,counts\n";

/// Files for the calls below.
const FILES: &[(&str, &str)] = &[
    ("empty.csv", ""),
    ("prose.txt", "Dear reader,\nthis is a letter.\n"),
    ("no-rows.csv", RUN),
    (
        "bad-header.csv",
        "# counts_per_rev = = 3\nt_s,command_v,counts\n0,0,0\n",
    ),
    (
        "newer.csv",
        "# format = \"motorlab-run/9\"\nt_s,command_v,counts\n0,0,0\n",
    ),
    (
        "no-counts.csv",
        "# counts_per_rev = 720\nt_s,command_v\n0,0\n",
    ),
    (
        "cells.csv",
        "# counts_per_rev = 720\nt_s,command_v,counts\n0,0,0\n0.1,3\n",
    ),
    (
        "falls.csv",
        "# counts_per_rev = 720\nt_s,command_v,counts\n0,0,0\n0.2,3,1\n0.1,3,2\n",
    ),
    (
        "log.csv",
        "time_ms,pwm,angle\n0,0,0\n10,255,0.1\n20,255,0.3\n30,255,0.5\n",
    ),
    ("bad.map", "[time]\ncolum = \"t\"\n"),
    ("half.map", "[time]\ncolumn = \"time_ms\"\nunit = \"ms\"\n"),
    ("key.toml", "resistence_ohm = 3\n"),
    ("text.toml", "resistance_ohm = \"three\"\n"),
    ("negative.toml", "resistance_ohm = -3\n"),
    ("effect.toml", "[effects.backlsh]\ngap_rad = 0.1\n"),
    ("no.toml", "resistance_ohm 3\n"),
    ("raw.log", "nothing of a raw log\n"),
    ("diagnosis.json", "{\"shape\": \"motorlab-nothing/1\"}\n"),
    ("profile.csv", "0,1\n1,x\n"),
    ("there.html", "a page of another program\n"),
];

/// Command lines of wrong use.
const WRONG: &[&str] = &[
    "captur virtual:",
    "banana",
    "capture",
    "capture virtual: --ts 0",
    "capture virtual: --duration -3",
    "capture virtual: --profile stp",
    "capture virtual: --profile step@7",
    "capture virtual: --columns t_us,cnts",
    "capture virtual:?effect=backlsh",
    "capture virtual:?efect=backlash",
    "capture virtual:?seed",
    "capture virtual:?clock_ppm=1e9",
    "capture virtual",
    "capture no-such-port",
    "capture log.csv",
    "capture virtual: --supply 1e300",
    "capture virtual: --ts 0.001 --duration 9999",
    "capture virtual: --until-known 0s",
    "capture virtual: --until-known many",
    "compare",
    "compare no-such.csv",
    "compare empty.csv",
    "compare prose.txt",
    "compare no-rows.csv",
    "compare bad-header.csv",
    "compare newer.csv",
    "compare no-counts.csv",
    "compare cells.csv",
    "compare falls.csv",
    "compare good.csv --motor key.toml",
    "compare good.csv --motor text.toml",
    "compare good.csv --motor negative.toml",
    "compare good.csv --motor effect.toml",
    "compare good.csv --motor no.toml",
    "compare good.csv --motor no-such.toml",
    "compare good.csv --with good.csv:nothing=1",
    "compare good.csv --with other.csv:supply_v=1",
    "compare good.csv --with good.csv",
    "compare good.csv --html there.html",
    "compare good.csv --html good.csv",
    "compare good.csv --html no-such-folder/page.html",
    "compare good.csv --output page.html",
    "check no-such.csv",
    "diagnose good.csv --hold-out good.csv",
    "diagnose good.csv --repeats good.csv,other.csv",
    "diagnose good.csv --repeats good.csv",
    "diagnose good.csv --good-enough -1",
    "diagnose good.csv --nominal fitted",
    "diagnose good.csv --explian",
    "simulate --ts 1e-6 --duration 1e6",
    "simulate --profile profile.csv",
    "simulate --profile empty.csv",
    "simulate --efect backlash",
    "design --ts 100",
    "design --next-of diagnosis.json",
    "explain backlsh",
    "effects backlsh",
    "schema diagnos",
    "import log.csv",
    "import prose.txt",
    "import empty.csv",
    "import no-such.csv",
    "import log.csv --map bad.map",
    "import log.csv --map half.map",
    "import log.csv --position nothing:deg",
    "import log.csv --position angle:furlong",
    "import log.csv --counts-per-rev=-3",
    "replay raw.log -o new.csv",
    "replay raw.log --speed fast -o new.csv",
    "tabulate diagnosis.json -o table.csv",
    "tabulate no-such.json -o table.csv",
    "motor no-such.toml",
    "motor key.toml",
    "motor --resistance x",
    "export parquet no-such.csv",
    "export banana good.csv",
    "blind run no-such-set",
    "blind score no-such-set",
    "blind make --cases 2 --kind banana set",
    "blind make --cases 2 --random-load -1 set",
    "blind seal good.csv --label banana --into set",
    "lab --class no-such-folder",
    "flash no-such-port --hex no-such.hex",
];

/// The messages of one call and its document with `--json`, unless both have a hint.
fn lacks_hint(folder: &Path, line: &str) -> Option<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let said = run(folder, &words);
    let with_json: Vec<&str> = words.iter().copied().chain(["--json"]).collect();
    let document = run(folder, &with_json);
    let found: Option<Value> = serde_json::from_str(&document.output).ok();
    let remedy = found.and_then(|found| found["error"]["remedy"].as_str().map(str::to_owned));
    let hints: Vec<&str> = (said.messages.lines())
        .filter_map(|line| line.strip_prefix("hint: "))
        .filter(|hint| hint.len() > 5)
        .collect();
    let is_wrong_use = said.status.is_some_and(|status| status >= 2);
    let says_what = said
        .messages
        .lines()
        .any(|line| line.starts_with("error: "));
    let is_whole = is_wrong_use
        && says_what
        && !hints.is_empty()
        && remedy.is_some_and(|remedy| remedy.starts_with(hints[hints.len() - 1]))
        && !said.messages.contains("panicked");
    (!is_whole).then(|| {
        format!(
            "motorlab {line}: status {:?}, {}\n{}",
            said.status, said.messages, document.output
        )
    })
}

#[test]
fn every_wrong_use_has_a_hint() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in FILES {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    let made = run(
        folder.path(),
        &["simulate", "--duration", "0.6", "-o", "good.csv"],
    );
    assert_eq!(made.status, Some(0), "{}", made.messages);
    let lacking: Vec<String> = (WRONG.iter())
        .filter_map(|line| lacks_hint(folder.path(), line))
        .collect();
    assert!(
        lacking.is_empty(),
        "{} of {} without a hint\n{}",
        lacking.len(),
        WRONG.len(),
        lacking.join("\n")
    );
}

/// The error names the file and the line; the hint follows once.
#[test]
fn a_hint_is_the_last_line_and_is_printed_once() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("key.toml"), "resistence_ohm = 3\n").expect("a file");
    let said = run(folder.path(), &["motor", "key.toml"]).messages;
    assert_eq!(
        said,
        "error: key.toml: line 1: unknown key 'resistence_ohm'\n\
         hint: did you mean 'resistance_ohm'? `motorlab motor --template` prints all keys\n"
    );
}

/// Errors without a hint, with the reason.
const WITHOUT: &[(&str, &str)] = &[
    // Reasons in a list of skipped rows; the error of the whole log has the hint.
    ("src/import/error.rs", "the line is longer than"),
    ("src/import/error.rs", "cells where the columns are"),
    ("src/import/error.rs", "is not a finite number"),
    ("src/import/error.rs", "is empty; where signals come"),
    ("src/import/error.rs", "no comment line before it"),
    (
        "src/import/error.rs",
        "time goes from {before} s to {after} s; it must rise",
    ),
    (
        "src/import/error.rs",
        "in SI is {value}, which lies outside",
    ),
    // The system error that caused it has the hint.
    ("src/board/profile.rs", "cannot read the profile"),
    // Not correctable by a user: the program made the header.
    (
        "src/recording/write_error.rs",
        "the run's header is no TOML",
    ),
    // Test of how causes are printed.
    ("src/cli/failure.rs", "cannot read motor.toml"),
];

/// The arguments of every `#[error(...)]` of a source file.
fn error_texts(source: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, mark) in source.match_indices("#[error(") {
        let (mut depth, mut quoted, mut escaped) = (1, false, false);
        let text = source[at + mark.len()..].chars().take_while(|&c| {
            match c {
                _ if escaped => escaped = false,
                '\\' if quoted => escaped = true,
                '"' => quoted = !quoted,
                '(' if !quoted => depth += 1,
                ')' if !quoted => depth -= 1,
                _ => {}
            }
            depth > 0
        });
        found.push(text.collect());
    }
    found
}

/// Ends of texts that are another error's, or a function's with the hint.
const DELEGATED: &[&str] = &[
    "{source}",
    "{error}",
    "{problem}",
    "{what}",
    "{why}",
    "{0}",
    "{}",
];

/// Whether an error's text has a hint, or ends with another error's.
fn has_hint(text: &str) -> bool {
    let literal = text.split('"').nth(1).unwrap_or_default();
    text == "transparent"
        || text.contains("hint: ")
        || DELEGATED.iter().any(|end| literal.ends_with(end))
}

fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_kind_of_error_has_a_hint() {
    assert!(!has_hint("\"{run}: too short\", run = shown(run)"));
    assert!(!has_hint("\"{run}: more than {most}\", run = shown(run)"));
    assert!(has_hint("\"{run}: too short\\nhint: record more\""));
    assert!(has_hint("\"{run}: {source}\", run = shown(run)"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    for folder in ["src", "motor-chain/src", "python/src", "web/src"] {
        sources(&root.join(folder), &mut paths);
    }
    let (mut lacking, mut kinds, mut used) = (Vec::new(), 0, Vec::new());
    for path in &paths {
        let name = path.strip_prefix(root).expect("inside").to_string_lossy();
        let name = name.replace('\\', "/");
        for text in error_texts(&fs::read_to_string(path).expect("text")) {
            kinds += 1;
            if has_hint(text.trim()) {
                continue;
            }
            let known = WITHOUT
                .iter()
                .position(|(file, part)| *file == name && text.contains(part));
            match known {
                Some(at) => used.push(at),
                None => lacking.push(format!("{name}: {}", text.trim())),
            }
        }
    }
    assert!(kinds > 150, "{kinds}");
    assert!(lacking.is_empty(), "{}", lacking.join("\n"));
    used.sort_unstable();
    used.dedup();
    assert_eq!(
        used.len(),
        WITHOUT.len(),
        "an exception that no error needs"
    );
}
