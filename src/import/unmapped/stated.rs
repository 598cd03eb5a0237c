//! The sample time stated in a line above the rows: `Sample Interval,2E-03`, `# fs = 200 Hz`, `Sampling period: 5
//! ms`.

use super::decide::Decision;
use super::units::{Role, unit_of};

/// Words before a sample time, and before a sample rate.
const TIMES: [&str; 16] = [
    "sample interval",
    "sampling interval",
    "sample time",
    "sampling time",
    "sample period",
    "sampling period",
    "sampletime",
    "time step",
    "timestep",
    "time interval",
    "abtastzeit",
    "abtastintervall",
    "interval",
    "period",
    "dt",
    "ts",
];
const RATES: [&str; 10] = [
    "sample rate",
    "sampling rate",
    "samplerate",
    "sample frequency",
    "sampling frequency",
    "abtastrate",
    "data rate",
    "log rate",
    "fs",
    "f_s",
];
/// Most characters between such words and their number: a unit in brackets, a mark.
const MOST_BETWEEN: usize = 12;
/// Without a unit, a time is in s up to this value, and in ms above.
const MOST_SECONDS: f64 = 1.0;

/// A sample time in s, and the line that states it.
pub(super) struct Stated {
    pub sample_time_s: f64,
    pub line: String,
}

impl Decision<'_> {
    /// The sample time in a line above the rows or a comment.
    pub(super) fn stated_sample_time(&self) -> Option<Stated> {
        let mut lines = self.survey.banner.iter().chain(&self.survey.comments);
        lines.find_map(|line| {
            let sample_time_s = stated(line)?;
            Some(Stated {
                sample_time_s,
                line: line.clone(),
            })
        })
    }
}

/// The sample time in s in a line.
fn stated(line: &str) -> Option<f64> {
    let line = line.to_lowercase().replace(['µ', 'μ'], "u");
    let time = || {
        let (number, unit) = TIMES.iter().find_map(|word| number_after(&line, word))?;
        let unit_s = match unit_of(Role::Time, &unit) {
            Some(unit) => super::clock_units::in_seconds(unit),
            None if number <= MOST_SECONDS => 1.0,
            None => 1e-3,
        };
        Some(number * unit_s)
    };
    let rate = || {
        let (number, unit) = RATES.iter().find_map(|word| number_after(&line, word))?;
        let hz = match unit.as_str() {
            "khz" | "ksps" => 1e3 * number,
            _ => number,
        };
        Some(hz.recip())
    };
    time().or_else(rate).filter(|s| s.is_finite() && *s > 0.0)
}

/// The number after a word, and its unit after the number or between the two in brackets.
fn number_after(line: &str, word: &str) -> Option<(f64, String)> {
    line.match_indices(word).find_map(|(at, _)| {
        let is_whole = !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let after = &line[at + word.len()..];
        let begins = after.find(|c: char| c.is_ascii_digit())?;
        let between = &after[..begins];
        let is_mark = |c: char| {
            matches!(
                c,
                '=' | ':' | ',' | ';' | '\t' | ' ' | '"' | '(' | ')' | '[' | ']'
            )
        };
        let beside: String = between.chars().filter(|c| c.is_alphabetic()).collect();
        let is_near = between.chars().count() <= MOST_BETWEEN
            && between.chars().all(|c| is_mark(c) || c.is_alphabetic())
            && between.chars().next().is_some_and(is_mark)
            && (beside.is_empty() || between.contains(['(', '[']));
        let digits = &after[begins..];
        // The longest prefix that is a number, exponent included.
        let ends = digits
            .find(|c: char| !matches!(c, '0'..='9' | '.' | 'e' | '-' | '+'))
            .unwrap_or(digits.len());
        let (number, length) = (1..=ends)
            .rev()
            .find_map(|end| Some((digits[..end].parse::<f64>().ok()?, end)))?;
        let behind = digits[length..].trim_start_matches(is_mark);
        let unit: String = behind.chars().take_while(|c| c.is_alphabetic()).collect();
        let unit = if unit.is_empty() { beside } else { unit };
        (is_whole && is_near).then_some((number, unit))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_times_and_rates_are_read_with_their_units() {
        for (line, seconds) in [
            ("Sample Interval,2E-03", Some(0.002)),
            ("\"Sampling Period:\",10 ms", Some(0.01)),
            ("sample time [ms]: 5", Some(0.005)),
            ("fs = 200 Hz", Some(0.005)),
            ("Sample rate (kHz);2", Some(0.0005)),
            ("sampling rate: 2 kHz", Some(0.0005)),
            ("dt = 10", Some(0.01)),
            ("dt=0.01 s", Some(0.01)),
            ("Record Length,2500", None),
            ("width = 5", None),
            ("start: 12:30", None),
        ] {
            let found = stated(line);
            assert_eq!(found.is_some(), seconds.is_some(), "{line}: {found:?}");
            let off = found
                .zip(seconds)
                .map(|(found, seconds)| found / seconds - 1.0);
            assert!(off.is_none_or(|off| off.abs() < 1e-9), "{line}: {found:?}");
        }
    }
}
