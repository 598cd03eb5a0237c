//! Formatting of figures in messages.

use crate::motor::CommandKind;

/// A time with four significant digits, in the unit that gives 1 to 1000.
pub(super) fn time(seconds: f64) -> String {
    let (factor, unit) = match seconds.abs() {
        s if s >= 1.0 || s == 0.0 => (1.0, "s"),
        s if s >= 1e-3 => (1e3, "ms"),
        s if s >= 1e-6 => (1e6, "us"),
        _ => (1e9, "ns"),
    };
    format!("{} {unit}", digits(factor * seconds, 4))
}

pub(super) fn unit(kind: CommandKind) -> &'static str {
    match kind {
        CommandKind::Voltage => "V",
        CommandKind::Current => "A",
        CommandKind::Torque => "N m",
    }
}

/// A number with this many significant digits, without trailing zeros.
pub(super) fn digits(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (digits - 1 - value.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    match text.split_once('.') {
        Some((whole, part)) => {
            let part = part.trim_end_matches('0');
            let point = if part.is_empty() { "" } else { "." };
            format!("{whole}{point}{part}")
        }
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_printed_in_the_customary_unit() {
        for (seconds, words) in [
            (3.0, "3 s"),
            (0.0035, "3.5 ms"),
            (20e-6, "20 us"),
            (0.000_000_3, "300 ns"),
            (33.6, "33.6 s"),
            (0.0, "0 s"),
            (1234.56, "1235 s"),
        ] {
            assert_eq!(time(seconds), words);
        }
    }
}
