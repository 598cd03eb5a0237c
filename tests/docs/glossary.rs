//! The glossary: terms sorted and unique, each in use, each JSON key in its schema.

use std::fs;
use std::path::Path;

use crate::support::pages::{self, Page, root};
use serde_json::Value;

const GLOSSARY: &str = "docs/reference/glossary.md";

/// A row of the glossary's table.
struct Row {
    term: String,
    definition: String,
    /// JSON path and file of its schema.
    key: Option<(String, String)>,
}

fn rows() -> Vec<Row> {
    let page = Page::read(Path::new(GLOSSARY));
    let lines = page.text.lines().filter(|line| line.starts_with("| **"));
    lines
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            let [term, definition, _, _, key] = cells[..] else {
                panic!("not five cells: {line}");
            };
            let key = key.strip_prefix("[`").map(|key| {
                let (path, link) = key.split_once("`](").expect("a link");
                (path.to_owned(), link.trim_end_matches(')').to_owned())
            });
            Row {
                term: term.trim_matches('*').to_owned(),
                definition: definition.to_owned(),
                key,
            }
        })
        .collect()
}

fn resolved<'a>(schema: &'a Value, root: &'a Value) -> &'a Value {
    match schema["$ref"].as_str() {
        Some(target) => root
            .pointer(target.trim_start_matches('#'))
            .expect("a definition"),
        None => schema,
    }
}

/// Whether a schema has `a.b[].c`, with `*` for any key of a map.
fn has(schema: &Value, root: &Value, path: &str) -> bool {
    let schema = resolved(schema, root);
    for alternative in ["anyOf", "oneOf", "allOf"] {
        if let Some(alternatives) = schema[alternative].as_array() {
            return alternatives.iter().any(|one| has(one, root, path));
        }
    }
    if let Some(rest) = path.strip_prefix("[]") {
        return schema
            .get("items")
            .is_some_and(|items| has(items, root, rest));
    }
    let path = path.trim_start_matches('.');
    if path.is_empty() {
        return true;
    }
    let end = path.find(['.', '[']).unwrap_or(path.len());
    let (key, rest) = path.split_at(end);
    let next = match key {
        "*" => schema.get("additionalProperties"),
        key => schema.get("properties").and_then(|all| all.get(key)),
    };
    next.is_some_and(|next| has(next, root, rest))
}

#[test]
fn terms_are_sorted_unique_and_defined() {
    let rows = rows();
    assert!(rows.len() >= 60, "{}", rows.len());
    let folded: Vec<String> = rows.iter().map(|row| row.term.to_lowercase()).collect();
    for pair in folded.windows(2) {
        assert!(pair[0] < pair[1], "{} before {}", pair[0], pair[1]);
    }
    for row in &rows {
        let sentences = pages::sentences(&row.definition);
        assert!(
            (1..=2).contains(&sentences.iter().filter(|one| !one.is_empty()).count()),
            "{}",
            row.term
        );
    }
}

#[test]
fn every_key_is_in_its_schema() {
    let keys: Vec<(String, String)> = rows().into_iter().filter_map(|row| row.key).collect();
    assert!(keys.len() >= 40, "{}", keys.len());
    for (path, link) in keys {
        let file = Page::read(Path::new(GLOSSARY)).beside(&link);
        let text = fs::read_to_string(root().join(&file)).expect("a schema");
        let schema: Value = serde_json::from_str(&text).expect("JSON");
        assert!(has(&schema, &schema, &path), "{path} in {}", file.display());
    }
}

#[test]
fn every_term_is_in_use_and_pages_link_to_the_glossary() {
    let mut texts = Vec::new();
    for page in pages::all() {
        let linked = page
            .links()
            .iter()
            .any(|link| page.beside(link) == Path::new(GLOSSARY));
        let wants = [
            "docs/README.md",
            "docs/SUMMARY.md",
            "docs/method/diagnosis.md",
            "docs/reference/reading-a-diagnosis.md",
        ];
        if wants.iter().any(|path| page.path == Path::new(path)) {
            assert!(linked, "{} does not link to it", page.path.display());
        }
        if page.path != Path::new(GLOSSARY) {
            texts.push(page.text);
        }
    }
    let schemas = fs::read_dir(root().join("docs/json")).expect("a folder");
    texts.extend(schemas.filter_map(|file| fs::read_to_string(file.ok()?.path()).ok()));
    let text = texts.join(" ").to_lowercase();
    let words: Vec<&str> = text.split_whitespace().collect();
    let text = words.join(" ");
    let unused: Vec<String> = (rows().into_iter().map(|row| row.term))
        .filter(|term| !text.contains(&term.to_lowercase()))
        .collect();
    assert!(unused.is_empty(), "{unused:?}");
}
