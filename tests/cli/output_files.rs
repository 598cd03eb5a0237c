//! No output replaces a file of another command or a person, and every failure is a document with `--json`.

use std::fs;
use std::path::Path;

use crate::support::command::run;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let made = run(
        folder.path(),
        &["simulate", "--duration", "0.5", "-o", "run.csv"],
    );
    assert_eq!(made.status, Some(0), "{}", made.messages);
    fs::write(folder.path().join("motor.toml"), "resistance_ohm = 9.0\n").expect("a file");
    folder
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).expect("a file")
}

/// No temporary files remain in the folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

/// The arguments of every command with an output file, with `{}` for the file.
const WRITERS: [&[&str]; 8] = [
    &[
        "compare",
        "run.csv",
        "--motor",
        "motor.toml",
        "--html",
        "{}",
    ],
    &["compare", "run.csv", "--motor", "motor.toml", "--svg", "{}"],
    &[
        "simulate",
        "--motor",
        "motor.toml",
        "--duration",
        "0.5",
        "--svg",
        "{}",
    ],
    &[
        "diagnose",
        "run.csv",
        "--motor",
        "motor.toml",
        "--model-out",
        "{}",
    ],
    &[
        "diagnose",
        "run.csv",
        "--motor",
        "motor.toml",
        "--html",
        "{}",
    ],
    &["export", "json", "--motor", "motor.toml", "-o", "{}"],
    &["export", "mujoco", "--motor", "motor.toml", "-o", "{}"],
    &["export", "urdf", "--motor", "motor.toml", "-o", "{}"],
];

fn with(arguments: &[&'static str], file: &'static str) -> Vec<&'static str> {
    let put = |argument: &&'static str| if *argument == "{}" { file } else { argument };
    arguments.iter().map(put).collect()
}

#[test]
fn inputs_links_and_files_of_other_users_are_not_overwritten() {
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("notes.txt"), "mine").expect("a file");
    fs::hard_link(path.join("motor.toml"), path.join("hard")).expect("a link");
    fs::create_dir(path.join("inner")).expect("a folder");
    #[cfg(unix)]
    std::os::unix::fs::symlink("notes.txt", path.join("soft")).expect("a link");
    let before = (names(path), read(path, "run.csv"), read(path, "motor.toml"));
    for arguments in WRITERS {
        for target in [
            "motor.toml",
            "hard",
            "soft",
            "inner",
            "./inner/../motor.toml",
        ] {
            let mut arguments = with(arguments, target);
            arguments.push("--force");
            let done = run(path, &arguments);
            assert_eq!(done.status, Some(2), "{arguments:?}: {}", done.messages);
            assert!(done.messages.contains(target), "{}", done.messages);
        }
        let done = run(path, &with(arguments, "notes.txt"));
        assert_eq!(done.status, Some(2), "{arguments:?}: {}", done.messages);
        assert!(done.messages.contains("--force"), "{}", done.messages);
        let done = run(path, &with(arguments, "none/there"));
        assert_eq!(done.status, Some(3), "{arguments:?}: {}", done.messages);
    }
    let compare = run(
        path,
        &["compare", "run.csv", "--html", "run.csv", "--force"],
    );
    assert_eq!(compare.status, Some(2));
    let after = (names(path), read(path, "run.csv"), read(path, "motor.toml"));
    assert_eq!(before, after);
    assert_eq!(read(path, "notes.txt"), b"mine");
}

#[test]
fn only_files_of_the_same_command_are_replaced() {
    let folder = folder();
    let path = folder.path();
    let all = WRITERS
        .iter()
        .filter(|arguments| arguments[0] != "diagnose");
    for arguments in all {
        let file = "written";
        assert_eq!(
            run(path, &with(arguments, file)).status,
            Some(0),
            "{arguments:?}"
        );
        assert_eq!(
            run(path, &with(arguments, file)).status,
            Some(0),
            "{arguments:?}"
        );
        let other: &[&str] = if arguments[0] == "export" {
            WRITERS[0]
        } else {
            WRITERS[5]
        };
        assert_eq!(
            run(
                path,
                &with(
                    &[other[0], other[1], other[2], other[3], other[4], "{}"],
                    file
                )
            )
            .status,
            Some(2)
        );
        let mut forced = with(other, file);
        forced.push("--force");
        assert_eq!(run(path, &forced).status, Some(0), "{forced:?}");
        fs::remove_file(path.join(file)).expect("a file");
    }
    assert_eq!(names(path), ["motor.toml", "run.csv"]);
}

/// Arguments, exit status, and the document's kind, file and row.
type Failing<'a> = (&'a [&'a str], i32, &'a str, Option<&'a str>, Option<u64>);

#[test]
fn every_failure_is_a_document() {
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("bad.csv"), "# format = \"motorlab-run/1\"\n# counts_per_rev = 720\nt_s,command_v,counts\n0,1,2\n0.1,x,2\n0.2,1,2\n")
        .expect("a file");
    for (name, text) in [
        ("map.toml", "supply_v = 5\n[time]\nunit = ms\n"),
        ("lacks.toml", "[time]\nunit = \"ms\"\n"),
        (
            "right.toml",
            "counts_per_rev = 720\n[time]\ncolumn = \"t\"\nunit = \"ms\"\n[command]\ncolumn = \"u\"\nunit = \"V\"\n[position]\ncolumn = \"n\"\nunit = \"counts\"\n",
        ),
        ("log.csv", "a,b,c\n1,2,3\n"),
        ("odd.toml", "resistance_ohm = 9.0\ninertia = 1\n"),
        ("profile.csv", "t_s,command_v\n0,1\n1,x\n"),
    ] {
        fs::write(path.join(name), text).expect("a file");
    }
    fs::create_dir(path.join("inner")).expect("a folder");
    let cases: [Failing<'_>; 23] = [
        (
            &["compare", "bad.csv"],
            2,
            "bad_input",
            Some("bad.csv"),
            Some(5),
        ),
        (
            &["check", "bad.csv"],
            2,
            "bad_input",
            Some("bad.csv"),
            Some(5),
        ),
        (
            &["diagnose", "bad.csv"],
            2,
            "bad_input",
            Some("bad.csv"),
            Some(5),
        ),
        (
            &["lab", "--run", "bad.csv"],
            2,
            "bad_input",
            Some("bad.csv"),
            Some(5),
        ),
        (
            &["compare", "none.csv"],
            2,
            "bad_input",
            Some("none.csv"),
            None,
        ),
        (
            &["simulate", "--motor", "none.toml"],
            2,
            "bad_input",
            Some("none.toml"),
            None,
        ),
        (
            &["simulate", "--svg", "no/x.svg"],
            3,
            "cannot_write",
            Some("no/x.svg"),
            None,
        ),
        (
            &["compare", "run.csv", "--html", "run.csv"],
            2,
            "output_refused",
            Some("run.csv"),
            None,
        ),
        (
            &["export", "urdf", "-o", "run.csv"],
            2,
            "output_refused",
            Some("run.csv"),
            None,
        ),
        (&["design", "--bogus"], 2, "wrong_use", None, None),
        (&["bogus"], 2, "wrong_use", None, None),
        (&[], 2, "wrong_use", None, None),
        (
            &["blind", "run", "nowhere"],
            2,
            "bad_input",
            Some("nowhere/manifest.json"),
            None,
        ),
        (
            &["import", "none.log", "--map", "none.toml"],
            2,
            "bad_input",
            Some("none.toml"),
            None,
        ),
        (
            &["import", "none.log", "--map", "map.toml"],
            2,
            "bad_input",
            Some("map.toml"),
            Some(3),
        ),
        (
            &["import", "none.log", "--map", "lacks.toml"],
            2,
            "bad_input",
            Some("lacks.toml"),
            Some(1),
        ),
        (
            &["import", "log.csv", "--map", "right.toml"],
            2,
            "bad_input",
            Some("log.csv"),
            Some(1),
        ),
        (
            &["simulate", "--motor", "odd.toml"],
            2,
            "bad_input",
            Some("odd.toml"),
            Some(2),
        ),
        (
            &["simulate", "--profile", "profile.csv"],
            2,
            "bad_input",
            Some("profile.csv"),
            Some(3),
        ),
        (
            &["export", "json", "--motor", "odd.toml", "-o", "run.csv"],
            2,
            "output_refused",
            Some("run.csv"),
            None,
        ),
        (
            &["capture", "virtual:", "-o", "."],
            2,
            "output_refused",
            Some("."),
            None,
        ),
        (
            &["capture", "virtual:", "-o", "new.csv", "--log", ".."],
            2,
            "output_refused",
            Some(".."),
            None,
        ),
        (
            &["replay", "log.csv", "-o", "inner"],
            2,
            "output_refused",
            Some("inner"),
            None,
        ),
    ];
    for (arguments, status, kind, file, row) in cases {
        let all: Vec<&str> = arguments.iter().copied().chain(["--json"]).collect();
        let done = run(path, &all);
        assert_eq!(done.status, Some(status), "{all:?}: {}", done.messages);
        let document: serde_json::Value = serde_json::from_str(&done.output)
            .unwrap_or_else(|error| panic!("{all:?}: {error}: {}", done.output));
        let error = &document["error"];
        assert_eq!(error["kind"], kind, "{all:?}");
        assert_eq!(error["file"].as_str(), file, "{all:?}");
        assert_eq!(error["row"].as_u64(), row, "{all:?}");
        assert!(
            error["message"]
                .as_str()
                .is_some_and(|text| !text.is_empty())
        );
        assert!(error.get("remedy").is_some());
        assert!(done.messages.contains("error: "), "{}", done.messages);
    }
}

#[test]
fn a_long_name_gives_a_short_message() {
    let folder = folder();
    let name = format!("{}\u{202e}.csv", "a".repeat(100_000));
    let done = run(folder.path(), &["compare", &name]);
    assert_eq!(done.status, Some(2));
    assert!(done.messages.len() < 4000 && !done.messages.contains('\u{202e}'));
}

/// Files of an earlier call are kept if the next one fails.
#[cfg(unix)]
#[test]
fn a_demo_that_fails_leaves_the_runs_of_the_earlier_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let board = ["--board", "speed=max"];
    let first = run(path, &[&["demo"][..], &board].concat());
    assert_eq!(first.status, Some(0), "{}", first.messages);
    let demo = path.join("demo");
    let before = (
        names(&demo),
        read(&demo, "step30.csv"),
        read(&demo, "step3.csv"),
    );
    assert!(
        !before.0.iter().any(|name| name.starts_with('.')),
        "{before:?}"
    );
    // Left by a call that was killed.
    fs::write(demo.join(".motorlab-step30.csv"), "half").expect("a file");
    let failed = run(path, &["demo", "--board", "speed=max&hang_up_after=20"]);
    assert_ne!(failed.status, Some(0), "{}", failed.messages);
    assert_eq!(before.1, read(&demo, "step30.csv"));
    assert_eq!(before.2, read(&demo, "step3.csv"));
    let again = run(path, &[&["demo"][..], &board].concat());
    assert_eq!(again.status, Some(0), "{}", again.messages);
    assert_eq!(names(&demo), before.0);
    assert_ne!(before.1, read(&demo, "step30.csv"));
}

/// A simulated run takes the next free name, and with `--force` the place of the run, but never that of its profile.
#[test]
fn a_simulated_run_replaces_another_only_with_force() {
    let directory = tempfile::tempdir().expect("a directory");
    let here = directory.path();
    let simulate = |ts: &str, more: &[&str]| {
        let asked = ["simulate", "--duration", "1", "-o", "run.csv", "--ts", ts];
        run(here, &[&asked, more].concat())
    };
    let rows = |name: &str| {
        let text = std::fs::read_to_string(here.join(name)).expect("a run");
        text.lines().filter(|line| !line.starts_with('#')).count() - 1
    };
    for (ts, more) in [("0.1", &[][..]), ("0.05", &[]), ("0.01", &["--force"])] {
        let done = simulate(ts, more);
        assert_eq!(done.status, Some(0), "{}", done.messages);
    }
    assert_eq!((rows("run.csv"), rows("run-2.csv")), (101, 21));
    let refused = simulate("0.1", &["--force", "--profile", "run.csv"]);
    assert_eq!(refused.status, Some(2), "{}", refused.messages);
    assert!(
        refused.messages.contains("is an input"),
        "{}",
        refused.messages
    );
    assert_eq!(rows("run.csv"), 101);
    let names = std::fs::read_dir(here).expect("a directory");
    assert_eq!(names.count(), 2, "nothing else is left");
}
