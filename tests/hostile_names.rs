//! Nothing that comes from a file or a device becomes markup in a page, or steers a terminal.

#[path = "support/command.rs"]
mod command;

use std::path::{Path, PathBuf};

use command::run;
use motorlab::board::{IdealBench, VirtualBoard, VirtualBoardOptions};

/// Ends an attribute, a tag, a script and a style, and begins others.
const HOSTILE: &str = "\"'></script></style><script>alert(1)</script><img src=x onerror=alert(2)>";

/// Every page and drawing beneath `directory`.
fn pages(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(pages(&path));
        } else if matches!(path.extension(), Some(kind) if kind == "html" || kind == "svg") {
            found.push(path);
        }
    }
    found
}

/// The texts are there, but not as markup: no tag begins in them, and no quotation mark ends.
fn are_harmless(pages: &[PathBuf], word: &str) {
    let mut told = false;
    for page in pages {
        let text = std::fs::read_to_string(page).expect("a page");
        for markup in ["<script>alert", "<img", "\"'>", "alert(2)>"] {
            assert!(!text.contains(markup), "{markup} in {}", page.display());
        }
        assert!(!text.chars().any(|c| c.is_control() && !"\n\t".contains(c)));
        told |= text.contains(word);
    }
    assert!(told, "{word} is nowhere in {pages:?}");
}

#[test]
fn what_a_file_says_is_text_in_every_page() {
    let directory = tempfile::tempdir().expect("a directory");
    // No slash fits into a file's name.
    let name = format!("{}.csv", HOSTILE.replace('/', ""));
    let simulated = ["simulate", "--duration", "1.5", "-o", "run.csv"];
    assert_eq!(run(directory.path(), &simulated).status, Some(0));
    let plain = std::fs::read_to_string(directory.path().join("run.csv")).expect("a run");
    let quoted = toml::Value::from(format!("{HOSTILE}\u{1b}[2J")).to_string();
    let keys = ["profile", "started", "recorder", "device", "firmware"];
    let header: String = keys.map(|key| format!("# {key} = {quoted}\n")).concat();
    let rest: String = plain
        .lines()
        .filter(|line| {
            !keys
                .iter()
                .any(|key| line.starts_with(&format!("# {key} =")))
        })
        .map(|line| format!("{line}\n"))
        .collect();
    let (format_line, rest) = rest.split_once('\n').expect("lines");
    let hostile = format!("{format_line}\n{header}{rest}");
    std::fs::write(directory.path().join(&name), hostile).expect("a file");
    let motor = format!("motor{name}.toml");
    std::fs::write(directory.path().join(&motor), "resistance_ohm = 9.0\n").expect("a file");
    for arguments in [
        &[
            "compare",
            &name,
            "--motor",
            &motor,
            "--html",
            "compare.html",
        ][..],
        &[
            "diagnose",
            &name,
            "--motor",
            &motor,
            "--html",
            "diagnose.html",
        ],
        &["lab", "--run", &name, "--motor", &motor, "-o", "lab"],
    ] {
        let done = run(directory.path(), arguments);
        assert_eq!(done.status, Some(0), "{arguments:?}: {}", done.messages);
        assert!(!done.messages.contains('\u{1b}') && !done.output.contains('\u{1b}'));
    }
    for page in ["compare.html", "diagnose.html"] {
        are_harmless(&[directory.path().join(page)], "alert(2)");
    }
    are_harmless(&pages(&directory.path().join("lab")), "html");
}

#[test]
fn what_a_board_calls_itself_is_text_in_the_run_and_in_the_page() {
    let mut options = VirtualBoardOptions::default();
    options.firmware.name = "<img src=x>\u{1b}[2J\"".to_owned();
    options.banner = "<script>alert(1)</script>\u{1b}[2J\n".to_owned();
    let board = VirtualBoard::spawn(IdealBench::new(100.0), options).expect("a virtual board");
    let directory = tempfile::tempdir().expect("a directory");
    let port = board.path().display().to_string();
    let done = run(directory.path(), &["capture", &port, "--duration", "0.9"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    assert!(!done.messages.contains('\u{1b}') && !done.output.contains('\u{1b}'));
    let text = std::fs::read_to_string(directory.path().join("run.csv")).expect("a run");
    assert!(text.contains("<img src=x>") && !text.contains('\u{1b}'));
    let compare = ["compare", "run.csv", "--html", "compare.html"];
    assert_eq!(run(directory.path(), &compare).status, Some(0));
    are_harmless(&[directory.path().join("compare.html")], "run.csv");
}

#[test]
fn a_name_of_several_lines_is_one_line_wherever_it_is_shown() {
    let directory = tempfile::tempdir().expect("a directory");
    let name = "a\nb\u{202e}.csv";
    let shown = "a\u{fffd}b\u{fffd}.csv";
    let simulate = ["simulate", "--duration", "1.5", "-o", name];
    assert_eq!(run(directory.path(), &simulate).status, Some(0));
    for arguments in [
        &["compare", name][..],
        &["check", name],
        &["export", "matlab", "--run", name, "-o", "mat"],
    ] {
        let done = run(directory.path(), arguments);
        assert_eq!(done.status, Some(0), "{arguments:?}: {}", done.messages);
        assert!(
            !done.output.contains("a\nb"),
            "{arguments:?}: {}",
            done.output
        );
    }
    let compared = run(directory.path(), &["compare", name]);
    assert!(compared.output.contains(shown), "{}", compared.output);
    // A profile's name goes into the header of a run.
    let profile = "p\ncomplete = true\n.csv";
    std::fs::write(
        directory.path().join(profile),
        "t_s,command_v\n0,0\n0.1,4\n",
    )
    .expect("a file");
    let capture = [
        "capture",
        "virtual:?speed=max",
        "--profile",
        profile,
        "--duration",
        "0.3",
    ];
    let done = run(directory.path(), &capture);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let text = std::fs::read_to_string(directory.path().join("run.csv")).expect("a run");
    let keys = text.lines().filter(|line| line.starts_with("# complete"));
    assert_eq!(keys.count(), 1, "{text}");
}
