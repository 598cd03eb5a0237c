//! Lines of `label:value` pairs, as for the Arduino plotter: `target:0,actual:5`, `Pos: 123 PWM: 80`, `t=5;n=17`,
//! `Motor speed: 12.3 rpm | PWM: 80`. A leading number in brackets, `[0.020] Pos: 123`, is the time.
//!
//! The labels of the first such line are the column names of all lines with the same labels in the same order.

use super::stamp::before_line;
use super::unmapped::is_known;

/// A label, its value, and the unit after the value, which may be empty.
type Pair<'a> = (&'a [u8], &'a [u8], &'a [u8]);
/// The label of a number in brackets.
const TIME: &[u8] = b"time";

/// The pairs of a line (without a terminal's stamp); `None` if a part of it is no pair.
pub(super) fn pairs(line: &[u8]) -> Option<Vec<Pair<'_>>> {
    let is_between = |byte: &u8| matches!(byte, b',' | b';' | b'|' | b'\t' | b' ' | b'\r');
    let mut found: Vec<Pair> = Vec::new();
    // Start of the words of a label with several words.
    let mut words: Option<usize> = None;
    let mut end = 0;
    for field in line.split(is_between) {
        let start = end;
        end += field.len() + 1;
        if field.is_empty() {
            continue;
        }
        let at = field.iter().position(|byte| matches!(byte, b':' | b'='));
        // The words of a label are separated by blanks only.
        if words.is_some_and(|from| {
            line[from..start]
                .iter()
                .any(|byte| *byte != b' ' && is_between(byte))
        }) {
            return None;
        }
        match (at, found.last_mut()) {
            (Some(at), _) if is_label(&line[words.unwrap_or(start)..start + at]) => {
                let (value, unit) = apart(&field[at + 1..]);
                found.push((
                    &line[words.take().unwrap_or(start)..start + at],
                    value,
                    unit,
                ));
            }
            (None, None) if words.is_none() && bracketed(field).is_some() => {
                let (value, unit) = bracketed(field)?;
                found.push((TIME, value, unit));
            }
            // `label: value`, with a blank, and `label: value unit`.
            (None, Some((_, value, unit))) if value.is_empty() => (*value, *unit) = apart(field),
            (None, Some((_, _, unit))) if unit.is_empty() && words.is_none() && is_unit(field) => {
                *unit = field;
            }
            (None, _) if is_label(field) => words = words.or(Some(start)),
            _ => return None,
        }
    }
    let is_whole = words.is_none() && found.iter().all(|(_, value, _)| !value.is_empty());
    (is_whole && !found.is_empty()).then_some(found)
}

/// `[0.020]`, `[20ms]`: the number and its unit.
fn bracketed(field: &[u8]) -> Option<(&[u8], &[u8])> {
    let inside = field.strip_prefix(b"[")?.strip_suffix(b"]")?;
    let (number, unit) = apart(inside);
    let is_number = number
        .iter()
        .all(|byte| byte.is_ascii_digit() || *byte == b'.');
    (is_number && !number.is_empty()).then_some((number, unit))
}

/// `5ms`: a number directly followed by its unit.
fn apart(value: &[u8]) -> (&[u8], &[u8]) {
    let digits = value
        .iter()
        .rposition(|byte| byte.is_ascii_digit() || *byte == b'.');
    match digits.map(|at| value.split_at(at + 1)) {
        Some((number, unit)) if is_unit(unit) => (number, unit),
        _ => (value, b""),
    }
}

fn is_unit(text: &[u8]) -> bool {
    std::str::from_utf8(text).is_ok_and(is_known)
}

/// The label with its unit in brackets, as in column names.
pub(super) fn label_of(label: &[u8], unit: &[u8]) -> Vec<u8> {
    match unit.is_empty() {
        true => label.to_vec(),
        false => [label, b" [", unit, b"]"].concat(),
    }
}

/// A label begins with a letter, unlike a number.
fn is_label(text: &[u8]) -> bool {
    text.first()
        .is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_' || !byte.is_ascii())
}

/// The labels of a line, the first one empty if a terminal's stamp is a column before them.
pub(super) fn labels(line: &[u8]) -> Option<Vec<Vec<u8>>> {
    let (stamp, rest) = match before_line(line) {
        Some((_, rest)) => (Some(Vec::new()), rest),
        None => (None, line),
    };
    let labels = (pairs(rest)?.into_iter()).map(|(label, _, unit)| label_of(label, unit));
    Some(stamp.into_iter().chain(labels).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_label_value_pairs_are_recognized() {
        for (line, expected) in [
            (
                "target:0,actual:5",
                Some(vec![("target", "0", ""), ("actual", "5", "")]),
            ),
            (
                "Pos:123 PWM:80\r",
                Some(vec![("Pos", "123", ""), ("PWM", "80", "")]),
            ),
            (
                "Pos: 123;  PWM: -8.5",
                Some(vec![("Pos", "123", ""), ("PWM", "-8.5", "")]),
            ),
            ("t=5\tn=17", Some(vec![("t", "5", ""), ("n", "17", "")])),
            (
                "Time: 5 ms, PWM=25% RPM: 1e3",
                Some(vec![
                    ("Time", "5", "ms"),
                    ("PWM", "25", "%"),
                    ("RPM", "1e3", ""),
                ]),
            ),
            (
                "Motor speed: 12.5 rpm | Motor PWM: 80",
                Some(vec![
                    ("Motor speed", "12.5", "rpm"),
                    ("Motor PWM", "80", ""),
                ]),
            ),
            (
                "[0.020] Pos: 123",
                Some(vec![("time", "0.020", ""), ("Pos", "123", "")]),
            ),
            (
                "[20ms] Pos: 123 | U: 5V",
                Some(vec![
                    ("time", "20", "ms"),
                    ("Pos", "123", ""),
                    ("U", "5", "V"),
                ]),
            ),
            ("Pos: 5 ready", None),
            ("12:34:56", None),
            ("Motor lab v1: ready now", None),
            ("Motor, left: 5 and right", None),
            ("Pos:", None),
            ("1,2,3", None),
            ("", None),
        ] {
            let expected = expected.map(|pairs| {
                pairs
                    .into_iter()
                    .map(|(label, value, unit)| {
                        (label.as_bytes(), value.as_bytes(), unit.as_bytes())
                    })
                    .collect::<Vec<_>>()
            });
            assert_eq!(pairs(line.as_bytes()), expected, "{line}");
        }
        let stamped = labels(b"12:34:56.789 -> Pos:1,PWM:2").expect("labels");
        assert_eq!(stamped, [&b""[..], b"Pos", b"PWM"]);
    }
}
