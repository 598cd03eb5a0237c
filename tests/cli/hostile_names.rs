//! No text from a file or a device becomes markup in a page, or controls a terminal.
#![cfg(unix)]

use std::path::{Path, PathBuf};

use crate::support;
use crate::support::command::run;
use motorlab::board::{IdealBench, VirtualBoard, VirtualBoardOptions};

/// Closes an attribute, a tag, a script and a style, and opens others.
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

/// The texts are present, but not as markup: no tag begins in them, and no quotation mark ends.
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
fn texts_of_files_are_escaped_in_every_page() {
    let directory = tempfile::tempdir().expect("a directory");
    // A file name has no slash.
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
fn names_of_boards_are_escaped_in_runs_and_pages() {
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
fn a_name_of_several_lines_is_printed_on_one_line() {
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
    // A profile's name is written into the header of a run.
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

/// A line break, terminal control sequences and a change of the writing direction.
const FORGED: &str = "a\nerror: forged\t\u{1b}[2J\u{202e}b";

/// Calls of every command with such names: `{gone}` is missing, `{bad}` is an invalid file, `{run}` a run, `{log}` a
/// raw log, `{plain}` a log of another program, `{motor}` a motor file and `{folder}` a folder.
const CALLS: &[&str] = &[
    "ports {gone}",
    "capture {gone}",
    "capture {bad}",
    "capture {folder}",
    "capture {bad} --columns {gone}",
    "capture virtual:{gone}",
    "capture virtual:?motor={gone}",
    "capture virtual:?{gone}=1",
    "capture virtual:?speed=max --duration 0.3 --profile {gone}",
    "capture virtual:?speed=max --duration 0.3 --profile {bad}",
    "capture virtual:?speed=max --duration 0.3 -o {run}",
    "capture virtual:?speed=max --duration 0.3 -o {folder}",
    "capture virtual:?speed=max --duration 0.3 -o {gone}/x.csv",
    "capture virtual:?speed=max --duration 0.3 --log {run}",
    "capture virtual:?speed=max --duration 0.3 --log {gone}/x.log",
    "capture virtual:?speed=max --duration 0.3 --live --motor {gone}",
    "replay {gone}",
    "replay {bad}",
    "replay {log}",
    "replay {log} -o {run}",
    "replay {log} --columns {gone}",
    "replay {gone} --pty",
    "virtual {gone}",
    "virtual ?motor={gone}",
    "simulate --motor {gone}",
    "simulate --motor {bad}",
    "simulate --motor {motor}",
    "simulate --profile {gone}",
    "simulate --profile {bad}",
    "simulate --duration 1 -o {run}",
    "simulate --duration 1 -o {folder}",
    "check {gone}",
    "check {bad}",
    "check {run} --motor {bad}",
    "check {run} --motor {motor}",
    "check {plain}",
    "compare {gone}",
    "compare {bad}",
    "compare {plain}",
    "compare {run} --motor {bad}",
    "compare {run} --motor {motor}",
    "compare {run} --html {run}",
    "compare {run} --html {folder}",
    "compare {run} --with {gone}:supply_v=4",
    "compare {run} --with {run}:{gone}=4",
    "lab --no-diagnosis --run {gone} -o lab",
    "lab --no-diagnosis --run {run} --motor {bad} -o lab",
    "lab --no-diagnosis --run {run} -o {run}",
    "lab --board {gone} -o lab",
    "diagnose {gone}",
    "diagnose {bad}",
    "diagnose {plain}",
    "diagnose {run} --motor {bad}",
    "diagnose {run} --hold-out {gone}",
    "diagnose {run} --reference {bad}",
    "diagnose {run} --repeats {gone}",
    "diagnose {run} --model-out {run}",
    "diagnose {run} --good-enough {gone}",
    "design --motor {gone}",
    "design --motor {bad}",
    "design --diagnosis {gone}",
    "design --diagnosis {bad}",
    "design --profile {gone}",
    "effects {gone}",
    "effects --motor {gone}",
    "effects stribeck --motor {motor}",
    "explain {gone}",
    "motor {gone}",
    "motor {bad}",
    "motor {motor}",
    "motor {motor} -o {run}",
    "export {gone}",
    "export json --motor {gone} -o x",
    "export matlab --run {bad} -o x",
    "export matlab --run {run} -o {run}",
    "export matlab --run {run} -o x",
    "blind make --cases 1 --kind {gone} {folder}",
    "blind make --cases 1 --kind none {run}",
    "blind make --cases 1 --kind none set --labels {bad}",
    "blind seal --label none --run {gone} --into {folder}",
    "blind seal --label {gone} --run {run} --into {folder}",
    "blind run {gone}",
    "blind run {folder}",
    "blind run {folder} --diagnoser {gone}",
    "blind score {gone} --labels {gone}",
    "blind score {folder} --labels {bad}",
    "import {gone}",
    "import {bad}",
    "import {bad} --map {gone}",
    "import {plain} --map {bad}",
    "import {plain} --time {gone}",
    "import {plain} --save-map {run}",
    "import {plain} -o {run}",
    "import {run}",
    "demo --board {gone} -o x",
    "demo -o {run}",
    "demo -o {bad}/x",
    "firmware {gone}",
    "firmware {run}",
    "flash {gone}",
    "flash {bad} --hex {gone}",
    "flash {bad} --board {gone}",
    "completions {gone}",
    "man {run}",
    "man {bad}/x",
    "schema {gone}",
    "names {gone}",
    "lab --class {gone}",
    "lab --class {run}",
    "capture virtual: --until-known {gone}",
    "tabulate {gone}",
];

/// Files of each kind under such a name, by the placeholder in [`CALLS`].
fn forged_files(directory: &Path) -> Vec<(&'static str, String)> {
    let kinds = ["gone", "bad", "run", "log", "plain", "motor", "folder"];
    let named: Vec<_> = kinds
        .map(|kind| (kind, format!("{FORGED} {kind}.csv")))
        .into();
    let name = |kind: &str| {
        let found = named.iter().find(|(of, _)| *of == kind);
        found.map(|(_, name)| name.clone()).expect("a kind")
    };
    let put =
        |kind: &str, text: &str| std::fs::write(directory.join(name(kind)), text).expect("a file");
    put("bad", "no\u{1}thing = [\n");
    put("motor", "resistance_ohm = 9.0\n");
    put(
        "plain",
        "time_ms,position,command_v\n0,0,1\n10,1,1\n20,2,1\n30,4,1\n",
    );
    std::fs::create_dir(directory.join(name("folder"))).expect("a folder");
    let capture = ["capture", "virtual:?speed=max", "--duration", "1"];
    let outputs = ["-o", &name("run"), "--log", "raw.log"];
    let done = run(directory, &[&capture[..], &outputs].concat());
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let raw = std::fs::read_to_string(directory.join("raw.log")).expect("a log");
    // Its last lines are invalid, which is reported with the names of the log and of the run.
    put("log", &format!("{raw}nothing\nnothing\n"));
    named
}

#[test]
fn no_command_prints_a_name_on_more_than_one_line() {
    let directory = tempfile::tempdir().expect("a directory");
    let named = forged_files(directory.path());
    let help = run(directory.path(), &["--help"]);
    let commands = help
        .output
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"));
    for line in commands.skip(1).take_while(|line| !line.is_empty()) {
        let Some(command) = line
            .strip_prefix("  ")
            .and_then(|line| line.split(' ').next())
        else {
            continue;
        };
        let is_called = CALLS
            .iter()
            .any(|call| call.split(' ').next() == Some(command));
        assert!(
            is_called || matches!(command, "" | "help"),
            "no call of {command}"
        );
    }
    let mut wrong = Vec::new();
    for (k, call) in CALLS.iter().enumerate() {
        let mut words: Vec<String> = call.split(' ').map(str::to_owned).collect();
        for word in &mut words {
            for (kind, name) in &named {
                *word = word.replace(&format!("{{{kind}}}"), name);
            }
        }
        if k % 2 == 1 {
            words.push("--json".to_owned());
        }
        let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
        let done = run(directory.path(), &arguments);
        let said = format!("{}{}", done.output, done.messages);
        let forges = said.lines().any(|line| line.starts_with("error: forged"));
        if done.status.is_none() || forges || said.contains(['\u{1b}', '\u{202e}']) {
            wrong.push(format!("{call}: {:?}\n{said}", done.status));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn a_proposed_command_line_is_parsed_by_bash_unchanged() {
    let directory = tempfile::tempdir().expect("a directory");
    let name = "a\n it's\u{1b} b.csv";
    let log = "time_ms,position,command_v\n0,0,1\n10,1,1\n20,2,1\n30,4,1\n";
    std::fs::write(directory.path().join(name), log).expect("a file");
    let done = run(directory.path(), &["import", name]);
    let begins = "  motorlab import ";
    let mut lines = done.messages.lines();
    let line = lines.find_map(|line| line.strip_prefix(begins));
    let (word, _) = line
        .and_then(|line| line.split_once(" --"))
        .unwrap_or_else(|| panic!("{}", done.messages));
    let read = std::process::Command::new("bash")
        .args(["-c", &format!("printf %s {word}")])
        .output();
    match read {
        Ok(read) => assert_eq!(String::from_utf8_lossy(&read.stdout), name, "{word}"),
        Err(_) => support::skip(
            "a_proposed_command_line_is_parsed_by_bash_unchanged",
            "no bash",
        ),
    }
}
