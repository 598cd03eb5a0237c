//! Text from files and devices without control characters, and of limited length, for output.

use std::borrow::Cow;
use std::path::Path;

use serde::Serialize;

/// A number for messages, with six digits.
pub(crate) fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    // Six digits without trailing zeros.
    let digits = 5 - number.abs().log10().floor() as i32;
    let factor = 10_f64.powi(digits);
    let rounded = (number * factor).round() / factor;
    format!("{:.*}", digits.clamp(0, 12) as usize, rounded)
        .trim_end_matches(|c| c == '0' && digits > 0)
        .trim_end_matches('.')
        .to_owned()
}

/// A number with this many significant digits, for messages and mappings.
pub(crate) fn rounded_to(number: f64, count: i32) -> f64 {
    if number == 0.0 {
        return number;
    }
    let digit = 10_f64.powi(number.abs().log10().floor() as i32 + 1 - count);
    let rounded = (number / digit).round() * digit;
    short(rounded).parse().unwrap_or(number)
}

/// Whether a character controls a terminal, changes the writing direction, or is invisible.
pub fn is_harmful(c: char) -> bool {
    (c.is_control() && !matches!(c, '\n' | '\t'))
        || matches!(c,
            '\u{61C}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{2069}'
            | '\u{FEFF}' | '\u{FFFE}' | '\u{FFFF}')
}

/// The text with every such character replaced by `�`; line ends and tabs stay.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(is_harmful) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.replace(is_harmful, "\u{FFFD}"))
}

/// The text on one line: line ends and tabs are replaced as well. For names of files, boards and keys, which have
/// none.
pub fn one_line(text: &str) -> Cow<'_, str> {
    let breaks = |c: char| is_harmful(c) || matches!(c, '\n' | '\t');
    if !text.contains(breaks) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.replace(breaks, "\u{FFFD}"))
}

/// A path for output.
pub fn shown(path: impl AsRef<Path>) -> String {
    one_line(&path.as_ref().to_string_lossy()).into_owned()
}

/// A TOML document with every text on one line, keys included, so that no text adds a line to a header.
pub fn one_line_table(table: &toml::Table) -> toml::Table {
    let pair =
        |(key, value): (&String, &toml::Value)| (one_line(key).into_owned(), one_line_value(value));
    table.iter().map(pair).collect()
}

fn one_line_value(value: &toml::Value) -> toml::Value {
    match value {
        toml::Value::String(text) => one_line(text).into_owned().into(),
        toml::Value::Array(values) => values.iter().map(one_line_value).collect::<Vec<_>>().into(),
        toml::Value::Table(table) => one_line_table(table).into(),
        other => other.clone(),
    }
}

/// The text on one line, escaped for Markdown: no table, link, image, tag, list or heading.
pub fn markdown_text(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (k, c) in one_line(text).chars().enumerate() {
        let is_mark = matches!(
            c,
            '\\' | '`' | '*' | '[' | ']' | '<' | '>' | '|' | '&' | '#' | '~' | '!'
        ) || (k == 0 && matches!(c, '-' | '+' | '='));
        if is_mark {
            out.push('\\');
        }
        out.push(c);
    }
    out
}

/// The text clipped to this many characters: beginning, end, and the number of characters left out.
pub fn clipped(text: &str, most: usize) -> Cow<'_, str> {
    let length = text.chars().count();
    if length <= most {
        return Cow::Borrowed(text);
    }
    let (head, tail) = (most - most / 3, most / 3);
    let begins: String = text.chars().take(head).collect();
    let ends: String = text.chars().skip(length - tail).collect();
    Cow::Owned(format!(
        "{begins} [{} characters left out] {ends}",
        length - head - tail
    ))
}

/// The value as JSON; control characters are escaped as `\u`, with the same meaning.
///
/// # Errors
/// The value cannot be serialized as JSON.
pub fn plain_json(document: &impl Serialize) -> serde_json::Result<String> {
    let text = serde_json::to_string_pretty(document)?;
    if !text.contains(is_harmful) {
        return Ok(text);
    }
    let escaped = text.chars().map(|c| match c {
        c if is_harmful(c) => format!("\\u{:04x}", u32::from(c)),
        c => c.to_string(),
    });
    Ok(escaped.collect())
}

/// A word of a command line, quoted where this system's shell needs it: PowerShell on Windows.
pub fn quoted(word: &str) -> String {
    if cfg!(windows) {
        powershell_quoted(word)
    } else {
        posix_quoted(word)
    }
}

/// In PowerShell a comma separates words, a leading `@` or `~` has a meaning, and a backslash has none.
fn powershell_quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_./:@%+=-\\".contains(c);
    if !word.is_empty() && !word.starts_with('@') && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", one_line(word).replace('\'', "''"))
}

fn posix_quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_./:@%+=,-~".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    if one_line(word) == word {
        return format!("'{}'", word.replace('\'', "'\\''"));
    }
    // Control characters and line ends are written as bash escapes.
    let escaped = word.chars().map(|c| match c {
        '\'' | '\\' => format!("\\{c}"),
        c if one_line(c.encode_utf8(&mut [0; 4])).contains(c) => c.to_string(),
        c => format!("\\u{:04x}", u32::from(c)),
    });
    format!("$'{}'", escaped.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_and_invisible_characters_are_replaced() {
        assert_eq!(
            plain("a\u{1b}[2J\u{202e}b\u{200b}c\n"),
            "a\u{FFFD}[2J\u{FFFD}b\u{FFFD}c\n"
        );
        assert!(matches!(plain("µ Ω ü 漢"), Cow::Borrowed(_)));
    }

    #[test]
    fn names_and_header_texts_are_one_line() {
        assert_eq!(
            shown("a\nb\tc\u{202e}.csv"),
            "a\u{FFFD}b\u{FFFD}c\u{FFFD}.csv"
        );
        let header: toml::Table =
            "device = \"x\\ncomplete = true\"\nn = 1\n[port]\n\"a\\nb\" = [\"c\\n\"]\n"
                .parse()
                .expect("TOML");
        let text = toml::to_string(&one_line_table(&header)).expect("TOML");
        assert_eq!(
            text,
            "device = \"x\u{FFFD}complete = true\"\nn = 1\n\n[port]\n\"a\u{FFFD}b\" = [\"c\u{FFFD}\"]\n"
        );
    }

    #[test]
    fn text_opens_no_markup_in_markdown() {
        assert_eq!(
            markdown_text("- a|b <img> [x](y) `c` a_b\n# d"),
            "\\- a\\|b \\<img\\> \\[x\\](y) \\`c\\` a_b\u{FFFD}\\# d"
        );
    }

    #[test]
    fn a_word_is_quoted_for_either_shell() {
        for (word, posix, powershell) in [
            ("crawl@0.25", "crawl@0.25", "crawl@0.25"),
            ("crawl@0.25,8s", "crawl@0.25,8s", "'crawl@0.25,8s'"),
            (r"runs\a.csv", r"'runs\a.csv'", r"runs\a.csv"),
            ("it's", r"'it'\''s'", "'it''s'"),
            (
                "virtual:?a=1&b=2",
                "'virtual:?a=1&b=2'",
                "'virtual:?a=1&b=2'",
            ),
            ("@all", "@all", "'@all'"),
            ("", "''", "''"),
        ] {
            assert_eq!(posix_quoted(word), posix);
            assert_eq!(powershell_quoted(word), powershell);
        }
    }

    #[test]
    fn a_long_text_is_shortened_in_the_middle() {
        let text = format!("{}é{}z", "a".repeat(5000), "b".repeat(5000));
        let short = clipped(&text, 300);
        assert!(short.starts_with("aaa") && short.ends_with("bz") && short.chars().count() < 340);
        assert_eq!(clipped("short", 5), "short");
    }
}
