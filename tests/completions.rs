//! Names that the shell completes, asked of bash itself, and `motorlab names`.
#![cfg(unix)]

#[path = "support/command.rs"]
mod command;

use std::path::Path;
use std::process::Command;

use command::run;
use motorlab::board::BUILT_IN;
use motorlab::motor::catalogue::catalogue;
use serde_json::Value;

/// What bash proposes where the cursor stands behind this line.
fn proposed(script: &Path, line: &str) -> Vec<String> {
    let asked = r#"
        source "$1" || exit 1
        COMP_LINE=$2 COMP_POINT=${#2} COMP_WORDS=($2) COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        _motorlab_or_names motorlab "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
        printf '%s\n' "${COMPREPLY[@]}""#;
    let done = Command::new("bash")
        .args(["-c", asked, "bash"])
        .arg(script)
        .arg(line)
        .output()
        .expect("bash starts");
    let text = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(
        done.status.success(),
        "{line}: {text}{}",
        String::from_utf8_lossy(&done.stderr)
    );
    text.lines().map(str::to_owned).collect()
}

#[test]
fn bash_completes_profiles_columns_and_effects() {
    if Command::new("bash").arg("--version").output().is_err() {
        eprintln!("skipped: there is no bash");
        return;
    }
    let keep = tempfile::tempdir().expect("a folder");
    let done = run(keep.path(), &["completions", "bash"]);
    let script = keep.path().join("motorlab.bash");
    std::fs::write(&script, done.output).expect("written");
    for (line, some) in [
        ("motorlab capture COM3 --profile cr", &["crawl"][..]),
        ("motorlab capture COM3 --profile ", &["step", "reversing"]),
        // Behind the last break of the word, which `@` is.
        ("motorlab simulate --profile crawl@0.1", &["0.1", "0.15"]),
        ("motorlab simulate --profile crawl@0.2,", &["0.2,15s"]),
        ("motorlab capture COM3 --columns t_us,cou", &["t_us,counts"]),
        ("motorlab effects back", &["backlash"]),
        (
            "motorlab effects trans",
            &["transport_delay", "transmission"],
        ),
        ("motorlab capture virtual:?eff", &["?effect="]),
        ("motorlab capture virtual:?effect=back", &["backlash"]),
        // In quotes bash leaves the word whole.
        (
            "motorlab capture 'virtual:?effect=backlash&ga",
            &["virtual:?effect=backlash&gap_rad="],
        ),
        ("motorlab demo --board effect=stri", &["stribeck"]),
        // What the generated script knows goes on as before.
        ("motorlab capt", &["capture"]),
        ("motorlab capture COM3 --unt", &["--until-known"]),
    ] {
        let proposed = proposed(&script, line);
        for word in some {
            assert!(
                proposed.iter().any(|known| known == word),
                "{line}: {word}: {proposed:?}"
            );
        }
        assert!(proposed.len() < 60, "{line}: {proposed:?}");
    }
    assert!(!proposed(&script, "motorlab effects back").contains(&"cogging".to_owned()));
}

#[test]
fn names_are_listed_for_people_and_programs() {
    let keep = tempfile::tempdir().expect("a folder");
    let all = run(keep.path(), &["names", "--json"]);
    let all: Value = serde_json::from_str(&all.output).expect("one document");
    assert_eq!(all["shape"], "motorlab-names/1");
    let names = |kind: &str| -> Vec<&str> {
        let list = all[kind].as_array().expect("a list").iter();
        list.filter_map(|named| named["name"].as_str()).collect()
    };
    assert_eq!(names("profiles"), BUILT_IN.map(|(name, _)| name));
    let ids: Vec<&str> = catalogue().iter().map(|kind| kind.id).collect();
    assert_eq!(names("effects"), ids);
    assert!(names("columns").contains(&"pwm") && names("keys").contains(&"seed"));
    let columns = run(keep.path(), &["names", "columns"]);
    assert!(columns.output.contains("counts of the encoder") && !columns.output.contains("crawl"));
}
