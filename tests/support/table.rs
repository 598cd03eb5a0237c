//! Tables of errors that are snapshots and part of the documentation.

/// The power of ten that bounds an error.
pub fn decade(error: f64) -> String {
    format!("< 1e{}", error.max(1e-12).log10().ceil())
}

/// The table is in docs/method/simulation.md.
pub fn documented(table: &str) {
    let document =
        std::fs::read_to_string("docs/method/simulation.md").expect("docs/method/simulation.md");
    assert!(
        document.contains(table.trim_end()),
        "docs/method/simulation.md has another table than this:\n{table}"
    );
}
