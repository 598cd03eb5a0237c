//! First steps of a new user: the demo, a virtual port, help for the shell.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::Child;

use crate::support::command::{RunFile, finish, run, start};

#[test]
fn the_demo_records_both_sample_times_and_diagnoses_a_gap() {
    let directory = tempfile::tempdir().expect("a directory");
    let done = run(directory.path(), &["demo", "--json"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let document: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
    let runs = document["comparison"]["runs"].as_array().expect("a list");
    let sample_times: Vec<_> = runs.iter().map(|run| &run["sample_time_s"]).collect();
    assert_eq!(sample_times, [&0.03, &0.003]);
    for run in runs {
        assert_eq!(run["lost"], 0);
        // Quantization is 1/sqrt(12) counts; at rest it is 0.
        let rmse = run["position_rmse_counts"].as_f64().expect("a number");
        assert!((0.2..0.32).contains(&rmse), "{rmse}");
        let file = run["path"].as_str().expect("a path");
        assert!(RunFile::read(&directory.path().join(file)).complete());
    }
    // The third is of another motor: a gap of many counts, and the diagnosis names the board's effect.
    let gap = &document["gap"]["runs"][0];
    assert!(gap["position_rmse_counts"].as_f64() > Some(10.0), "{gap}");
    let diagnosis = &document["diagnosis"];
    assert_eq!(diagnosis["verdict"], "effect", "{}", diagnosis["sentence"]);
    assert_eq!(diagnosis["effects"][0], "voltage_drop");
    let html = document["html"].as_str().expect("a path");
    let html = std::fs::read_to_string(directory.path().join(html)).expect("a page");
    // Agreement, gap and diagnosis are on one page.
    for name in ["step30.csv", "step3.csv", "gap.csv", "Diagnosis of the gap"] {
        assert!(html.contains(name), "{name}");
    }
    assert!(html.matches("<figure data-plot=").count() >= 4);
    // It opens without a network: no address but SVG's name space and the source of uPlot, which is inlined.
    let addresses = html.replace("http://www.w3.org/2000/svg", "");
    let addresses = addresses.replace("/*! https://github.com/leeoniya/uPlot (v1.6.32) */", "");
    for outside in ["http:", "https:", "src=", "@import", "url("] {
        assert!(!addresses.contains(outside), "{outside}");
    }
}

#[test]
fn a_demo_replaces_earlier_runs_and_accepts_a_board_with_an_effect() {
    let directory = tempfile::tempdir().expect("a directory");
    for board in ["", "effect=stribeck"] {
        let done = run(directory.path(), &["demo", "--json", "--board", board]);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let document: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
        assert_eq!(document["comparison"]["runs"][1]["path"], "demo/step3.csv");
    }
    assert!(!directory.path().join("demo/step3-2.csv").exists());
}

/// The first line that a command prints.
fn first_line(child: &mut Child) -> String {
    let mut line = String::new();
    let mut output = BufReader::new(child.stdout.take().expect("a pipe"));
    output.read_line(&mut line).expect("a line");
    line.trim().to_owned()
}

#[test]
fn a_virtual_board_is_a_port_that_capture_opens_again_and_again() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut board = start(directory.path(), &["virtual", "virtual:?speed=max"]);
    let port = first_line(&mut board);
    for name in ["one.csv", "two.csv"] {
        let arguments = ["capture", &port, "--duration", "0.6", "-o", name];
        let done = run(directory.path(), &arguments);
        assert_eq!(done.status, Some(0), "{}", done.messages);
    }
    let counts = |name: &str| RunFile::read(&directory.path().join(name)).column("counts");
    let (one, two) = (counts("one.csv"), counts("two.csv"));
    assert_eq!((one.len(), two.len()), (200, 200));
    // The shaft is where the first run left it, and turns by the same angle, within one count.
    assert!(one[199] > 100.0 && two[0] >= one[199], "{one:?} {two:?}");
    let (first_turn, second_turn) = (one[199] - one[0], two[199] - two[0]);
    assert!((first_turn - second_turn).abs() <= 1.0);
    board.kill().expect("it runs");
    finish(board);
}

#[test]
fn any_program_may_open_a_virtual_board() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut board = start(directory.path(), &["virtual", "virtual:?banner=hello"]);
    let port = first_line(&mut board);
    // As a program without knowledge of motorlab: open, query, read bytes.
    let mut line = File::options()
        .read(true)
        .write(true)
        .open(Path::new(&port))
        .expect("openable");
    // IDENTIFY as in PROTOCOL.md: type 81 and its CRC, COBS-encoded.
    line.write_all(&[0x00, 0x04, 0x81, 0x59, 0x60, 0x00])
        .expect("writable");
    let mut heard = Vec::new();
    let mut block = [0; 64];
    while !heard.windows(4).any(|four| four == b"MLAB") {
        let length = line.read(&mut block).expect("readable");
        assert!(length > 0 && heard.len() < 1000, "{heard:?}");
        heard.extend_from_slice(&block[..length]);
    }
    assert!(heard.starts_with(b"hello"));
    board.kill().expect("it runs");
    finish(board);
}

const SUBCOMMANDS: [&str; 7] = [
    "ports", "capture", "replay", "virtual", "simulate", "compare", "demo",
];

#[test]
fn completions_know_the_subcommands_in_every_shell() {
    let directory = tempfile::tempdir().expect("a directory");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let done = run(directory.path(), &["completions", shell]);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        for name in SUBCOMMANDS {
            assert!(done.output.contains(name), "{shell}: {name}");
        }
    }
    assert_eq!(
        run(directory.path(), &["completions", "csh"]).status,
        Some(2)
    );
}

#[test]
fn there_is_a_manual_page_for_each_subcommand_and_an_example_in_each_help() {
    let directory = tempfile::tempdir().expect("a directory");
    assert_eq!(run(directory.path(), &["man", "man1"]).status, Some(0));
    let page = |name: &str| {
        let path = directory.path().join("man1").join(name);
        std::fs::read_to_string(path).expect("a page")
    };
    assert!(page("motorlab.1").contains(".TH motorlab"));
    for name in SUBCOMMANDS {
        assert!(page(&format!("motorlab-{name}.1")).contains(".SH SYNOPSIS"));
        let help = run(directory.path(), &[name, "--help"]);
        assert!(help.output.contains("Example"), "{name}");
        assert!(help.output.contains("--json"), "{name}");
    }
}

/// A share or a time in another notation does not turn a profile into a path, and a voltage is no share.
#[test]
fn a_profile_that_is_misspelt_is_named_or_explained() {
    let directory = tempfile::tempdir().expect("a directory");
    for (asked, said) in [
        ("crawl@0.25,8", "did you mean 'crawl@0.25,8s'?"),
        ("crwl@0.25,8s", "did you mean 'crawl@0.25,8s'?"),
        ("step@50", "did you mean 'step@0.5'?"),
        ("step@2", "'@2' is no share of the supply"),
        ("step@1.5", "'@1.5' is no share of the supply"),
        ("steps.csv", "cannot read the profile steps.csv"),
    ] {
        let done = run(directory.path(), &["simulate", "--profile", asked]);
        assert_eq!(done.status, Some(2), "{asked}");
        assert!(done.messages.contains(said), "{asked}: {}", done.messages);
        let leads_away = done.messages.contains("step@0.0");
        assert!(!leads_away, "{asked}: {}", done.messages);
    }
}

#[test]
fn a_board_that_names_its_columns_is_not_the_sketch() {
    let directory = tempfile::tempdir().expect("a directory");
    let columns = [
        "capture",
        "virtual:",
        "--columns",
        "t_us,counts,pwm",
        "--duration",
        "1",
    ];
    let done = run(directory.path(), &columns);
    assert_ne!(done.status, Some(0));
    assert!(
        done.messages.contains("leave out --columns") && !done.messages.contains("MLAB"),
        "{}",
        done.messages
    );
}
