//! A line without what programs print around its numbers: the brackets of a list, a tuple or an object, the bars of a table, the marks of a frame,
//! the dash of a list in YAML, the prefix of a log of ESP-IDF or ROS, the colours of a terminal. A rule between names and rows is an empty line.

use std::borrow::Cow;

use super::labels::pairs;
use super::logger::of_ros;

/// Characters that a rule is drawn with.
const RULE: &[u8] = b"-=+|:_,; \t\r";
/// Of a list, on a line of their own.
const BRACKETS: &[u8] = b"[](),; ";
/// Of MATLAB and Python, below what they printed.
const PROMPTS: [&[u8]; 2] = [b">>", b">>>"];
/// So many of them in a row are a rule, and no minus before a number.
const LEAST_RULE: usize = 3;

/// Rest of a line.
pub(super) fn bare(line: &[u8]) -> Cow<'_, [u8]> {
    let text = line.trim_ascii();
    match text.first() {
        Some(0x1b) => Cow::Owned(bare(&without_colours(text)).into_owned()),
        Some(b'-' | b'=' | b'+' | b'|' | b':' | b'_') if is_rule(text) => Cow::Borrowed(b""),
        Some(b'[' | b']' | b'(' | b')') if text.iter().all(|byte| BRACKETS.contains(byte)) => {
            Cow::Borrowed(b"")
        }
        Some(b'>') if PROMPTS.contains(&text) => Cow::Borrowed(b""),
        Some(b'|') => between(text, b"|", b"|"),
        Some(b'/') => between(text, b"/*", b"*/"),
        Some(b'{') => braced(text),
        Some(b'-') if text.starts_with(b"- {") || text.starts_with(b"- [") => {
            Cow::Owned(bare(&text[2..]).into_owned())
        }
        Some(b'(' | b'[') => of_ros(text).map_or_else(|| listed(text), Cow::Owned),
        Some(b'a' | b'n') => {
            let list = [&b"array("[..], b"np.array("]
                .into_iter()
                .find_map(|begins| text.strip_prefix(begins));
            list.map_or(Cow::Borrowed(line), listed)
        }
        Some(b'E' | b'W' | b'I' | b'D' | b'V') => {
            logged(text).map_or(Cow::Borrowed(line), Cow::Owned)
        }
        _ => Cow::Borrowed(line),
    }
}

fn is_rule(text: &[u8]) -> bool {
    let drawn = |byte: &u8| matches!(byte, b'-' | b'=' | b'_');
    text.iter().all(|byte| RULE.contains(byte))
        && text
            .chunk_by(|a, b| a == b)
            .any(|run| run.len() >= LEAST_RULE && drawn(&run[0]))
}

fn between<'a>(text: &'a [u8], begins: &[u8], ends: &[u8]) -> Cow<'a, [u8]> {
    let inner = text
        .strip_prefix(begins)
        .and_then(|text| text.strip_suffix(ends));
    Cow::Borrowed(inner.unwrap_or(text))
}

/// `{0, 3, 255},` of C, `{t: 0, pos: 3}` of JavaScript. With quotes inside it is JSON.
fn braced(text: &[u8]) -> Cow<'_, [u8]> {
    let is_between = |byte: &u8| matches!(byte, b',' | b';' | b' ');
    let end = text.iter().rposition(|byte| !is_between(byte));
    let inner = text[..end.map_or(0, |at| at + 1)]
        .strip_prefix(b"{")
        .and_then(|text| text.strip_suffix(b"}"));
    let is_bare = |inner: &&[u8]| {
        !inner
            .iter()
            .any(|byte| matches!(byte, b'{' | b'}' | b'"' | b'\'' | b'|'))
    };
    Cow::Borrowed(inner.filter(is_bare).unwrap_or(text))
}

/// `(0, 3, 255)`, `[10, 0, 0],`, `[[0. 0. 0.]`: one row of a list. Brackets inside are names or units.
fn listed(text: &[u8]) -> Cow<'_, [u8]> {
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

/// `I (1234) motor: pos=3 duty=255` of ESP-IDF: milliseconds since the start, and the message.
fn logged(text: &[u8]) -> Option<Vec<u8>> {
    let after = text[1..].strip_prefix(b" (")?;
    let digits = after
        .iter()
        .position(|byte| !byte.is_ascii_digit())
        .filter(|end| *end > 0)?;
    let (ms, after) = after.split_at(digits);
    let after = after.strip_prefix(b") ")?;
    let message = after[after.windows(2).position(|two| two == b": ")? + 2..].trim_ascii();
    let (before, between): (&[u8], &[u8]) = match pairs(message) {
        Some(_) => (b"log_ms:", b" "),
        None => (b"", b","),
    };
    Some([before, ms, between, message].concat())
}

/// Without the escape sequences that set colours: `ESC [ 0 ; 3 2 m`.
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
    fn what_stands_around_the_numbers_is_taken_off() {
        for (line, left) in [
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
            assert_eq!(String::from_utf8_lossy(&found), left, "{line}");
        }
    }
}
