//! Escaping of text from files and devices for HTML and SVG.

use std::borrow::Cow;

use crate::plain::is_harmful;

/// The text with `& < > " '` as entities, and control, invisible and direction characters as `�`.
pub fn escaped(text: &str) -> Cow<'_, str> {
    let harmful = |c: char| matches!(c, '&' | '<' | '>' | '"' | '\'') || is_harmful(c);
    if !text.contains(harmful) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if is_harmful(c) => out.push('\u{FFFD}'),
            c => out.push(c),
        }
    }
    Cow::Owned(out)
}

/// The same as HTML, with text between backticks as code.
pub(super) fn with_code(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    // An unpaired backtick is literal.
    if parts.len().is_multiple_of(2) {
        return escaped(text).into_owned();
    }
    let mut out = String::with_capacity(text.len() + 16);
    for (k, part) in parts.into_iter().enumerate() {
        let part = escaped(part);
        match k % 2 {
            0 => out.push_str(&part),
            _ => out.push_str(&format!("<code>{part}</code>")),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{escaped, with_code};

    #[test]
    fn commands_are_code_and_a_single_backtick_is_text() {
        assert_eq!(
            with_code("type `a <b`."),
            "type <code>a &lt;b</code>.".to_owned()
        );
        assert_eq!(with_code("a ` b"), "a ` b");
    }

    #[test]
    fn nothing_opens_a_tag_or_an_attribute() {
        assert_eq!(
            escaped("<a href='x' b=\"y\">&\u{1b}[31m"),
            "&lt;a href=&#39;x&#39; b=&quot;y&quot;&gt;&amp;\u{FFFD}[31m"
        );
        assert!(matches!(
            escaped("plain µ text"),
            std::borrow::Cow::Borrowed(_)
        ));
    }
}
