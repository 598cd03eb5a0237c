//! Range checks of the numbers in a mapping file.

use super::MapError;

/// A factor of 1 up to rounding becomes 1, so that counts stay integral.
pub(super) fn unity(factor: f64) -> f64 {
    if (factor - 1.0).abs() < 4.0 * f64::EPSILON {
        1.0
    } else {
        factor
    }
}

pub(super) fn wrong(
    section: &'static str,
    key: &'static str,
    found: f64,
    expected: &str,
) -> MapError {
    MapError::Value {
        section,
        key,
        found: found.to_string(),
        expected: expected.to_owned(),
    }
}

pub(super) fn positive(
    section: &'static str,
    key: &'static str,
    value: f64,
) -> Result<f64, MapError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(wrong(section, key, value, "a number above 0"))
    }
}

pub(super) fn optional_positive(
    section: &'static str,
    key: &'static str,
    value: Option<f64>,
) -> Result<Option<f64>, MapError> {
    value.map(|value| positive(section, key, value)).transpose()
}

/// `scale`, 1 if it is not given.
pub(super) fn nonzero(section: &'static str, scale: Option<f64>) -> Result<f64, MapError> {
    let scale = scale.unwrap_or(1.0);
    if scale.is_finite() && scale != 0.0 {
        Ok(scale)
    } else {
        Err(wrong(section, "scale", scale, "a number other than 0"))
    }
}

pub(super) fn finite(
    section: &'static str,
    key: &'static str,
    value: Option<f64>,
) -> Result<f64, MapError> {
    let value = value.unwrap_or(0.0);
    if value.is_finite() {
        Ok(value)
    } else {
        Err(wrong(section, key, value, "a finite number"))
    }
}
