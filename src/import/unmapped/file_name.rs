//! A constant command in the name of the log: `step_12V.csv`, `motor 9,5 V run2.txt`, `pwm120.csv`.

use super::command::PERCENT;
use crate::plain::short;

/// The commands in a file's name, without repetitions, in the format of `--command` before the `@`. `1_5V` has two: 5
/// V, and 1.5 V.
pub(super) fn commands_of(file_name: &str) -> Vec<String> {
    let name = file_name.strip_suffix(".gz").unwrap_or(file_name);
    let stem = match name.rsplit_once('.') {
        Some((stem, extension)) if extension.starts_with(|c: char| c.is_ascii_alphabetic()) => stem,
        _ => name,
    };
    let mut found: Vec<String> = Vec::new();
    let mut rest_at = 0;
    while let Some(at) = stem[rest_at..].find(|c: char| c.is_ascii_digit()) {
        let from = rest_at + at;
        let end = end_of_number(stem, from);
        rest_at = end;
        let Some(number) = number(stem, from, end) else {
            continue;
        };
        let (before, after) = (&stem[..from], &stem[end..]);
        let command = match unit_after(after).as_str() {
            "v" | "volt" | "volts" => format!("{}V", short(number)),
            "percent" => format!("{}%", short(number)),
            _ if after.starts_with('%') => format!("{}%", short(number)),
            "" => match preceding_word(before).as_str() {
                "duty" | "percent" if number.abs() <= PERCENT => format!("{}%", short(number)),
                "pwm" => format!("{}pwm", short(number)),
                _ => continue,
            },
            _ => continue,
        };
        if command.ends_with('V') {
            found.extend(with_decimal_underscore(before, &stem[from..end]));
        }
        found.push(command);
    }
    found.sort();
    found.dedup();
    found
}

/// End of the digits from here on, with a point or comma between them.
fn end_of_number(text: &str, from: usize) -> usize {
    let digits = |from: usize| {
        let rest = &text[from..];
        from + rest
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(rest.len())
    };
    let whole = digits(from);
    match text[whole..].strip_prefix(['.', ',']) {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => digits(whole + 1),
        _ => whole,
    }
}

/// The number, negative after a minus sign that is not a hyphen.
fn number(text: &str, from: usize, end: usize) -> Option<f64> {
    let number: f64 = text[from..end].replace(',', ".").parse().ok()?;
    let is_below = text[..from]
        .strip_suffix('-')
        .is_some_and(|before| !before.ends_with(|c: char| c.is_alphanumeric() || c == ')'));
    Some(if is_below { -number } else { number })
}

/// The letters after a number, possibly after a blank; empty if a digit follows them, as in `3V3`.
fn unit_after(text: &str) -> String {
    let text = text.strip_prefix(' ').unwrap_or(text);
    let end = text
        .find(|c: char| !c.is_alphabetic())
        .unwrap_or(text.len());
    match text[end..].starts_with(|c: char| c.is_ascii_digit()) {
        true => "?".to_owned(),
        false => text[..end].to_lowercase(),
    }
}

/// The letters before a number, possibly with a character and a minus between.
fn preceding_word(text: &str) -> String {
    let text = text.strip_suffix('-').unwrap_or(text);
    let text = text.strip_suffix(['_', ' ', '-', '=']).unwrap_or(text);
    let word = text.rsplit(|c: char| !c.is_alphabetic()).next();
    word.unwrap_or_default().to_lowercase()
}

/// `9_5V` may be 9.5 V.
fn with_decimal_underscore(before: &str, digits: &str) -> Option<String> {
    let before = before.strip_suffix('_')?;
    let whole = before.rsplit(|c: char| !c.is_ascii_digit()).next()?;
    let is_whole = digits.bytes().all(|byte| byte.is_ascii_digit());
    let number: f64 = format!("{whole}.{digits}").parse().ok()?;
    ((1..=2).contains(&whole.len()) && is_whole).then(|| format!("{}V", short(number)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read_from_file_names() {
        for (name, commands) in [
            ("step_12V.csv", vec!["12V"]),
            ("9.5V.csv", vec!["9.5V"]),
            ("12.0V.txt", vec!["12V"]),
            ("12.0V", vec!["12V"]),
            ("motor_9.5V.csv.gz", vec!["9.5V"]),
            ("motor 9,5 V run2.txt", vec!["9.5V"]),
            ("test-12V.csv", vec!["12V"]),
            ("step_-5V.csv", vec!["-5V"]),
            ("12V-2.csv", vec!["12V"]),
            ("step9V.csv", vec!["9V"]),
            ("data(6V).csv", vec!["6V"]),
            ("9 Volt.csv", vec!["9V"]),
            ("pwm120.csv", vec!["120pwm"]),
            ("run_duty_40.csv", vec!["40%"]),
            ("duty_-20.txt", vec!["-20%"]),
            ("2026-04-13-12V.csv", vec!["12V"]),
            ("9_5V.csv", vec!["5V", "9.5V"]),
            ("9V_24V.csv", vec!["24V", "9V"]),
            ("6V_6V.csv", vec!["6V"]),
            ("3V3.csv", vec![]),
            ("run_2_voltage.csv", vec![]),
            ("log.csv", vec![]),
        ] {
            assert_eq!(commands_of(name), commands, "{name}");
        }
    }
}
