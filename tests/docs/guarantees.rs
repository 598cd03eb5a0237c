//! The tests that docs/method/recorder.md names for its guarantees exist.

use std::fs;
use std::path::Path;

/// Words between grave accents that name a test by its path.
fn named_tests(text: &str) -> Vec<&str> {
    let words = text.split('`').skip(1).step_by(2);
    words.filter(|word| word.contains("::")).collect()
}

/// Possible source files of `file::test` or `room::file::test`.
fn sources(path: &[&str]) -> Vec<String> {
    let joined = path.join("/");
    [
        format!("tests/{joined}.rs"),
        format!("src/{joined}.rs"),
        format!("src/{joined}/mod.rs"),
    ]
    .into_iter()
    .filter_map(|file| fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).ok())
    .collect()
}

#[test]
fn every_test_that_the_documentation_names_is_there() {
    let named = named_tests(include_str!("../../docs/method/recorder.md"));
    assert!(named.len() > 40, "{}", named.len());
    for name in named {
        let parts: Vec<&str> = name.split("::").collect();
        let Some((test, path)) = parts.split_last() else {
            continue;
        };
        let wanted = format!("fn {test}(");
        let found = sources(path).iter().any(|text| text.contains(&wanted));
        assert!(found, "{name}");
    }
}

#[test]
fn the_table_of_faults_is_the_one_that_its_test_holds() {
    let snapshot = include_str!("../recorder/snapshots/recorder__faults__the_sweep.snap");
    let table = snapshot.rsplit("---").next().unwrap_or_default();
    let document = include_str!("../../docs/method/recorder.md");
    for row in table.lines().filter(|row| !row.is_empty()) {
        assert!(document.contains(&format!("    {row}\n")), "{row}");
    }
}
