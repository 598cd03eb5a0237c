//! Figures in text: significant digits, units for readers, no line break between value and unit.

use crate::units::rpm_from_rad_s;

/// A number with this many significant digits; in scientific notation if very small or very large.
pub fn figure(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "\u{2013}".to_owned();
    }
    if value.is_infinite() {
        return "unlimited".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor() as i32;
    let text = if (-4..6).contains(&magnitude) {
        let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
        trimmed(&format!("{value:.decimals$}"))
    } else {
        let mantissa = value / 10f64.powi(magnitude);
        let decimals = digits.saturating_sub(1);
        let mantissa = trimmed(&format!("{mantissa:.decimals$}"));
        format!("{mantissa}\u{d7}10{}", superscript(magnitude))
    };
    text.replace('-', "\u{2212}")
}

fn superscript(number: i32) -> String {
    let raise = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    number.to_string().chars().map(raise).collect()
}

fn trimmed(text: &str) -> String {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text.to_owned()
    }
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    format!("{}\u{a0}%", figure(100.0 * share, 3))
}

/// A probability with two decimals, three above 0.99; never 0 or 1.
pub fn probability(p: f64) -> String {
    match p {
        p if p >= 0.999 => ">\u{a0}0.999".to_owned(),
        p if p >= 0.99 => format!("{:.3}", (1000.0 * p).floor() / 1000.0),
        p if p < 0.005 => "<\u{a0}0.01".to_owned(),
        p => format!("{p:.2}"),
    }
}

/// A probability with its symbol: `P = 0.93`, or of an event `P(no effect is present) = 0.93`.
pub fn probability_of(event: &str, p: f64) -> String {
    let symbol = match event {
        "" => "P".to_owned(),
        event => format!("P({event})"),
    };
    let value = probability(p);
    let equals = if value.starts_with(['<', '>']) {
        ""
    } else {
        "=\u{a0}"
    };
    format!("{symbol} {equals}{value}")
}

/// A relative change in percent, with its sign.
pub fn change(relative: f64) -> String {
    let sign = if relative > 0.0 { "+" } else { "" };
    format!("{sign}{}", percent(relative))
}

/// A speed in RPM.
pub fn rpm(speed_rad_s: f64) -> String {
    format!("{}\u{a0}RPM", figure(rpm_from_rad_s(speed_rad_s), 4))
}

/// A speed that may have no limit, in RPM.
pub fn rpm_or_unlimited(speed_rad_s: Option<f64>) -> String {
    speed_rad_s.map_or_else(|| "unlimited".to_owned(), rpm)
}

/// A time in ms below a second, else in s.
pub fn time(seconds: f64) -> String {
    if seconds.abs() < 1.0 {
        format!("{}\u{a0}ms", figure(1e3 * seconds, 3))
    } else {
        format!("{}\u{a0}s", figure(seconds, 3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_the_requested_digits() {
        assert_eq!(figure(0.033898305, 4), "0.0339");
        assert_eq!(figure(47.7464829, 4), "47.75");
        assert_eq!(figure(8e-6, 4), "8\u{d7}10\u{207b}\u{2076}");
        assert_eq!(figure(-2475.3, 4), "\u{2212}2475");
        assert_eq!(figure(123_456.7, 4), "123457");
        assert_eq!(figure(0.0, 3), "0");
        assert_eq!(percent(0.4949), "49.5\u{a0}%");
        assert_eq!(time(0.0004), "0.4\u{a0}ms");
        assert_eq!(probability(1.0), ">\u{a0}0.999");
        assert_eq!(probability(0.0), "<\u{a0}0.01");
        assert_eq!(probability(0.25), "0.25");
        assert_eq!(probability(0.9989), "0.998");
        assert_eq!(probability_of("", 0.934), "P =\u{a0}0.93");
        assert_eq!(probability_of("no gap", 1.0), "P(no gap) >\u{a0}0.999");
        assert_eq!(change(0.0679), "+6.79\u{a0}%");
    }
}
