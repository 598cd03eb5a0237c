//! Removal of the formatting around the numbers of a line: brackets of lists, tuples and objects, bars and rules of
//! tables, comment marks as frame delimiters, YAML's dash, the prefix of an ESP-IDF or ROS log, terminal colours.
//!
//! In: a line. Out: its content; empty for a rule, a prompt, and a line of brackets only.

use std::borrow::Cow;

use super::labels::pairs;
use super::logger::ros_message;

const RULE_CHARACTERS: &[u8] = b"-=+|:_,; \t\r";
/// Begin or end of a list on a line of its own.
const BRACKET_LINE: &[u8] = b"[](),; ";
/// Of MATLAB and Python, after their output.
const PROMPTS: [&[u8]; 2] = [b">>", b">>>"];
/// A shorter run may be a minus sign or an empty cell.
const LEAST_RULE_RUN: usize = 3;

pub(super) fn bare(line: &[u8]) -> Cow<'_, [u8]> {
    let text = line.trim_ascii();
    match text.first() {
        Some(0x1b) => Cow::Owned(bare(&without_colours(text)).into_owned()),
        Some(b'-' | b'=' | b'+' | b'|' | b':' | b'_') if is_rule(text) => Cow::Borrowed(b""),
        Some(b'[' | b']' | b'(' | b')') if text.iter().all(|byte| BRACKET_LINE.contains(byte)) => {
            Cow::Borrowed(b"")
        }
        Some(b'>') if PROMPTS.contains(&text) => Cow::Borrowed(b""),
        Some(b'|') => between(text, b"|", b"|"),
        Some(b'/') => between(text, b"/*", b"*/"),
        Some(b'{') => brace_content(text),
        Some(b'-') if text.starts_with(b"- {") || text.starts_with(b"- [") => {
            Cow::Owned(bare(&text[2..]).into_owned())
        }
        Some(b'(' | b'[') => ros_message(text).map_or_else(|| list_row(text), Cow::Owned),
        Some(b'a' | b'n') => {
            let array = [&b"array("[..], b"np.array("]
                .into_iter()
                .find_map(|prefix| text.strip_prefix(prefix));
            array.map_or(Cow::Borrowed(line), list_row)
        }
        Some(b'E' | b'W' | b'I' | b'D' | b'V') => {
            esp_idf_message(text).map_or(Cow::Borrowed(line), Cow::Owned)
        }
        _ => Cow::Borrowed(line),
    }
}

fn is_rule(text: &[u8]) -> bool {
    let is_line = |byte: &u8| matches!(byte, b'-' | b'=' | b'_');
    text.iter().all(|byte| RULE_CHARACTERS.contains(byte))
        && text
            .chunk_by(|a, b| a == b)
            .any(|run| run.len() >= LEAST_RULE_RUN && is_line(&run[0]))
}

fn between<'a>(text: &'a [u8], prefix: &[u8], suffix: &[u8]) -> Cow<'a, [u8]> {
    let inner = text
        .strip_prefix(prefix)
        .and_then(|text| text.strip_suffix(suffix));
    Cow::Borrowed(inner.unwrap_or(text))
}

/// Content of `{0, 3, 255},` of C or `{t: 0, pos: 3}` of JavaScript. Quotes are JSON's and bars are MegunoLink's, whose
/// own readers need the braces.
fn brace_content(text: &[u8]) -> Cow<'_, [u8]> {
    let is_separator = |byte: &u8| matches!(byte, b',' | b';' | b' ');
    let end = text.iter().rposition(|byte| !is_separator(byte));
    let inner = text[..end.map_or(0, |at| at + 1)]
        .strip_prefix(b"{")
        .and_then(|text| text.strip_suffix(b"}"));
    let is_plain = |inner: &&[u8]| {
        !inner
            .iter()
            .any(|byte| matches!(byte, b'{' | b'}' | b'"' | b'\'' | b'|'))
    };
    Cow::Borrowed(inner.filter(is_plain).unwrap_or(text))
}

/// Content of one row of a list: `(0, 3, 255)`, `[10, 0, 0],`, `[[0. 0. 0.]`. Brackets inside belong to names or units.
fn list_row(text: &[u8]) -> Cow<'_, [u8]> {
    let opens = |byte: &u8| matches!(byte, b'(' | b'[' | b' ');
    let closes = |byte: &u8| matches!(byte, b')' | b']' | b',' | b';' | b' ');
    let from = text
        .iter()
        .position(|byte| !opens(byte))
        .unwrap_or(text.len());
    let to = text
        .iter()
        .rposition(|byte| !closes(byte))
        .map_or(from, |at| at + 1);
    let inner = &text[from..to.max(from)];
    let is_closed = text.iter().any(|byte| matches!(byte, b')' | b']'));
    let is_nested = inner
        .iter()
        .any(|byte| matches!(byte, b'(' | b')' | b'[' | b']'));
    Cow::Borrowed(if is_nested || !is_closed { text } else { inner })
}

/// Time in ms since the start and message of a line of ESP-IDF: `I (1234) motor: pos=3 duty=255`.
fn esp_idf_message(text: &[u8]) -> Option<Vec<u8>> {
    let after = text[1..].strip_prefix(b" (")?;
    let digits = after
        .iter()
        .position(|byte| !byte.is_ascii_digit())
        .filter(|end| *end > 0)?;
    let (ms, after) = after.split_at(digits);
    let after = after.strip_prefix(b") ")?;
    let message = after[after.windows(2).position(|two| two == b": ")? + 2..].trim_ascii();
    let (label, separator): (&[u8], &[u8]) = match pairs(message) {
        Some(_) => (b"log_ms:", b" "),
        None => (b"", b","),
    };
    Some([label, ms, separator, message].concat())
}

/// Removes the escape sequences of colours (SGR of ECMA-48): `ESC[0;32m`.
fn without_colours(text: &[u8]) -> Vec<u8> {
    let mut plain = Vec::with_capacity(text.len());
    let mut is_escaped = false;
    for byte in text {
        match (is_escaped, byte) {
            (false, 0x1b) => is_escaped = true,
            (true, b'm') => is_escaped = false,
            (false, byte) => plain.push(*byte),
            (true, _) => {}
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formatting_around_the_numbers_is_removed() {
        for (line, expected) in [
            ("(0, 3, 255)", "0, 3, 255"),
            ("[10, 0, 0],", "10, 0, 0"),
            ("[[0.   0.1  0. ]", "0.   0.1  0."),
            (" [0.01 0.1 0. ]]", "0.01 0.1 0."),
            ("array([[0. , 0.1],", "0. , 0.1"),
            ("/*0,3,255*/", "0,3,255"),
            ("{0, 3, 255},", "0, 3, 255"),
            ("{t: 0, pos: 3}", "t: 0, pos: 3"),
            ("{\"t\": 0}", "{\"t\": 0}"),
            ("{TIMEPLOT|DATA|pos|T|3}", "{TIMEPLOT|DATA|pos|T|3}"),
            ("| time_ms | pwm |", " time_ms | pwm "),
            ("|---|---|", ""),
            ("------ ------", ""),
            ("======", ""),
            ("====,====", ""),
            ("[", ""),
            ("])", ""),
            (">>", ""),
            (">pos:3", ">pos:3"),
            ("I (10) motor: pos=0 duty=0", "log_ms:10 pos=0 duty=0"),
            ("\u{1b}[0;32mI (10) motor: 0,255\u{1b}[0m", "10,0,255"),
            ("[rad],[V]", "[rad],[V]"),
            ("[2026-04-13 19:03:12.345] 5", "[2026-04-13 19:03:12.345] 5"),
            ("-5,3", "-5,3"),
            ("-", "-"),
            ("a,b", "a,b"),
            ("Index,t", "Index,t"),
            ("", ""),
        ] {
            let found = bare(line.as_bytes());
            assert_eq!(String::from_utf8_lossy(&found), expected, "{line}");
        }
    }
}
