//! The cells of one line.

use std::borrow::Cow;

use super::error::RowProblem;
use super::labels::{label_of, pairs};
use super::stamp::before_line;

/// Separator of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    /// One byte.
    Byte(u8),
    /// Any number of spaces and tabs.
    Blanks,
    /// Each cell has its label: `Pos:123 PWM:80`.
    Labels,
}

impl Separator {
    /// Apparent separator of a line (of names, or the first row).
    pub fn guess(line: &[u8], decimal_comma: bool) -> Self {
        let line = before_line(line).map_or(line, |(_, rest)| rest);
        let commas: &[u8] = if decimal_comma { b"\t;|" } else { b"\t;,|" };
        let found = commas.iter().find(|byte| line.contains(byte));
        found.map_or(Self::Blanks, |&byte| Self::Byte(byte))
    }
}

/// Where the cells of the present line stand. Kept between lines, so that a line allocates nothing.
#[derive(Debug, Default, Clone)]
pub(super) struct Cells {
    text: Vec<u8>,
    ends: Vec<(usize, usize)>,
    /// Labels of the cells, if any.
    labels: Vec<Vec<u8>>,
}

impl Cells {
    /// Cells of these texts.
    pub fn of(texts: &[Vec<u8>]) -> Self {
        let mut cells = Self::default();
        texts.iter().for_each(|text| cells.push(text));
        cells
    }

    /// From here on each cell has this label; one with another is taken as it stands, and is no number.
    pub fn expect(&mut self, labels: Vec<Vec<u8>>) {
        self.labels = labels;
    }

    fn push(&mut self, cell: &[u8]) {
        let from = self.text.len();
        self.text.extend_from_slice(cell);
        self.ends.push((from, self.text.len()));
    }

    fn split_labelled(&mut self, line: &[u8]) {
        let Some(pairs) = pairs(line) else {
            self.push(line);
            return;
        };
        for (label, value, unit) in pairs {
            let label = label_of(label, unit);
            match self.labels.get(self.ends.len()) {
                Some(expected) if *expected == label => self.push(value),
                _ => self.push(&[&label, b":".as_slice(), value].concat()),
            }
        }
    }

    /// Takes a line apart. Cells in double quotes may hold the separator, and `""` for a quote; so may those in single
    /// quotes. A terminal's time stamp before the line is a cell of its own.
    pub fn split(&mut self, line: &[u8], separator: Separator) {
        self.text.clear();
        self.ends.clear();
        let line = match before_line(line) {
            Some((stamp, rest)) => {
                self.text.extend_from_slice(stamp);
                self.ends.push((0, stamp.len()));
                rest
            }
            None => line,
        };
        let origin = self.text.len();
        let byte = match separator {
            Separator::Blanks => {
                self.text.extend_from_slice(line);
                let mut start = None;
                for (at, byte) in line.iter().chain(b" ").enumerate() {
                    match (byte.is_ascii_whitespace(), start) {
                        (true, Some(from)) => {
                            self.ends.push((origin + from, origin + at));
                            start = None;
                        }
                        (false, None) => start = Some(at),
                        _ => {}
                    }
                }
                return;
            }
            Separator::Labels => return self.split_labelled(line),
            Separator::Byte(byte) => byte,
        };
        if memchr::memchr2(b'"', b'\'', line).is_none() {
            self.text.extend_from_slice(line);
            let mut from = origin;
            for at in memchr::memchr_iter(byte, line) {
                self.ends.push((from, origin + at));
                from = origin + at + 1;
            }
            self.ends.push((from, self.text.len()));
            return;
        }
        let (mut start, mut quoted) = (origin, false);
        let mut rest = line;
        while let Some((&next, after)) = rest.split_first() {
            rest = after;
            match next {
                b'"' if quoted && rest.first() == Some(&b'"') => {
                    rest = &rest[1..];
                    self.text.push(b'"');
                }
                b'"' => quoted = !quoted,
                _ if next == byte && !quoted => {
                    self.ends.push((start, self.text.len()));
                    start = self.text.len();
                }
                b'\'' if !quoted && blank(&self.text[start..]) => match single_quoted(rest, byte) {
                    Some(length) => {
                        self.text.extend_from_slice(&rest[..length]);
                        rest = &rest[length + 1..];
                    }
                    None => self.text.push(next),
                },
                _ => self.text.push(next),
            }
        }
        self.ends.push((start, self.text.len()));
    }

    /// How many cells there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Takes empty cells at the end off, down to `count`: lines that end in separators.
    pub fn trim_to(&mut self, count: usize) {
        while self.len() > count
            && self
                .ends
                .last()
                .is_some_and(|&(a, b)| blank(&self.text[a..b]))
        {
            self.ends.pop();
        }
    }

    /// A cell without the blanks around it; empty where there is none.
    pub fn get(&self, at: usize) -> &[u8] {
        self.ends
            .get(at)
            .map_or(b"", |&(from, to)| self.text[from..to].trim_ascii())
    }

    /// A cell as text, whatever its encoding.
    pub fn text(&self, at: usize) -> Cow<'_, str> {
        decode(self.get(at))
    }
}

/// Length of the content of a cell in single quotes, after the first one: the next one ends the cell. Others are in a
/// number (`1'234`) or a word.
fn single_quoted(rest: &[u8], separator: u8) -> Option<usize> {
    let length = memchr::memchr(b'\'', rest)?;
    let after = rest[length + 1..].iter().find(|byte| **byte != b' ');
    after
        .is_none_or(|byte| *byte == separator || *byte == b'\r')
        .then_some(length)
}

fn blank(bytes: &[u8]) -> bool {
    bytes.trim_ascii().is_empty()
}

/// Bytes as UTF-8, or else as Latin-1.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// A cell as a finite number. `column` is for the message.
pub(super) fn number(cell: &[u8], decimal_comma: bool, column: &str) -> Result<f64, RowProblem> {
    let text = std::str::from_utf8(cell).map(|text| match ungrouped(text) {
        Some(text) => Cow::Owned(text),
        None => Cow::Borrowed(text),
    });
    let parsed = match text.as_deref() {
        Ok(text) if decimal_comma && text.contains(',') && !text.contains('.') => {
            text.replace(',', ".").parse::<f64>()
        }
        // The minus of spreadsheets and word processors.
        Ok(text) => match text.strip_prefix('\u{2212}') {
            Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => {
                rest.parse::<f64>().map(|number| -number)
            }
            _ => text
                .parse::<f64>()
                .or_else(|error| of_fortran(text).ok_or(error)),
        },
        Err(_) => "".parse::<f64>(),
    };
    match parsed {
        Ok(number) if number.is_finite() => Ok(number),
        Err(_) if cell.is_empty() => Err(RowProblem::Empty {
            column: column.to_owned(),
        }),
        _ => Err(RowProblem::NotANumber {
            column: column.to_owned(),
            found: shortened(&decode(cell)),
        }),
    }
}

/// Fortran's double precision: `1.0D+03`.
fn of_fortran(text: &str) -> Option<f64> {
    let (digits, exponent) = text.split_once(['D', 'd'])?;
    let is_number = digits.contains('.') && exponent.starts_with(['+', '-']);
    is_number.then(|| format!("{digits}e{exponent}").parse().ok())?
}

/// The exact integer in a cell; a float is inexact beyond 2^53.
pub(super) fn whole(cell: &[u8]) -> Option<i64> {
    std::str::from_utf8(cell).ok()?.parse().ok()
}

/// Marks between groups of three digits that stand nowhere else in a number: the apostrophe, and blanks that break no line.
const GROUP_MARKS: [char; 5] = ['\'', '\u{2019}', '\u{a0}', '\u{202f}', '\u{2009}'];

/// A number without such marks: `1'234'567.5`.
fn ungrouped(text: &str) -> Option<String> {
    let may_have = |byte: u8| byte == b'\'' || !byte.is_ascii();
    if !text.bytes().any(may_have) || !text.contains(GROUP_MARKS) {
        return None;
    }
    let digits = text.strip_prefix(['-', '\u{2212}']).unwrap_or(text);
    let whole = digits.split(['.', ',']).next().unwrap_or_default();
    let mut groups = whole.split(GROUP_MARKS);
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let is_first = groups
        .next()
        .is_some_and(|first| (1..=3).contains(&first.len()) && is_digits(first));
    let is_grouped = is_first && groups.all(|group| group.len() == 3 && is_digits(group));
    is_grouped.then(|| text.replace(GROUP_MARKS, ""))
}

/// Groups of three digits in a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Groups {
    /// There are two marks at least, or a decimal mark follows: the groups are no three decimals.
    pub is_sure: bool,
}

/// Whether a number is written in groups of three digits with this mark between them: `1,234,567`, `-1.234,5`.
pub(super) fn grouped(cell: &[u8], mark: u8) -> Option<Groups> {
    let decimal = if mark == b',' { b'.' } else { b',' };
    let digits = cell.strip_prefix(b"-").unwrap_or(cell);
    let mut parts = digits.splitn(2, |byte| *byte == decimal);
    let (whole, decimals) = (parts.next()?, parts.next());
    let is_digits = |text: &[u8]| text.iter().all(u8::is_ascii_digit);
    let mut groups = whole.split(|byte| *byte == mark);
    let first = groups.next()?;
    let is_first = (1..=3).contains(&first.len()) && first[0] != b'0' && is_digits(first);
    let rest: Vec<&[u8]> = groups.collect();
    let is_group = |group: &&[u8]| group.len() == 3 && is_digits(group);
    let is_grouped = is_first && !rest.is_empty() && rest.iter().all(is_group);
    let is_decimal = decimals.is_none_or(|decimals| !decimals.is_empty() && is_digits(decimals));
    (is_grouped && is_decimal).then_some(Groups {
        is_sure: rest.len() > 1 || decimals.is_some(),
    })
}

/// A number without the marks between its thousands; anything else as it is.
pub(super) fn without_groups(cell: &[u8], mark: u8) -> Cow<'_, [u8]> {
    match grouped(cell, mark) {
        Some(_) => Cow::Owned(cell.iter().copied().filter(|byte| *byte != mark).collect()),
        None => Cow::Borrowed(cell),
    }
}

/// The number after a word in a comment, as in `# Step 2/5 | PWM = 120` after `PWM`. The case of letters is no matter.
pub(super) fn number_after(comment: &str, word: &str) -> Option<f64> {
    value_after(comment, word).map(|(number, _)| number)
}

/// The same, and the word after the number, which may be its unit.
pub(super) fn value_after(comment: &str, word: &str) -> Option<(f64, String)> {
    let (text, word) = (comment.to_lowercase(), word.trim().to_lowercase());
    text.match_indices(&word).find_map(|(at, _)| {
        let is_whole = !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let after = text[at + word.len()..].trim_start();
        let after = after.strip_prefix(['=', ':']).unwrap_or(after).trim_start();
        let end = after.find(|c: char| !matches!(c, '0'..='9' | '.' | '-' | '+'));
        let (digits, rest) = after.split_at(end.unwrap_or(after.len()));
        let number = digits.trim_end_matches('.').parse::<f64>().ok();
        let unit = rest.trim_start().split([' ', '\t', ',', ';', '|', ')']);
        let unit = unit.into_iter().next().unwrap_or_default().to_owned();
        number.filter(|_| is_whole).map(|number| (number, unit))
    })
}

/// For messages.
pub(super) fn shortened(text: &str) -> String {
    let mut found: String = text.chars().take(40).collect();
    if found.len() < text.len() {
        found.push('…');
    }
    found.escape_debug().to_string()
}

/// The cells of one line.
pub(super) fn texts(line: &str, separator: Separator) -> Vec<String> {
    let mut cells = Cells::default();
    cells.split(line.as_bytes(), separator);
    (0..cells.len())
        .map(|at| cells.text(at).into_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(line: &str, separator: Separator) -> Vec<String> {
        let mut cells = Cells::default();
        cells.split(line.as_bytes(), separator);
        (0..cells.len())
            .map(|k| cells.text(k).into_owned())
            .collect()
    }

    #[test]
    fn separators_are_guessed_and_kept_to() {
        for (line, separator, expected) in [
            ("1,2 , 3", Separator::Byte(b','), vec!["1", "2", "3"]),
            ("1;2,5;", Separator::Byte(b';'), vec!["1", "2,5", ""]),
            ("1\t2\t", Separator::Byte(b'\t'), vec!["1", "2", ""]),
            ("  1   2 \t 3 ", Separator::Byte(b'\t'), vec!["1   2", "3"]),
            ("  1   2  3 ", Separator::Blanks, vec!["1", "2", "3"]),
        ] {
            assert_eq!(Separator::guess(line.as_bytes(), false), separator);
            assert_eq!(cells(line, separator), expected);
        }
        let comma = Separator::Byte(b',');
        assert_eq!(
            cells(r#""a, b","say ""x""",3"#, comma),
            ["a, b", "say \"x\"", "3"]
        );
        assert_eq!(Separator::guess(b"1,5 2,5", true), Separator::Blanks);
    }

    #[test]
    fn the_number_after_a_word_is_found() {
        for (comment, expected) in [
            ("# Step 2/5 | PWM = 120", Some(120.0)),
            ("# pwm: -80.5, left", Some(-80.5)),
            ("# PWM 30.", Some(30.0)),
            ("# RPWM = 3", None),
            ("# PWM off", None),
            ("", None),
        ] {
            assert_eq!(number_after(comment, "PWM"), expected, "{comment}");
        }
    }

    #[test]
    fn only_finite_numbers_are_numbers() {
        assert_eq!(number(b"-1.5e3", false, "x"), Ok(-1500.0));
        assert_eq!(number(b"-1,5", true, "x"), Ok(-1.5));
        assert_eq!(number(b"-1'234'567.5", false, "x"), Ok(-1_234_567.5));
        assert_eq!(number(b"-1.5D+03", false, "x"), Ok(-1500.0));
        assert_eq!(
            number("12\u{202f}345,5".as_bytes(), true, "x"),
            Ok(12_345.5)
        );
        for bad in [
            "",
            "NaN",
            "inf",
            "-Infinity",
            "1e999",
            "1,5",
            "0x10",
            "1 2",
            "1'23",
            "'123",
            "1D3",
            "1.0D3",
            "\u{fffd}",
        ] {
            let error = number(bad.as_bytes(), false, "speed").expect_err(bad);
            assert!(error.to_string().contains("column speed"), "{error}");
        }
        assert!(number(b"\xb0\xff", false, "x").is_err());
    }
}
