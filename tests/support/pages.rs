//! The pages of the documentation as text: links, anchors, command lines, sentences.

use std::fs;
use std::path::{Component, Path, PathBuf};

/// The repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// One page.
pub struct Page {
    /// Path from the root.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

/// README, CHANGELOG and everything under docs.
pub fn all() -> Vec<Page> {
    let mut paths = vec![PathBuf::from("README.md"), PathBuf::from("CHANGELOG.md")];
    let mut folders = vec![PathBuf::from("docs")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).expect("a folder") {
            let entry = entry.expect("an entry");
            let path = folder.join(entry.file_name());
            if entry.file_type().expect("a type").is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "md") {
                paths.push(path);
            }
        }
    }
    paths.sort();
    paths.iter().map(|path| Page::read(path)).collect()
}

impl Page {
    pub fn read(path: &Path) -> Self {
        let text = fs::read_to_string(root().join(path));
        Self {
            path: path.to_owned(),
            text: text.unwrap_or_else(|error| panic!("{}: {error}", path.display())),
        }
    }

    /// A path in the page, from the root; the page itself for the empty one.
    pub fn beside(&self, relative: &str) -> PathBuf {
        if relative.is_empty() {
            return self.path.clone();
        }
        let mut target = PathBuf::new();
        let folder = self.path.parent().expect("a folder");
        for part in folder.join(relative).components() {
            match part {
                Component::ParentDir => {
                    target.pop();
                }
                other => target.push(other),
            }
        }
        target
    }

    /// Lines outside fenced blocks, without text between grave accents.
    fn prose(&self) -> impl Iterator<Item = String> {
        let mut fenced = false;
        self.text.lines().filter_map(move |line| {
            let fence = line.trim_start().starts_with("```");
            fenced ^= fence;
            (!fence && !fenced).then(|| without_code(line))
        })
    }

    /// Targets of its links and pictures, except network addresses.
    pub fn links(&self) -> Vec<String> {
        let mut links = Vec::new();
        for line in self.prose() {
            for rest in line.split("](").skip(1) {
                let link = rest.split(')').next().unwrap_or_default();
                if !link.contains(':') {
                    links.push(link.to_owned());
                }
            }
        }
        links
    }

    /// The anchors of its headings, as GitHub and mdBook make them.
    pub fn anchors(&self) -> Vec<String> {
        let mut anchors: Vec<String> = Vec::new();
        let mut fenced = false;
        for line in self.text.lines() {
            fenced ^= line.trim_start().starts_with("```");
            if fenced || !line.starts_with('#') {
                continue;
            }
            let heading = line.trim_start_matches('#').trim().to_lowercase();
            let kept = heading
                .chars()
                .filter(|c| c.is_alphanumeric() || "-_ ".contains(*c));
            let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
            let before = anchors.iter().filter(|there| **there == anchor).count();
            anchors.push(match before {
                0 => anchor,
                n => format!("{anchor}-{n}"),
            });
        }
        anchors
    }

    /// The lines of its `sh` blocks that call the program, one per call.
    pub fn commands(&self) -> Vec<String> {
        let mut commands = Vec::new();
        let mut inside = false;
        for line in self.text.lines() {
            if line.starts_with("```") {
                inside = line == "```sh";
            } else if inside {
                let calls = line.split("&&").map(str::trim);
                let ours = calls.filter(|call| call.starts_with("motorlab "));
                commands.extend(ours.map(str::to_owned));
            }
        }
        commands
    }
}

/// A line without text between grave accents; links whose text is code stay links.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("code")
}

/// A command line as a shell splits it: quotes, comments, and nothing from a redirection on.
pub fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in line.chars() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '>' | '|') => break,
            (None, '#') if word.is_none() => break,
            (None, ' ') => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

/// The sentences of a page: of paragraphs, list items and table cells. Code is one word; a cell is a list with
/// semicolons, or an equation and no sentence.
pub fn sentences(text: &str) -> Vec<String> {
    let (mut blocks, mut open, mut fenced) = (Vec::new(), String::new(), false);
    for line in text.lines() {
        let trimmed = line.trim();
        let fence = trimmed.starts_with("```");
        fenced ^= fence;
        let indented = line.starts_with("    ") && open.is_empty();
        if fence || fenced || trimmed.is_empty() || trimmed.starts_with('#') || indented {
            blocks.push(std::mem::take(&mut open));
        } else if trimmed.starts_with('|') {
            blocks.push(std::mem::take(&mut open));
            let cells = without_code(trimmed).replace(';', "|");
            let said = cells.split('|').filter(|cell| !cell.contains(" = "));
            blocks.extend(said.map(str::to_owned));
        } else {
            if let Some(item) = item(trimmed) {
                blocks.push(std::mem::replace(&mut open, item.to_owned()));
            } else {
                open.push(' ');
                open.push_str(trimmed);
            }
        }
    }
    blocks.push(open);
    let mut sentences = Vec::new();
    for block in blocks {
        let plain = without_targets(&without_code(&block));
        let mut sentence = Vec::new();
        for word in plain.split_whitespace() {
            sentence.push(word);
            let bare = word.trim_end_matches([')', '"', '*', ']']);
            if bare.ends_with(['.', '?', '!']) {
                sentences.push(sentence.join(" "));
                sentence.clear();
            }
        }
        sentences.push(sentence.join(" "));
    }
    sentences
}

/// Text after the mark of a list item.
fn item(line: &str) -> Option<&str> {
    let dashed = line.strip_prefix("- ").or_else(|| line.strip_prefix("* "));
    dashed.or_else(|| {
        let (number, rest) = line.split_once(". ")?;
        number.parse::<u32>().is_ok().then_some(rest)
    })
}

/// Links as their text, pictures as nothing.
fn without_targets(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("](") {
        let end = rest[at..].find(')').map_or(rest.len(), |end| at + end + 1);
        let begin = rest[..at].rfind('[').unwrap_or(at);
        let picture = rest[..begin].ends_with('!');
        out.push_str(rest[..begin].trim_end_matches('!'));
        if !picture {
            out.push_str(rest.get(begin + 1..at).unwrap_or_default());
        }
        rest = &rest[end..];
    }
    out.push_str(rest);
    out
}
