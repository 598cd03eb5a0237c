//! Names that shells complete, by bash, fish and zsh, and `motorlab names`.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use crate::support::command::run;
use motorlab::board::BUILT_IN;
use motorlab::motor::catalogue::catalogue;
use serde_json::Value;

/// Proposals of a shell for this line.
type Proposed = fn(&Path, &str) -> Vec<String>;

fn in_bash(script: &Path, line: &str) -> Vec<String> {
    let asked = r#"
        source "$1" || exit 1
        COMP_LINE=$2 COMP_POINT=${#2} COMP_WORDS=($2) COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        _motorlab_or_names motorlab "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
        printf '%s\n' "${COMPREPLY[@]}""#;
    lines_of("bash", &["-c", asked, "bash"], script, line)
}

fn in_fish(script: &Path, line: &str) -> Vec<String> {
    let asked = "source $argv[1]; or exit 1; complete -C $argv[2]";
    let lines = lines_of("fish", &["--no-config", "-c", asked, "--"], script, line);
    let words = lines.iter().filter_map(|line| line.split('\t').next());
    words.map(str::to_owned).collect()
}

/// Calls the script's function as zsh's completion does, and prints its proposals.
fn in_zsh(script: &Path, line: &str) -> Vec<String> {
    let asked = r#"
        compdef() { : }
        source "$1" || exit 1
        compadd() { shift 3; print -rl -- "$@" }
        _motorlab_generated() { print -l generated }
        words=(${(z)2}); [[ $2 == *" " ]] && words+=("")
        CURRENT=$#words PREFIX=$words[-1]
        _motorlab"#;
    lines_of("zsh", &["-fc", asked, "zsh"], script, line)
}

fn lines_of(shell: &str, before: &[&str], script: &Path, line: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_BIN_EXE_motorlab"))
        .parent()
        .expect("a folder");
    let others = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(folder.to_owned()).chain(std::env::split_paths(&others));
    let done = Command::new(shell)
        .args(before)
        .arg(script)
        .arg(line)
        .env("PATH", std::env::join_paths(paths).expect("paths"))
        .output()
        .expect("the shell starts");
    let text = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(
        done.status.success(),
        "{shell}: {line}: {text}{}",
        String::from_utf8_lossy(&done.stderr)
    );
    text.lines().map(str::to_owned).collect()
}

#[test]
fn shells_complete_profiles_columns_and_effects() {
    let shells: [(&str, Proposed); 3] = [("bash", in_bash), ("fish", in_fish), ("zsh", in_zsh)];
    for (shell, proposed) in shells {
        if Command::new(shell).arg("--version").output().is_err() {
            eprintln!("skipped: there is no {shell}");
            continue;
        }
        let keep = tempfile::tempdir().expect("a folder");
        let done = run(keep.path(), &["completions", shell]);
        let script = keep.path().join("motorlab.script");
        std::fs::write(&script, done.output).expect("written");
        // The text after the word's last break, which `@` and `:` are in bash, is completed.
        let kept = |word: &str, rest: &str| {
            if shell == "bash" {
                rest.to_owned()
            } else {
                format!("{word}{rest}")
            }
        };
        for (line, some) in [
            (
                "motorlab capture COM3 --profile cr",
                vec!["crawl".to_owned()],
            ),
            (
                "motorlab capture COM3 --profile ",
                vec!["step".to_owned(), "reversing".to_owned()],
            ),
            (
                "motorlab simulate --profile crawl@0.1",
                vec![kept("crawl@", "0.1"), kept("crawl@", "0.15")],
            ),
            (
                "motorlab simulate --profile crawl@0.2,",
                vec![kept("crawl@", "0.2,15s")],
            ),
            (
                "motorlab capture COM3 --columns t_us,cou",
                vec!["t_us,counts".to_owned()],
            ),
            ("motorlab effects back", vec!["backlash".to_owned()]),
            ("motorlab schema diag", vec!["diagnosis".to_owned()]),
            (
                "motorlab effects trans",
                vec!["transport_delay".to_owned(), "transmission".to_owned()],
            ),
            (
                "motorlab demo --board effect=stri",
                vec![kept("effect=", "stribeck")],
            ),
        ] {
            let proposed = proposed(&script, line);
            for word in &some {
                assert!(
                    proposed.contains(word),
                    "{shell}: {line}: {word}: {proposed:?}"
                );
            }
            assert!(proposed.len() < 60, "{shell}: {line}: {proposed:?}");
        }
        assert!(!proposed(&script, "motorlab effects back").contains(&"cogging".to_owned()));
    }
}

/// Special cases of bash: broken words, quoted words, and completions of the generated script.
#[test]
fn bash_completes_words_with_word_breaks() {
    if Command::new("bash").arg("--version").output().is_err() {
        eprintln!("skipped: there is no bash");
        return;
    }
    let keep = tempfile::tempdir().expect("a folder");
    let done = run(keep.path(), &["completions", "bash"]);
    let script = keep.path().join("motorlab.bash");
    std::fs::write(&script, done.output).expect("written");
    for (line, word) in [
        ("motorlab capture virtual:?eff", "?effect="),
        ("motorlab capture virtual:?effect=back", "backlash"),
        (
            "motorlab capture 'virtual:?effect=backlash&ga",
            "virtual:?effect=backlash&gap_rad=",
        ),
        ("motorlab capt", "capture"),
        ("motorlab capture COM3 --unt", "--until-known"),
    ] {
        let proposed = in_bash(&script, line);
        assert!(
            proposed.iter().any(|known| known == word),
            "{line}: {proposed:?}"
        );
    }
}

#[test]
fn only_options_of_the_help_are_completed() {
    if Command::new("bash").arg("--version").output().is_err() {
        eprintln!("skipped: there is no bash");
        return;
    }
    let keep = tempfile::tempdir().expect("a folder");
    let done = run(keep.path(), &["completions", "bash"]);
    let script = keep.path().join("motorlab.bash");
    std::fs::write(&script, done.output).expect("written");
    let proposed = in_bash(&script, "motorlab names --");
    assert!(proposed.contains(&"--json".to_owned()), "{proposed:?}");
    assert!(
        !proposed.contains(&"--completing".to_owned()),
        "{proposed:?}"
    );
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
