//! Tables of errors that are snapshots and stand in the documentation.

/// The power of ten that an error stays below.
pub fn decade(error: f64) -> String {
    format!("< 1e{}", error.max(1e-12).log10().ceil())
}

/// The table stands in docs/method/simulation.md as it is.
pub fn documented(table: &str) {
    let document =
        std::fs::read_to_string("docs/method/simulation.md").expect("docs/method/simulation.md");
    assert!(
        document.contains(table.trim_end()),
        "docs/method/simulation.md has another table than this:\n{table}"
    );
}
