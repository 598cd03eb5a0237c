//! Time stamps in common notations: `12:34:56.789`, `2026-04-13 19:03:12`, `13.04.2026 19:03:12`, `4/13/2026 7:03:12
//! PM`, `13-Apr-2026 19:03:12` of MATLAB, `Apr 13 19:03:12` of syslog, RFC 3339; `12:34:56:789` of controllers; minutes and seconds, `0:57.120` and `0:57`; IEC 61131's `T#1s250ms`,
//! and a time with its unit, `12.5 ms`.
//!
//! Terminals print them before each line: the Arduino IDE `12:34:56.789 -> `, PlatformIO `12:34:56.789 > `, minicom
//! `[2026-04-13 19:03:12.345] `, Tera Term `[Mon Apr 13 19:03:12.345 2026] `, others `(19:03:12.345) ` or a tab after
//! it. Loggers print a level and their name after it.

use super::logger::message;

/// Seconds in a day, after which a time of day wraps.
pub(super) const DAY_S: f64 = 86_400.0;

/// Most bytes before the first colon of a stamp: `[2026-04-13 19:`.
const LONGEST_BEFORE_TIME: usize = 15;

/// A time stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stamp {
    /// Seconds since 1970, or since midnight without a date.
    pub s: f64,
    /// Without a date.
    pub is_of_day: bool,
    /// `12:34`, read as minutes and seconds; hours and minutes have the same notation.
    pub is_either: bool,
}

/// The stamp in a cell without other text.
pub(super) fn stamp(cell: &[u8]) -> Option<Stamp> {
    let cell = cell.trim_ascii();
    // Stamps begin with a digit, or a letter of a time literal.
    let first = *cell.first()?;
    let is_word = || first.is_ascii_alphabetic() && begins(cell).is_some();
    if !first.is_ascii_digit() && !matches!(first, b'T' | b't' | b'L' | b'-') && !is_word() {
        return None;
    }
    match begins(cell) {
        Some((stamp, b"")) => Some(stamp),
        _ => minutes(cell).or_else(|| {
            let s = duration(cell)?;
            Some(Stamp {
                s,
                is_of_day: false,
                is_either: false,
            })
        }),
    }
}

/// Hours of a day.
const HOURS: i64 = 24;

/// `0:57.120` and `0:57`: minutes and seconds.
fn minutes(cell: &[u8]) -> Option<Stamp> {
    let (minutes, rest) = number(cell, 1, 3)?;
    let (seconds, rest) = number(rest.strip_prefix(b":")?, 2, 2)?;
    let (fraction, after) = fraction(rest);
    (seconds < 60 && after.is_empty()).then(|| Stamp {
        s: (60 * minutes + seconds) as f64 + fraction,
        is_of_day: false,
        is_either: rest.is_empty() && minutes < HOURS,
    })
}

/// `T#1s250ms`, `TIME#5ms`, or one number with its unit.
fn duration(cell: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(cell)
        .ok()?
        .replace(['µ', 'μ'], "u")
        .to_lowercase();
    let literal = ["t#", "time#", "lt#", "ltime#"]
        .into_iter()
        .find_map(|mark| text.strip_prefix(mark));
    let mut rest = literal.unwrap_or(&text);
    let sign = match rest.strip_prefix('-') {
        Some(after) => {
            rest = after;
            -1.0
        }
        None => 1.0,
    };
    let mut total_s = 0.0;
    loop {
        let end = rest.find(|c: char| !c.is_ascii_digit() && !matches!(c, '.' | ',' | '_'))?;
        let (digits, after) = rest.split_at(end);
        let after = after.trim_start();
        let letters = after
            .find(|c: char| !c.is_ascii_alphabetic())
            .unwrap_or(after.len());
        let (unit, after) = after.split_at(letters);
        let unit_s = match unit {
            "d" if literal.is_some() => DAY_S,
            "h" if literal.is_some() => 3600.0,
            "m" if literal.is_some() => 60.0,
            "s" | "sec" => 1.0,
            "ms" => 1e-3,
            "us" => 1e-6,
            "ns" => 1e-9,
            _ => return None,
        };
        let number: f64 = digits.replace('_', "").replace(',', ".").parse().ok()?;
        total_s += number * unit_s;
        rest = after;
        match (rest.is_empty(), literal) {
            (true, _) => return Some(sign * total_s),
            (false, None) => return None,
            (false, Some(_)) => rest = rest.strip_prefix('_').unwrap_or(rest),
        }
    }
}

/// The time stamp that a terminal printed before a line, and the line of the board.
pub(super) fn before_line(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let line = line.trim_ascii_start();
    // Every stamp has a time of day.
    memchr::memchr(b':', &line[..line.len().min(LONGEST_BEFORE_TIME)])?;
    let (inside, closes) = match line.first() {
        Some(b'[') => (&line[1..], Some(b"]")),
        Some(b'(') => (&line[1..], Some(b")")),
        _ => (line, None),
    };
    let (_, rest) = begins(inside)?;
    let stamp = &inside[..inside.len() - rest.len()];
    if let Some(closes) = closes {
        return Some((stamp, rest.strip_prefix(closes)?.trim_ascii_start()));
    }
    // A tab is the terminal's if the cells have another separator; one comma may be a decimal one.
    if let Some(content) = rest.strip_prefix(b"\t") {
        let has = |marks: &[u8]| content.iter().filter(|byte| marks.contains(byte)).count();
        let is_divided = has(b",") > 1 || has(b";:=") > 0;
        return (is_divided && has(b"\t") == 0).then_some((stamp, content));
    }
    let arrow = rest.trim_ascii_start();
    match arrow.strip_prefix(b"->").or(arrow.strip_prefix(b">")) {
        Some(content) => Some((stamp, content.trim_ascii_start())),
        None => Some((stamp, message(rest)?)),
    }
}

/// `Mon Apr 13 19:03:12.345 2026` of C's `ctime`, and the rest.
fn ctime(text: &[u8]) -> Option<(Stamp, &[u8])> {
    let (weekday, rest) = text.split_at_checked(3)?;
    let (month, rest) = month(rest.strip_prefix(b" ")?)?;
    let (day, rest) = number(rest.strip_prefix(b" ")?.trim_ascii_start(), 1, 2)?;
    let (of_day, rest) = begins(rest.strip_prefix(b" ")?)?;
    let (year, rest) = number(rest.strip_prefix(b" ")?, 4, 4)?;
    let days = days_since_1970(year, month, day)?;
    let stamp = Stamp {
        s: (days * DAY_S as i64) as f64 + of_day.s,
        is_of_day: false,
        is_either: false,
    };
    (weekday.iter().all(u8::is_ascii_alphabetic) && of_day.is_of_day).then_some((stamp, rest))
}

/// `Apr 13 19:03:12.345` of syslog, and the rest.
fn syslog(text: &[u8]) -> Option<(Stamp, &[u8])> {
    let (_, rest) = month(text)?;
    let (_, rest) = number(rest.strip_prefix(b" ")?.trim_ascii_start(), 1, 2)?;
    let time = rest.strip_prefix(b" ")?;
    time.first().filter(|byte| byte.is_ascii_digit())?;
    begins(time).filter(|(stamp, _)| stamp.is_of_day)
}

/// The number of a month of three letters, and the rest.
fn month(text: &[u8]) -> Option<(i64, &[u8])> {
    const MONTHS: &[u8; 36] = b"JanFebMarAprMayJunJulAugSepOctNovDec";
    let (name, rest) = text.split_at_checked(3)?;
    let at = MONTHS.chunks(3).position(|month| month == name)?;
    Some((at as i64 + 1, rest))
}

/// The leading time stamp, and the rest.
fn begins(text: &[u8]) -> Option<(Stamp, &[u8])> {
    if text.first().is_some_and(u8::is_ascii_alphabetic) {
        return ctime(text).or_else(|| syslog(text));
    }
    let (days, text, is_of_day) = match date(text) {
        Some((days, rest)) => {
            let time = rest.strip_prefix(b"T").or(rest.strip_prefix(b" "))?;
            (days, time, false)
        }
        None => (0, text, true),
    };
    let (hours, rest) = number(text, 1, 2)?;
    let (minutes, rest) = number(rest.strip_prefix(b":")?, 2, 2)?;
    let (seconds, rest) = number(rest.strip_prefix(b":")?, 2, 2)?;
    if hours > 23 || minutes > 59 || seconds > 60 {
        return None;
    }
    let (fraction, rest) = fraction(rest);
    let (hours, rest) = of_half_day(hours, rest)?;
    let (east_s, rest) = if is_of_day { (0, rest) } else { zone(rest) };
    let whole = days * DAY_S as i64 + 3600 * hours + 60 * minutes + seconds - east_s;
    let s = whole as f64 + fraction;
    let stamp = Stamp {
        s,
        is_of_day,
        is_either: false,
    };
    Some((stamp, rest))
}

/// Hours with an optional `AM` or `PM`.
fn of_half_day(hours: i64, text: &[u8]) -> Option<(i64, &[u8])> {
    let after = text.trim_ascii_start();
    let Some((half, rest)) = after.split_at_checked(2) else {
        return Some((hours, text));
    };
    let from = match half {
        b"AM" | b"am" => 0,
        b"PM" | b"pm" => 12,
        _ => return Some((hours, text)),
    };
    (1..=12)
        .contains(&hours)
        .then_some((hours % 12 + from, rest))
}

/// `2026-04-13`, `2026/04/13`, `13.04.2026`, `4/13/2026`, `13-Apr-2026` or `13 Apr 2026` as days since 1970.
fn date(text: &[u8]) -> Option<(i64, &[u8])> {
    let (first, rest) = number(text, 1, 4)?;
    let (&between, after) = rest.split_first()?;
    if matches!(between, b'-' | b' ')
        && let Some((month, rest)) = month(after)
    {
        let (year, rest) = number(rest.strip_prefix(&[between])?, 4, 4)?;
        return Some((days_since_1970(year, month, first)?, rest));
    }
    if !matches!(between, b'-' | b'/' | b'.') {
        return None;
    }
    let (second, rest) = number(after, 1, 2)?;
    let (third, rest) = number(rest.strip_prefix(&[between])?, 1, 4)?;
    let (year, month, day) = match (first, between) {
        (1000.., _) => (first, second, third),
        (_, b'.') => (third, second, first),
        (_, b'/') => (third, first, second),
        _ => return None,
    };
    Some((days_since_1970(year, month, day)?, rest))
}

/// Days since 1970 in the Gregorian calendar.
fn days_since_1970(year: i64, month: i64, day: i64) -> Option<i64> {
    if year < 1000 {
        return None;
    }
    let month = time::Month::try_from(u8::try_from(month).ok()?).ok()?;
    let date = time::Date::from_calendar_date(year as i32, month, u8::try_from(day).ok()?).ok()?;
    let days = date.to_julian_day() - time::OffsetDateTime::UNIX_EPOCH.date().to_julian_day();
    Some(i64::from(days))
}

/// An integer with this many digits.
fn number(text: &[u8], least: usize, most: usize) -> Option<(i64, &[u8])> {
    let digits = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if digits < least || digits > most {
        return None;
    }
    let value = |value, &digit: &u8| 10 * value + i64::from(digit - b'0');
    Some((text[..digits].iter().fold(0, value), &text[digits..]))
}

/// `.789` or `,789`; of controllers `:789` and `;789`, with three or six digits.
fn fraction(text: &[u8]) -> (f64, &[u8]) {
    let Some((mark, after)) = text.split_first() else {
        return (0.0, text);
    };
    let digits = after
        .iter()
        .take_while(|byte| byte.is_ascii_digit())
        .count();
    let is_mark =
        matches!(mark, b'.' | b',') || (matches!(mark, b':' | b';') && matches!(digits, 3 | 6));
    if !is_mark {
        return (0.0, text);
    }
    let parsed = std::str::from_utf8(&after[..digits]).map(|digits| format!("0.{digits}").parse());
    match parsed {
        Ok(Ok(fraction)) if digits > 0 => (fraction, &after[digits..]),
        _ => (0.0, text),
    }
}

/// Seconds east of Greenwich: `Z`, `+02:00`, `-0330`.
fn zone(text: &[u8]) -> (i64, &[u8]) {
    if let Some(rest) = text.strip_prefix(b"Z") {
        return (0, rest);
    }
    let offset = || {
        let sign = match text.first()? {
            b'+' => 1,
            b'-' => -1,
            _ => return None,
        };
        let (hours, minutes, rest) = match number(&text[1..], 4, 4) {
            Some((both, rest)) => (both / 100, both % 100, rest),
            None => {
                let (hours, rest) = number(&text[1..], 2, 2)?;
                let (minutes, rest) = number(rest.strip_prefix(b":")?, 2, 2)?;
                (hours, minutes, rest)
            }
        };
        Some((sign * (3600 * hours + 60 * minutes), rest))
    };
    offset().unwrap_or((0, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_every_kind_are_seconds() {
        // Checked with `date -u -d ... +%s`.
        for (text, s, is_of_day) in [
            ("00:00:00", 0.0, true),
            ("12:34:56.789", 45_296.789, true),
            ("7:05:09,25", 25_509.25, true),
            ("1970-01-01 00:00:00", 0.0, false),
            ("2026-04-13 19:03:12", 1_776_106_992.0, false),
            ("2026/04/13 19:03:12.5", 1_776_106_992.5, false),
            ("2026-04-13T21:03:12.5+02:00", 1_776_106_992.5, false),
            ("2024-02-29T23:59:59Z", 1_709_251_199.0, false),
            ("2026-04-13T15:33:12-0330", 1_776_106_992.0, false),
            ("13.04.2026 19:03:12", 1_776_106_992.0, false),
            ("4/13/2026 7:03:12.5 PM", 1_776_106_992.5, false),
            ("13-Apr-2026 19:03:12.5", 1_776_106_992.5, false),
            ("13 Apr 2026 19:03:12", 1_776_106_992.0, false),
            ("12:00:01 am", 1.0, true),
            ("12:34:56:789", 45_296.789, true),
            ("12:34:56;789", 45_296.789, true),
            ("0:57.120", 57.12, false),
            ("Mon Apr 13 19:03:12.5 2026", 1_776_106_992.5, false),
            ("Apr  3 19:03:12.5", 68_592.5, true),
            ("75:03,5", 4503.5, false),
            ("0:57", 57.0, false),
            ("12:34", 754.0, false),
            ("T#1s250ms", 1.25, false),
            ("TIME#-2m_5ms", -120.005, false),
            ("12,5 ms", 0.0125, false),
            ("250us", 2.5e-4, false),
        ] {
            let found = stamp(text.as_bytes()).unwrap_or_else(|| panic!("{text}"));
            assert!((found.s - s).abs() < 1e-6, "{text}: {}", found.s);
            assert_eq!(found.is_of_day, is_of_day, "{text}");
            assert_eq!(found.is_either, ["0:57", "12:34"].contains(&text), "{text}");
        }
        for none in [
            "",
            "12:60",
            "12.5",
            "24:00:00",
            "12:60:00",
            "2026-02-30 00:00:00",
            "13-Api-2026 00:00:00",
            "2026 04 13 00:00:00",
            "13:00:00 PM",
            "1.2.3 00:00:00",
            "12:34:56 -> 1",
            "1:2:3",
            "0:61.5",
            "0:57.",
            "12:34:56:7",
            "5 m",
            "5 rpm",
            "T#5",
            "T#",
            "-",
        ] {
            assert_eq!(stamp(none.as_bytes()), None, "{none}");
        }
    }

    #[test]
    fn a_terminals_prefix_is_separated_from_the_line() {
        for (line, expected) in [
            ("12:34:56.789 -> 255,12", Some(("12:34:56.789", "255,12"))),
            ("12:34:56.789 > 255 12", Some(("12:34:56.789", "255 12"))),
            (
                "[2026-04-13 19:03:12.345] 5",
                Some(("2026-04-13 19:03:12.345", "5")),
            ),
            ("(12:34:56.789) 5", Some(("12:34:56.789", "5"))),
            (
                "[Mon Apr 13 19:03:12.345 2026] 5",
                Some(("Mon Apr 13 19:03:12.345 2026", "5")),
            ),
            (
                "2026-04-13 19:03:12.345\t255,12,3",
                Some(("2026-04-13 19:03:12.345", "255,12,3")),
            ),
            (
                "Apr 13 19:03:12 rpi motor[812]: n=5",
                Some(("Apr 13 19:03:12", "n=5")),
            ),
            ("12:34:56.789\t255,12", None),
            ("12:34:56.789\t255\t12", None),
            ("12:34:56.789\t255", None),
            ("12:34:56.789,255", None),
            ("12:34:56.789 255", None),
            ("255,12", None),
        ] {
            let found = before_line(line.as_bytes());
            let expected = expected.map(|(a, b)| (a.as_bytes(), b.as_bytes()));
            assert_eq!(found, expected, "{line}");
        }
    }
}
