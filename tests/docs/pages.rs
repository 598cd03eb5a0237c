//! The documentation is consistent: links and anchors have targets, every page is reachable, every printed command
//! line is valid, and the tutorial runs.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support;
use crate::support::command::run;
use crate::support::pages::{self, Page, root, words};
use clap::Parser;
use motorlab::cli::CommandLine;
use motorlab::motor::catalogue::catalogue;
use serde_json::Value;

/// Most words of the page on the method of the diagnosis, with its equations.
const METHOD_WORDS: usize = 2000;
/// Most words of the decisions.
const DECISIONS_WORDS: usize = 2500;
/// Most lines of the README.
const README_LINES: usize = 150;

#[test]
fn every_link_has_a_target() {
    let mut dead = Vec::new();
    let mut seen = 0;
    for page in pages::all() {
        for link in page.links() {
            seen += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = page.beside(file);
            if !root().join(&target).exists() {
                dead.push(format!("{}: {link}", page.path.display()));
            } else if !anchor.is_empty() && target.extension().is_some_and(|end| end == "md") {
                let anchors = Page::read(&target).anchors();
                if !anchors.iter().any(|there| there == anchor) {
                    dead.push(format!("{}: {link}", page.path.display()));
                }
            }
        }
    }
    assert!(seen > 100, "{seen}");
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

#[test]
fn every_page_is_found_from_the_index() {
    let mut found = BTreeSet::new();
    let mut open: Vec<PathBuf> = ["docs/README.md", "docs/SUMMARY.md"]
        .map(PathBuf::from)
        .into();
    while let Some(path) = open.pop() {
        if !found.insert(path.clone()) {
            continue;
        }
        let page = Page::read(&path);
        let linked = page.links().into_iter().map(|link| {
            let file = link.split('#').next().unwrap_or_default();
            page.beside(file)
        });
        open.extend(linked.filter(|target| target.extension().is_some_and(|end| end == "md")));
    }
    let lost: Vec<PathBuf> = (pages::all().into_iter().map(|page| page.path))
        .filter(|path| path.starts_with("docs") && !found.contains(path))
        .collect();
    assert!(lost.is_empty(), "{lost:?}");
}

#[test]
fn every_command_line_to_copy_is_one() {
    let mut wrong = Vec::new();
    let mut seen = 0;
    for page in pages::all() {
        for line in page.commands() {
            seen += 1;
            if let Err(error) = CommandLine::try_parse_from(words(&line)) {
                wrong.push(format!("{}: {line}\n{error}", page.path.display()));
            }
        }
    }
    assert!(seen > 80, "{seen}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Characters with another meaning in PowerShell, outside quotes: a chain, a comma, a home folder, another line.
#[test]
fn the_readmes_commands_work_in_powershell() {
    let page = Page::read(Path::new("README.md"));
    let commands = page.commands();
    assert!(commands.len() > 5, "{commands:?}");
    for line in commands {
        let bare: String = line.split('\'').step_by(2).collect();
        let bare = bare.split('#').next().unwrap_or_default();
        for other in ["&", ",", "~", "<", ";", "$", "@", "\\"] {
            assert!(!bare.contains(other), "{line}: {other}");
        }
    }
    assert!(!page.text.contains("&&"), "a chain of commands");
}

/// The documents of the tutorial's commands, in order, run in a folder with its two files only.
fn tutorial() -> Vec<(Vec<String>, Value)> {
    let page = Page::read(Path::new("docs/tutorial/README.md"));
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["log.csv", "bench.toml"] {
        let from = root().join("docs/tutorial").join(name);
        fs::copy(from, folder.path().join(name)).expect("a copy");
    }
    let mut documents = Vec::new();
    for line in page.commands() {
        let mut arguments = words(&line);
        arguments.remove(0);
        arguments.push("--json".to_owned());
        let borrowed: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let done = run(folder.path(), &borrowed);
        assert_eq!(done.status, Some(0), "{line}\n{}", done.messages);
        let document = serde_json::from_str(&done.output).expect("one document");
        documents.push((arguments, document));
    }
    documents
}

#[test]
fn the_tutorial_runs_with_its_stated_results() {
    let done = tutorial();
    let of = |name: &str| -> Vec<&Value> {
        let named = done.iter().filter(|(arguments, _)| arguments[0] == name);
        named.map(|(_, document)| document).collect()
    };
    let verdicts: Vec<&str> = (of("diagnose").iter())
        .map(|found| found["verdict"].as_str().expect("a verdict"))
        .collect();
    assert_eq!(verdicts, ["no_gap", "effect", "effect"]);
    let rmse = |document: &Value, run: usize| {
        let figure = &document["runs"][run]["position_rmse_counts"];
        figure.as_f64().expect("a number")
    };
    // A gap of tens of counts on the ramp, and none with the identified effect.
    let compared = of("compare");
    assert!(rmse(compared[0], 0) > 20.0, "{}", compared[0]);
    assert!(rmse(compared[1], 1) < 1.0, "{}", compared[1]);
    let hidden = of("design")[0].to_string();
    assert!(hidden.contains("dead_zone"), "{hidden}");
    // The threshold is between the two levels at which the motor rests and turns, and the true one is in both
    // intervals.
    let bench = fs::read_to_string(root().join("docs/tutorial/bench.toml")).expect("a file");
    let bench: toml::Table = bench.parse().expect("TOML");
    let truth = bench["effects"]["dead_zone"]["threshold_v"]
        .as_float()
        .expect("a number");
    for (found, levels) in of("diagnose")[1..].iter().zip([(1.3, 1.7), (1.39, 1.61)]) {
        assert_eq!(found["effects"], serde_json::json!(["dead_zone"]));
        let threshold = &found["causes"][0]["parameters"]["threshold_v"];
        let [lo, hi] = ["lo95", "hi95"].map(|end| threshold[end].as_f64().expect("a number"));
        assert!(
            levels.0 < lo && lo < truth && truth < hi && hi < levels.1,
            "{threshold}"
        );
    }
}

/// The README's text of the demo's diagnosis is what the demo prints, with `[...]` for omitted parts.
#[test]
fn the_readme_quotes_what_the_demo_prints() {
    let readme = Page::read(Path::new("README.md"));
    let quoted: Vec<&str> = (readme.text.lines())
        .filter_map(|line| line.strip_prefix("> "))
        .collect();
    let folder = tempfile::tempdir().expect("a folder");
    let done = run(folder.path(), &["demo"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let printed = done.output.replace('\u{a0}', " ");
    let quoted = quoted.join(" ");
    let parts: Vec<&str> = quoted.split("[...]").map(str::trim).collect();
    assert!(parts.len() >= 2, "{quoted}");
    for part in parts {
        assert!(printed.contains(part), "{part}\n{printed}");
    }
}

#[test]
fn the_readme_the_method_and_the_decisions_are_short() {
    let readme = Page::read(Path::new("README.md"));
    assert!(readme.text.lines().count() <= README_LINES);
    let effects = format!("{} effects", catalogue().len());
    assert!(readme.text.contains(&effects), "{effects}");
    for (path, most) in [
        ("docs/method/diagnosis.md", METHOD_WORDS),
        ("docs/decisions/README.md", DECISIONS_WORDS),
    ] {
        let page = Page::read(Path::new(path));
        let words = page.text.split_whitespace();
        let words = words
            .filter(|word| word.contains(char::is_alphanumeric))
            .count();
        assert!(words <= most, "{path}: {words}");
    }
}

#[test]
fn the_book_is_built_where_mdbook_is() {
    let Ok(version) = Command::new("mdbook").arg("--version").output() else {
        support::skip("the_book_is_built_where_mdbook_is", "no mdbook on the path");
        return;
    };
    assert!(version.status.success());
    let folder = tempfile::tempdir().expect("a folder");
    let built = Command::new("mdbook")
        .args(["build", "--dest-dir"])
        .arg(folder.path())
        .arg(root())
        .output()
        .expect("it starts");
    assert!(
        built.status.success(),
        "{}",
        String::from_utf8_lossy(&built.stderr)
    );
    assert!(folder.path().join("tutorial/index.html").is_file());
    let mut seen = 0;
    let mut dead = Vec::new();
    for page in html_below(folder.path()) {
        let text = fs::read_to_string(&page).expect("a page");
        let place = page.strip_prefix(folder.path()).expect("below");
        let depth = place.components().count() - 1;
        for link in text.split("href=\"").skip(1) {
            let link = link.split(['"', '#']).next().unwrap_or_default();
            // Files outside the documentation are no links in the book: docs/book.js.
            let ups = link.split('/').filter(|part| *part == "..").count();
            if link.is_empty() || link.contains(':') || ups > depth {
                continue;
            }
            seen += 1;
            if !page.with_file_name(link).exists() {
                dead.push(format!("{}: {link}", place.display()));
            }
        }
    }
    assert!(seen > 500, "{seen}");
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

/// Pictures have a background of their own, so that they are readable on light and dark pages.
#[test]
fn every_picture_has_a_background() {
    let pictures = files_below(&root().join("docs"));
    let is_drawing = |path: &PathBuf| path.extension().is_some_and(|end| end == "svg");
    let mut bare = pictures.into_iter().filter(is_drawing).filter(|path| {
        let text = fs::read_to_string(path).expect("a picture");
        !text.contains("fill=\"var(--paper)\"") && !text.contains("class=\"paper\"")
    });
    assert_eq!(bare.next(), None);
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let of = |path: PathBuf| match path.is_dir() {
        true => files_below(&path),
        false => vec![path],
    };
    paths.flat_map(of).collect()
}

/// Pages of a book, except the print page and the error page.
fn html_below(folder: &Path) -> Vec<PathBuf> {
    let is_page = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default();
        let is_other = name == "print.html" || name == "404.html";
        path.extension().is_some_and(|end| end == "html") && !is_other
    };
    files_below(folder).into_iter().filter(is_page).collect()
}
