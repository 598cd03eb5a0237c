//! One vocabulary, the field's: phrases that motorlab does not use, each with the term that it does.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::pages::root;

/// Files and folders that are searched, from the root.
const COVERED: &[&str] = &[
    "README.md",
    "CHANGELOG.md",
    "benches",
    "case-generator",
    "docs",
    "fuzz",
    "firmware-protocol",
    "motor-chain",
    "python",
    "src",
    "tests",
    "web",
    "workflow",
];

/// Files that are not searched: this list, data and the notices of others.
const LEFT_OUT: &[&str] = &[
    "tests/docs/vocabulary.rs",
    "src/report/uplot",
    // Independent programs with their own names, and tables of earlier runs.
    "tests/reference",
    "tests/thorough",
    "tests/real/maps",
    "docs/real/found.json",
];

/// Extensions of searched files.
const EXTENSIONS: &[&str] = &[
    "c", "cpp", "css", "h", "html", "ino", "js", "json", "md", "py", "pyi", "rs", "snap", "toml",
];

/// Fixed headings of effects, fields of the case generator, and JSON keys that only a new format number could rename.
const PUBLISHED: &[&str] = &[
    // A type of JavaScript.
    "Promise",
    "What it is",
    "What it does to a recording",
    "What causes it",
    "tells_apart",
    "cannot_tell_apart",
    "\"wander_scale\"",
    "\"wander\"",
    "wander_relative",
    "wander_time_s",
    "wander_counts",
    "gap.wander",
    "gaining_pieces",
    "\"pieces\"",
    "expected_separation",
];

/// Phrases with the term of the field. `*` at the end of a phrase is any end of a word. A phrase of one word is searched
/// in identifiers as well.
const BANNED: &[(&str, &str)] = &[
    ("a little off", "within tolerance"),
    ("another than", "differs from"),
    ("are come by", "are computed"),
    ("are had", "active voice"),
    ("asked of", "asked, expected"),
    ("bears out", "confirms"),
    ("beyond its tolerance", "outside its tolerance"),
    ("beyond their tolerances", "outside their tolerances"),
    ("borne out", "confirmed on held-out data"),
    ("by chance", "at random, null distribution"),
    ("chance makes", "null distribution"),
    ("counts a turn", "counts per revolution"),
    ("cruise*", "steady-speed step"),
    ("goes round", "wraps, rotates"),
    ("gone round", "wrapped"),
    ("going round", "wrapping"),
    ("had back", "reconstructed"),
    ("honest*", "calibrated"),
    ("in which stretches", "time intervals"),
    ("is come by", "is computed"),
    ("is had", "active voice"),
    ("is so", "is true"),
    ("keep back", "hold out"),
    ("keeps back", "holds out"),
    ("kept back", "held out, withheld"),
    ("kept from the fit", "held out"),
    ("ladder*", "step tables"),
    ("less_start", "residual after initial-state correction"),
    ("mend*", "correct, fix"),
    ("motor's numbers", "parameters"),
    ("motor's own numbers", "parameters"),
    ("no chance in it", "deterministic"),
    ("numbers of the motor", "parameters"),
    ("of before", "earlier"),
    ("ordered by what", "residual against"),
    ("other numbers", "re-identified parameters"),
    ("piece", "segment, part"),
    ("pieces", "segments, parts"),
    ("pieced", "joined"),
    ("promise*", "score statistic, guarantee"),
    ("put back", "added again"),
    ("rung", "nested model"),
    ("rungs", "nested models"),
    ("said of", "stated about"),
    ("says of", "states about"),
    ("scatters by", "varies by"),
    ("stood still", "stopped, gap in the time stamps"),
    ("stretch*", "interval, block"),
    ("stroll*", "steady-speed step"),
    ("sure wrong", "overconfident"),
    ("take back", "remove"),
    ("takes back", "removes"),
    ("takes them back", "removes them"),
    ("tell apart", "separate"),
    ("tell them apart", "separate them"),
    ("tell the two apart", "separate the two"),
    ("tells apart", "separates"),
    ("tells them apart", "separates them"),
    ("that is none", "name it"),
    ("there at all", "inclusion probability, present"),
    ("told apart", "separated"),
    ("unseen twin", "unidentifiable direction"),
    ("wander*", "random load torque"),
    ("went round", "wrapped"),
    ("what is there", "name it"),
    ("wrong and sure", "overconfident and wrong"),
    ("% sure", "P = ..."),
];

/// Phrases that readers of the pages had to read twice, with the plain words. Searched in the pages of [`PAGES`]
/// only.
const BANNED_IN_PAGES: &[(&str, &str)] = &[
    ("begins anew", "restarts, wraps"),
    ("cannot see", "cannot show, not visible"),
    (
        "difference rule",
        "difference of the counts over one sample",
    ),
    ("finished call", "call to complete"),
    ("finished command", "command to complete"),
    ("goes on", "continues"),
    ("held against", "compared with"),
    ("holds against", "compares with"),
    ("in mid-run", "during a run"),
    ("in play", "considered"),
    ("is told", "is printed, is commanded"),
    ("one of 255", "full scale 255"),
    ("one folder a", "one folder per"),
    ("one page a", "one page per"),
    ("one row a", "one row per"),
    ("one rule a", "one rule per"),
    ("passed over", "ignored"),
    ("passes over", "ignores"),
    ("says the other", "sets the other"),
    ("taken for", "mistaken for"),
    ("there and back", "up and down"),
    ("told as", "declared as"),
    ("told by", "recognised by"),
    ("turned round", "reversed"),
    ("wait for the clock", "faster than real time"),
];

/// Idiom of comments and names, with the plain words. Searched outside [`OTHER_ROOMS`].
const BANNED_IN_ROOMS: &[(&str, &str)] = &[
    ("bears the encoder", "carries the encoder"),
    ("begin anew", "restart"),
    ("begins anew", "restarts, wraps"),
    ("began anew", "restarted"),
    ("deed*", "action, disturbance"),
    ("goes on", "continues"),
    ("hang together", "are coupled"),
    ("held against", "compared with"),
    ("in mid-run", "during the run"),
    ("in the dark", "without the labels"),
    ("oddit*", "unmodelled effect"),
    ("on end", "in a row, consecutive"),
    ("passed over", "skipped, ignored"),
    ("passes over", "skips, ignores"),
    ("slips of the hand", "misspellings"),
    ("throw dice", "draw random numbers"),
    ("throws dice", "draws random numbers"),
    ("unasked", "without a request"),
];

/// Where [`BANNED_IN_ROOMS`] is not searched: history, the sketch, and modules with their own words.
const OTHER_ROOMS: &[&str] = &[
    "CHANGELOG.md",
    "firmware-protocol/arduino",
    "src/check",
    "src/import",
    "tests/import",
];

/// Pages: every `.md` file of these.
const PAGES: &[&str] = &["README.md", "docs", "firmware-protocol"];

fn files(path: PathBuf, found: &mut Vec<PathBuf>) {
    if LEFT_OUT.iter().any(|out| path == root().join(out)) {
        return;
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_built = name.starts_with('.') || ["target", "__pycache__"].contains(&&*name);
    if path.is_dir() && !is_built {
        let entries = fs::read_dir(&path).expect("a folder");
        for entry in entries {
            files(entry.expect("an entry").path(), found);
        }
    } else if path
        .extension()
        .is_some_and(|end| EXTENSIONS.iter().any(|known| end == *known))
    {
        found.push(path);
    }
}

/// Lines joined, without marks of comments and of quotes, so that a phrase is found across lines.
fn running(text: &str) -> String {
    let marks = ["///", "//!", "//", "#", ">", "*"];
    let bare = text.lines().map(|line| {
        let line = line.trim_start();
        let mark = marks.iter().find(|mark| line.starts_with(**mark));
        mark.map_or(line, |mark| line[mark.len()..].trim_start())
            .trim_end_matches('\\')
    });
    let joined = bare.collect::<Vec<_>>().join(" ");
    joined.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Words of an identifier separated: `held_out` and `HeldOut` as `held out`.
fn with_parts_of_identifiers(text: &str) -> String {
    let mut out = String::new();
    let mut before = ' ';
    for c in text.chars() {
        if c == '_' || (c.is_uppercase() && before.is_lowercase()) {
            out.push(' ');
        }
        if c != '_' {
            out.extend(c.to_lowercase());
        }
        before = c;
    }
    out
}

/// Positions of a phrase as whole words.
fn places<'a>(text: &'a str, phrase: &'a str) -> impl Iterator<Item = usize> + 'a {
    let stem = phrase.trim_end_matches('*');
    let is_open = stem.len() < phrase.len();
    text.match_indices(stem)
        .map(|(at, _)| at)
        .filter(move |&at| {
            let is_word = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
            let before = is_word(text[..at].chars().next_back());
            let after = is_word(text[at + stem.len()..].chars().next());
            !(before && stem.starts_with(char::is_alphanumeric)) && (is_open || !after)
        })
}

/// Sentences that begin with "What" and are no questions, outside headings and links.
fn what_sentences(text: &str) -> Vec<String> {
    let prose = text
        .lines()
        .filter(|line| !line.starts_with('#') || line.starts_with("#["));
    let text = running(&prose.collect::<Vec<_>>().join("\n"));
    let mut found = Vec::new();
    for (at, _) in text.match_indices("What ") {
        let before = text[..at].trim_end();
        let begins = before.is_empty()
            || before.ends_with([
                '.', ':', ';', '"', '|', '-', '?', '!', '*', '`', '}', '{', ',', '(',
            ]);
        let rest = &text[at..];
        let end = rest
            .find(['.', '?', '"', '|', ':', '\\', ']'])
            .unwrap_or(rest.len());
        let is_statement = !rest[end..].starts_with(['?', ']']);
        if begins && is_statement {
            found.push(rest[..end].to_owned());
        }
    }
    found
}

/// Banned phrases of one text, each with its context and its replacement.
fn findings(text: &str) -> Vec<String> {
    let mut original = text.to_owned();
    for key in PUBLISHED {
        original = original.replace(key, "");
    }
    let mut found = phrases(&original, BANNED);
    let what = what_sentences(&original).into_iter();
    found.extend(what.map(|sentence| format!("a sentence with `What` as its subject: {sentence}")));
    found
}

fn phrases(text: &str, banned: &[(&str, &str)]) -> Vec<String> {
    let spaced = running(text).to_lowercase();
    let parted = with_parts_of_identifiers(&running(text));
    let mut found = Vec::new();
    for (phrase, term) in banned {
        let text = if phrase.contains(' ') {
            &spaced
        } else {
            &parted
        };
        for at in places(text, phrase) {
            let start = text[..at]
                .char_indices()
                .rev()
                .nth(40)
                .map_or(0, |(at, _)| at);
            let around: String = text[start..].chars().take(100).collect();
            found.push(format!("`{phrase}` ({term}): {around}"));
        }
    }
    found
}

#[test]
fn banned_phrases_are_found() {
    for bad in [
        "The rungs are\n/// lower.",
        "fn wanders_slowly()",
        "struct KeptPieces;",
        "How they\nare come by is told elsewhere.",
        "Then. What is kept is kept.",
        "80 % sure",
    ] {
        assert!(!findings(bad).is_empty(), "{bad}");
    }
    for bad in [
        "`speed=max` does not wait for the clock.",
        "A bad line is passed\nover.",
    ] {
        assert!(!phrases(bad, BANNED_IN_PAGES).is_empty(), "{bad}");
    }
    for bad in ["fn deed()", "The board begins\n// anew.", "Oddity"] {
        assert!(!phrases(bad, BANNED_IN_ROOMS).is_empty(), "{bad}");
    }
    for good in [
        "What is held out?",
        "# What it is",
        "The segments are held out.",
        "`wander_counts`",
    ] {
        assert_eq!(findings(good), Vec::<String>::new(), "{good}");
    }
}

/// Findings of `search` in the files below some paths, more than `least`, each with the file's name.
fn found_in(
    covered: &[&str],
    least: usize,
    is_read: fn(&Path) -> bool,
    search: fn(&str) -> Vec<String>,
) -> Vec<String> {
    let mut paths = Vec::new();
    for path in covered {
        files(root().join(path), &mut paths);
    }
    paths.retain(|path| is_read(path));
    paths.sort();
    assert!(paths.len() > least, "{}", paths.len());
    let mut found = Vec::new();
    for path in &paths {
        let text = fs::read_to_string(path).expect("text");
        let name = path.strip_prefix(root()).unwrap_or(Path::new("")).display();
        let of_file = search(&text).into_iter();
        found.extend(of_file.map(|one| format!("{name}: {one}")));
    }
    found
}

#[test]
fn pages_have_no_misread_phrase() {
    let is_page = |path: &Path| path.extension().is_some_and(|end| end == "md");
    let found = found_in(PAGES, 60, is_page, |text| phrases(text, BANNED_IN_PAGES));
    assert!(
        found.is_empty(),
        "{} phrases\n{}",
        found.len(),
        found.join("\n")
    );
}

#[test]
fn rooms_have_no_idiom() {
    let in_room = |path: &Path| {
        let name = path.strip_prefix(root()).unwrap_or(path);
        !OTHER_ROOMS.iter().any(|other| name.starts_with(other))
    };
    let found = found_in(COVERED, 80, in_room, |text| phrases(text, BANNED_IN_ROOMS));
    assert!(
        found.is_empty(),
        "{} phrases\n{}",
        found.len(),
        found.join("\n")
    );
}

#[test]
fn texts_use_the_terms_of_the_field() {
    let found = found_in(COVERED, 80, |_| true, findings);
    assert!(
        found.is_empty(),
        "{} phrases\n{}",
        found.len(),
        found.join("\n")
    );
}
