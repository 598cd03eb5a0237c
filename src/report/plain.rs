//! Text from files and devices made harmless wherever people read it, and short enough to be read.

use std::borrow::Cow;

/// Whether a character steers a terminal, turns the direction of reading, or cannot be seen.
pub fn is_harmful(c: char) -> bool {
    (c.is_control() && !matches!(c, '\n' | '\t'))
        || matches!(c,
            '\u{61C}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{2069}'
            | '\u{FEFF}' | '\u{FFFE}' | '\u{FFFF}')
}

/// The text with every such character as `�`; line ends and tabs stay.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(is_harmful) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.replace(is_harmful, "\u{FFFD}"))
}

/// The text with at most so many characters: of a longer one the beginning and the end, and how much is left out.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_or_hides_is_replaced_and_words_stay() {
        assert_eq!(
            plain("a\u{1b}[2J\u{202e}b\u{200b}c\n"),
            "a\u{FFFD}[2J\u{FFFD}b\u{FFFD}c\n"
        );
        assert!(matches!(plain("µ Ω ü 漢"), Cow::Borrowed(_)));
    }

    #[test]
    fn a_long_text_keeps_its_beginning_and_its_end() {
        let text = format!("{}é{}z", "a".repeat(5000), "b".repeat(5000));
        let short = clipped(&text, 300);
        assert!(short.starts_with("aaa") && short.ends_with("bz") && short.chars().count() < 340);
        assert_eq!(clipped("short", 5), "short");
    }
}
