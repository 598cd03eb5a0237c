//! From a line of a logger to its message, and for ROS its time:
//!
//! - `2026-04-13 12:34:56,789 INFO motor: pwm=80` of Python,
//! - `2026-04-13 12:34:56.789 | INFO | main:go:12 - pwm=80` of loguru,
//! - `Apr 13 12:34:56 host motor[812]: pwm=80` of syslog and systemd's journal,
//! - `[INFO] [1690000000.123456789] [motor]: pwm: 80` of ROS.

use super::labels::pairs;

const LEVELS: [&[u8]; 8] = [
    b"INFO",
    b"DEBUG",
    b"WARNING",
    b"WARN",
    b"ERROR",
    b"CRITICAL",
    b"FATAL",
    b"TRACE",
];
/// The level is among so many words after the time stamp; a later one is text of the message.
const LEVEL_WORDS: usize = 4;

/// The message in the text after a time stamp, if a level or a process precedes it.
pub(super) fn message(rest: &[u8]) -> Option<&[u8]> {
    syslog_message(rest).or_else(|| message_after_level(rest))
}

/// Of ` host motor[812]: pwm=80`.
fn syslog_message(rest: &[u8]) -> Option<&[u8]> {
    let mut words = rest.strip_prefix(b" ")?.splitn(3, |byte| *byte == b' ');
    let (_, process, message) = (words.next()?, words.next()?, words.next()?);
    let mut id_and_name = process
        .strip_suffix(b"]:")?
        .rsplitn(2, |byte| *byte == b'[');
    let is_id = id_and_name.next()?.iter().all(u8::is_ascii_digit);
    (is_id && id_and_name.next().is_some()).then_some(message)
}

/// Separators also occur in the name of the logger, so that the message begins at the first labelled number, or else at
/// the first digit after a separator and a blank.
fn message_after_level(rest: &[u8]) -> Option<&[u8]> {
    let is_separator = |byte: &u8| matches!(byte, b' ' | b'|' | b'-' | b'[' | b']' | b':');
    let mut at = 0;
    let mut words = rest.split(is_separator).map(|word| {
        let end = at + word.len();
        at = end + 1;
        (word, end)
    });
    let words = words.by_ref().filter(|(word, _)| !word.is_empty());
    let is_level = |(word, _): &(&[u8], usize)| LEVELS.contains(word);
    let (_, end) = words.take(LEVEL_WORDS).find(is_level)?;
    let after = &rest[end..];
    let starts =
        (1..after.len()).filter(|&at| is_separator(&after[at - 1]) && !is_separator(&after[at]));
    let mut messages = starts.map(|at| &after[at..]);
    messages
        .clone()
        .find(|message| has_labelled_number(message))
        .or_else(|| {
            let is_separated = |message: &&[u8]| {
                let before = &after[..after.len() - message.len()];
                matches!(before, [.., b':' | b'-' | b'|' | b']', b' '])
            };
            messages.find(|message| is_separated(message) && message[0].is_ascii_digit())
        })
}

/// Whether a message consists of labelled values with a number among them.
fn has_labelled_number(message: &[u8]) -> bool {
    let is_number = |value: &[u8]| {
        let text = std::str::from_utf8(value).unwrap_or_default();
        text.parse::<f64>().is_ok_and(f64::is_finite)
    };
    pairs(message).is_some_and(|found| found.iter().any(|(_, value, _)| is_number(value)))
}

/// Time in s and message of a line of ROS.
pub(super) fn ros_message(text: &[u8]) -> Option<Vec<u8>> {
    let (level, after) = bracketed(text)?;
    let (s, after) = bracketed(after.strip_prefix(b" ")?)?;
    let is_time = s.contains(&b'.') && s.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.');
    if !LEVELS.contains(&level.trim_ascii()) || !is_time {
        return None;
    }
    let after = match after.strip_prefix(b" ").and_then(bracketed) {
        Some((_, after)) => after,
        None => after,
    };
    let message = after.strip_prefix(b": ")?;
    let (label, separator): (&[u8], &[u8]) = match pairs(message) {
        Some(_) => (b"log_s:", b" "),
        None => (b"", b","),
    };
    Some([label, s, separator, message].concat())
}

/// Content of leading brackets, and the rest.
fn bracketed(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let inside = text.strip_prefix(b"[")?;
    let end = memchr::memchr(b']', inside)?;
    Some((&inside[..end], &inside[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_follows_level_and_logger() {
        for (rest, expected) in [
            (" INFO motor: pwm=80 n=3", Some("pwm=80 n=3")),
            (" - motor - INFO - pwm: 80, n: 3", Some("pwm: 80, n: 3")),
            (" | DEBUG    | __main__:go:12 - pwm=80", Some("pwm=80")),
            (" [WARNING] root: 10,80,3", Some("10,80,3")),
            (" rpi motor[812]: pwm=80", Some("pwm=80")),
            (" rpi motor[812]: 10,80,3", Some("10,80,3")),
            (" rpi motor: pwm=80", None),
            (" INFO 10 80 3", None),
            (" motor: pwm=80", None),
            (" INFO motor: ready", None),
            ("", None),
        ] {
            let found = message(rest.as_bytes());
            assert_eq!(found, expected.map(str::as_bytes), "{rest}");
        }
    }

    #[test]
    fn messages_of_ros_have_the_time_in_s() {
        for (line, expected) in [
            (
                "[INFO] [1690.25] [motor]: pwm: 80",
                Some("log_s:1690.25 pwm: 80"),
            ),
            ("[ WARN] [1690.25]: 80,3", Some("1690.25,80,3")),
            ("[INFO] [motor]: pwm: 80", None),
            ("[1690.25] pwm: 80", None),
        ] {
            let found = ros_message(line.as_bytes());
            assert_eq!(
                found,
                expected.map(|text| text.as_bytes().to_vec()),
                "{line}"
            );
        }
    }
}
