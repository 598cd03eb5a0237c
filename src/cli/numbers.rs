//! Numeric flags, checked against the one table of plausible ranges.

use crate::diagnose::GoodEnough;
use crate::motor::plausible::{self, Range, Shown};

pub(super) fn number_in(text: &str, range: Range) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if range.holds(value) => Ok(value),
        Ok(value) if !value.is_nan() => Err(format!(
            "{} lies outside {range}\nhint: give it in the unit of that range",
            Shown(value)
        )),
        _ => Err(format!(
            "no number\nhint: a number of {range}, with a decimal point and without a unit"
        )),
    }
}

pub(super) fn sample_time_s(text: &str) -> Result<f64, String> {
    number_in(text, plausible::SAMPLE_TIME_S)
}

pub(super) fn duration_s(text: &str) -> Result<f64, String> {
    number_in(text, plausible::DURATION_S)
}

pub(super) fn counts_per_rev(text: &str) -> Result<f64, String> {
    number_in(text, plausible::COUNTS_PER_REV)
}

pub(super) fn supply_v(text: &str) -> Result<f64, String> {
    number_in(text, plausible::SUPPLY_V)
}

/// Counts, or a share in percent.
pub(super) fn good_enough(text: &str) -> Result<GoodEnough, String> {
    let (number, is_share) = match text.strip_suffix('%') {
        Some(number) => (number, true),
        None => (text, false),
    };
    let value: f64 = number.trim().parse().map_err(|_| {
        format!("'{text}' is neither counts nor a share\nhint: 5 is 5 counts, 1% is a share of the travel")
    })?;
    match (value.is_finite() && value >= 0.0, is_share) {
        (false, _) => Err("expected 0 or more\nhint: --good-enough 0.5 is half a count RMS, --good-enough 2% a share of the travel".to_owned()),
        (true, true) => Ok(GoodEnough::Share(value / 100.0)),
        (true, false) => Ok(GoodEnough::Counts(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn implausible_numbers_are_refused_with_their_range() {
        assert_eq!(supply_v("4.5"), Ok(4.5));
        for (text, expected) in [
            ("1e9", "1e9 lies outside 0.001 .. 100000 V"),
            ("-3", "-3 lies outside"),
            ("inf", "outside"),
            ("nan", "no number"),
            ("4,5", "no number"),
        ] {
            let error = supply_v(text).expect_err(text);
            assert!(error.contains(expected), "{error}");
        }
    }
}
