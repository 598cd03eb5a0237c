//! Headers that loggers print before a message: `2026-04-13 12:34:56,789 INFO motor: pwm=80` of Python, `2026-04-13 12:34:56.789 | INFO
//! | main:go:12 - pwm=80` of loguru, `[INFO] [1690000000.123456789] [motor]: pwm: 80` of ROS, `Apr 13 12:34:56 host motor[812]: pwm=80` of syslog
//! and systemd's journal.

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
/// The level is among the first words after the time.
const LEVEL_WORDS: usize = 4;

/// The message after a time stamp, if a level or the name of a process is between them: its numbers with labels, or separated.
pub(super) fn message(rest: &[u8]) -> Option<&[u8]> {
    of_syslog(rest).or_else(|| after_level(rest))
}

/// Of syslog and systemd's journal: ` host motor[812]: pwm=80`.
fn of_syslog(rest: &[u8]) -> Option<&[u8]> {
    let mut words = rest.strip_prefix(b" ")?.splitn(3, |byte| *byte == b' ');
    let (_, process, message) = (words.next()?, words.next()?, words.next()?);
    let mut name = process
        .strip_suffix(b"]:")?
        .rsplitn(2, |byte| *byte == b'[');
    let is_number = name.next()?.iter().all(u8::is_ascii_digit);
    (is_number && name.next().is_some()).then_some(message)
}

fn after_level(rest: &[u8]) -> Option<&[u8]> {
    let is_between = |byte: &u8| matches!(byte, b' ' | b'|' | b'-' | b'[' | b']' | b':');
    let mut at = 0;
    let mut words = rest.split(is_between).map(|word| {
        let end = at + word.len();
        at = end + 1;
        (word, end)
    });
    let words = words.by_ref().filter(|(word, _)| !word.is_empty());
    let is_level = |(word, _): &(&[u8], usize)| LEVELS.contains(word);
    let (_, end) = words.take(LEVEL_WORDS).find(is_level)?;
    let after = &rest[end..];
    let begins =
        (1..after.len()).filter(|&at| is_between(&after[at - 1]) && !is_between(&after[at]));
    let mut messages = begins.map(|at| &after[at..]);
    messages
        .clone()
        .find(|message| has_number(message))
        .or_else(|| {
            let is_marked = |message: &&[u8]| {
                let before = &after[..after.len() - message.len()];
                matches!(before, [.., b':' | b'-' | b'|' | b']', b' '])
            };
            messages.find(|message| is_marked(message) && message[0].is_ascii_digit())
        })
}

/// Whether a message is of pairs of a label and a value, one of which is a number.
fn has_number(message: &[u8]) -> bool {
    let is_number = |value: &[u8]| {
        let text = std::str::from_utf8(value).unwrap_or_default();
        text.parse::<f64>().is_ok_and(f64::is_finite)
    };
    pairs(message).is_some_and(|found| found.iter().any(|(_, value, _)| is_number(value)))
}

/// Of ROS: the seconds, and the message.
pub(super) fn of_ros(text: &[u8]) -> Option<Vec<u8>> {
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
    let (before, between): (&[u8], &[u8]) = match pairs(message) {
        Some(_) => (b"log_s:", b" "),
        None => (b"", b","),
    };
    Some([before, s, between, message].concat())
}

/// The content of brackets, and what follows.
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
            let found = of_ros(line.as_bytes());
            assert_eq!(
                found,
                expected.map(|text| text.as_bytes().to_vec()),
                "{line}"
            );
        }
    }
}
